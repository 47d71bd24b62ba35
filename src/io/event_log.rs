//! Log of all events as NumPy arrays in the folder `events`. The values are exact. Events are in the order of time.
//!
//! | file | kind | content |
//! |---|---|---|
//! | `time.npy` | `f64` | simulated time |
//! | `kind.npy` | `u8` | 0 core, 1 capture, 2 release, 3 bounce, 4 to 9 walls -x, +x, -y, +y, -z, +z, 10 thermostat, 11 another surface, 12 exit, 13 entry, 14 rest, 15 wake |
//! | `particle.npy` | `u32` | id of the particle |
//! | `partner.npy` | `i64` | id of the other particle; -1 if there is none |
//! | `positions.npy` | `f64` x 2 x 3 | positions of particle and partner, inside the box; 0 without a partner |
//! | `velocities_before.npy`, `velocities_after.npy` | `f64` x 2 x 3 | velocities of particle and partner |
//! | `energy_step.npy` | `f64` | potential energy gained; for a surface or a thermostat, the energy that it supplied |
//! | `dissipated.npy` | `f64` | kinetic energy lost in an inelastic contact; negative if the TC model lifts a particle at rest |
//!
//! Numbers are little-endian. An event has 181 bytes.

use std::fs;
use std::path::Path;

use super::error::OutputError;
use super::npy::array::{HEADER_SIZE, header};
use super::partial::PartialFile;
use crate::Vector;
use crate::base::numbers::index;
use crate::engine::event::Event;
use crate::run::checkpoint::{CheckpointError, Manifest, ManifestEntry};

pub(super) const FOLDER: &str = "events";

/// A column of the log: name of its file, NumPy type, shape of an entry, and bytes per entry.
type Kind = (&'static str, &'static str, &'static [usize], u64);

const COLUMNS: [Kind; 9] = [
    ("time.npy", "<f8", &[], 8),
    ("kind.npy", "|u1", &[], 1),
    ("particle.npy", "<u4", &[], 4),
    ("partner.npy", "<i8", &[], 8),
    ("positions.npy", "<f8", &[2, 3], 48),
    ("velocities_before.npy", "<f8", &[2, 3], 48),
    ("velocities_after.npy", "<f8", &[2, 3], 48),
    ("energy_step.npy", "<f8", &[], 8),
    ("dissipated.npy", "<f8", &[], 8),
];

/// Number of events in the buffer of 0.7 MB.
const GATHERED: usize = 4096;

pub(super) fn bytes_of_event() -> f64 {
    COLUMNS.iter().map(|(.., size)| *size as f64).sum()
}

#[derive(Debug)]
pub(super) struct EventLog {
    columns: Vec<PartialFile>,
    gathered: [Vec<u8>; COLUMNS.len()],
}

impl EventLog {
    pub fn create(run: &Path) -> Result<Self, OutputError> {
        let folder = run.join(FOLDER);
        fs::create_dir_all(&folder).map_err(|source| OutputError::Folder { path: folder.clone(), source })?;
        let column = |(name, kind, shape, _): &Kind| {
            let mut file = PartialFile::create(folder.join(name))?;
            file.write_head(&header(kind, shape, 0))?;
            Ok(file)
        };
        Ok(Self::of(COLUMNS.iter().map(column).collect::<Result<_, OutputError>>()?))
    }

    pub fn resume(run: &Path, manifest: &Manifest) -> Result<Self, OutputError> {
        let column = |(name, ..): &Kind| {
            let (name, path) = (format!("{FOLDER}/{name}"), run.join(FOLDER).join(name));
            let Some(entry) = manifest.files.iter().find(|entry| Path::new(&entry.name) == Path::new(&name)) else {
                return Err(CheckpointError::File { path, found: 0, expected: HEADER_SIZE as u64 }.into());
            };
            PartialFile::resume(path, entry)
        };
        Ok(Self::of(COLUMNS.iter().map(column).collect::<Result<_, _>>()?))
    }

    fn of(columns: Vec<PartialFile>) -> Self {
        Self { columns, gathered: COLUMNS.map(|(.., size)| Vec::with_capacity(GATHERED * index(size))) }
    }

    #[inline]
    pub fn add(&mut self, event: &Event) -> Result<(), OutputError> {
        let partner = event.partner().map_or(-1, |partner| i64::from(partner.0));
        let [time, kind, particle, partners, positions, before, after, energy_step, dissipated] = &mut self.gathered;
        kind.push(event.code());
        particle.extend_from_slice(&event.particle.0.to_le_bytes());
        partners.extend_from_slice(&partner.to_le_bytes());
        for (column, number) in [(time, event.time), (energy_step, event.energy_step), (dissipated, event.dissipated)] {
            column.extend_from_slice(&number.to_le_bytes());
        }
        for (column, vectors) in [(positions, &event.positions), (before, &event.before), (after, &event.after)] {
            column.extend_from_slice(&bytes(vectors));
        }
        if kind.len() < GATHERED { Ok(()) } else { self.hand_on() }
    }

    fn hand_on(&mut self) -> Result<(), OutputError> {
        for (column, entries) in self.columns.iter_mut().zip(&mut self.gathered) {
            column.write_bytes(entries)?;
            entries.clear();
        }
        Ok(())
    }

    pub fn length(&self) -> u64 {
        let gathered = self.gathered.iter().map(|entries| entries.len() as u64);
        self.columns.iter().map(PartialFile::length).chain(gathered).sum()
    }

    pub fn keep(&mut self, run: &Path) -> Result<Vec<ManifestEntry>, OutputError> {
        self.hand_on()?;
        self.columns.iter_mut().map(|column| column.keep(run)).collect()
    }

    /// Writes the final number of entries into the header of each column, and returns the files.
    pub fn finish(mut self) -> Result<Vec<PartialFile>, OutputError> {
        self.hand_on()?;
        for (column, (_, kind, shape, size)) in self.columns.iter_mut().zip(&COLUMNS) {
            let entries = (column.length() - HEADER_SIZE as u64) / size;
            column.replace_head(&header(kind, shape, index(entries)))?;
        }
        Ok(self.columns)
    }
}

fn bytes(vectors: &[Vector; 2]) -> [u8; 48] {
    let mut bytes = [0; 48];
    for (to, x) in bytes.chunks_exact_mut(8).zip(vectors.iter().flatten()) {
        to.copy_from_slice(&x.to_le_bytes());
    }
    bytes
}

pub(super) fn names() -> impl Iterator<Item = String> {
    COLUMNS.iter().map(|(name, ..)| format!("{FOLDER}/{name}"))
}
