//! Contact distances of pairs. They are the units of scaled distances.

use super::Class;
use crate::analysis::instruments::system::SystemDescription;
use crate::model::diameters::scaled_distance;

/// Sums over the particles of a species: their number, and the sums of the first three powers of their diameters.
type PowerSums = [f64; 4];

/// Contact distance of two particles `[length]`, given by their species and diameters. `None` without hard cores.
pub(super) fn contact_distance(system: &SystemDescription, [(a, of_a), (b, of_b)]: [(usize, f64); 2]) -> Option<f64> {
    let core = system.cores.get(a, b)?;
    if system.own_diameters.is_empty() {
        return Some(core);
    }
    Some(scaled_distance(core, system.diameters[a] + system.diameters[b], of_a + of_b))
}

/// Returns the largest contact distance of all pairs `[length]`; 0 without hard cores.
pub(super) fn largest_contact_distance(system: &SystemDescription) -> f64 {
    let mut largest: Vec<Option<f64>> = vec![None; system.species_names.len()];
    for (id, &species) in (0..).zip(&system.species) {
        let of_species = &mut largest[species as usize];
        *of_species = Some(of_species.unwrap_or(0.0).max(system.diameter_of(id)));
    }
    let present = || largest.iter().enumerate().filter_map(|(species, largest)| Some((species, (*largest)?)));
    let pairs = present().flat_map(|a| present().map(move |b| [a, b]));
    pairs.filter_map(|pair| contact_distance(system, pair)).fold(0.0, f64::max)
}

/// Returns the mean of `sigma^D` over the pairs of two classes, with the contact distance `sigma` of a pair in `D`
/// dimensions `[length^D]`. `None` if some pairs have no hard cores.
pub(super) fn mean_contact_volume(system: &SystemDescription, [a, b]: [&Class; 2], is_same: bool) -> Option<f64> {
    let (sums, dimensions) = (power_sums(system), system.space.dimensions());
    let (mut total, mut pairs) = (0.0, 0.0);
    for &first in &a.species {
        for &second in &b.species {
            let [one, other] = [first, second].map(|species| system.diameters[species]);
            let core = system.cores.get(first, second)?;
            // The contact distance is this slope times the sum of the diameters.
            let slope = scaled_distance(core, one + other, 1.0);
            let scale = (0..dimensions).fold(1.0, |product, _| product * slope);
            let [x, y] = [sums[first], sums[second]];
            total += scale * sum_over_pairs([x, y], dimensions);
            pairs += x[0] * y[0];
            if is_same && first == second {
                // A particle is no pair with itself.
                let twice = (0..dimensions).fold(1.0, |product, _| product * 2.0);
                total -= scale * twice * x[dimensions];
                pairs -= x[0];
            }
        }
    }
    Some(if pairs > 0.0 { total / pairs } else { 0.0 })
}

/// Sums `(d_i + d_j)^D` over all pairs of two groups, by the binomial theorem.
fn sum_over_pairs([x, y]: [PowerSums; 2], dimensions: usize) -> f64 {
    match dimensions {
        3 => x[0] * y[3] + 3.0 * (x[1] * y[2] + x[2] * y[1]) + x[3] * y[0],
        2 => x[0] * y[2] + 2.0 * x[1] * y[1] + x[2] * y[0],
        _ => x[0] * y[1] + x[1] * y[0],
    }
}

fn power_sums(system: &SystemDescription) -> Vec<PowerSums> {
    let mut sums = vec![PowerSums::default(); system.species_names.len()];
    for (id, &species) in (0..).zip(&system.species) {
        let mut power = 1.0;
        for sum in &mut sums[species as usize] {
            *sum += power;
            power *= system.diameter_of(id);
        }
    }
    sums
}
