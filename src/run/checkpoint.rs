//! Checkpoints: files from which a run continues as if it had not been interrupted, bit for bit.
//!
//! | bytes | content |
//! |---|---|
//! | 16 | `carom checkpoint`, or `carom simulation` for a simulation without a run |
//! | 12 | version of carom that wrote the file, padded with zeros |
//! | 8 | fingerprint of the sources of that build, little endian |
//! | n | scene, engine, run state, lengths and checksums of the output files (`postcard`, all bits of every number) |
//! | 8 | n, little endian |
//! | 4 | CRC-32 of all previous bytes, little endian |
//!
//! A checkpoint can only be read by a program with the same fingerprint. Another program may store the state
//! differently, or round differently. The fingerprint is computed at build time from `Cargo.lock` and all sources,
//! except sources that only report on runs. Checksums (CRC-32) show whether the output files match the checkpoint.

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
use crate::engine::{EngineError, Simulation};
use crate::model::Until;
use crate::run::RunState;

/// Relative tolerance for equal times.
const NEAR: f64 = 1e-9;

/// A checkpoint, from which a run continues as if it had not been interrupted, bit for bit.
#[derive(Debug, Deserialize)]
pub struct Checkpoint {
    /// The simulation at the time of the checkpoint.
    pub simulation: Simulation,
    /// State of the run besides the simulation.
    pub state: RunState,
    /// Output files of the run.
    pub manifest: Manifest,
}

pub(crate) type Content<'a> = (&'a Simulation, &'a RunState, &'a Manifest);

pub(crate) fn write(file: &File, content: &impl Serialize) -> io::Result<()> {
    write_sealed(file, Kind::Checkpoint, content)?;
    durability::sync_all(file)
}

pub(crate) fn read_content<T: DeserializeOwned>(path: &Path) -> Result<T, CheckpointError> {
    let read = File::open(path).and_then(|file| read_sealed(file, Kind::Checkpoint));
    read.map_err(|source| CheckpointError::unreadable(path, source))?.map_err(|flaw| match flaw {
        Flaw::Damaged(why) => CheckpointError::Damaged { path: path.to_owned(), why },
        Flaw::OtherVersion { found, here } => CheckpointError::OtherVersion { path: path.to_owned(), found, here },
    })
}

impl Checkpoint {
    /// Reads a checkpoint.
    ///
    /// # Errors
    /// [`CheckpointError`] if the file does not exist, was written by another version, or is damaged.
    pub fn read(path: &Path) -> Result<Self, CheckpointError> {
        let checkpoint: Self = read_content(path)?;
        if let Some(what) = checkpoint.simulation.unsound_index() {
            return Err(CheckpointError::Damaged { path: path.to_owned(), why: format!("inconsistent data: {what}") });
        }
        checkpoint.simulation.enlarge();
        Ok(checkpoint)
    }

    /// Reads the checksum at the end of a checkpoint. The CRC-32 of the whole file, including this checksum, would be
    /// the same for all checkpoints.
    pub(crate) fn stated_checksum(path: &Path) -> Result<u32, CheckpointError> {
        let unreadable = |source| CheckpointError::unreadable(path, source);
        let mut file = File::open(path).map_err(unreadable)?;
        let mut checksum = [0; 4];
        file.seek(SeekFrom::End(-4)).and_then(|_| file.read_exact(&mut checksum)).map_err(unreadable)?;
        Ok(u32::from_le_bytes(checksum))
    }

    pub(crate) fn has_ended(&self) -> bool {
        self.state.has_ended(&self.simulation)
    }

    /// Advances the simulation to the exact end of the last stage. The last checkpoint may be slightly earlier.
    pub(crate) fn go_to_end(&mut self) -> Result<(), EngineError> {
        match self.state.rest_of_stage(&self.simulation) {
            Some((end, left)) if left > 0.0 => self.simulation.advance(Until::time(end)).map(|_| ()),
            _ => Ok(()),
        }
    }

    pub(crate) fn is_one(path: &Path) -> bool {
        Kind::Checkpoint.is_that_of(path)
    }

    pub(crate) fn refuse_passed(&self, limit: Until) -> Result<(), CheckpointError> {
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

    /// Sets a new limit of the measurement. A limit that has already been reached ends the measurement at once.
    pub fn extend(&mut self, limit: Until) {
        self.simulation.set_limit(limit);
        self.state.extend(limit);
    }
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    #[test]
    fn full_disk_is_reported_as_such() {
        let scene = SceneBuilder::new("full")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            // The checkpoint is larger than any buffer.
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(10_976).packing_fraction(0.3))
            .run(crate::model::RunPlan { limit: Until::events(1), ..Default::default() })
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
