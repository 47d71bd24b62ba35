use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

use crate::Vector;
use crate::analysis::instruments::followed::followed;
use crate::analysis::instruments::system::{Sample, SystemDescription};
use crate::base::numbers::{id, trunc_to_usize};
use crate::model::components::components;

/// Random stream that chooses the tracers. The initial state uses the streams 0, 1, ...
const STREAM: u64 = u64::MAX;

/// For fewer cells with particles, there is no standard error. For eight, the error is uncertain by about a quarter.
const FEWEST: usize = 8;

/// Number of cells along each axis, for boxes with 0 to 3 axes: about 27 cells in all.
const CELLS: [f64; 4] = [1.0, 27.0, 5.0, 3.0];

/// All moving particles, or a random choice that depends only on the seed, in the frame of the centre of mass.
///
/// In this frame, the mean square velocity of a particle is smaller by the factor `1 - m / M`, for mass `m` in a system
/// of mass `M`. Squared displacements and velocities are divided by this factor. If only some components of the
/// momentum are conserved, for example between walls, the divisor is the mean of the factor over the axes.
///
/// In a sheared box only the components across the flow, y and z, are followed. Motion along x includes the streaming
/// velocity, which changes with the position. Between walls nothing diffuses, so axes with walls are followed only if
/// there are no other axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Tracers {
    ids: Vec<u32>,
    /// For each tracer, the index of the species in `species`.
    kinds: Vec<u32>,
    /// The cell in which each tracer started. All tracers of a molecule have the cell of the first particle of the
    /// molecule.
    cells: Vec<u32>,
    pub species: Vec<u32>,
    /// Number of tracers of each species, and the factor `1 / (1 - m / M)`.
    counts: Vec<u64>,
    scales: Vec<f64>,
    drift: Vector,
    start: f64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Frame {
    /// Unwrapped positions `[length]`.
    pub positions: Vec<Vector>,
    /// Velocities relative to the centre of mass `[length / time]`.
    pub velocities: Vec<Vector>,
}

impl Tracers {
    pub fn new(sample: &Sample<'_>, system: &SystemDescription, most: usize) -> Self {
        let ids = choice(&system.moving, most, system.seed);
        let species_of = |id: &u32| system.species[*id as usize];
        let mut species: Vec<u32> = ids.iter().map(species_of).collect();
        species.sort_unstable();
        species.dedup();
        let kinds: Vec<u32> =
            ids.iter().map(|particle| id(species.partition_point(|s| *s < species_of(particle)))).collect();
        let mut counts = vec![0; species.len()];
        let mut scales = vec![1.0; species.len()];
        let followed = followed(system);
        for (id, kind) in ids.iter().zip(&kinds) {
            counts[*kind as usize] += 1;
            if system.conserved_axes != [false; 3] {
                let parts = followed.axes.iter().map(|&axis| system.free_part(system.masses[*id as usize], axis));
                scales[*kind as usize] = followed.axes.len() as f64 / parts.sum::<f64>();
            }
        }
        let drift = followed.of(system.common_velocity(sample.velocities));
        let cells = cells(sample, system);
        let cells = ids.iter().map(|&id| cells[id as usize]).collect();
        Self { ids, kinds, cells, species, counts, scales, drift, start: sample.time }
    }

    pub fn dimensions(system: &SystemDescription) -> f64 {
        followed(system).axes.len() as f64
    }

    /// Number of groups: one for all particles and, with several species, one for each species.
    pub fn groups(&self) -> usize {
        if self.species.len() > 1 { 1 + self.species.len() } else { 1 }
    }

    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Estimates the variance of the mean of `value(k)`, a squared quantity of tracer `k`, over a group. Neighbours and
    /// beads of a chain move together. Deviations from the mean of a species are therefore summed over each cell, and
    /// only these sums are treated as independent. `None` for fewer than [`FEWEST`] cells.
    pub fn variance_of_mean(&self, group: usize, value: impl Fn(usize) -> f64) -> Option<f64> {
        let chosen = || {
            let kinds = self.kinds.iter().map(|&kind| kind as usize).enumerate();
            kinds.filter(|(_, kind)| group.checked_sub(1).is_none_or(|species| species == *kind))
        };
        let mut sums = vec![[0.0; 2]; self.species.len()];
        for (k, kind) in chosen() {
            sums[kind][0] += 1.0;
            sums[kind][1] += value(k);
        }
        let mut by_cell: BTreeMap<u32, f64> = BTreeMap::new();
        for (k, kind) in chosen() {
            let [count, sum] = sums[kind];
            *by_cell.entry(self.cells[k]).or_default() += (value(k) - sum / count) * self.scales[kind];
        }
        let (count, cells) = (chosen().count() as f64, by_cell.len() as f64);
        let squares: f64 = by_cell.values().map(|sum| sum * sum).sum();
        (by_cell.len() >= FEWEST).then(|| squares * cells / ((cells - 1.0) * count * count))
    }

    pub fn count_of(&self, group: usize) -> f64 {
        let of_species = group.checked_sub(1).and_then(|species| self.counts.get(species));
        of_species.map_or(self.ids.len() as f64, |count| *count as f64)
    }

    /// The factor `1 - m / M` of a group, or the mean over the axes. `None` if the species of the group have different
    /// factors.
    pub fn free_part_of(&self, group: usize) -> Option<f64> {
        let scales = match group.checked_sub(1) {
            None => &self.scales[..],
            Some(species) => self.scales.get(species..=species)?,
        };
        let first = scales.first()?;
        scales.iter().all(|scale| scale == first).then_some(1.0 / first)
    }

    pub fn frame(&self, sample: &Sample<'_>, system: &SystemDescription) -> Frame {
        let drifted = self.drift * (sample.time - self.start);
        let followed = followed(system);
        let ids = || self.ids.iter().map(|&id| id as usize);
        Frame {
            positions: ids().map(|id| followed.of(sample.unwrapped(id, &system.space)) - drifted).collect(),
            velocities: ids().map(|id| followed.of(sample.velocities[id]) - self.drift).collect(),
        }
    }

    /// Returns, for each group, the mean of `square(k) / (1 - m / M)` over the tracers `k`. `square(k)` must be
    /// quadratic in displacements or velocities.
    pub fn means(&self, square: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.species.len()];
        for (k, kind) in self.kinds.iter().enumerate() {
            sums[*kind as usize] += square(k);
        }
        sums.iter_mut().zip(&self.scales).for_each(|(sum, scale)| *sum *= scale);
        let mut means = vec![sums.iter().sum::<f64>() / self.ids.len() as f64];
        if self.species.len() > 1 {
            means.extend(sums.iter().zip(&self.counts).map(|(sum, count)| sum / *count as f64));
        }
        means
    }
}

fn cells(sample: &Sample<'_>, system: &SystemDescription) -> Vec<u32> {
    let space = &system.space;
    let along = CELLS[space.dimensions().min(3)];
    let cell = |position: &Vector| {
        let place =
            |axis: usize| (along * (position[axis] - space.lower[axis]) / space.size[axis]).clamp(0.0, along - 1.0);
        system.axes().fold(0, |number, axis| number * trunc_to_usize(along) + trunc_to_usize(place(axis)))
    };
    let mut cells: Vec<u32> = sample.positions.iter().map(|position| id(cell(position))).collect();
    for component in components(system.species.len(), &system.bonds) {
        let first = cells[component.ids[0] as usize];
        component.ids.iter().for_each(|&id| cells[id as usize] = first);
    }
    cells
}

/// Chooses ids at random, each with the same probability, and keeps their order.
fn choice(ids: &[u32], most: usize, seed: u64) -> Vec<u32> {
    if ids.len() <= most {
        return ids.to_vec();
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(STREAM);
    let mut chosen = Vec::with_capacity(most);
    for (passed, &id) in ids.iter().enumerate() {
        let (left, missing) = ((ids.len() - passed) as u128, (most - chosen.len()) as u128);
        if (u128::from(random.next_u64()) * left) >> 64 < missing {
            chosen.push(id);
        }
    }
    chosen
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_choice_depends_on_the_seed_and_has_the_size_that_was_asked_for() {
        let ids: Vec<u32> = (0..1000).collect();
        let chosen = choice(&ids, 300, 7);
        assert_eq!(chosen.len(), 300);
        assert!(chosen.is_sorted());
        assert_eq!(chosen, choice(&ids, 300, 7));
        assert_ne!(chosen, choice(&ids, 300, 8));
        assert_eq!(choice(&ids, 1000, 7), ids);
        // On average, 150 of the 300 chosen ids are in the lower half. The standard deviation, without replacement, is
        // sqrt(300 * 0.7) / 2 = 7.2.
        let low = chosen.iter().filter(|id| **id < 500).count();
        assert!(low.abs_diff(150) < 30, "{low}");
    }
}
