//! Particles that wait at an inlet, and the sizes that new ones can have.

use serde::{Deserialize, Serialize};

use crate::Vector;
use crate::engine::pairs::rows::Rows;
use crate::engine::sizes::Size;
use crate::model::random::Random;
use crate::model::{Inlet, Particle, Scene, SpeciesId};

/// A particle that waits for a place.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(in crate::engine) struct Newcomer {
    pub species: SpeciesId,
    /// `None` if the particles of the species are equal.
    pub size: Option<Size>,
}

impl Newcomer {
    /// Checks data from a file: the species must exist, and the diameter must lie in the range of the species. `species`
    /// is the number of species.
    pub fn is_sound(&self, species: usize, rows: &Rows) -> bool {
        let is_in_range = |size: Size| {
            rows.diameters(self.species).contains(&(2.0 * size.radius))
                && (0.0..f64::INFINITY).contains(&size.inverse_mass)
        };
        (self.species.0 as usize) < species && self.size.is_none_or(is_in_range)
    }
}

/// Sizes of the new particles of a species.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct SizesOfSpecies {
    /// Empty unless the species has individual diameters and enters at an inlet.
    individual: Vec<Size>,
    /// Sums of the shares of all sizes up to each size; the last sum is 1 within round-off.
    sums: Vec<f64>,
}

impl SizesOfSpecies {
    /// Returns the sizes of each species of a scene.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let mut all = vec![Self::default(); scene.species.len()];
        for id in scene.inlets.iter().flat_map(Inlet::species) {
            let individual = scene.species[id.0 as usize].individual.as_ref();
            let Some(distribution) = individual.and_then(|it| it.distribution.as_ref()) else { continue };
            let mut sum = 0.0;
            let of = |(diameter, share): (f64, f64)| {
                sum += share;
                (Size::of(scene, &Particle::new(id, Vector::zeros(), Vector::zeros()).diameter(diameter)), sum)
            };
            let (individual, sums) = distribution.shares().into_iter().map(of).unzip();
            all[id.0 as usize] = Self { individual, sums };
        }
        all
    }

    /// Draws an individual size; `None` if the particles of the species are equal.
    pub fn draw(&self, random: &mut Random) -> Option<Size> {
        let last = self.individual.len().checked_sub(1)?;
        let number = random.uniform();
        Some(self.individual[self.sums.partition_point(|sum| *sum <= number).min(last)])
    }

    /// Checks data from a file. `id` is the species, and `species` the number of species.
    pub fn is_sound(&self, id: SpeciesId, species: usize, rows: &Rows) -> bool {
        let of = |size: &Size| Newcomer { species: id, size: Some(*size) }.is_sound(species, rows);
        self.individual.len() == self.sums.len() && self.individual.iter().all(of)
    }
}
