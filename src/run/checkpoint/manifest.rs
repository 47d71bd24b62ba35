//! The manifest of a checkpoint: the output files that belong to it, with lengths and checksums.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Checked, CheckpointError};

/// An entry of the manifest: one output file at the time of a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManifestEntry {
    /// Its name in the folder of the run.
    pub name: String,
    /// Length at the checkpoint `[bytes]`. Later bytes do not belong to it.
    pub length: u64,
    /// Number of bytes at its start that are replaced at the end of the run and not checked.
    pub head: u64,
    /// CRC-32 of the bytes in between.
    pub checksum: u32,
}

impl ManifestEntry {
    /// Checks that the file at `path` still has its content of the checkpoint.
    pub(crate) fn check(&self, path: &Path) -> Result<(), CheckpointError> {
        let unreadable = |source| CheckpointError::FileUnreadable { path: path.to_owned(), source };
        let mut file = File::open(path).map_err(unreadable)?;
        let found = file.metadata().map_err(unreadable)?.len();
        if found < self.length {
            return Err(CheckpointError::File { path: path.to_owned(), found, expected: self.length });
        }
        file.seek(SeekFrom::Start(self.head)).map_err(unreadable)?;
        let mut sum = Checked::new(io::sink());
        io::copy(&mut file.take(self.length.saturating_sub(self.head)), &mut sum).map_err(unreadable)?;
        let (found, expected) = (sum.checksum(), self.checksum);
        if found == expected {
            return Ok(());
        }
        Err(CheckpointError::Content { path: path.to_owned(), length: self.length, found, expected })
    }
}

/// The manifest of a checkpoint: the output files of the run at that time.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// CRC-32 of the text of the scene without its limit, which may be changed; `None` if the text is not
    /// kept.
    pub scene: Option<u32>,
    /// Files that grow during the run.
    pub files: Vec<ManifestEntry>,
}
