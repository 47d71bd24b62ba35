//! Which species have a row in the tables of the event loop.

use serde::{Deserialize, Serialize};

use crate::model::{Scene, SpeciesId};

/// With more species than this, only species with particles have a row. The tables are square, and are read for every
/// pair.
const FEW: usize = 256;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rows {
    /// The species of each row. If grains may sleep, each species has a second row, for its sleeping particles. The
    /// second rows follow the first rows in the same order.
    species: Vec<SpeciesId>,
    /// Number of rows for particles that are awake.
    awake: u16,
    /// The table row of each species; 0 for species without a row.
    rows: Vec<u16>,
}

impl Rows {
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let count = scene.species.len();
        let has_row = if count <= FEW { vec![true; count] } else { scene.occurring_species() };
        let mut species: Vec<_> =
            (0..).zip(&has_row).filter(|(_, has_row)| **has_row).map(|(id, _)| SpeciesId(id)).collect();
        let mut rows = vec![0; count];
        // Row numbers cannot overflow, because scenes with more rows were rejected.
        for (row, species) in (0..=u16::MAX).zip(&species) {
            rows[species.0 as usize] = row;
        }
        let awake = u16::try_from(species.len()).unwrap_or(u16::MAX);
        if scene.sleep.is_some() {
            species.extend_from_within(..);
        }
        Self { species, awake, rows }
    }

    /// The row of the sleeping particles of the same species.
    #[must_use]
    pub fn asleep(&self, row: u16) -> u16 {
        row + self.awake
    }

    /// Whether a row is for sleeping particles.
    #[must_use]
    pub fn is_asleep(&self, row: u16) -> bool {
        row >= self.awake && self.has_sleep()
    }

    /// The row of particles of the same species that are awake.
    #[must_use]
    pub fn awake(&self, row: u16) -> u16 {
        if self.is_asleep(row) { row - self.awake } else { row }
    }

    /// Whether sleeping particles have rows.
    #[must_use]
    pub fn has_sleep(&self) -> bool {
        self.species.len() > usize::from(self.awake)
    }

    #[must_use]
    pub fn row(&self, species: SpeciesId) -> u16 {
        self.rows[species.0 as usize]
    }

    #[must_use]
    pub fn has_row(&self, species: SpeciesId) -> bool {
        self.species[..usize::from(self.awake)].binary_search(&species).is_ok()
    }

    #[must_use]
    pub fn are_sound(&self) -> bool {
        let awake = usize::from(self.awake);
        (self.species.len() == awake || self.species.len() == 2 * awake)
            && self.rows.iter().all(|row| usize::from(*row) < awake.max(1))
    }

    #[must_use]
    pub fn species(&self) -> &[SpeciesId] {
        &self.species
    }
}
