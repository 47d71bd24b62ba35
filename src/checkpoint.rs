//! Checkpoints: all that a run needs to go on with the same bits, in one file.
//!
//! | bytes | content |
//! |---|---|
//! | 16 | `carom checkpoint` |
//! | 16 | the version of carom that wrote it, padded with zeros |
//! | n | scene, engine and course of the run, and the lengths of its files (postcard, with all bits of every number) |
//! | 8 | n, little endian |
//! | 4 | CRC-32 of all that stands before, little endian |
//!
//! Only the version that wrote a checkpoint reads it: the next one may round differently, and would not go on with the same bits.

mod error;

pub use error::CheckpointError;

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::run::Course;
use crate::scene::Limit;
use crate::simulation::Simulation;

/// What every checkpoint begins with.
const MAGIC: &[u8; 16] = b"carom checkpoint";

/// Bytes before and behind the content.
const HEAD: usize = 32;
const TAIL: usize = 12;

/// An output file at the time of a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeptFile {
    /// Its name in the folder of the run.
    pub name: String,
    /// How long it was `[bytes]`; what was written later does not belong to the checkpoint.
    pub length: u64,
}

/// A run to go on with.
#[derive(Debug, Deserialize)]
pub struct Checkpoint {
    /// The simulation as it was.
    pub simulation: Simulation,
    /// How far the run had come.
    pub course: Course,
    /// Its files.
    pub files: Vec<KeptFile>,
}

/// The same to be written.
#[derive(Serialize)]
struct Content<'a> {
    simulation: &'a Simulation,
    course: &'a Course,
    files: &'a [KeptFile],
}

fn version() -> [u8; 16] {
    let mut padded = [0; 16];
    for (to, from) in padded.iter_mut().zip(env!("CARGO_PKG_VERSION").bytes()) {
        *to = from;
    }
    padded
}

/// Counts and checks what goes through it.
struct Checked<W> {
    inner: W,
    checksum: crc32fast::Hasher,
    length: u64,
}

impl<W: Write> Write for Checked<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.checksum.update(&bytes[..written]);
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

/// Writes a checkpoint into a file, and makes it safe on the disk.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(file: &File, simulation: &Simulation, course: &Course, files: &[KeptFile]) -> io::Result<()> {
    let inner = BufWriter::with_capacity(1 << 20, file);
    let mut out = Checked { inner, checksum: crc32fast::Hasher::new(), length: 0 };
    out.write_all(MAGIC)?;
    out.write_all(&version())?;
    let content = Content { simulation, course, files };
    postcard::to_io(&content, &mut out).map_err(io::Error::other)?;
    let length = out.length - HEAD as u64;
    out.write_all(&length.to_le_bytes())?;
    let checksum = out.checksum.clone().finalize();
    out.write_all(&checksum.to_le_bytes())?;
    out.flush()?;
    file.sync_all()
}

impl Checkpoint {
    /// Reads a checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError`] if there is none, if another version wrote it, or if a single bit of it has changed.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let bytes = std::fs::read(path).map_err(|source| CheckpointError::unreadable(path, source))?;
        let damaged = |why| CheckpointError::Damaged { path: path.to_owned(), why };
        if !bytes.starts_with(MAGIC) {
            return Err(damaged("it does not begin like one".to_owned()));
        }
        let length = bytes.len().checked_sub(HEAD + TAIL).ok_or_else(|| damaged("its end is missing".to_owned()))?;
        let (content, tail) = bytes.split_at(HEAD + length);
        let (stated, checksum) = tail.split_at(8);
        if stated != (length as u64).to_le_bytes() {
            return Err(damaged("its end is missing".to_owned()));
        }
        let mut found = crc32fast::Hasher::new();
        found.update(content);
        found.update(stated);
        if checksum != found.finalize().to_le_bytes() {
            return Err(damaged("its checksum is wrong".to_owned()));
        }
        if content[MAGIC.len()..HEAD] != version() {
            let found = String::from_utf8_lossy(&content[MAGIC.len()..HEAD]).trim_end_matches('\0').to_owned();
            return Err(CheckpointError::OtherVersion { path: path.to_owned(), found });
        }
        let checkpoint: Self = postcard::from_bytes(&content[HEAD..]).map_err(|error| damaged(error.to_string()))?;
        checkpoint.simulation.enlarge();
        Ok(checkpoint)
    }

    /// Gives the measured stretch another end; one that was reached before ends it at once.
    pub fn extend(&mut self, limit: Limit) {
        self.simulation.set_limit(limit);
        self.course.extend(limit);
    }
}
