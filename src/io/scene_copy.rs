//! The copy of the scene in the folder of a run, from which the run can be repeated.

use std::fs;
use std::io;
use std::path::Path;

use super::error::OutputError;
use super::partial::PartialFile;
use crate::base::checksum::checksum;
use crate::model::Limit;
use crate::run::checkpoint::CheckpointError;
use crate::scene::{with_limit, without_limit};

/// The text, and its checksum, by which that of another run is refused.
#[derive(Debug)]
pub(super) struct SceneCopy {
    file: PartialFile,
    /// Of the text without its limit.
    pub checksum: u32,
}

impl SceneCopy {
    /// Keeps a text.
    pub fn create(path: &Path, text: &str) -> Result<Self, OutputError> {
        let mut file = PartialFile::create(path.to_owned())?;
        file.write(text)?;
        file.flush()?;
        Ok(Self { file, checksum: identity(text) })
    }

    /// Whether the text is that of a checkpoint.
    pub fn check(path: &Path, expected: u32) -> Result<(), CheckpointError> {
        let path = PartialFile::present(path);
        let text = fs::read_to_string(&path)
            .map_err(|source| CheckpointError::FileUnreadable { path: path.clone(), source })?;
        let found = identity(&text);
        if found == expected { Ok(()) } else { Err(CheckpointError::Scene { path, found, expected }) }
    }

    /// Goes on with a text that has been checked.
    pub fn resume(path: &Path, checksum: u32) -> Result<Self, OutputError> {
        Ok(Self { file: PartialFile::reopen(path.to_owned())?, checksum })
    }

    /// Changes the limit in the text, if it has another one.
    pub fn set_limit(&mut self, limit: Limit) -> Result<(), OutputError> {
        let text = self.file.text()?;
        let changed =
            with_limit(&text, limit).map_err(|error| OutputError::write(self.file.path())(io::Error::other(error)))?;
        if changed == text { Ok(()) } else { self.file.replace(&changed) }
    }

    pub fn into_file(self) -> PartialFile {
        self.file
    }
}

/// The checksum of a text without its limit.
fn identity(text: &str) -> u32 {
    checksum(without_limit(text).as_bytes())
}
