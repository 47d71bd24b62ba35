//! Saves and loads simulations with their exact state, in the format of checkpoints.

use std::fs::File;
use std::io::{self, Cursor, Read, Seek, Write};
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use super::atomic::{Existing, write_atomically};
use super::error::cure_of;
use crate::engine::Simulation;
use crate::run::checkpoint::{Flaw, Kind, read_sealed, write_sealed};

/// Error of saving or loading a simulation.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SavedError {
    /// Something other than a saved simulation exists at the path.
    #[error("{} exists and is not a saved simulation", .0.display())]
    Exists(PathBuf),
    /// The file cannot be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
    /// The file is damaged, or is not a saved simulation.
    #[error("{name} is not a saved simulation, or is damaged: {why}")]
    Damaged {
        /// Name of the file.
        name: String,
        /// Description of the damage.
        why: String,
    },
    /// Another version or build of Carom wrote the file.
    #[error("carom {found} wrote {name}, and this is carom {} ({here}), which may continue differently", env!("CARGO_PKG_VERSION"))]
    OtherVersion {
        /// Name of the file.
        name: String,
        /// Version that wrote the file, with a fingerprint of its source code.
        found: String,
        /// Fingerprint of the source code of the running program.
        here: &'static str,
    },
}

impl SavedError {
    /// Returns a suggestion for the user.
    #[must_use]
    pub fn cure(&self) -> &'static str {
        match self {
            Self::Exists(_) => "choose another path, or replace it with --force",
            Self::Write { source, .. } => cure_of(source),
            Self::Read { .. } => "give the path of a saved simulation that can be read",
            Self::Damaged { .. } => "save the simulation again",
            Self::OtherVersion { .. } => "load it with the version that saved it, or begin the simulation again",
        }
    }
}

/// Saves a simulation and data of the calling program. After [`load_simulation`], a run gives exactly the same results.
///
/// An existing saved simulation is replaced. Any other file is replaced only if `existing` permits.
///
/// ```
/// use carom::engine::{Simulation, Until};
/// use carom::io::{Existing, load_simulation, save_simulation};
/// # use carom::model::Scene;
///
/// # let directory = tempfile::tempdir()?;
/// # let path = directory.path().join("fluid.carom");
/// # let scene = Scene::from_file("configs/hard_sphere_fluid.toml")?;
/// let mut simulation = Simulation::without_plan(scene);
/// simulation.advance(Until::events(500))?;
/// save_simulation(&path, &simulation, &"a note", Existing::Keep)?;
/// let (mut again, note) = load_simulation::<String>(&path)?;
/// for simulation in [&mut simulation, &mut again] {
///     simulation.advance(Until::events(1_000))?;
/// }
/// assert_eq!((again.snapshot(), note.as_str()), (simulation.snapshot(), "a note"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`SavedError::Exists`] and [`SavedError::Write`]. Both errors leave an existing file unchanged.
pub fn save_simulation(
    path: &Path,
    simulation: &Simulation,
    beside: &impl Serialize,
    existing: Existing,
) -> Result<(), SavedError> {
    let existing = if Kind::Simulation.is_that_of(path) { Existing::Replace } else { existing };
    let write = |file: &mut dyn Write| write_sealed(file, Kind::Simulation, &(simulation, beside));
    write_atomically(path, existing, write).map_err(|source| match source.kind() {
        io::ErrorKind::AlreadyExists => SavedError::Exists(path.to_owned()),
        _ => SavedError::Write { path: path.to_owned(), source },
    })
}

/// Loads a simulation and its data. The simulation runs on one thread unless [`Simulation::set_threads`] is called.
///
/// # Errors
/// [`SavedError`] if the file does not exist, is damaged, or was written by another version.
pub fn load_simulation<T: DeserializeOwned>(path: &Path) -> Result<(Simulation, T), SavedError> {
    let unreadable = |source| SavedError::Read { path: path.to_owned(), source };
    // Opening a pipe would block.
    if path.exists() && !path.is_file() {
        return Err(unreadable(io::Error::new(io::ErrorKind::InvalidInput, "not a plain file")));
    }
    let file = File::open(path).map_err(unreadable)?;
    read(file, &path.display().to_string()).map_err(unreadable)?
}

/// Returns the bytes that [`save_simulation`] writes.
///
/// # Errors
/// If the simulation or the data cannot be serialized.
pub fn simulation_to_bytes(simulation: &Simulation, beside: &impl Serialize) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_sealed(&mut bytes, Kind::Simulation, &(simulation, beside))?;
    Ok(bytes)
}

/// Restores the simulation and the data from the bytes of [`simulation_to_bytes`].
///
/// # Errors
/// The errors of [`load_simulation`].
pub fn simulation_from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<(Simulation, T), SavedError> {
    let name = "what was pickled";
    read(Cursor::new(bytes), name)
        .unwrap_or_else(|error| Err(SavedError::Damaged { name: name.to_owned(), why: error.to_string() }))
}

fn read<T: DeserializeOwned>(input: impl Read + Seek, name: &str) -> io::Result<Result<(Simulation, T), SavedError>> {
    let name = name.to_owned();
    let found = match read_sealed::<(Simulation, T)>(input, Kind::Simulation)? {
        Ok((simulation, beside)) => match simulation.unsound_index() {
            None => Ok((simulation, beside)),
            Some(what) => Err(SavedError::Damaged { name, why: format!("inconsistent data: {what}") }),
        },
        Err(Flaw::Damaged(why)) => Err(SavedError::Damaged { name, why }),
        Err(Flaw::OtherVersion { found, here }) => Err(SavedError::OtherVersion { name, found, here }),
    };
    if let Ok((simulation, _)) = &found {
        simulation.enlarge();
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    fn saved() -> Vec<u8> {
        let scene = SceneBuilder::new("saved")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(32).packing_fraction(0.3))
            .run(crate::model::RunPlan { limit: crate::model::Until::events(1), ..Default::default() })
            .build()
            .unwrap();
        simulation_to_bytes(&Simulation::without_plan(scene), &7_u8).unwrap()
    }

    #[test]
    fn every_changed_bit_and_every_missing_byte_is_found() {
        let good = saved();
        assert_eq!(simulation_from_bytes::<u8>(&good).unwrap().1, 7);
        for at in (0..good.len()).step_by(97).chain(good.len() - 12..good.len()) {
            let mut bad = good.clone();
            bad[at] ^= 1 << (at % 8);
            let error = simulation_from_bytes::<u8>(&bad).unwrap_err();
            assert!(matches!(error, SavedError::Damaged { .. }), "{at}: {error}");
            assert!(simulation_from_bytes::<u8>(&good[..at]).is_err(), "{at}");
        }
    }

    #[test]
    fn foreign_file_is_neither_loaded_nor_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("notes.txt");
        std::fs::write(&path, "notes of mine, which are longer than the first bytes of a file").unwrap();
        assert!(matches!(load_simulation::<u8>(&path), Err(SavedError::Damaged { .. })));
        let (simulation, _) = simulation_from_bytes::<u8>(&saved()).unwrap();
        let refused = save_simulation(&path, &simulation, &1_u8, Existing::Keep);
        assert!(matches!(refused, Err(SavedError::Exists(_))));
        assert!(std::fs::read_to_string(&path).unwrap().starts_with("notes"));
        save_simulation(&path, &simulation, &1_u8, Existing::Replace).unwrap();
        // `Existing::Keep` does not protect saved simulations.
        save_simulation(&path, &simulation, &2_u8, Existing::Keep).unwrap();
        assert_eq!(load_simulation::<u8>(&path).unwrap().1, 2);
        assert!(matches!(load_simulation::<u8>(folder.path()), Err(SavedError::Read { .. })));
        assert!(matches!(load_simulation::<u8>(&folder.path().join("none")), Err(SavedError::Read { .. })));
    }

    #[test]
    fn file_of_another_version_is_rejected() {
        let mut other = saved();
        other[28] ^= 1;
        let content = other.len() - 4;
        let checksum = crc32fast::hash(&other[..content]).to_le_bytes();
        other[content..].copy_from_slice(&checksum);
        assert!(matches!(simulation_from_bytes::<u8>(&other), Err(SavedError::OtherVersion { .. })));
    }
}
