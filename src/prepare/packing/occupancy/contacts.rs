use crate::model::diameters::{Diameters, scaled_distance};
use crate::model::species_pairs::SpeciesPairs;
use crate::model::{Particle, Species, SpeciesId};

/// A particle to be placed: its species and its individual diameter `[length]`, if it has one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Kind {
    pub species: SpeciesId,
    pub diameter: Option<f64>,
}

impl Kind {
    pub(crate) fn of_species(species: SpeciesId) -> Self {
        Self { species, diameter: None }
    }

    pub(crate) fn of(particle: &Particle) -> Self {
        Self { species: particle.species, diameter: particle.diameter }
    }

    /// Individual diameter of the particle if it has one, otherwise the diameter of its species `[length]`.
    pub(crate) fn diameter_among(&self, species: &[Species]) -> f64 {
        self.diameter.unwrap_or(species[self.index()].diameter)
    }

    /// Index of the species.
    pub(crate) fn index(&self) -> usize {
        self.species.0 as usize
    }
}

/// Contact distances of pairs `[length]`; 0 for pairs without a hard core.
#[derive(Debug, Clone)]
pub(crate) struct Contacts {
    /// Contact distances of particles with the diameters of their species.
    of_species: SpeciesPairs<f64>,
    /// Diameter of each species, and the range of the diameters of its particles `[length]`. Empty unless particles have
    /// individual diameters.
    sizes: Vec<(f64, Diameters)>,
}

impl Contacts {
    pub(crate) fn of(of_species: SpeciesPairs<f64>) -> Self {
        Self { of_species, sizes: Vec::new() }
    }

    /// Adds the diameters of species and particles, if any species has individual diameters.
    pub(crate) fn among(self, species: &[Species], ranges: Vec<Diameters>) -> Self {
        if species.iter().all(|species| species.individual.is_none()) {
            return self;
        }
        Self { sizes: species.iter().map(|species| species.diameter).zip(ranges).collect(), ..self }
    }

    #[cfg(test)]
    pub(crate) fn new(species: usize) -> Self {
        Self::of(SpeciesPairs::new(species))
    }

    #[cfg(test)]
    pub(crate) fn set(&mut self, a: usize, b: usize, distance: f64) {
        self.of_species.set(a, b, distance);
    }

    /// Largest contact distance of particles of two species.
    #[inline]
    pub(crate) fn get(&self, a: usize, b: usize) -> f64 {
        self.with_sizes([a, b], self.of_species(a, b), |range| range.largest)
    }

    /// Smallest contact distance of particles of two species.
    pub(crate) fn smallest(&self, a: usize, b: usize) -> f64 {
        self.with_sizes([a, b], self.of_species(a, b), |range| range.smallest)
    }

    /// Contact distance of particles with the diameters of their species.
    #[inline]
    pub(crate) fn of_species(&self, a: usize, b: usize) -> f64 {
        self.of_species.get(a, b).unwrap_or(0.0)
    }

    /// Contact distance of two particles.
    #[inline]
    pub(crate) fn between(&self, a: &Kind, b: &Kind) -> f64 {
        let contact = self.of_species(a.index(), b.index());
        if self.sizes.is_empty() {
            return contact;
        }
        let [one, other] = [a, b].map(|kind| self.sizes[kind.index()].0);
        let of_pair = 0.5 * (a.diameter.unwrap_or(one) + b.diameter.unwrap_or(other));
        scaled_distance(contact, 0.5 * (one + other), of_pair)
    }

    /// Largest contact distance of each pair of species.
    pub(crate) fn iter(&self) -> impl Iterator<Item = ([usize; 2], f64)> + '_ {
        self.of_species.iter().map(|(pair, contact)| (pair, self.with_sizes(pair, contact, |range| range.largest)))
    }

    fn with_sizes(&self, pair: [usize; 2], contact: f64, size: impl Fn(&Diameters) -> f64) -> f64 {
        if self.sizes.is_empty() {
            return contact;
        }
        let [(one, range), (other, its_range)] = pair.map(|species| &self.sizes[species]);
        scaled_distance(contact, 0.5 * (one + other), 0.5 * (size(range) + size(its_range)))
    }

    /// Multiplies all contact distances by a factor. The diameters of particles stay the same.
    pub(crate) fn scaled(&self, factor: f64) -> Self {
        let of_species = self.of_species.map(|distance| Some(distance * factor));
        Self { of_species, sizes: self.sizes.clone() }
    }

    /// Shortest contact distance that is not 0; infinite without hard cores.
    pub(crate) fn shortest(&self) -> f64 {
        let all = self.of_species.iter();
        let all = all.map(|(pair, contact)| self.with_sizes(pair, contact, |range| range.smallest));
        all.filter(|distance| *distance > 0.0).fold(f64::INFINITY, f64::min)
    }

    pub(crate) fn largest(&self) -> f64 {
        self.iter().map(|(_, distance)| distance).fold(0.0, f64::max)
    }
}
