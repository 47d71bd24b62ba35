//! Standard error of the diffusion coefficient, from the scatter between particles and between axes.

use serde::{Deserialize, Serialize};

use super::lags::Lags;
use super::tracers::Tracers;
use crate::Vector;
use crate::analysis::instruments::slope::straight_terms;
use crate::analysis::statistics::student;

/// Smallest number of degrees of freedom for an error estimate.
const FEWEST: f64 = 4.0;

/// Scatter of two numbers for each tracer and axis. The slope of the squared displacement, over the straight part of
/// the curve, has the index 0. The bend, with the index 1, is the difference between the slopes of the two halves.
///
/// A run has few spans, and overlapping origins are not independent, so the scatter of origins alone says little about
/// the error of a short run. Two more sources help:
/// - There are many particles. If they move independently, a mean over `N` particles has the variance `s^2 / N`, where
///   `s^2` is the variance of one particle over all origins. This estimate does not include the flow around each
///   moving particle, which decays as `1 / r`.
/// - Axes are independent, and the correlation of overlapping origins is known for a Brownian path with the diffusion
///   coefficient `D`. The squared displacements in two time intervals have the covariance `8 D^2 o^2`, where `o` is
///   the overlap of the intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Spread {
    /// Least-squares coefficients of each linear lag, for the slope (0) and for the bend (1).
    coefficients: Vec<[f64; 2]>,
    stride: usize,
    /// Slope and bend of each tracer, summed over all origins that have reached the span.
    sums: Vec<[f64; 2]>,
    /// Number of origins that have reached the span. For each group, axis, slope and bend, `axes` contains the mean
    /// over these origins and the sum of squared deviations.
    origins: u64,
    axes: Vec<[[[f64; 2]; 2]; 3]>,
}

#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Slopes {
    /// Slope and bend of each tracer, summed over the axes.
    tracers: Vec<[f64; 2]>,
    /// For each group and axis, the mean slope and bend of the tracers of the group.
    axes: Vec<[[f64; 2]; 3]>,
}

impl Spread {
    pub fn new(lags: &Lags, tracers: &Tracers) -> Self {
        let mut coefficients = vec![[0.0; 2]; lags.steps + 1];
        for (kind, terms) in straight_terms(lags.steps, lags.interval(), 0).into_iter().flatten().enumerate() {
            for (step, coefficient) in terms {
                coefficients[step][kind] += coefficient;
            }
        }
        let stride = usize::try_from(lags.stride).unwrap_or(usize::MAX);
        let axes = vec![[[[0.0; 2]; 2]; 3]; tracers.groups()];
        Self { coefficients, stride, sums: vec![[0.0; 2]; tracers.len()], origins: 0, axes }
    }

    pub fn begin(&self) -> Slopes {
        Slopes { tracers: vec![[0.0; 2]; self.sums.len()], axes: vec![[[0.0; 2]; 3]; self.axes.len()] }
    }

    pub fn follow(&self, slopes: &mut Slopes, step: usize, tracers: &Tracers, moved: impl Fn(usize) -> Vector) {
        let coefficients = self.coefficients[step];
        if coefficients == [0.0; 2] {
            return;
        }
        for (k, sums) in slopes.tracers.iter_mut().enumerate() {
            let square = moved(k).norm_squared();
            (0..2).for_each(|kind| sums[kind] += coefficients[kind] * square);
        }
        for axis in 0..3 {
            let means = tracers.means(|k| moved(k)[axis] * moved(k)[axis]);
            for (of_group, mean) in slopes.axes.iter_mut().zip(means) {
                (0..2).for_each(|kind| of_group[axis][kind] += coefficients[kind] * mean);
            }
        }
    }

    pub fn add(&mut self, slopes: &Slopes) {
        for (sum, slope) in self.sums.iter_mut().zip(&slopes.tracers) {
            (0..2).for_each(|kind| sum[kind] += slope[kind]);
        }
        self.origins += 1;
        for (moments, slope) in self.axes.iter_mut().flatten().flatten().zip(slopes.axes.iter().flatten().flatten()) {
            let [mean, squares] = moments;
            let before = slope - *mean;
            *mean += before / self.origins as f64;
            *squares += before * (slope - *mean);
        }
    }

    pub fn sum(&self, tracer: usize, kind: usize) -> f64 {
        self.sums[tracer][kind]
    }

    /// Standard error of the mean slope (0) or bend (1) of a group, from the scatter of origins along each axis. `None`
    /// if there are too few independent origins.
    pub fn error_by_axes(&self, group: usize, kind: usize) -> Option<f64> {
        let origins = self.origins as f64;
        let together = self.variance_of_mean_of_origins(kind);
        let used = |axis: &[[f64; 2]; 2]| axis[kind][1] > 0.0;
        let axes = self.axes.get(group)?.iter().filter(|axis| used(axis));
        let freedom = axes.clone().count() as f64 * (1.0 / together - 1.0);
        let variance = |axis: &[[f64; 2]; 2]| axis[kind][1] / (origins * (1.0 - together)) * together;
        (freedom >= FEWEST).then(|| student(freedom) * axes.map(variance).sum::<f64>().sqrt())
    }

    /// For a Brownian path, variance of the mean over all origins, divided by the variance of one origin:
    /// `sum r_ij / n^2` with the correlations `r_ij` of the `n` origins.
    fn variance_of_mean_of_origins(&self, kind: usize) -> f64 {
        let span = self.coefficients.len() - 1;
        // Element `k` is the sum of the coefficients of all linear lags from `k` on.
        let mut from = vec![0.0; span + 2];
        for k in (0..=span).rev() {
            from[k] = from[k + 1] + self.coefficients[k][kind];
        }
        // The intervals `[0, k]` and `[shift, shift + l]` overlap by `l` if the second interval ends first
        // (`of_other`), and by `k - shift` otherwise (`of_own`).
        let covariance = |shift: usize| -> f64 {
            let square = |k: usize| (k * k) as f64 * self.coefficients[k][kind];
            let of_other = |l: usize| square(l) * from[(shift + l + 1).min(span + 1)];
            let of_own = |k: usize| ((k - shift) * (k - shift)) as f64 * self.coefficients[k][kind] * from[k - shift];
            (0..=span).map(of_other).sum::<f64>() + (shift..=span).map(of_own).sum::<f64>()
        };
        let (origins, own) = (self.origins as f64, covariance(0));
        let others = (1..self.origins).map_while(|apart| {
            let shift = usize::try_from(apart).ok()?.checked_mul(self.stride)?;
            (shift < span).then(|| 2.0 * (1.0 - apart as f64 / origins) * covariance(shift) / own)
        });
        (1.0 + others.sum::<f64>()) / origins
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn covariance_of_origins_matches_brownian_path_overlap() {
        let coefficients: Vec<[f64; 2]> =
            (0..=13).map(|k| [f64::from(k % 5) - 1.5, f64::from(k * k % 7) - 2.0]).collect();
        let (stride, origins) = (4, 6);
        let spread = Spread { coefficients, stride, sums: Vec::new(), origins, axes: Vec::new() };
        for kind in 0..2 {
            // If two Gaussian displacements have the covariance `c`, their squares have the covariance `2 c^2`. Here,
            // `c` is proportional to the overlap of the two time intervals.
            let covariance = |shift: usize| -> f64 {
                let of = |k: usize, l: usize| {
                    let overlap = (k.min(shift + l) as f64 - shift as f64).max(0.0);
                    spread.coefficients[k][kind] * spread.coefficients[l][kind] * overlap * overlap
                };
                (0..14).map(|k| (0..14).map(|l| of(k, l)).sum::<f64>()).sum()
            };
            let pairs = (0..6_usize).flat_map(|i| (0..6_usize).map(move |j| stride * i.abs_diff(j)));
            let expected = pairs.map(covariance).sum::<f64>() / (36.0 * covariance(0));
            let found = spread.variance_of_mean_of_origins(kind);
            assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
        }
    }
}
