//! Checkpoints: all that a run needs to go on with the same bits, in one file.
//!
//! | bytes | content |
//! |---|---|
//! | 16 | `carom checkpoint` |
//! | 12 | the version of carom that wrote it, padded with zeros |
//! | 8 | the fingerprint of the sources that it was built from, little endian |
//! | n | scene, engine and state of the run, lengths and checksums of its files (postcard, with all bits of every number) |
//! | 8 | n, little endian |
//! | 4 | CRC-32 of all that stands before, little endian |
//!
//! Only a program of the same sources and dependencies reads a checkpoint: another one may lay the state out otherwise, or round differently, and would
//! not go on with the same bits. The fingerprint is taken at build time, of all sources but those that only talk about runs, and of `Cargo.lock`.
//! The files of a run belong to its checkpoint by their checksums (CRC-32): those of another run are refused.

mod checked;
mod error;
mod manifest;

pub(crate) use checked::Checked;
pub use error::CheckpointError;
pub use manifest::{Manifest, ManifestEntry};

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::base::numbers;
use crate::engine::{EngineError, Simulation, Until};
use crate::model::Limit;
use crate::run::RunState;

/// First bytes of every checkpoint.
const MAGIC: &[u8; 16] = b"carom checkpoint";

/// Fingerprint of the sources that the program was built from.
const FINGERPRINT: &str = env!("CAROM_FINGERPRINT");

/// Bytes of the version.
const VERSION: usize = 12;

/// Bytes that are read or written at a time.
const PIECE: usize = 1 << 20;

/// The longest name or path that a checkpoint holds has fewer bytes.
const LONGEST_TEXT: usize = 1 << 20;

/// Bytes before and behind the content.
const HEAD: usize = MAGIC.len() + VERSION + FINGERPRINT.len() / 2;
const TAIL: usize = 12;

/// Of a time: as much is what rounding makes of it.
const NEAR: f64 = 1e-9;

/// Checkpoint of a run: all that it needs to go on with the same bits.
#[derive(Debug, Deserialize)]
pub struct Checkpoint {
    /// The simulation as it was.
    pub simulation: Simulation,
    /// How far the run had come.
    pub state: RunState,
    /// Its files.
    pub manifest: Manifest,
}

/// Content of a [`Checkpoint`] to be written, field by field.
pub(crate) type Content<'a> = (&'a Simulation, &'a RunState, &'a Manifest);

/// The first bytes of the checkpoints that this program writes, and reads.
fn head() -> [u8; HEAD] {
    let mut head = [0; HEAD];
    // The build script writes nothing but digits.
    let sources = u64::from_str_radix(FINGERPRINT, 16).unwrap_or_default().to_le_bytes();
    head[..MAGIC.len()].copy_from_slice(MAGIC);
    head[MAGIC.len() + VERSION..].copy_from_slice(&sources);
    for (to, from) in head[MAGIC.len()..][..VERSION].iter_mut().zip(env!("CARGO_PKG_VERSION").bytes()) {
        *to = from;
    }
    head
}

/// A writer that keeps its error, which the serializer does not pass on.
struct KeepsError<W> {
    inner: W,
    failure: Option<io::Error>,
}

impl<W> KeepsError<W> {
    fn note<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| {
            let kind = error.kind();
            self.failure = Some(error);
            kind.into()
        })
    }
}

impl<W: Write> Write for KeepsError<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.inner.write(bytes);
        self.note(result)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.inner.flush();
        self.note(result)
    }
}

/// Writes any content in the form of a checkpoint, and makes it safe on the disk.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(file: &File, content: &impl Serialize) -> io::Result<()> {
    // The serializer writes number by number, and a checksum takes long of a few bytes at a time.
    let mut out = BufWriter::with_capacity(PIECE, Checked::new(file));
    out.write_all(&head())?;
    let mut keeper = KeepsError { inner: &mut out, failure: None };
    if let Err(error) = postcard::to_io(content, &mut keeper) {
        return Err(keeper.failure.unwrap_or_else(|| io::Error::other(error)));
    }
    out.flush()?;
    let length = out.get_ref().length() - HEAD as u64;
    out.write_all(&length.to_le_bytes())?;
    out.flush()?;
    let checksum = out.get_ref().checksum();
    out.write_all(&checksum.to_le_bytes())?;
    out.flush()?;
    file.sync_all()
}

/// The first bytes of a checkpoint, of which no bit has changed; all that stands behind them is read in pieces. Otherwise what is wrong with it.
fn sound_head(file: &mut File) -> io::Result<Result<[u8; HEAD], &'static str>> {
    let length = file.metadata()?.len();
    let mut head = [0; HEAD];
    let whole = length >= (HEAD + TAIL) as u64;
    let begins = if whole { HEAD } else { MAGIC.len().min(numbers::index(length)) };
    file.read_exact(&mut head[..begins])?;
    if head[..MAGIC.len()] != *MAGIC {
        return Ok(Err("it does not begin like one"));
    }
    if !whole {
        return Ok(Err("its end is missing"));
    }
    let content = length - (HEAD + TAIL) as u64;
    let mut found = Checked::new(io::sink());
    found.write_all(&head)?;
    io::copy(&mut BufReader::with_capacity(PIECE, (&*file).take(content)), &mut found)?;
    let (mut stated, mut checksum) = ([0; 8], [0; 4]);
    file.read_exact(&mut stated)?;
    file.read_exact(&mut checksum)?;
    found.write_all(&stated)?;
    if u64::from_le_bytes(stated) != content {
        return Ok(Err("its end is missing"));
    }
    Ok(if checksum == found.checksum().to_le_bytes() { Ok(head) } else { Err("its checksum is wrong") })
}

/// Reads the content of a checkpoint, without memory for more than what is made of it.
///
/// # Errors
/// [`CheckpointError`] if there is none, if another version wrote it, or if a single bit of it has changed.
pub(crate) fn read_content<T: DeserializeOwned>(path: &Path) -> Result<T, CheckpointError> {
    let unreadable = |source| CheckpointError::unreadable(path, source);
    let mut file = File::open(path).map_err(unreadable)?;
    let damaged = |why: String| CheckpointError::Damaged { path: path.to_owned(), why };
    let found = sound_head(&mut file).map_err(unreadable)?.map_err(|why| damaged(why.to_owned()))?;
    if found != head() {
        let (version, sources) = found[MAGIC.len()..].split_at(VERSION);
        let version = String::from_utf8_lossy(version).trim_end_matches('\0').to_owned();
        let sources = sources.iter().rev().map(|byte| format!("{byte:02x}")).collect::<String>();
        let found = format!("{version} ({sources})");
        return Err(CheckpointError::OtherVersion { path: path.to_owned(), found, here: FINGERPRINT });
    }
    file.seek(SeekFrom::Start(HEAD as u64)).map_err(unreadable)?;
    let reader = BufReader::with_capacity(PIECE, file);
    match postcard::from_io::<T, _>((reader, &mut vec![0; LONGEST_TEXT])) {
        Ok((content, _)) => Ok(content),
        Err(error) => Err(damaged(error.to_string())),
    }
}

impl Checkpoint {
    /// Reads a checkpoint, without memory for more than what is made of it.
    ///
    /// # Errors
    /// [`CheckpointError`] if there is none, if another version wrote it, or if a single bit of it has changed.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let checkpoint: Self = read_content(path)?;
        checkpoint.simulation.enlarge();
        Ok(checkpoint)
    }

    /// The checksum that a checkpoint ends with, of all that stands before; that of the whole file is the same for all.
    pub(crate) fn stated_checksum(path: &Path) -> Result<u32, CheckpointError> {
        let unreadable = |source| CheckpointError::unreadable(path, source);
        let mut file = File::open(path).map_err(unreadable)?;
        let mut checksum = [0; 4];
        file.seek(SeekFrom::End(-4)).and_then(|_| file.read_exact(&mut checksum)).map_err(unreadable)?;
        Ok(u32::from_le_bytes(checksum))
    }

    /// Whether the run has come to an end that its scene asks for, or to that of all events.
    pub(crate) fn has_ended(&self) -> bool {
        self.state.has_ended(&self.simulation)
    }

    /// Goes on to the end of its last stage, of which the last checkpoint of a run may be short by a rounding of the time of a row.
    ///
    /// # Errors
    /// If the simulation cannot go on.
    pub(crate) fn go_to_end(&mut self) -> Result<(), EngineError> {
        match self.state.rest_of_stage(&self.simulation) {
            Some((end, left)) if left > 0.0 => self.simulation.advance(Until::time(end)).map(|_| ()),
            _ => Ok(()),
        }
    }

    /// Whether a file begins like a checkpoint.
    pub(crate) fn is_one(path: &Path) -> bool {
        let mut magic = [0; MAGIC.len()];
        // A pipe would be waited for.
        path.is_file() && File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok() && magic == *MAGIC
    }

    /// Refuses an end of the measurement that it is beyond, so that no scene names an end that was none.
    ///
    /// # Errors
    /// [`CheckpointError::Passed`].
    pub(crate) fn refuse_passed(&self, limit: Limit) -> Result<(), CheckpointError> {
        let Some((time, events)) = self.state.measured_so_far(&self.simulation) else { return Ok(()) };
        let is_later = |asked: &f64| time - asked > NEAR * asked + f64::EPSILON * self.simulation.time();
        let passed = match (limit.time.filter(is_later), limit.events.filter(|asked| events > *asked)) {
            (Some(asked), _) => Some((format!("a time of {time}"), format!("a time of {asked}"))),
            (None, Some(asked)) => Some((format!("{events} events"), format!("{asked} events"))),
            (None, None) => None,
        };
        let Some((measured, asked)) = passed else { return Ok(()) };
        Err(CheckpointError::Passed { time: self.simulation.time(), measured, asked })
    }

    /// Gives the measurement another end; one that was reached before ends it at once.
    pub fn extend(&mut self, limit: Limit) {
        self.simulation.set_limit(limit);
        self.state.extend(limit);
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use crate::model::potential::Potential;
    use crate::scene::{Amount, Lattice, SceneBuilder};

    #[test]
    fn a_full_disk_is_told_as_such() {
        let scene = SceneBuilder::new("full")
            .species("A", 1.0, 1.0)
            .interaction("A", "A", Potential::hard_sphere(1.0).unwrap(), 1.0)
            // Some megabytes, more than any buffer on the way.
            .fill(Lattice::FaceCentredCubic, "A", 10_976, Amount::PackingFraction(0.3))
            .run(crate::model::RunPlan { limit: Limit::events(1), ..Default::default() })
            .build()
            .unwrap();
        let simulation = Simulation::without_plan(scene);
        let state = RunState::new(&simulation);
        let full = File::options().write(true).open("/dev/full").unwrap();
        let content: Content = (&simulation, &state, &Manifest { scene: None, files: Vec::new() });
        let error = write(&full, &content).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::StorageFull);
    }
}
