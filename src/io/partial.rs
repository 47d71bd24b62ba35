use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::plain;
use crate::base::durability;
use crate::run::checkpoint::{Checked, CheckpointError, ManifestEntry};

const SUFFIX: &str = ".partial";

/// A file with a temporary name until it is complete. Each write updates a checksum for the next checkpoint.
#[derive(Debug)]
pub(crate) struct PartialFile {
    path: PathBuf,
    partial: PathBuf,
    file: BufWriter<Checked<File>>,
    /// Length of the head `[bytes]`. The checksum excludes the head, which is overwritten at the end of the run.
    head: u64,
}

impl PartialFile {
    pub fn create(path: PathBuf) -> Result<Self, OutputError> {
        let partial = partial_of(&path);
        let file = plain::create(&partial).map_err(OutputError::write(&partial))?;
        Ok(Self { path, partial, file: buffered(Checked::new(file)), head: 0 })
    }

    pub fn with_text(path: PathBuf, text: &str) -> Result<Self, OutputError> {
        let mut file = Self::create(path)?;
        file.write(text)?;
        Ok(file)
    }

    /// Returns the temporary path if a file exists there, otherwise the final path.
    pub fn present(path: &Path) -> PathBuf {
        let partial = partial_of(path);
        if partial.exists() { partial } else { path.to_owned() }
    }

    pub fn check(path: &Path, entry: &ManifestEntry) -> Result<(), CheckpointError> {
        let path = Self::present(path);
        if path.exists() {
            return entry.check(&path);
        }
        Err(CheckpointError::File { path, found: 0, expected: entry.length })
    }

    /// Reopens a file, and removes the data that were written after the checkpoint. Call [`Self::check`] first.
    pub fn resume(path: PathBuf, entry: &ManifestEntry) -> Result<Self, OutputError> {
        let (partial, file) = open_again(&path)?;
        file.set_len(entry.length).map_err(OutputError::write(&partial))?;
        let mut file = Checked::go_on(file, entry.length, entry.checksum);
        seek_end(&mut file, &partial)?;
        Ok(Self { path, partial, file: buffered(file), head: entry.head })
    }

    /// Reopens a file that is not in a checkpoint. Writing continues at the end of the file.
    pub fn reopen(path: PathBuf) -> Result<Self, OutputError> {
        let (partial, file) = open_again(&path)?;
        let mut file = Checked::new(file);
        seek_end(&mut file, &partial)?;
        Ok(Self { path, partial, file: buffered(file), head: 0 })
    }

    pub fn write_bytes(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        self.file.write_all(bytes).map_err(OutputError::write(&self.partial))
    }

    /// Writes a provisional head to an empty file. [`Self::replace_head`] later writes the final head.
    pub fn write_head(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        self.replace_head(bytes)?;
        self.head = bytes.len() as u64;
        self.file.get_mut().pass(self.head);
        Ok(())
    }

    /// Replaces the first bytes of the file. Writing then continues at the end of the file.
    pub fn replace_head(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        self.flush()?;
        let mut file = self.file.get_ref().inner();
        file.seek(SeekFrom::Start(0))
            .and_then(|_| file.write_all(bytes))
            .and_then(|()| file.seek(SeekFrom::End(0)))
            .map(drop)
            .map_err(OutputError::write(&self.partial))
    }

    pub fn length(&self) -> u64 {
        self.file.get_ref().length() + self.file.buffer().len() as u64
    }

    /// Syncs the file to disk. Returns an entry for a checkpoint.
    pub fn keep(&mut self, folder: &Path) -> Result<ManifestEntry, OutputError> {
        self.flush()?;
        let written = self.file.get_ref();
        durability::sync_data(written.inner()).map_err(OutputError::write(&self.partial))?;
        let name = self.path.strip_prefix(folder).unwrap_or(&self.path).to_string_lossy().into_owned();
        Ok(ManifestEntry { name, length: written.length(), head: self.head, checksum: written.checksum() })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn writer(&mut self) -> &mut impl Write {
        &mut self.file
    }

    pub fn write(&mut self, text: &str) -> Result<(), OutputError> {
        self.write_bytes(text.as_bytes())
    }

    /// Passes all buffered data to the operating system, so that other programs can read them.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.file.flush().map_err(OutputError::write(&self.partial))
    }

    pub fn sync(&mut self) -> Result<(), OutputError> {
        self.flush()?;
        durability::sync_all(self.file.get_ref().inner()).map_err(OutputError::write(&self.partial))
    }

    pub fn discard(self) -> Result<(), OutputError> {
        fs::remove_file(&self.partial).map_err(OutputError::write(&self.partial))
    }

    pub fn complete(mut self) -> Result<PathBuf, OutputError> {
        self.sync()?;
        fs::rename(&self.partial, &self.path).map_err(OutputError::write(&self.path))?;
        Ok(self.path)
    }
}

/// Opens an existing file for writing, under its temporary name.
fn open_again(path: &Path) -> Result<(PathBuf, File), OutputError> {
    let partial = partial_of(path);
    if !partial.exists() {
        fs::rename(path, &partial).map_err(OutputError::write(&partial))?;
    }
    let file = plain::open(OpenOptions::new().write(true), &partial).map_err(OutputError::write(&partial))?;
    Ok((partial, file))
}

fn seek_end(file: &mut Checked<File>, path: &Path) -> Result<(), OutputError> {
    file.inner().seek(SeekFrom::End(0)).map(drop).map_err(OutputError::write(path))
}

fn buffered(file: Checked<File>) -> BufWriter<Checked<File>> {
    BufWriter::with_capacity(1 << 16, file)
}

pub(super) fn partial_of(path: &Path) -> PathBuf {
    let mut partial = path.as_os_str().to_owned();
    partial.push(SUFFIX);
    PathBuf::from(partial)
}
