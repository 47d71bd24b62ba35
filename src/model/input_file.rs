//! Files that a scene reads.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::base::checksum::checksum;

/// A file that a scene reads, other than the scene file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct InputFile {
    /// Absolute path.
    pub path: String,
    /// Checksum of the contents: `crc32:` and eight hexadecimal digits.
    pub checksum: String,
    /// Names of columns that the scene does not use. Not stored with a run.
    #[serde(skip)]
    pub unused: Vec<String>,
    /// Number of unused bytes after the triangles of a mesh. Not stored with a run.
    #[serde(skip)]
    pub extra_bytes: usize,
    /// Number of merged vertices of a mesh. Not stored with a run.
    #[serde(skip)]
    pub merged_vertices: usize,
}

impl InputFile {
    pub(crate) fn new(path: &Path, content: &[u8]) -> Self {
        let absolute = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
        Self {
            path: absolute.to_string_lossy().into_owned(),
            checksum: word(content),
            unused: Vec::new(),
            extra_bytes: 0,
            merged_vertices: 0,
        }
    }

    pub(crate) fn of_checkpoint(path: &Path, checksum: u32) -> Self {
        Self { checksum: spelled(checksum), ..Self::new(path, &[]) }
    }

    /// Returns the new checksum if the file has changed, otherwise `None`.
    ///
    /// # Errors
    /// If the file cannot be read.
    pub fn changed(&self) -> io::Result<Option<String>> {
        let content = fs::read(&self.path)?;
        let now = match content.split_last_chunk::<4>() {
            // A checkpoint ends with the CRC-32 of all other bytes, so the CRC-32 of a whole checkpoint is constant.
            Some((rest, end)) if checksum(rest).to_le_bytes() == *end => word(rest),
            _ => word(&content),
        };
        Ok((now != self.checksum).then_some(now))
    }
}

/// Returns the checksum as in scene files, such as `crc32:0123abcd`.
pub(crate) fn word(content: &[u8]) -> String {
    spelled(checksum(content))
}

pub(crate) fn spelled(checksum: u32) -> String {
    format!("crc32:{checksum:08x}")
}

pub(crate) fn is_checksum(word: &str) -> bool {
    let is_digit = |c: char| c.is_ascii_digit() || ('a'..='f').contains(&c);
    word.strip_prefix("crc32:").is_some_and(|digits| digits.len() == 8 && digits.chars().all(is_digit))
}
