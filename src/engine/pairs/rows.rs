//! The species that have rows in the tables of the event loop.

use serde::{Deserialize, Serialize};

use crate::model::{Scene, SpeciesId};

/// If there are at most this many species, each has a row. If there are more, only species with particles
/// have a row, because the tables are square and read for every pair.
const FEW: usize = 256;

/// The species in the square tables: all species if they are few, otherwise only species with particles.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rows {
    /// The species of each row.
    species: Vec<SpeciesId>,
    /// The row of each species; 0 for species without a row, which have no particles.
    rows: Vec<u16>,
}

impl Rows {
    /// Rows of the species of a scene.
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let count = scene.species.len();
        let mut has_row = vec![count <= FEW; count];
        for particle in &scene.particles {
            has_row[particle.species.0 as usize] = true;
        }
        let species: Vec<_> =
            (0..).zip(&has_row).filter(|(_, has_row)| **has_row).map(|(id, _)| SpeciesId(id)).collect();
        let mut rows = vec![0; count];
        // A scene with more rows was rejected.
        for (row, species) in (0..=u16::MAX).zip(&species) {
            rows[species.0 as usize] = row;
        }
        Self { species, rows }
    }

    /// The row of a species that has particles.
    #[must_use]
    pub fn row(&self, species: SpeciesId) -> u16 {
        self.rows[species.0 as usize]
    }

    /// Whether the row of each species exists.
    #[must_use]
    pub fn are_sound(&self) -> bool {
        self.rows.iter().all(|row| usize::from(*row) < self.species.len().max(1))
    }

    /// The species, by row.
    #[must_use]
    pub fn species(&self) -> &[SpeciesId] {
        &self.species
    }
}
