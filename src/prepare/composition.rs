//! Mixtures: numbers of particles, mean volume, and size of the box.

use std::f64::consts::{PI, SQRT_2};

use crate::Vector;
use crate::base::numbers::{index, trunc_to_usize};
use crate::model::scene::own_volume;
use crate::model::space::Boundary;
use crate::model::{Space, Species, SpeciesId};
use crate::prepare::lattice::root;

/// Divides `count` in the given proportions. Numbers are rounded down, and the rest goes to the largest remainders.
pub(crate) fn whole_numbers(shares: &[(SpeciesId, f64)], count: usize) -> Vec<(SpeciesId, usize)> {
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let exact: Vec<f64> = shares.iter().map(|(_, share)| share / total * count as f64).collect();
    let mut numbers: Vec<usize> = exact.iter().map(|&number| trunc_to_usize(number).min(count)).collect();
    let mut order: Vec<usize> = (0..shares.len()).collect();
    order.sort_by(|&a, &b| exact[b].fract().total_cmp(&exact[a].fract()));
    let mut rest = count.saturating_sub(numbers.iter().sum());
    for &index in order.iter().cycle() {
        if rest == 0 {
            break;
        }
        numbers[index] += 1;
        rest -= 1;
    }
    shares.iter().zip(numbers).map(|((species, _), number)| (*species, number)).collect()
}

/// Converts shares to whole numbers of particles, from which the size of the box is calculated.
pub(crate) fn realised(shares: Vec<(SpeciesId, f64)>, count: u64) -> Vec<(SpeciesId, f64)> {
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let numbers = whole_numbers(&shares, index(count));
    let is_exact = |((_, share), (_, number)): (&(SpeciesId, f64), &(SpeciesId, usize))| {
        // A difference due to rounding would only change the last digits of the size of the box.
        (share / total * count as f64 - *number as f64).abs() < 1e-6
    };
    if shares.iter().zip(&numbers).all(is_exact) {
        return shares;
    }
    numbers.into_iter().map(|(species, number)| (species, number as f64)).collect()
}

/// Mean volume of a particle. A distribution of individual diameters is divided among `count` particles, or among very
/// many particles if there is no `count`.
pub(crate) fn mean_volume(
    shares: &[(SpeciesId, f64)],
    count: Option<u64>,
    species: &[Species],
    dimensions: usize,
) -> f64 {
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let volume = |diameter| own_volume(diameter, dimensions);
    let of_species = |species: &Species, share: f64| {
        let Some(distribution) = species.individual.as_ref().and_then(|individual| individual.distribution.as_ref())
        else {
            return volume(species.diameter);
        };
        let particles = count.map(|count| trunc_to_usize((share * count as f64).round()).max(1));
        particles.map_or_else(
            || distribution.mean_of(volume),
            |count| distribution.divided(count).into_iter().map(volume).sum::<f64>() / count as f64,
        )
    };
    shares.iter().map(|(id, share)| share / total * of_species(&species[id.0 as usize], share / total)).sum()
}

/// The largest packing fraction: `pi / (3 sqrt 2)` for equal spheres, and `pi / (2 sqrt 3)` for equal disks. In
/// mixtures, small particles can fill the holes, so the bound is 1.
pub(crate) fn largest_packing_fraction(dimensions: usize, species: usize) -> f64 {
    match (dimensions, species) {
        (3, 1) => PI / (3.0 * SQRT_2),
        (2, 1) => PI / 12.0_f64.sqrt(),
        _ => 1.0,
    }
}

/// Edges of a cube, square or line of the given volume `[length]`; 0 along flat axes.
pub(crate) fn edges(volume: f64, space: &Space) -> Vector {
    let edge = root(volume, space.dimensions());
    Vector::from_fn(|k, _| if space.boundary[k] == Boundary::Flat { 0.0 } else { edge })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_become_whole_numbers_that_add_up() {
        let shares = [(SpeciesId(0), 0.5), (SpeciesId(1), 0.25), (SpeciesId(2), 0.25)];
        let numbers = |count| whole_numbers(&shares, count).iter().map(|(_, n)| *n).collect::<Vec<_>>();
        assert_eq!(numbers(8), [4, 2, 2]);
        assert_eq!(numbers(7), [3, 2, 2]);
        assert_eq!(numbers(1), [1, 0, 0]);
    }
}
