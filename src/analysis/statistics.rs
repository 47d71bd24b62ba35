//! Means of correlated series with their standard errors, in bounded memory.

mod curve;
mod spectrum;
mod stationarity;

pub use curve::CurveAverage;
pub use stationarity::{Stationarity, stationarity};

use serde::{Deserialize, Serialize};
use spectrum::Density;

const MOST_BINS: usize = 1024;

/// Relative round-off error of a conserved quantity in a long run of `1e8` events.
pub(crate) const ROUNDING: f64 = 1e-11;

const FEWEST_VALUES: usize = 8;

/// Minimum number of independent values for a standard error. Smaller numbers are often estimated too high.
const FEWEST_INDEPENDENT: f64 = 8.0;

/// Minimum number of independent values for the error of a variance. With fewer, a small variance may be chance.
const FEWEST_FOR_VARIANCE: f64 = 16.0;

/// A mean with its standard error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Estimate {
    /// The mean over the whole series.
    pub mean: f64,
    /// Standard error of the mean; `None` if it is unknown, for example because the series is too short.
    pub standard_error: Option<f64>,
}

impl Estimate {
    /// Removes an error that is not finite. Returns `None` if the mean is not finite.
    #[must_use]
    pub(crate) fn finite(self) -> Option<Self> {
        let standard_error = self.standard_error.filter(|error| error.is_finite());
        self.mean.is_finite().then_some(Self { mean: self.mean, standard_error })
    }

    /// Divides the mean and the error by a nonzero constant.
    #[must_use]
    pub fn over(self, divisor: f64) -> Self {
        let standard_error = self.standard_error.map(|error| error / divisor.abs());
        Self { mean: self.mean / divisor, standard_error }
    }

    #[must_use]
    pub(crate) fn times(self, factor: f64) -> Self {
        let standard_error = self.standard_error.map(|error| error * factor.abs());
        Self { mean: self.mean * factor, standard_error }
    }
}

/// Block average of a correlated time series. The standard error includes the correlation.
///
/// Each value has a weight, such as the time that it covers. Values are collected in bins of equal weight. When there
/// are too many bins, neighbours merge and the bin weight doubles, so memory stays bounded.
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
    /// An empty series. `bin_weight` is the typical weight of a value, for example 1 for evenly spaced samples.
    #[must_use]
    pub fn new(bin_weight: f64) -> Self {
        Self::with_most_bins(MOST_BINS, bin_weight)
    }

    pub(crate) fn with_most_bins(most_bins: usize, bin_weight: f64) -> Self {
        Self { most_bins, bin_weight, bins: Vec::new(), open_sum: 0.0, open_weight: 0.0, sum: 0.0, weight: 0.0 }
    }

    /// Adds a value with a positive weight. Ignores other weights, and numbers that are not finite.
    pub fn add(&mut self, value: f64, weight: f64) {
        if !(value.is_finite() && weight.is_finite() && weight > 0.0) {
            return;
        }
        // If the bin weight came from a long first value, all later values together might not fill a second bin.
        if self.bins.len() == 1 && self.open_weight == 0.0 && 1.5 * weight < self.bin_weight {
            self.bin_weight = weight;
        }
        self.sum += value * weight;
        self.weight += weight;
        self.open_sum += value * weight;
        self.open_weight += weight;
        while weight > 1.5 * self.bin_weight && !self.bins.is_empty() {
            self.merge();
        }
        // Weights are differences of times. Because of round-off, even equal intervals have slightly different weights.
        if self.open_weight >= self.bin_weight * (1.0 - 1e-6) {
            self.bins.push(self.open_sum / self.open_weight);
            (self.open_sum, self.open_weight) = (0.0, 0.0);
        }
        if self.bins.len() >= self.most_bins {
            self.merge();
        }
    }

    /// The mean of all values; `None` without values. Thousands of times faster than [`Self::estimate`].
    #[must_use]
    pub fn mean(&self) -> Option<f64> {
        (self.weight > 0.0).then(|| self.sum / self.weight)
    }

    /// The mean of all values and its standard error; `None` if there are no values.
    #[must_use]
    pub fn estimate(&self) -> Option<Estimate> {
        self.mean().map(|mean| Estimate { mean, standard_error: error_of(&self.bins, mean, mean) })
    }

    /// The mean of a bounded quantity's time derivative. Only the ends of the series contribute to the error.
    pub(crate) fn estimate_of_ends(&self) -> Option<Estimate> {
        Some(Estimate { mean: self.mean()?, standard_error: error_of_ends(&self.bins) })
    }

    /// The mean and its error, if the difference from `other` is the time derivative of a bounded quantity. For
    /// example, the force on a wall and the virial have such a difference. If the error of the difference is unknown,
    /// uses [`Self::estimate`].
    pub(crate) fn estimate_beside(&self, other: &Self) -> Option<Estimate> {
        let difference = self.with(other, |own, other| own - other);
        let of_ends = difference.and_then(|difference| error_of_ends(&difference.bins));
        let errors = of_ends.zip(other.estimate()?.standard_error);
        let together = errors.map(|(of_ends, error)| libm::hypot(of_ends, error));
        Some(Estimate { standard_error: together.or(self.estimate()?.standard_error), mean: self.mean()? })
    }

    /// Applies a linear function to the values of two averages over the same times. `None` if the times differ.
    pub(crate) fn with(&self, other: &Self, combine: impl Fn(f64, f64) -> f64) -> Option<Self> {
        let is_together = self.weight == other.weight && self.bins.len() == other.bins.len();
        is_together.then(|| Self {
            bins: self.bins.iter().zip(&other.bins).map(|(a, b)| combine(*a, *b)).collect(),
            sum: combine(self.sum, other.sum),
            open_sum: combine(self.open_sum, other.open_sum),
            ..*self
        })
    }

    /// Calculates the ratio `R = a / b` of the means of `self` and of another average over the same times. Its standard
    /// error is the error of `(a - R b) / b`. `None` if either average has no values or if `b = 0`.
    #[must_use]
    pub fn ratio(&self, other: &Self) -> Option<Estimate> {
        let (a, b) = (self.mean()?, other.mean()?);
        if b == 0.0 {
            return None;
        }
        let ratio = a / b;
        let residues = self.with(other, |a, b| a - ratio * b);
        let error = residues.and_then(|residues| error_of(&residues.bins, 0.0, a));
        Some(Estimate { mean: ratio, standard_error: error.map(|error| error / b.abs()) })
    }

    /// The variance of the values, `s^2 = <x^2> - <x>^2 + d^2`, where `squares` contains the squares of the same
    /// values. `d^2` is the likeliest squared difference of the sample mean and the true mean.
    ///
    /// The error is the error of the mean of `x^2 - 2 <x> x`, but at least `e s`, where `e` is the standard error of
    /// the mean. Without this bound, a variance that is small by chance would have too small an error. The bound is
    /// `s^2 / sqrt(n)` for `n = (s / e)^2` independent values, because squares relax twice as fast as values.
    ///
    /// The error is unknown if `n` is less than 16. `None` if one of the averages has no values.
    #[must_use]
    pub fn variance(&self, squares: &Self) -> Option<Estimate> {
        let (mean, square) = (self.mean()?, squares.mean()?);
        let about_mean = (square - mean * mean).max(0.0);
        let Some(error) = self.estimate()?.standard_error else {
            return Some(Estimate { mean: about_mean, standard_error: None });
        };
        let variance = about_mean + likeliest_squared_error(&self.bins).unwrap_or(0.0);
        let residues = self.with(squares, |x, square| square - 2.0 * mean * x);
        let standard_error = residues
            .filter(|_| variance >= FEWEST_FOR_VARIANCE * error * error)
            .and_then(|residues| error_of(&residues.bins, square - 2.0 * mean * mean, square))
            .map(|of_residues| of_residues.max(error * variance.sqrt()));
        Some(Estimate { mean: variance, standard_error })
    }

    /// Whether the series is stationary.
    #[must_use]
    pub fn stationarity(&self) -> Stationarity {
        verdict_on(&self.bins, self.mean().unwrap_or(0.0))
    }

    pub(crate) fn is_constant(&self) -> bool {
        let mean = self.mean().unwrap_or(0.0);
        self.bins.iter().all(|x| (x - mean).abs() <= ROUNDING * mean.abs())
    }

    pub(crate) fn second_half(&self) -> Self {
        let bins = self.bins[self.bins.len() / 2..].to_vec();
        let sum = bins.iter().sum::<f64>() * self.bin_weight;
        let weight = bins.len() as f64 * self.bin_weight;
        Self { bins, sum, weight, open_sum: 0.0, open_weight: 0.0, ..*self }
    }

    /// Whether the ratio to another average over the same times is stationary; unknown if the divisor is ever zero.
    #[must_use]
    pub fn stationarity_of_ratio(&self, other: &Self) -> Stationarity {
        let ratios: Vec<f64> = self.bins.iter().zip(&other.bins).map(|(a, b)| a / b).collect();
        let ratio = self.mean().zip(other.mean()).map_or(f64::NAN, |(a, b)| a / b);
        verdict_on(&ratios, ratio)
    }

    pub(crate) fn add_series(&mut self, other: &Self) {
        self.sum += other.sum;
        self.open_sum += other.open_sum;
        self.bins.iter_mut().zip(&other.bins).for_each(|(bin, other)| *bin += other);
    }

    fn scale(&mut self, factor: f64) {
        self.sum *= factor;
        self.open_sum *= factor;
        self.bins.iter_mut().for_each(|bin| *bin *= factor);
    }

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

/// Tests whether a series of bins is stationary. The verdict is unknown if later values change a constant mean.
fn verdict_on(bins: &[f64], mean: f64) -> Stationarity {
    match stationarity(bins) {
        Stationarity::Constant if differs_from_constant(bins, mean, mean) => Stationarity::Unknown,
        verdict => verdict,
    }
}

/// Whether all full bins are equal, but later values change the mean.
fn differs_from_constant(bins: &[f64], mean: f64, scale: f64) -> bool {
    let first = bins.first().copied().unwrap_or(mean);
    let rounding = ROUNDING * scale.abs().max(first.abs());
    bins.iter().all(|x| (x - first).abs() <= rounding) && (first - mean).abs() > rounding
}

/// The argument `mean` includes values after the last full bin.
fn error_of(bins: &[f64], mean: f64, scale: f64) -> Option<f64> {
    if differs_from_constant(bins, mean, scale) { None } else { standard_error(bins) }
}

/// The standard error of the mean of `n` changes of a stationary quantity `A` with variance `s^2`: `sqrt(2) s / n`.
/// `None` if the series is too short to determine `s`, or if `A` is unbounded like a random walk.
pub(crate) fn error_of_ends(series: &[f64]) -> Option<f64> {
    let sums: Vec<f64> = series
        .iter()
        .scan(0.0, |sum, x| {
            *sum += x;
            Some(*sum)
        })
        .collect();
    let n = series.len() as f64;
    let mean = sums.iter().sum::<f64>() / n;
    let variance = sums.iter().map(|sum| (sum - mean) * (sum - mean)).sum::<f64>() / n;
    // The variance about the sample mean is too small by the squared error of the sample mean.
    let of_mean = standard_error(&sums)?;
    Some((2.0 * (variance + of_mean * of_mean)).sqrt() / n)
}

fn halved(blocks: &[f64]) -> Vec<f64> {
    blocks.chunks_exact(2).map(|pair| 0.5 * (pair[0] + pair[1])).collect()
}

/// The standard error of the mean of a correlated series.
///
/// The variance of the mean of `n` values is `S(0) / n` with the spectral density `S(0)` at frequency zero, the sum of
/// all autocovariances. It is estimated from a fit of white noise, relaxations, and changes of a bounded quantity, as
/// in the virial of a crystal. The fit resolves slow motion under fast noise, as in a heat bath.
///
/// An error from few independent values is uncertain. Student's distribution enlarges the error, so that the true mean
/// is within one error of the mean in 68.27 % of all cases.
///
/// `None` for fewer than eight independent values, or if the slowest motion in the fit has most of the variance. This
/// motion relaxes in a twelfth of the series. If it has most of `S(0)`, the error is enlarged by up to `sqrt(3)`.
#[must_use]
pub fn standard_error(series: &[f64]) -> Option<f64> {
    let Spread { variance, density } = spread(series)?;
    let n = series.len() as f64;
    let Some(density) = density else { return Some((variance / n).sqrt()) };
    let independent = n.min(n / density.at_zero);
    (independent >= FEWEST_INDEPENDENT)
        .then(|| student(independent - 1.0) * (density.at_zero * density.doubt * variance / n).sqrt())
}

/// The squared error of the mean by maximum likelihood, without the factors that enlarge [`standard_error`].
fn likeliest_squared_error(series: &[f64]) -> Option<f64> {
    let Spread { variance, density } = spread(series)?;
    Some(density.map_or(1.0, |density| density.at_zero) * variance / series.len() as f64)
}

struct Spread {
    variance: f64,
    /// Spectral density at frequency zero. `None` for a series that is constant within round-off.
    density: Option<Density>,
}

/// `None` for fewer than eight values, or if the spectral density cannot be determined.
fn spread(series: &[f64]) -> Option<Spread> {
    let n = series.len() as f64;
    if series.len() < FEWEST_VALUES {
        return None;
    }
    let mean = series.iter().sum::<f64>() / n;
    let deviations: Vec<f64> = series.iter().map(|x| x - mean).collect();
    let variance = deviations.iter().map(|x| x * x).sum::<f64>() / (n - 1.0);
    if variance.sqrt() <= ROUNDING * mean.abs() {
        return Some(Spread { variance, density: None });
    }
    Some(Spread { variance, density: Some(spectrum::density_at_zero(&deviations, variance)?) })
}

/// Width of the central 68.27 % of Student's distribution, relative to a Gaussian. The expansion to second order in
/// `1 / freedom` (M. Abramowitz and I. A. Stegun, 26.7.5) is accurate to 0.1 % for seven degrees of freedom.
pub(crate) fn student(freedom: f64) -> f64 {
    1.0 + 0.5 / freedom + 0.25 / (freedom * freedom)
}

#[derive(Debug, Clone, Copy)]
pub(crate) struct Correlation {
    /// The statistical inefficiency: the number of values per independent value, at least one.
    pub inefficiency: f64,
    /// Factor by which the true inefficiency may exceed the estimate; above 1 if most correlation is slow.
    pub doubt: f64,
}

/// `None` for fewer than eight values, or if the spectral density is unknown. A constant series is uncorrelated.
pub(crate) fn correlation(series: &[f64]) -> Option<Correlation> {
    let none = Correlation { inefficiency: 1.0, doubt: 1.0 };
    let of = |density: Density| Correlation { inefficiency: density.at_zero.max(1.0), doubt: density.doubt };
    Some(spread(series)?.density.map_or(none, of))
}

#[cfg(test)]
pub(crate) mod tests;
