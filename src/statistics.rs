//! Means of correlated series, with their standard errors, in bounded memory.

mod curve;

pub use curve::CurveAverage;

use serde::{Deserialize, Serialize};

/// Bins are merged pairwise when there are this many.
const MOST_BINS: usize = 1024;

/// The coarsest level of the blocking analysis has at least this many blocks: with fewer, the error of the error,
/// `1 / sqrt(2 (n - 1))`, exceeds a quarter.
const FEWEST_BLOCKS: usize = 8;

/// A mean with its uncertainty.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean over the whole series.
    pub mean: f64,
    /// Its standard error; `None` where the series is too short to tell.
    pub standard_error: Option<f64>,
}

impl Estimate {
    /// The estimate of the same quantity divided by a constant other than zero.
    #[must_use]
    pub fn over(self, divisor: f64) -> Self {
        let standard_error = self.standard_error.map(|error| error / divisor.abs());
        Self { mean: self.mean / divisor, standard_error }
    }
}

/// A sum that keeps what rounding cuts off (Neumaier), so that ledgers measure the dynamics and not the adding up.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Sum {
    sum: f64,
    correction: f64,
}

impl Sum {
    /// Adds a term.
    #[inline]
    pub fn add(&mut self, x: f64) {
        let sum = self.sum + x;
        self.correction += if self.sum.abs() >= x.abs() { (self.sum - sum) + x } else { (x - sum) + self.sum };
        self.sum = sum;
    }

    /// The sum of all terms so far.
    #[inline]
    #[must_use]
    pub fn total(&self) -> f64 {
        self.sum + self.correction
    }
}

/// A running mean of a series whose neighbouring values are correlated, as those of a trajectory are.
///
/// Values come with a weight, the time that they stand for. They are gathered in bins of equal weight; when there are too
/// many bins, neighbours merge and the weight doubles, so that memory stays bounded for any length of the series.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BlockAverage {
    most_bins: usize,
    bin_weight: f64,
    bins: Vec<f64>,
    open_sum: f64,
    open_weight: f64,
    sum: f64,
    weight: f64,
}

impl BlockAverage {
    /// An empty series, whose bins begin with the weight of one value.
    #[must_use]
    pub fn new(bin_weight: f64) -> Self {
        Self::with_most_bins(MOST_BINS, bin_weight)
    }

    /// An empty series that merges its bins when there are `most_bins`.
    fn with_most_bins(most_bins: usize, bin_weight: f64) -> Self {
        Self { most_bins, bin_weight, bins: Vec::new(), open_sum: 0.0, open_weight: 0.0, sum: 0.0, weight: 0.0 }
    }

    /// Adds a value that stands for a time of `weight`. Nothing that is not finite, or has no weight, is added.
    pub fn add(&mut self, value: f64, weight: f64) {
        if !(value.is_finite() && weight.is_finite() && weight > 0.0) {
            return;
        }
        self.sum += value * weight;
        self.weight += weight;
        self.open_sum += value * weight;
        self.open_weight += weight;
        while weight > 1.5 * self.bin_weight && !self.bins.is_empty() {
            self.merge();
        }
        // Times of even intervals are differences of times, and so even only to within round-off.
        if self.open_weight >= self.bin_weight * (1.0 - 1e-6) {
            self.bins.push(self.open_sum / self.open_weight);
            (self.open_sum, self.open_weight) = (0.0, 0.0);
        }
        if self.bins.len() >= self.most_bins {
            self.merge();
        }
    }

    /// The mean of all values and its standard error; `None` if there are no values.
    #[must_use]
    pub fn estimate(&self) -> Option<Estimate> {
        (self.weight > 0.0)
            .then(|| Estimate { mean: self.sum / self.weight, standard_error: standard_error(&self.bins) })
    }

    /// Joins neighbouring bins; one left over is opened again.
    fn merge(&mut self) {
        if self.bins.len() % 2 == 1
            && let Some(last) = self.bins.pop()
        {
            self.open_sum += last * self.bin_weight;
            self.open_weight += self.bin_weight;
        }
        self.bins = halved(&self.bins);
        self.bin_weight *= 2.0;
    }
}

/// Means of neighbours; one left over is dropped.
fn halved(blocks: &[f64]) -> Vec<f64> {
    blocks.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
}

/// The standard error of the mean of a correlated series, by blocking.
///
/// Of `n` blocks with variance `c`, the mean has the variance `c / (n - 1)` if they are independent, known to within the
/// factor `1 +- sqrt(2 / (n - 1))`. Each joining of neighbours makes the blocks less dependent; from the level on where
/// they are independent the estimate stays the same. The first level that no coarser one significantly (by two of its
/// uncertainties) exceeds is taken: Flyvbjerg and Petersen, J. Chem. Phys. 91, 461 (1989),
/// [doi:10.1063/1.457480](https://doi.org/10.1063/1.457480).
///
/// `None` for fewer than eight values.
#[must_use]
pub fn standard_error(series: &[f64]) -> Option<f64> {
    let mut levels: Vec<(f64, f64)> = Vec::new();
    let mut blocks = series.to_vec();
    while blocks.len() >= FEWEST_BLOCKS {
        let n = blocks.len() as f64;
        let mean = blocks.iter().sum::<f64>() / n;
        let variance = blocks.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n * (n - 1.0));
        levels.push((variance, 2.0 * (2.0 / (n - 1.0)).sqrt()));
        blocks = halved(&blocks);
    }
    let is_plateau = |(index, (variance, _)): &(usize, &(f64, f64))| {
        levels[index + 1..].iter().all(|(coarser, uncertainty)| coarser * (1.0 - uncertainty) <= *variance)
    };
    levels.iter().enumerate().find(is_plateau).map(|(_, (variance, _))| variance.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    /// `x' = rho x + noise`, uniform noise of variance 1/12.
    fn correlated(rho: f64, length: usize, seed: u64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut x = 0.0;
        let mut next = || {
            let noise = (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
            x = rho * x + noise;
            x
        };
        (0..1000).for_each(|_| {
            next();
        });
        (0..length).map(|_| next()).collect()
    }

    #[test]
    fn the_error_of_a_correlated_series_is_that_of_theory() {
        // The mean of n values of an AR(1) series has the variance s^2 / (n (1 - rho)^2) for large n.
        for (rho, seed) in [(0.0, 1), (0.5, 2), (0.9, 3)] {
            let n = 65_536;
            let error = standard_error(&correlated(rho, n, seed)).unwrap();
            let exact = (1.0 / 12.0_f64).sqrt() / ((1.0 - rho) * (n as f64).sqrt());
            // The plateau is found with some 512 blocks or more: 3 / sqrt(2 * 511) = 9 %, and as much for its choice.
            assert!((error / exact - 1.0).abs() < 0.2, "rho {rho}: {error} but {exact}");
        }
    }

    #[test]
    fn the_true_mean_lies_within_two_errors_as_often_as_it_should() {
        let is_near = |seed: &u64| {
            let mut average = BlockAverage::new(1.0);
            correlated(0.8, 4000, *seed).iter().for_each(|&x| average.add(x, 1.0));
            let Estimate { mean, standard_error } = average.estimate().unwrap();
            mean.abs() < 2.0 * standard_error.unwrap()
        };
        let near = (100..200).filter(is_near).count();
        // 95 of 100 are expected, with a standard deviation of 2.1; a noisy error costs a few.
        assert!((86..=100).contains(&near), "{near}");
    }

    #[test]
    fn memory_is_bounded_and_the_mean_is_exact() {
        let mut average = BlockAverage::new(0.5);
        (0..100_000).for_each(|k| average.add(f64::from(k), 0.5));
        assert!(average.bins.len() < MOST_BINS);
        assert_eq!(average.estimate().unwrap().mean, 49_999.5);
        let binned = average.bins.iter().sum::<f64>() * average.bin_weight + average.open_sum;
        assert_eq!(binned, average.sum);
    }

    #[test]
    fn longer_and_cut_off_intervals_count_by_their_time() {
        let mut average = BlockAverage::new(1.0);
        (0..21).for_each(|_| average.add(1.0, 1.0));
        (0..10).for_each(|_| average.add(2.0, 2.0));
        average.add(7.0, 0.5);
        assert_eq!(average.estimate().unwrap().mean, (21.0 + 40.0 + 3.5) / 41.5);
        assert_eq!(average.bin_weight, 2.0);
        assert_eq!(average.bins.len(), 20, "ten of ones, one begun by the odd one, and nine of twos");
    }

    #[test]
    fn too_little_is_none_and_never_nan() {
        let mut average = BlockAverage::new(1.0);
        assert_eq!(average.estimate(), None);
        average.add(f64::NAN, 1.0);
        average.add(1.0, 0.0);
        assert_eq!(average.estimate(), None);
        (0..7).for_each(|_| average.add(3.0, 1.0));
        assert_eq!(average.estimate(), Some(Estimate { mean: 3.0, standard_error: None }));
        average.add(3.0, 1.0);
        assert_eq!(average.estimate(), Some(Estimate { mean: 3.0, standard_error: Some(0.0) }));
    }
}
