//! Files that get their name when they are complete.

use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use super::error::OutputError;
use crate::checkpoint::{CheckpointError, KeptFile};

/// Ends the name of a file that is not complete.
pub(super) const SUFFIX: &str = ".partial";

/// A file that is written under a name of its own, and takes its final name at the end.
#[derive(Debug)]
pub(super) struct PartialFile {
    path: PathBuf,
    partial: PathBuf,
    file: BufWriter<File>,
}

impl PartialFile {
    /// An empty file beside `path`.
    pub fn create(path: PathBuf) -> Result<Self, OutputError> {
        let partial = partial_of(&path);
        // Not emptied before it is certain that nobody else writes to it.
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(&partial);
        let file = file.map_err(OutputError::write(&partial))?;
        lock(&file, &partial)?;
        file.set_len(0).map_err(OutputError::write(&partial))?;
        Ok(Self { path, partial, file: BufWriter::with_capacity(1 << 16, file) })
    }

    /// Whether a file that was `length` bytes long is still there, under either name.
    pub fn check(path: &Path, length: u64) -> Result<(), OutputError> {
        let partial = partial_of(path);
        let (path, found) = match (fs::metadata(&partial), fs::metadata(path)) {
            (Ok(metadata), _) => (partial.as_path(), metadata.len()),
            (Err(_), Ok(metadata)) => (path, metadata.len()),
            (Err(_), Err(_)) => (path, 0),
        };
        if found >= length {
            return Ok(());
        }
        Err(CheckpointError::File { path: path.to_owned(), found, expected: length }.into())
    }

    /// Goes on with a file, under its name of a file that is not complete; what is behind `length` is cut off.
    pub fn resume(path: PathBuf, length: Option<u64>) -> Result<Self, OutputError> {
        let partial = partial_of(&path);
        if !partial.exists() {
            fs::rename(&path, &partial).map_err(OutputError::write(&partial))?;
        }
        let mut file = OpenOptions::new().write(true).open(&partial).map_err(OutputError::write(&partial))?;
        lock(&file, &partial)?;
        if let Some(length) = length {
            file.set_len(length).map_err(OutputError::write(&partial))?;
        }
        file.seek(SeekFrom::End(0)).map_err(OutputError::write(&partial))?;
        Ok(Self { path, partial, file: BufWriter::with_capacity(1 << 16, file) })
    }

    /// What it contains so far.
    pub fn text(&mut self) -> Result<String, OutputError> {
        self.flush()?;
        fs::read_to_string(&self.partial).map_err(OutputError::write(&self.partial))
    }

    /// Replaces all of it, at once.
    pub fn replace(&mut self, text: &str) -> Result<(), OutputError> {
        let mut new = Self::create(self.partial.clone())?;
        new.write(text)?;
        new.complete()?;
        let file = OpenOptions::new().append(true).open(&self.partial).map_err(OutputError::write(&self.partial))?;
        self.file = BufWriter::with_capacity(1 << 16, file);
        Ok(())
    }

    /// Appends bytes.
    pub fn write_bytes(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        self.file.write_all(bytes).map_err(OutputError::write(&self.partial))
    }

    /// Replaces its first bytes; more goes to its end as before.
    pub fn replace_start(&mut self, bytes: &[u8]) -> Result<(), OutputError> {
        let seek = |file: &mut BufWriter<File>, to| file.seek(to).map(drop);
        seek(&mut self.file, SeekFrom::Start(0))
            .and_then(|()| self.file.write_all(bytes))
            .and_then(|()| seek(&mut self.file, SeekFrom::End(0)))
            .map_err(OutputError::write(&self.partial))
    }

    /// How long it is, with what is not yet written `[bytes]`.
    pub fn length(&mut self) -> Result<u64, OutputError> {
        self.file.stream_position().map_err(OutputError::write(&self.partial))
    }

    /// Makes what was written so far safe on the disk, and says how much that is; `folder` is that of the run.
    pub fn keep(&mut self, folder: &Path) -> Result<KeptFile, OutputError> {
        self.flush()?;
        let file = self.file.get_ref();
        file.sync_data().map_err(OutputError::write(&self.partial))?;
        let length = file.metadata().map_err(OutputError::write(&self.partial))?.len();
        let name = self.path.strip_prefix(folder).unwrap_or(&self.path).to_string_lossy().into_owned();
        Ok(KeptFile { name, length })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }

    pub fn writer(&mut self) -> &mut impl Write {
        &mut self.file
    }

    /// Appends text.
    pub fn write(&mut self, text: &str) -> Result<(), OutputError> {
        self.file.write_all(text.as_bytes()).map_err(OutputError::write(&self.partial))
    }

    /// Hands what was written so far to the operating system, so that it can be looked at.
    pub fn flush(&mut self) -> Result<(), OutputError> {
        self.file.flush().map_err(OutputError::write(&self.partial))
    }

    /// Makes it safe on the disk and gives it its name.
    pub fn complete(mut self) -> Result<PathBuf, OutputError> {
        self.flush()?;
        self.file.get_ref().sync_all().map_err(OutputError::write(&self.partial))?;
        fs::rename(&self.partial, &self.path).map_err(OutputError::write(&self.path))?;
        Ok(self.path)
    }
}

/// Keeps other processes from writing to a file, until it is closed; where the system has no locks, nothing does.
fn lock(file: &File, path: &Path) -> Result<(), OutputError> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(OutputError::Busy(path.to_owned())),
        Ok(()) | Err(TryLockError::Error(_)) => Ok(()),
    }
}

/// The name of a file that is not complete.
fn partial_of(path: &Path) -> PathBuf {
    let mut partial = path.as_os_str().to_owned();
    partial.push(SUFFIX);
    PathBuf::from(partial)
}
