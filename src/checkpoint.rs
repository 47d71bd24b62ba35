//! Checkpoints: all that a run needs to go on with the same bits, in one file.
//!
//! | bytes | content |
//! |---|---|
//! | 16 | `carom checkpoint` |
//! | 12 | the version of carom that wrote it, padded with zeros |
//! | 4 | the number of this layout, little endian |
//! | n | scene, engine and course of the run, lengths and checksums of its files (postcard, with all bits of every number) |
//! | 8 | n, little endian |
//! | 4 | CRC-32 of all that stands before, little endian |
//!
//! Only the version that wrote a checkpoint reads it: the next one may round differently, and would not go on with the same bits.
//! The files of a run belong to its checkpoint by their checksums (CRC-32): those of another run are refused.

mod checked;
mod error;

pub(crate) use checked::{Checked, checksum};
pub use error::CheckpointError;

use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::run::Course;
use crate::scene::Limit;
use crate::simulation::Simulation;

/// What every checkpoint begins with.
const MAGIC: &[u8; 16] = b"carom checkpoint";

/// Counts the layouts of the content; every change of what is stored is a new one.
const LAYOUT: u32 = 2;

/// Bytes of the version.
const VERSION: usize = 12;

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
    /// Bytes at its start that the end of the run replaces, and that are not checked.
    pub head: u64,
    /// CRC-32 of what lies between.
    pub checksum: u32,
}

impl KeptFile {
    /// Whether the file at `path` is still there, with what it had at the checkpoint.
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

/// The files of a run at the time of a checkpoint.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Kept {
    /// CRC-32 of the text of the scene but for its limit, which may be given anew; `None` if the text is not kept.
    pub scene: Option<u32>,
    /// Those that grow.
    pub files: Vec<KeptFile>,
}

/// A run to go on with.
#[derive(Debug, Deserialize)]
pub struct Checkpoint {
    /// The simulation as it was.
    pub simulation: Simulation,
    /// How far the run had come.
    pub course: Course,
    /// Its files.
    pub kept: Kept,
}

/// The same to be written.
#[derive(Serialize)]
struct Content<'a> {
    simulation: &'a Simulation,
    course: &'a Course,
    kept: &'a Kept,
}

fn version() -> [u8; VERSION] {
    let mut padded = [0; VERSION];
    for (to, from) in padded.iter_mut().zip(env!("CARGO_PKG_VERSION").bytes()) {
        *to = from;
    }
    padded
}

/// Writes a checkpoint into a file, and makes it safe on the disk.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(file: &File, simulation: &Simulation, course: &Course, kept: &Kept) -> io::Result<()> {
    let inner = BufWriter::with_capacity(1 << 20, file);
    let mut out = Checked::new(inner);
    out.write_all(MAGIC)?;
    out.write_all(&version())?;
    out.write_all(&LAYOUT.to_le_bytes())?;
    let content = Content { simulation, course, kept };
    postcard::to_io(&content, &mut out).map_err(io::Error::other)?;
    let length = out.length() - HEAD as u64;
    out.write_all(&length.to_le_bytes())?;
    let checksum = out.checksum();
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
        let (found, layout) = content[MAGIC.len()..HEAD].split_at(VERSION);
        if found != version() || layout != LAYOUT.to_le_bytes() {
            let found = String::from_utf8_lossy(found).trim_end_matches('\0').to_owned();
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
