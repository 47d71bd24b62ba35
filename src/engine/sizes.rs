//! Radii and masses of particles, with or without individual diameters.

use super::array::Array;
use super::columns::records::Record;
use super::columns::{Column, Order, PartNumbers, take_values};
use super::pairs::rules::SpeciesRules;
use super::parts::Engine;
use crate::model::diameters::scaled_distance;
use crate::model::{Particle, Scene};
use serde::{Deserialize, Serialize};

/// Radius and inverse mass of a particle with an individual diameter.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Size {
    /// Half the diameter `[length]`.
    pub radius: f64,
    /// Inverse mass; 0 if the particle is static.
    pub inverse_mass: f64,
}

impl Size {
    pub fn of(scene: &Scene, particle: &Particle) -> Self {
        Self { radius: 0.5 * scene.diameter(particle), inverse_mass: scene.mass(particle).recip() }
    }
}

/// The size of each particle. Empty if no particles have individual diameters.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct Sizes {
    pub radii: Array<f64>,
    pub inverse_masses: Array<f64>,
}

impl Sizes {
    pub fn of<'p>(scene: &Scene, particles: impl Iterator<Item = &'p Particle>) -> Self {
        let mut sizes = Self::default();
        if scene.has_individual_diameters() {
            particles.for_each(|particle| sizes.add(Size::of(scene, particle)));
        }
        sizes
    }

    pub fn is_empty(&self) -> bool {
        self.radii.is_empty()
    }

    /// The size of a particle; `None` if no particles have individual diameters.
    pub fn get(&self, particle: u32) -> Option<Size> {
        let radius = *self.radii.get(particle as usize)?;
        Some(Size { radius, inverse_mass: self.inverse_masses[particle as usize] })
    }

    pub fn swap(&mut self, [a, b]: [u32; 2]) {
        if !self.is_empty() {
            self.radii.swap(a as usize, b as usize);
            self.inverse_masses.swap(a as usize, b as usize);
        }
    }

    fn add(&mut self, size: Size) {
        self.radii.push(size.radius);
        self.inverse_masses.push(size.inverse_mass);
    }
}

impl Column for Sizes {
    const CHANGES_IN_CONTACTS: bool = false;

    fn permuted(&self, order: &Order) -> Self {
        Self { radii: order.permuted_if_any(&self.radii), inverse_masses: order.permuted_if_any(&self.inverse_masses) }
    }

    fn copy(&self, particle: u32, record: &mut Record) {
        record.size = self.get(particle);
    }

    fn push(&mut self, record: &Record) {
        record.size.into_iter().for_each(|size| self.add(size));
    }

    fn set(&mut self, particle: u32, record: &Record) {
        if let Some(size) = record.size {
            self.radii[particle as usize] = size.radius;
            self.inverse_masses[particle as usize] = size.inverse_mass;
        }
    }

    fn take_over(&mut self, part: &Self, numbers: &PartNumbers<'_>) {
        take_values(&mut self.radii, &part.radii, numbers);
        take_values(&mut self.inverse_masses, &part.inverse_masses, numbers);
    }

    fn share_memory(&mut self) {
        self.radii.become_alias();
        self.inverse_masses.become_alias();
    }

    fn fits(&self, count: usize) -> bool {
        [&self.radii, &self.inverse_masses].iter().all(|values| values.is_empty() || values.len() == count)
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Whether particles have individual diameters.
    #[inline]
    pub(super) fn has_sizes(&self) -> bool {
        TABLE && self.pairs.rules.has_sizes
    }

    #[inline]
    fn rules_of(&self, particle: u32) -> &SpeciesRules {
        &self.pairs.rules.species[usize::from(self.row(particle))]
    }

    /// Radius of a particle, which is the distance of its centre from a wall at contact `[length]`.
    #[inline]
    pub(super) fn radius(&self, particle: u32) -> f64 {
        if self.has_sizes() { self.state.sizes.radii[particle as usize] } else { self.rules_of(particle).radius }
    }

    /// Current individual diameter of a particle `[length]`; `None` if its species has one diameter.
    #[inline]
    pub(super) fn own_diameter(&self, particle: u32) -> Option<f64> {
        if !self.has_sizes() {
            return None;
        }
        self.pairs.rules.is_individual[usize::from(self.row(particle))]
            .then(|| 2.0 * self.radius(particle) * self.scale())
    }

    /// Inverse mass of a particle; 0 if it is static or asleep.
    #[inline]
    pub(super) fn inverse_mass(&self, particle: u32) -> f64 {
        let of_species = self.rules_of(particle).inverse_mass;
        if self.has_sizes() { self.own_inverse_mass(particle, of_species) } else { of_species }
    }

    /// Not inlined, because most scenes have equal particles.
    #[inline(never)]
    fn own_inverse_mass(&self, particle: u32, of_species: f64) -> f64 {
        if of_species == 0.0 { 0.0 } else { self.state.sizes.inverse_masses[particle as usize] }
    }

    /// Inverse moment of inertia of a particle; 0 if it is static or asleep.
    #[inline]
    pub(super) fn inverse_inertia(&self, particle: u32) -> f64 {
        let rules = self.rules_of(particle);
        if self.has_sizes() { self.with_size(particle, rules).inverse_inertia } else { rules.inverse_inertia }
    }

    /// Returns the rules of a particle as if it were awake.
    #[inline]
    pub(super) fn awake_rules(&self, particle: u32) -> SpeciesRules {
        let rules = &self.pairs.rules;
        let awake = &rules.species[usize::from(rules.rows.awake(self.row(particle)))];
        if self.has_sizes() { self.with_size(particle, awake) } else { *awake }
    }

    /// Replaces the radius and mass of a species by the radius and mass of a particle. Moments of inertia are
    /// proportional to `m R^2`. Not inlined, because most scenes have equal particles.
    #[inline(never)]
    fn with_size(&self, particle: u32, rules: &SpeciesRules) -> SpeciesRules {
        if rules.is_static() {
            return *rules;
        }
        let sizes = &self.state.sizes;
        let (radius, inverse_mass) = (sizes.radii[particle as usize], sizes.inverse_masses[particle as usize]);
        let ratio = rules.radius / radius;
        let inverse_inertia = rules.inverse_inertia * (inverse_mass / rules.inverse_mass) * ratio * ratio;
        SpeciesRules { radius, inverse_mass, inverse_inertia, ..*rules }
    }

    /// Distance of a discontinuity of two particles `[length]`. `distance` applies to the diameters of the two species.
    #[inline]
    pub(super) fn distance_of_pair(&self, distance: f64, pair: [u32; 2]) -> f64 {
        if self.has_sizes() { self.scaled_to_pair(distance, pair) } else { distance }
    }

    /// Not inlined, because most scenes have equal particles.
    #[inline(never)]
    fn scaled_to_pair(&self, distance: f64, [i, j]: [u32; 2]) -> f64 {
        let of_species = self.pairs.rules.sum_of_species_radii(self.row(i), self.row(j));
        scaled_distance(distance, of_species, self.radius(i) + self.radius(j))
    }

    /// Interaction range of two particles, whether they move or not `[length]`; negative if they never interact. The
    /// first particle is given by its table row and its radius.
    pub(super) fn range_between(&self, (row, radius): (u16, f64), other: u32) -> f64 {
        let rows = [row, self.row(other)].map(usize::from);
        let range = self.ranges.at(rows[0], rows[1]);
        if !self.has_sizes() || range < 0.0 {
            return range;
        }
        let radii = self.pairs.rules.rows.largest_radii();
        scaled_distance(range, radii[rows[0]] + radii[rows[1]], radius + self.radius(other))
    }

    /// Squared distance of a discontinuity of two particles `[length^2]`. `squared` applies to the diameters of the two
    /// species.
    #[inline]
    pub(super) fn squared_of_pair(&self, squared: f64, pair: [u32; 2]) -> f64 {
        if !self.has_sizes() {
            return squared;
        }
        // The square root of a square is exact.
        let distance = self.scaled_to_pair(squared.sqrt(), pair);
        distance * distance
    }
}

#[cfg(test)]
mod tests;
