//! The rows of the tables of the event loop: species, and ranges of diameters of a species.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::model::diameters::Diameters;
use crate::model::{Particle, Scene, SpeciesId};

/// With more species than this, only species with particles have a row. The tables are square, and are read for every
/// pair.
const FEW: usize = 256;

/// Diameters in a row of a species with individual diameters differ by at most this factor, unless the species needs more
/// than [`MOST_BANDS`] rows. The neighbour search uses the largest diameter of a row.
const ALIKE: f64 = 1.12;

/// Largest number of rows of a species.
const MOST_BANDS: i32 = 48;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Rows {
    /// The species of each row. If grains may sleep, each species has a second row, for its sleeping particles. The
    /// second rows follow the first rows in the same order. A species with individual diameters has several rows, from
    /// small to large particles.
    species: Vec<SpeciesId>,
    /// The largest radius of the particles of each row `[length]`.
    radii: Vec<f64>,
    /// The range of diameters of each species.
    diameters: Vec<Diameters>,
    /// Number of rows for particles that are awake.
    awake: u16,
    /// The first table row of each species; 0 for species without a row.
    rows: Vec<u16>,
}

impl Rows {
    #[must_use]
    pub fn of(scene: &Scene) -> Self {
        let count = scene.species.len();
        let has_row = if count <= FEW { vec![true; count] } else { scene.occurring_species() };
        let ranges = scene.diameters_of_species();
        let (mut species, mut radii) = (Vec::new(), Vec::new());
        let mut rows = vec![0; count];
        for id in (0..).zip(&has_row).filter(|(_, has_row)| **has_row).map(|(id, _)| SpeciesId(id)) {
            // Row numbers cannot overflow, because scenes with too many rows were rejected.
            rows[id.0 as usize] = u16::try_from(species.len()).unwrap_or(u16::MAX);
            for radius in bands(&ranges[id.0 as usize]) {
                species.push(id);
                radii.push(radius);
            }
        }
        let awake = u16::try_from(species.len()).unwrap_or(u16::MAX);
        if scene.sleep.is_some() {
            species.extend_from_within(..);
            radii.extend_from_within(..);
        }
        Self { species, radii, diameters: ranges, awake, rows }
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

    /// The first row of a species.
    #[must_use]
    pub fn row(&self, species: SpeciesId) -> u16 {
        self.rows[species.0 as usize]
    }

    /// The row of a particle that is awake. A particle that is larger than all others of its species has the last row.
    #[must_use]
    pub fn row_of(&self, particle: &Particle) -> u16 {
        let first = self.row(particle.species);
        let Some(diameter) = particle.diameter else { return first };
        let all = usize::from(first)..usize::from(self.awake);
        let own = self.species[all.clone()].partition_point(|species| *species == particle.species);
        let smaller = self.radii[all][..own].partition_point(|radius| *radius < 0.5 * diameter);
        first + u16::try_from(smaller.min(own.saturating_sub(1))).unwrap_or(0)
    }

    /// The smallest and the largest diameter of the particles of a species `[length]`.
    #[must_use]
    pub fn diameters(&self, species: SpeciesId) -> RangeInclusive<f64> {
        self.diameters.get(species.0 as usize).map_or(0.0..=0.0, |range| range.smallest..=range.largest)
    }

    /// The largest radius of the particles of each row `[length]`.
    #[must_use]
    pub fn largest_radii(&self) -> &[f64] {
        &self.radii
    }

    #[must_use]
    pub fn has_row(&self, species: SpeciesId) -> bool {
        self.species[..usize::from(self.awake)].binary_search(&species).is_ok()
    }

    /// Checks data from a file. `species` is the number of species.
    #[must_use]
    pub fn are_sound(&self, species: usize) -> bool {
        let awake = usize::from(self.awake);
        [self.rows.len(), self.diameters.len()] == [species; 2]
            && (self.species.len() == awake || self.species.len() == 2 * awake)
            && self.radii.len() == self.species.len()
            && self.rows.iter().all(|row| usize::from(*row) < awake.max(1))
    }

    #[must_use]
    pub fn species(&self) -> &[SpeciesId] {
        &self.species
    }
}

/// Divides a range of diameters into bands, which have a row each. Returns the largest radius of each band, in ascending
/// order.
pub fn bands(range: &Diameters) -> Vec<f64> {
    let (width, mut radii) = (libm::log(range.largest / range.smallest), Vec::new());
    // A species without a diameter has one band.
    if width > 0.0 && width.is_finite() {
        let wanted = (width / libm::log(ALIKE)).ceil();
        let count = (1..MOST_BANDS).find(|count| f64::from(*count) >= wanted).unwrap_or(MOST_BANDS);
        let of_band = |band: i32| 0.5 * range.smallest * libm::exp(width * f64::from(band) / f64::from(count));
        radii.extend((1..count).map(of_band));
    }
    radii.push(0.5 * range.largest);
    radii
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

    #[test]
    fn rows_of_another_number_of_species_are_not_sound() {
        let scene = SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(4).packing_fraction(0.1))
            .temperature(1.0)
            .build()
            .unwrap();
        let rows = Rows::of(&scene);
        assert!(rows.are_sound(1) && !rows.are_sound(2));
        let lost = [Rows { rows: vec![], ..rows.clone() }, Rows { diameters: vec![], ..rows.clone() }];
        assert!(lost.iter().all(|rows| !rows.are_sound(1)));
    }
}
