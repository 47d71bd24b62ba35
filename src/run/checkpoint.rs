//! Checkpoints: everything that a run needs to continue with the same bits, in one file.
//!
//! | bytes | content |
//! |---|---|
//! | 16 | `carom checkpoint`; for a simulation alone, `carom simulation` |
//! | 12 | the version of carom that wrote it, padded with zeros |
//! | 8 | the fingerprint of the sources of that build, little endian |
//! | n | scene, engine and state of the run, lengths and checksums of its files (postcard, with all bits of every number) |
//! | 8 | n, little endian |
//! | 4 | CRC-32 of everything before, little endian |
//!
//! A checkpoint can only be read by a program of the same sources and dependencies. Another program may store
//! the state differently, or round differently, and would not continue with the same bits. The fingerprint is
//! computed at build time from `Cargo.lock` and all sources, except sources that only report on runs. The
//! files of a run belong to its checkpoint by their checksums (CRC-32). Files of other runs are rejected.

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

/// Checkpoint of a run: everything needed to continue with the same bits.
#[derive(Debug, Deserialize)]
pub struct Checkpoint {
    /// The simulation in its state at the checkpoint.
    pub simulation: Simulation,
    /// Progress of the run.
    pub state: RunState,
    /// Its files.
    pub manifest: Manifest,
}

/// Content of a [`Checkpoint`] for writing, field by field.
pub(crate) type Content<'a> = (&'a Simulation, &'a RunState, &'a Manifest);

/// Writes any content in the format of a checkpoint, and syncs it to disk.
///
/// # Errors
/// If it cannot be written.
pub(crate) fn write(file: &File, content: &impl Serialize) -> io::Result<()> {
    write_sealed(file, Kind::Checkpoint, content)?;
    durability::sync_all(file)
}

/// Reads the content of a checkpoint, without memory for anything but the result.
///
/// # Errors
/// [`CheckpointError`] if it does not exist, was written by another version, or has a changed bit.
pub(crate) fn read_content<T: DeserializeOwned>(path: &Path) -> Result<T, CheckpointError> {
    let read = File::open(path).and_then(|file| read_sealed(file, Kind::Checkpoint));
    read.map_err(|source| CheckpointError::unreadable(path, source))?.map_err(|flaw| match flaw {
        Flaw::Damaged(why) => CheckpointError::Damaged { path: path.to_owned(), why },
        Flaw::OtherVersion { found, here } => CheckpointError::OtherVersion { path: path.to_owned(), found, here },
    })
}

impl Checkpoint {
    /// Reads a checkpoint, without memory for anything but the result.
    ///
    /// # Errors
    /// [`CheckpointError`] if it does not exist, was written by another version, or has a changed bit.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let checkpoint: Self = read_content(path)?;
        if let Some(what) = checkpoint.simulation.unsound_index() {
            return Err(CheckpointError::Damaged { path: path.to_owned(), why: format!("inconsistent data: {what}") });
        }
        checkpoint.simulation.enlarge();
        Ok(checkpoint)
    }

    /// The checksum at the end of a checkpoint, of everything before. The checksum of the whole file would be
    /// the same for all checkpoints.
    pub(crate) fn stated_checksum(path: &Path) -> Result<u32, CheckpointError> {
        let unreadable = |source| CheckpointError::unreadable(path, source);
        let mut file = File::open(path).map_err(unreadable)?;
        let mut checksum = [0; 4];
        file.seek(SeekFrom::End(-4)).and_then(|_| file.read_exact(&mut checksum)).map_err(unreadable)?;
        Ok(u32::from_le_bytes(checksum))
    }

    /// Whether the run has reached an end that its scene specifies, or has no further events.
    pub(crate) fn has_ended(&self) -> bool {
        self.state.has_ended(&self.simulation)
    }

    /// Continues to the end of the last stage. The last checkpoint may be slightly before it, by the rounding
    /// of the time of a row.
    ///
    /// # Errors
    /// If the simulation cannot continue.
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

    /// Rejects an end of the measurement that has already passed. Otherwise a scene could specify an end at
    /// which its run did not end.
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

    /// Sets another end of the measurement. If it has already been reached, the measurement ends at once.
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
            // Some megabytes, more than any buffer involved.
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
