//! Files that get their name when they are complete.

use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use super::error::OutputError;

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
        let mut partial = path.clone().into_os_string();
        partial.push(SUFFIX);
        let partial = PathBuf::from(partial);
        let file = File::create(&partial).map_err(OutputError::write(&partial))?;
        Ok(Self { path, partial, file: BufWriter::with_capacity(1 << 16, file) })
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
