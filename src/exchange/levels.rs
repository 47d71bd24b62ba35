//! Levels of the potential energy: their density of states and their populations.

use super::populations::bins;
use super::results::Population;
use crate::analysis::reweighting::{DensityOfStates, Reweighting};
use crate::analysis::statistics::Estimate;

/// Density of states of a level of the potential energy.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct LevelDensity {
    /// The energy of the level `[energy]`.
    pub energy: f64,
    /// Natural logarithm of the density of states `g(E)`. At the highest temperature `T`, the sum of `g(E) exp(-E / T)`
    /// is 1. There is no error estimate if a resample lacks the level.
    pub log_density_of_states: Estimate,
}

impl LevelDensity {
    pub(super) fn new(energy: f64, log_density_of_states: Estimate) -> Self {
        Self { energy, log_density_of_states }
    }

    pub(super) fn all(reweighting: &Reweighting, highest: f64) -> Vec<Self> {
        let density = reweighting.density();
        let relative = |density: &DensityOfStates| -> Vec<f64> {
            let sum = density.at(highest).log_partition;
            density.levels().map(|(_, logarithm)| logarithm - sum).collect()
        };
        let all = density.levels().zip(reweighting.estimates(relative));
        all.filter(|(_, it)| it.mean.is_finite()).map(|((energy, _), it)| Self::new(energy, it)).collect()
    }
}

/// Returns the populations at each temperature. More than a hundred levels are merged into bins.
pub(super) fn populations(reweighting: &Reweighting, temperatures: &[f64]) -> Vec<Vec<Population>> {
    let energies: Vec<f64> = reweighting.density().levels().map(|(energy, _)| energy).collect();
    let bins = bins(&energies);
    let of = |temperature: &f64| {
        let found = reweighting.estimates(|density| {
            let all = density.probabilities_at(*temperature);
            bins.iter().map(|(_, _, places)| all[places.clone()].iter().sum()).collect()
        });
        let population = |((energy, width, _), population): (&(f64, f64, _), Estimate)| Population {
            energy: *energy,
            width: *width,
            population,
        };
        bins.iter().zip(found).map(population).collect()
    };
    temperatures.iter().map(of).collect()
}
