//! Particles that wait at an inlet, and the sizes that new ones can have.

use serde::{Deserialize, Serialize};

use crate::Vector;
use crate::engine::pairs::rules::Rules;
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
    /// Checks data from a file: the species must exist, and only particles of species with individual diameters have a
    /// size, in the range of the species. `species` is the number of species.
    pub fn is_sound(&self, species: usize, rules: &Rules) -> bool {
        let is_in_range = |size: Size| {
            rules.rows.diameters(self.species).contains(&(2.0 * size.radius))
                && (0.0..f64::INFINITY).contains(&size.inverse_mass)
        };
        (self.species.0 as usize) < species
            && self.size.is_some() == rules.has_individual_diameters(self.species)
            && self.size.is_none_or(is_in_range)
    }
}

/// Sizes of the new particles of a species.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct SizesOfSpecies {
    /// Empty unless the species has individual diameters and enters at an inlet.
    individual: Vec<Size>,
    /// Cumulative shares: the share of all sizes up to and including each size. The last one is 1 within round-off.
    cumulative: Vec<f64>,
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
            let (individual, cumulative) = distribution.shares().into_iter().map(of).unzip();
            all[id.0 as usize] = Self { individual, cumulative };
        }
        all
    }

    /// Draws an individual size; `None` if the particles of the species are equal.
    pub fn draw(&self, random: &mut Random) -> Option<Size> {
        let last = self.individual.len().checked_sub(1)?;
        let number = random.uniform();
        Some(self.individual[self.cumulative.partition_point(|share| *share <= number).min(last)])
    }

    /// Checks data from a file. `id` is the species, and `species` the number of species.
    pub fn is_sound(&self, id: SpeciesId, species: usize, rules: &Rules) -> bool {
        let of = |size: &Size| Newcomer { species: id, size: Some(*size) }.is_sound(species, rules);
        self.individual.len() == self.cumulative.len() && self.cumulative.is_sorted() && self.individual.iter().all(of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::pairs::rules::Rules;

    /// Grains with individual diameters from 0.5 to 1.5 enter, and equal ones.
    const FEED: &str = "space = { size = [9.0, 9.0, 9.0], x = 'open' }
        species = [
            { name = 'grain', mass = 0.7, diameter = { distribution = 'uniform', lower = 0.5, upper = 1.5 }, diameters = 'individual' },
            { name = 'bead', mass = 1.3, diameter = 0.8 },
        ]
        interaction = [
            { species = ['grain', 'grain'], potential = 'hard-sphere' },
            { species = ['bead', 'grain'], potential = 'hard-sphere' },
            { species = ['bead', 'bead'], potential = 'hard-sphere' },
        ]
        inlet = [{ composition = { grain = 1, bead = 2 }, mass_rate = 3.475, region = { lower = [1.0, 1.0, 1.0], upper = [8.0, 8.0, 8.0] } }]
        run = { until_time = 1.0 }";

    #[test]
    fn a_mass_rate_uses_the_mean_mass_of_the_distribution() {
        let scene = Scene::from_toml(FEED, "feed.toml").unwrap();
        // The mean of d^3 is 1.25, so the mean mass is (0.875 + 2 * 1.3) / 3.
        let rate = scene.inlets()[0].rate;
        assert!((rate - 3.0).abs() < 1e-6, "{rate}");
    }

    #[test]
    fn sizes_that_do_not_fit_their_species_are_not_sound() {
        let scene = Scene::from_toml(FEED, "feed.toml").unwrap();
        let rules = Rules::new(&scene);
        let waiting = |species: u32, diameter: Option<f64>| {
            let size = diameter.map(|diameter| Size { radius: 0.5 * diameter, inverse_mass: 0.7 });
            Newcomer { species: SpeciesId(species), size }.is_sound(2, &rules)
        };
        assert!(waiting(0, Some(0.6)) && waiting(0, Some(1.4)) && waiting(1, None));
        assert!(!waiting(0, Some(0.4)) && !waiting(0, Some(1.6)), "beyond the range of the species");
        assert!(!waiting(0, None) && !waiting(1, Some(0.8)) && !waiting(2, None));

        let all = SizesOfSpecies::all(&scene);
        let sound = |sizes: &SizesOfSpecies, id: u32| sizes.is_sound(SpeciesId(id), 2, &rules);
        assert!(sound(&all[0], 0) && sound(&all[1], 1) && !sound(&all[0], 1));
        let mut damaged = all[0].clone();
        damaged.cumulative.swap(3, 700);
        assert!(!sound(&damaged, 0));
        damaged.cumulative.swap(3, 700);
        damaged.cumulative.pop();
        assert!(!sound(&damaged, 0));
    }
}
