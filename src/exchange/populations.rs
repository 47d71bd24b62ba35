//! Populations of the energy levels at each temperature.

use serde::{Deserialize, Serialize};

use super::results::Population;
use crate::analysis::statistics::{BlockAverage, Estimate};
use crate::model::Scene;

/// Maximum number of levels. More levels are merged into bins of equal width.
const MOST_LEVELS: usize = 100;

/// Approximate number of bins after levels are merged. Above [`MOST_BINS`], neighbouring bins are merged in pairs.
const BINS: f64 = 40.0;
const MOST_BINS: usize = 80;

/// Maximum length of a series for error estimates. Small, because there are many levels and temperatures.
const MOST_VALUES: usize = 128;

/// Tolerance for energies of the same level, relative to the largest energy of the potentials.
const SAME: f64 = 1e-9;

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Level {
    /// The energy of an exact level, or the index of a bin.
    at: f64,
    /// Fraction of samples in this level, for each temperature.
    occupied: Vec<BlockAverage>,
}

/// Populations of the levels of the potential energy. If there are too many levels, they are replaced by bins
/// `[k w, (k + 1) w)`, with a width `w` that doubles as needed.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Populations {
    levels: Vec<Level>,
    /// Width of the bins, or `None` for exact levels.
    width: Option<f64>,
    tolerance: f64,
    /// An average without samples. Each new level begins with a copy.
    empty: BlockAverage,
    temperatures: usize,
}

impl Populations {
    pub fn new(scene: &Scene, temperatures: usize) -> Self {
        let energies = scene.interactions.iter().flat_map(|it| it.potential.energies().iter().copied());
        let largest = energies.filter(|energy| energy.is_finite()).map(f64::abs).fold(0.0, f64::max);
        Self {
            levels: Vec::new(),
            width: None,
            tolerance: SAME * largest,
            empty: BlockAverage::with_most_bins(MOST_VALUES, 1.0),
            temperatures,
        }
    }

    pub fn add(&mut self, energies: &[f64]) {
        let levels: Vec<usize> = {
            for energy in energies {
                self.make_room(*energy);
            }
            // The indices are found now, because levels may have been inserted or merged above.
            energies.iter().map(|energy| self.find(*energy).unwrap_or_else(|place| place)).collect()
        };
        self.empty.add(0.0, 1.0);
        for (number, level) in self.levels.iter_mut().enumerate() {
            for (occupied, own) in level.occupied.iter_mut().zip(&levels) {
                occupied.add(if *own == number { 1.0 } else { 0.0 }, 1.0);
            }
        }
    }

    /// Returns the index of the level of an energy, or the index at which to insert a new level.
    fn find(&self, energy: f64) -> Result<usize, usize> {
        match self.width {
            Some(width) => {
                let bin = (energy / width).floor();
                self.levels.binary_search_by(|level| level.at.total_cmp(&bin))
            }
            None => {
                let place = self.levels.partition_point(|level| level.at < energy - self.tolerance);
                let is_it = self.levels.get(place).is_some_and(|level| level.at <= energy + self.tolerance);
                if is_it { Ok(place) } else { Err(place) }
            }
        }
    }

    fn make_room(&mut self, energy: f64) {
        let Err(place) = self.find(energy) else { return };
        // Adding zero removes the sign of a negative zero.
        let at = self.width.map_or(energy, |width| (energy / width).floor()) + 0.0;
        self.levels.insert(place, Level { at, occupied: vec![self.empty.clone(); self.temperatures] });
        match self.width {
            None if self.levels.len() > MOST_LEVELS => {
                let [first, .., last] = self.levels.as_slice() else { return };
                let width = power_of_two((last.at - first.at) / BINS);
                self.regroup(|at| (at / width).floor());
                self.width = Some(width);
            }
            Some(width) if self.levels.len() > MOST_BINS => {
                self.regroup(|bin| (0.5 * bin).floor());
                self.width = Some(2.0 * width);
            }
            _ => {}
        }
    }

    /// Applies a monotonic function to the field `at` of each level, and merges levels with equal results.
    fn regroup(&mut self, place: impl Fn(f64) -> f64) {
        let mut merged: Vec<Level> = Vec::new();
        for mut level in std::mem::take(&mut self.levels) {
            level.at = place(level.at) + 0.0;
            match merged.last_mut().filter(|last| last.at == level.at) {
                Some(last) => {
                    last.occupied.iter_mut().zip(&level.occupied).for_each(|(sum, more)| sum.add_series(more));
                }
                None => merged.push(level),
            }
        }
        self.levels = merged;
    }

    pub fn at(&self, place: usize) -> Vec<Population> {
        let nothing = Estimate { mean: 0.0, standard_error: None };
        let population = |level: &Level| Population {
            energy: self.width.map_or(level.at, |width| (level.at + 0.5) * width),
            width: self.width.unwrap_or(0.0),
            population: level.occupied[place].estimate().unwrap_or(nothing),
        };
        self.levels.iter().map(population).collect()
    }
}

/// Returns the energy, width and level indices of each bin. If there are few levels, each level is a bin.
pub(super) fn bins(energies: &[f64]) -> Vec<(f64, f64, std::ops::Range<usize>)> {
    let ([first, .., last], true) = (energies, energies.len() > MOST_LEVELS) else {
        return energies.iter().enumerate().map(|(place, energy)| (*energy, 0.0, place..place + 1)).collect();
    };
    let width = power_of_two((last - first) / BINS);
    let mut bins: Vec<(f64, f64, std::ops::Range<usize>)> = Vec::new();
    for (place, energy) in energies.iter().enumerate() {
        let middle = ((energy / width).floor() + 0.5) * width;
        match bins.last_mut().filter(|bin| bin.0 == middle) {
            Some(bin) => bin.2.end = place + 1,
            None => bins.push((middle, width, place..place + 1)),
        }
    }
    bins
}

/// Returns the smallest power of two that is at least a positive number. Bin edges are then exact.
fn power_of_two(number: f64) -> f64 {
    libm::exp2(libm::log2(number.max(f64::MIN_POSITIVE)).ceil())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn populations() -> Populations {
        Populations {
            levels: Vec::new(),
            width: None,
            tolerance: 1e-9,
            empty: BlockAverage::with_most_bins(MOST_VALUES, 1.0),
            temperatures: 2,
        }
    }

    fn means(populations: &Populations, temperature: usize) -> Vec<(f64, f64)> {
        populations.at(temperature).iter().map(|level| (level.energy, level.population.mean)).collect()
    }

    #[test]
    fn new_levels_count_as_empty_before() {
        let mut populations = populations();
        for energies in [[0.0, -1.0], [-1e-17, -1.0 + 1e-12], [-2.0, 0.0], [0.0, 0.0]] {
            populations.add(&energies);
        }
        assert_eq!(means(&populations, 0), [(-2.0, 0.25), (-1.0, 0.0), (0.0, 0.75)]);
        assert_eq!(means(&populations, 1), [(-2.0, 0.0), (-1.0, 0.5), (0.0, 0.5)]);
    }

    #[test]
    fn bins_cover_all_energies_and_few_energies_get_one_bin_each() {
        let energies: Vec<f64> = (0..250).map(|k| 0.7 * f64::from(k) - 60.0).collect();
        let all = bins(&energies);
        assert!(all.len() >= MOST_BINS / 4 && all.len() <= MOST_BINS);
        let mut next = 0;
        for (middle, width, places) in all {
            assert_eq!(places.start, next);
            next = places.end;
            assert!(energies[places].iter().all(|energy| (energy - middle).abs() <= 0.5 * width));
        }
        assert_eq!(next, energies.len());
        assert_eq!(bins(&[-1.0, 0.5]), [(-1.0, 0.0, 0..1), (0.5, 0.0, 1..2)]);
    }

    #[test]
    fn many_levels_become_bins_with_the_same_populations() {
        let mut populations = populations();
        let energy = |k: u32| f64::from((k * 7919) % 10_007) - 3000.0;
        for k in 0..10_007 {
            populations.add(&[energy(k), -2.0 * energy(k)]);
        }
        let width = populations.width.unwrap();
        assert!(populations.levels.len() <= MOST_BINS && populations.levels.len() >= MOST_BINS / 4);
        for (energy, mean) in means(&populations, 0).into_iter().filter(|(_, mean)| *mean > 0.0) {
            // Each integer from -3000 to 7006 was added once.
            let inside = (0..10_007).filter(|k| {
                (f64::from(*k) - 3000.0 - energy + 0.5 * width).floor() >= 0.0
                    && f64::from(*k) - 3000.0 < energy + 0.5 * width
            });
            assert!((mean * 10_007.0 - inside.count() as f64).abs() < 1e-6, "{energy} {width} {mean}");
        }
        let all: f64 = means(&populations, 1).iter().map(|(_, mean)| mean).sum();
        assert!((all - 1.0).abs() < 1e-12);
    }
}
