//! Averages at temperatures between the simulated temperatures.
//!
//! [`EnergyHistograms`] count the potential energies in several ensembles. The histograms determine the
//! [`DensityOfStates`], from which the moments of the energy are calculated. [`Reweighting`] estimates errors.
//!
//! ```
//! use carom::analysis::reweighting::{Ensemble, MultiHistogram};
//!
//! // Two levels. The upper one has three states: at T = 1, it has 3 / (3 + e) of the samples.
//! let upper = |t: f64| 3.0 / (3.0 + (1.0 / t).exp());
//! let (ensembles, samples) = (Ensemble::canonical(&[0.5, 2.0]), [1e4, 1e4]);
//! let in_upper = 1e4 * (upper(0.5) + upper(2.0));
//! let histogram =
//!     MultiHistogram { ensembles: &ensembles, samples: &samples, energies: &[-1.0, 0.0], counts: &[2e4 - in_upper, in_upper] };
//! let density = histogram.solve(&[0.0, 0.0]).expect("the energies at both temperatures overlap");
//! assert!((density.at(1.0).mean + 1.0 - upper(1.0)).abs() < 1e-12);
//! ```

mod density_of_states;
mod ensemble;
mod histograms;
mod spacing;

pub use density_of_states::{DensityOfStates, Moments, MultiHistogram};
pub use ensemble::Ensemble;
pub use histograms::{EnergyHistograms, EnergyLevels};

use super::statistics::{Correlation, Estimate, correlation, student};
use crate::model::random::{Purpose, Random};

/// Number of resamples. The errors have an uncertainty of 5 %.
const RESAMPLES: usize = 200;

/// Length of a block in correlation times.
const BLOCK_LENGTH: f64 = 5.0;

/// Minimum number of blocks, unless the histograms have fewer.
const FEWEST_BLOCKS: usize = 16;

/// Minimum number of independent energies for a standard error.
const FEWEST_INDEPENDENT: f64 = 8.0;

/// The density of states with errors from resampling.
///
/// Time is cut into blocks of five correlation times of the energy in the slowest ensemble. Each of 200 resamples has
/// as many blocks as the data, drawn with replacement. The same blocks are drawn for all ensembles, because swaps
/// correlate the replicas. The error is the standard deviation over the resamples, multiplied by two factors. These
/// factors correct for the correlation between blocks and for the small number of blocks (Student's factor).
///
/// H. R. Künsch, Ann. Statist. 17, 1217 (1989), [doi:10.1214/aos/1176347265](https://doi.org/10.1214/aos/1176347265).
#[derive(Debug, Clone)]
pub struct Reweighting {
    density: DensityOfStates,
    resamples: Vec<DensityOfStates>,
    /// Ratio of the reported error to the standard deviation over the resamples.
    factor: f64,
    blocks: usize,
}

impl Reweighting {
    /// Determines the density of states. Returns `None` if there are no samples, or if the energies of the ensembles do
    /// not overlap. `seed` selects the resamples.
    #[must_use]
    pub fn new(histograms: &EnergyHistograms, seed: u64) -> Option<Self> {
        if histograms.is_empty() {
            return None;
        }
        let (energies, variances) = histograms.energies();
        let start = MultiHistogram::start(histograms.ensembles(), &histograms.means());
        let solve = |counts: &histograms::Counts, start: &[f64]| {
            let density = counts.solve(histograms.ensembles(), &energies, start)?;
            Some(density.with_variances(&variances).with_means(counts.means()))
        };
        let density = solve(&histograms.counts(0..histograms.blocks()), &start)?;
        let Some(Blocks { ends, factor }) = Blocks::of(histograms) else {
            return Some(Self { density, resamples: Vec::new(), factor: f64::NAN, blocks: 0 });
        };
        let blocks: Vec<_> = ends.windows(2).map(|ends| histograms.counts(ends[0]..ends[1])).collect();
        let mut random = Random::new(seed, Purpose::Bootstrap, 0);
        let mut drawn = || {
            let mut sum = blocks[random.below(blocks.len())].clone();
            (1..blocks.len()).for_each(|_| sum.add(&blocks[random.below(blocks.len())]));
            sum
        };
        let resamples = (0..RESAMPLES).filter_map(|_| solve(&drawn(), density.free_energies())).collect();
        Some(Self { resamples, factor, blocks: blocks.len(), density })
    }

    /// The density of states.
    #[must_use]
    pub fn density(&self) -> &DensityOfStates {
        &self.density
    }

    /// Number of blocks from which the errors were calculated; 0 if the errors are unknown.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.blocks
    }

    /// Estimates numbers that `of` calculates from the density of states. A number has no error if the series is too
    /// short, or if the energies of the ensembles do not overlap in a resample.
    pub fn estimates(&self, of: impl Fn(&DensityOfStates) -> Vec<f64>) -> Vec<Estimate> {
        let means = of(&self.density);
        let drawn: Vec<Vec<f64>> = self.resamples.iter().map(of).collect();
        let estimate = |(place, mean): (usize, &f64)| {
            let values = || drawn.iter().filter_map(|values| values.get(place)).copied();
            let error = (drawn.len() == RESAMPLES).then(|| self.factor * deviation(values()));
            Estimate { mean: *mean, standard_error: error.filter(|error| error.is_finite()) }
        };
        means.iter().enumerate().map(estimate).collect()
    }
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0)).sqrt()
}

struct Blocks {
    /// Boundaries of the resampled blocks, in blocks of the histograms.
    ends: Vec<usize>,
    factor: f64,
}

impl Blocks {
    fn of(histograms: &EnergyHistograms) -> Option<Self> {
        let count = histograms.blocks();
        let mut slowest = Correlation { inefficiency: 1.0, doubt: 1.0 };
        for place in 0..histograms.ensembles().len() {
            let here = correlation(&histograms.series(place))?;
            if here.inefficiency > slowest.inefficiency {
                slowest = here;
            }
        }
        let inefficiency = slowest.inefficiency;
        if count as f64 / inefficiency < FEWEST_INDEPENDENT {
            return None;
        }
        let asked = crate::base::numbers::trunc_to_usize(count as f64 / (BLOCK_LENGTH * inefficiency));
        let blocks = asked.max(FEWEST_BLOCKS).min(count);
        let length = count as f64 / blocks as f64;
        let n = blocks as f64;
        // For few blocks: Student's factor, and a correction because the deviations are from the sample mean.
        let of_number = student(n - 1.0) * (n / (n - 1.0)).sqrt();
        let factor = of_number * (slowest.doubt / in_blocks(inefficiency, length)).sqrt();
        Some(Self { ends: (0..=blocks).map(|block| block * count / blocks).collect(), factor })
    }
}

/// Returns the fraction of the variance of a mean that independent blocks of length `L` reproduce. For correlations
/// `r^k` with the inefficiency `g = (1 + r) / (1 - r)`, it is about `1 - x` with `x = (g^2 - 1) / (2 g L)`.
fn in_blocks(inefficiency: f64, length: f64) -> f64 {
    let x = (inefficiency - inefficiency.recip()) / (2.0 * length);
    if x > 0.0 { 1.0 - x * (1.0 - libm::exp(-x.recip())) } else { 1.0 }
}

#[cfg(test)]
mod tests;
