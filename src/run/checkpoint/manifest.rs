//! The manifest of a checkpoint: a list of the output files of the run, with their lengths and checksums.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::{Checked, CheckpointError};

/// An output file of the run, as it was at the time of a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ManifestEntry {
    /// Name of the file in the run folder.
    pub name: String,
    /// Length at the time of the checkpoint `[bytes]`. Later bytes are not part of the checkpoint.
    pub length: u64,
    /// Number of leading bytes that are overwritten when the run ends. The checksum excludes these bytes.
    pub head: u64,
    /// CRC-32 of the first `length` bytes of the file, except the first `head` bytes.
    pub checksum: u32,
}

impl ManifestEntry {
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

/// List of the output files of a run at the time of a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Manifest {
    /// CRC-32 of the scene without the limit of the measurement, which may change; `None` if the text is not kept.
    pub scene: Option<u32>,
    /// Output files that grow during the run.
    pub files: Vec<ManifestEntry>,
}
