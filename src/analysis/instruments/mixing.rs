//! How well species are mixed, in the cells of a grid.

use super::budgeted_times::budgeted_times;
use super::grid::Grid;
use super::instrument::{Instrument, Setup};
use super::quantity::{Curve, Measured, Number};
use super::rows_over_time::RowsOverTime;
use super::system::{Sample, SystemDescription};
use crate::analysis::sampling_times::SamplingTimes;
use crate::analysis::statistics::BlockAverage;
use crate::model::measurement_plan as plan;
use serde::{Deserialize, Serialize};

/// With more moving species than this, only the index of all species is measured.
const MOST_SPECIES: usize = 8;

/// Numbers of operations per particle, and per species and cell, in a sample.
const WORK: f64 = 10.0;
const WORK_OF_CELL: f64 = 4.0;

/// Index of mixing after Lacey (J. Appl. Chem. 4, 257, 1954), for cells with different numbers of particles.
///
/// Let the grid contain `N` moving particles, `n_k` of them in cell `k`, and let `K` cells be occupied. The variance of
/// the number fraction `c_k` of a species is `S^2 = sum (n_k / N) (c_k - p)^2`, with the fraction `p` in the whole grid.
/// It is `p (1 - p)` if each cell contains a single species, and on average `p (1 - p) (K - 1) / (N - 1)` if the
/// species are assigned to the particles at random. The index is
///
/// ```text
///     1 - sum S^2 / sum p (1 - p)
/// M = ---------------------------
///        1 - (K - 1) / (N - 1)
/// ```
///
/// The sums are over all species, or over one species. The index is 0 for separate species, and 1 on average for a
/// random mixture. It exceeds 1 if the species alternate.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Mixing {
    name: String,
    times: SamplingTimes,
    time: f64,
    grid: Grid,
    /// The species that are measured separately.
    species: Vec<u32>,
    /// The indices of all species together, and of each species in `species`.
    averages: Vec<BlockAverage>,
    rows: RowsOverTime,
}

impl Mixing {
    pub fn new(plan: &plan::Mixing, setup: &Setup<'_>) -> Self {
        let system = setup.system;
        let moving: Vec<u32> = system.moving_species().collect();
        // Two species have the same index.
        let species = if (3..=MOST_SPECIES).contains(&moving.len()) { moving } else { Vec::new() };
        let grid = Grid::new(plan.bins, plan.lower, plan.upper, &system.space);
        let in_cells = WORK_OF_CELL * (grid.cells() * system.species_masses.len()) as f64;
        let times = budgeted_times(setup, plan.interval, WORK * system.moving.len() as f64 + in_cells);
        let average = BlockAverage::new(times.interval());
        let mut mixing = Self {
            name: plan.name.clone(),
            time: setup.sample.time,
            grid,
            averages: vec![average; 1 + species.len()],
            species,
            rows: RowsOverTime::new(),
            times,
        };
        let first = mixing.indices(&setup.sample, system);
        mixing.rows.add(setup.sample.time, first);
        mixing
    }

    /// Returns the index of all species and of each species. `None` if it is not defined: in a single occupied cell, and
    /// if no cell contains two particles.
    fn indices(&self, sample: &Sample<'_>, system: &SystemDescription) -> Vec<Option<f64>> {
        let kinds = system.species_masses.len();
        // For each cell, the numbers of particles of all species.
        let mut counts = vec![0.0; self.grid.cells() * kinds];
        for (species, position) in sample.species.iter().zip(sample.positions) {
            if system.species_masses[species.0 as usize].is_finite()
                && let Some(cell) = self.grid.cell_of(position, &system.space)
            {
                counts[cell * kinds + species.0 as usize] += 1.0;
            }
        }
        // For each species, the sums of n_k c_k and of n_k c_k^2.
        let (mut totals, mut squares) = (vec![0.0; kinds], vec![0.0; kinds]);
        let mut occupied = 0.0;
        for cell in counts.chunks(kinds) {
            let number: f64 = cell.iter().sum();
            if number > 0.0 {
                occupied += 1.0;
                for ((total, square), count) in totals.iter_mut().zip(&mut squares).zip(cell) {
                    *total += count;
                    *square += count * count / number;
                }
            }
        }
        let all: f64 = totals.iter().sum();
        let fractions = || totals.iter().map(|total| total / all);
        let variances: Vec<f64> = squares.iter().zip(fractions()).map(|(square, p)| square / all - p * p).collect();
        let separate: Vec<f64> = fractions().map(|p| p * (1.0 - p)).collect();
        let random = (occupied - 1.0) / (all - 1.0);
        let index = |variance: f64, separate: f64| {
            let index = (1.0 - variance / separate) / (1.0 - random);
            (index.is_finite() && occupied > 1.0).then_some(index)
        };
        let of_all = index(variances.iter().sum(), separate.iter().sum());
        let each = self.species.iter().map(|&k| index(variances[k as usize], separate[k as usize]));
        [of_all].into_iter().chain(each).collect()
    }
}

impl Instrument for Mixing {
    fn next_sample(&self) -> f64 {
        self.times.next()
    }

    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        if !self.times.is_due(sample.time) {
            return;
        }
        let elapsed = sample.time - self.time;
        self.time = sample.time;
        let indices = self.indices(sample, system);
        for (average, index) in self.averages.iter_mut().zip(&indices) {
            index.iter().for_each(|index| average.add(*index, elapsed));
        }
        self.rows.add(sample.time, indices);
    }

    fn report(&self, system: &SystemDescription, measured: &mut Measured) {
        let name = format!("mixing_{}", self.name);
        let title = format!("Index of mixing {}", self.name);
        let mut curve = Curve::new(&name, &title, INDEX).variable("t", "time", self.rows.times());
        let titles = system.titles_of_all_and_of(self.species.iter().copied());
        for (index, ((key, of), average)) in titles.into_iter().zip(&self.averages).enumerate() {
            let (name, title) = (format!("{name}{key}"), format!("{title}{of}"));
            measured.numbers.push(Number::estimated(&name, &title, "1", average.estimate(), INDEX));
            curve = curve.series(&format!("index{of}"), "1", &self.rows.column(index));
        }
        measured.curves.push(curve);
    }
}

const INDEX: &str = "M = (1 - sum S^2 / sum p (1 - p)) / (1 - (K - 1) / (N - 1)) with the variances \
    S^2 = sum (n_k / N) (c_k - p)^2 of the fractions c_k of each species in K occupied cells, averaged over the samples: \
    0 for separate species, 1 for a random mixture.";

#[cfg(test)]
mod tests;
