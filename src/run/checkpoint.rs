//! Checkpoints: all that a run needs to go on with the same bits, in one file.
//!
//! | bytes | content |
//! |---|---|
//! | 16 | `carom checkpoint`; of a simulation alone, `carom simulation` |
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
mod sealed;

pub(crate) use checked::Checked;
pub use error::CheckpointError;
pub use manifest::{Manifest, ManifestEntry};
pub(crate) use sealed::{Flaw, Kind, read_sealed, write_sealed};

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::base::durability;
use crate::engine::{EngineError, Simulation, Until};
use crate::model::Limit;
use crate::run::RunState;

/// Relative round-off of a time.
const NEAR: f64 = 1e-9;

/// Checkpoint of a run: all that it needs to go on with the same bits.
#[derive(Debug, Deserialize)]
pub struct Checkpoint {
    /// The simulation as it was.
    pub simulation: Simulation,
    /// Progress of the run.
    pub state: RunState,
    /// Its files.
    pub manifest: Manifest,
}

/// Content of a [`Checkpoint`] to be written, field by field.
pub(crate) type Content<'a> = (&'a Simulation, &'a RunState, &'a Manifest);

/// Writes any content in the form of a checkpoint, and makes it safe on the disk.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(file: &File, content: &impl Serialize) -> io::Result<()> {
    write_sealed(file, Kind::Checkpoint, content)?;
    durability::sync_all(file)
}

/// Reads the content of a checkpoint, without memory for more than what is made of it.
///
/// # Errors
/// [`CheckpointError`] if there is none, if another version wrote it, or if a single bit of it has changed.
pub(crate) fn read_content<T: DeserializeOwned>(path: &Path) -> Result<T, CheckpointError> {
    let read = File::open(path).and_then(|file| read_sealed(file, Kind::Checkpoint));
    read.map_err(|source| CheckpointError::unreadable(path, source))?.map_err(|flaw| match flaw {
        Flaw::Damaged(why) => CheckpointError::Damaged { path: path.to_owned(), why },
        Flaw::OtherVersion { found, here } => CheckpointError::OtherVersion { path: path.to_owned(), found, here },
    })
}

impl Checkpoint {
    /// Reads a checkpoint, without memory for more than what is made of it.
    ///
    /// # Errors
    /// [`CheckpointError`] if there is none, if another version wrote it, or if a single bit of it has changed.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let checkpoint: Self = read_content(path)?;
        if let Some(what) = checkpoint.simulation.unsound_index() {
            return Err(CheckpointError::Damaged { path: path.to_owned(), why: format!("{what} of it cannot be") });
        }
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

    /// Continues to the end of the last stage. The last checkpoint may be short of it by the rounding of the time of a row.
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
        Kind::Checkpoint.is_that_of(path)
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
