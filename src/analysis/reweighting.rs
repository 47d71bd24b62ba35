//! Averages at temperatures between the simulated ones, from the energies at these.
//!
//! Samples of the potential energy of several ensembles, at several temperatures or with weights of the energy, are gathered in [`EnergyHistograms`], in two passes: the first finds the levels that occur. Together they determine the
//! [`DensityOfStates`], and that the moments of the energy at all temperatures between. [`Reweighting`] has errors, too.
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

/// Samples of blocks that are drawn for an error, which so has an error of 5 % of its own.
const RESAMPLES: usize = 200;

/// Length of a block in correlation times, or rather the statistical inefficiency.
const BLOCK_LENGTH: f64 = 5.0;

/// Blocks that there are at least, as long as they are longer than half of one.
const FEWEST_BLOCKS: usize = 16;

/// There are no errors of a series that is worth fewer independent values, as for those of means.
const FEWEST_INDEPENDENT: f64 = 8.0;

/// The density of states with densities of other samples of the same kind, from which errors of all that follows from it are known.
///
/// Time is cut into blocks of five correlation times of the energy: those of the ensemble in which it is slowest. Of these, as many as there are are drawn with replacement, 200 times, the same blocks of all
/// ensembles, because replicas that are swapped correlate them. The standard deviation of what follows from the samples that were drawn is the error. It is
/// larger by the correlation that blocks of this length miss, and by Student's factor for their number.
///
/// H. R. Künsch, Ann. Statist. 17, 1217 (1989), [doi:10.1214/aos/1176347265](https://doi.org/10.1214/aos/1176347265).
#[derive(Debug, Clone)]
pub struct Reweighting {
    density: DensityOfStates,
    resamples: Vec<DensityOfStates>,
    /// Of a standard deviation, for the error.
    factor: f64,
    blocks: usize,
}

impl Reweighting {
    /// Of histograms; the blocks that are drawn follow from a seed. `None` where energies of the ensembles do not overlap, or where there are none.
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

    /// Number of blocks that the errors are from; 0 without errors.
    #[must_use]
    pub fn blocks(&self) -> usize {
        self.blocks
    }

    /// Numbers that follow from a density of states, with their errors. There are none of a series that is too short for them, or of which some samples that are drawn do not overlap.
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

/// The standard deviation of numbers.
fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let count = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / count;
    (values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / (count - 1.0)).sqrt()
}

/// Blocks that may be drawn instead of each other.
struct Blocks {
    /// Where each ends and the next one begins, in blocks of the histograms.
    ends: Vec<usize>,
    /// Of a standard deviation, for the error.
    factor: f64,
}

impl Blocks {
    /// `None` of a series that is too short.
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
        // Of deviations from the mean of the sample, and in so few blocks.
        let of_number = student(n - 1.0) * (n / (n - 1.0)).sqrt();
        let factor = of_number * (slowest.doubt / in_blocks(inefficiency, length)).sqrt();
        Some(Self { ends: (0..=blocks).map(|block| block * count / blocks).collect(), factor })
    }
}

/// The part of the variance of a mean that blocks of a length have in them, of values with correlations that decay as `r^k`, whose inefficiency is
/// `g = (1 + r) / (1 - r)`: about `1 - x` with `x = (g^2 - 1) / (2 g L)`.
fn in_blocks(inefficiency: f64, length: f64) -> f64 {
    let x = (inefficiency - inefficiency.recip()) / (2.0 * length);
    if x > 0.0 { 1.0 - x * (1.0 - libm::exp(-x.recip())) } else { 1.0 }
}

#[cfg(test)]
mod tests;
