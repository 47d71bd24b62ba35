//! Which species have a row in the tables of the event loop.

use serde::{Deserialize, Serialize};

use crate::model::{Scene, SpeciesId};

/// With more species than this, only species with particles have a row. The tables are square, and are read for every
/// pair.
const FEW: usize = 256;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rows {
    species: Vec<SpeciesId>,
    /// The table row of each species; 0 for species without a row.
    rows: Vec<u16>,
}

impl Rows {
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let count = scene.species.len();
        let has_row = if count <= FEW { vec![true; count] } else { scene.occurring_species() };
        let species: Vec<_> =
            (0..).zip(&has_row).filter(|(_, has_row)| **has_row).map(|(id, _)| SpeciesId(id)).collect();
        let mut rows = vec![0; count];
        // Row numbers cannot overflow, because scenes with more rows were rejected.
        for (row, species) in (0..=u16::MAX).zip(&species) {
            rows[species.0 as usize] = row;
        }
        Self { species, rows }
    }

    #[must_use]
    pub fn row(&self, species: SpeciesId) -> u16 {
        self.rows[species.0 as usize]
    }

    #[must_use]
    pub fn has_row(&self, species: SpeciesId) -> bool {
        self.species.binary_search(&species).is_ok()
    }

    #[must_use]
    pub fn are_sound(&self) -> bool {
        self.rows.iter().all(|row| usize::from(*row) < self.species.len().max(1))
    }

    #[must_use]
    pub fn species(&self) -> &[SpeciesId] {
        &self.species
    }
}
