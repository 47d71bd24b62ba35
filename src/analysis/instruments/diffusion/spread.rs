//! Scatter of the mean squared displacements of single particles.

use serde::{Deserialize, Serialize};

use super::lags::Lags;
use crate::analysis::instruments::slope::straight_terms;

/// Slope of the squared displacement of each tracer over the straight part, and the difference between the slopes of its halves, summed over origins.
///
/// Spans of a run are few, and origins that overlap are not independent: their scatter says little of the error of their mean. Particles are many, and
/// where each goes its own way, the variance of a mean over `N` of them is `s^2 / N` with the variance `s^2` of one particle over all its origins,
/// however they overlap. What all have in common, as a temperature that fluctuates, is not in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Spread {
    /// Coefficients of the two by linear time.
    coefficients: Vec<[f64; 2]>,
    /// By tracer, over all origins that came to the span.
    sums: Vec<[f64; 2]>,
}

impl Spread {
    pub fn new(lags: &Lags, tracers: usize) -> Self {
        let mut coefficients = vec![[0.0; 2]; lags.steps + 1];
        for (kind, terms) in straight_terms(lags.steps, lags.interval(), 0).into_iter().flatten().enumerate() {
            for (step, coefficient) in terms {
                coefficients[step][kind] += coefficient;
            }
        }
        Self { coefficients, sums: vec![[0.0; 2]; tracers] }
    }

    /// Adds the squared displacement of each tracer after a linear time to the sums of an origin.
    pub fn follow(&self, slopes: &mut [[f64; 2]], step: usize, moved: impl Fn(usize) -> f64) {
        let [slope, bend] = self.coefficients[step];
        if slope != 0.0 || bend != 0.0 {
            for (k, sums) in slopes.iter_mut().enumerate() {
                let square = moved(k);
                sums[0] += slope * square;
                sums[1] += bend * square;
            }
        }
    }

    /// Adds the sums of an origin that has come to the span.
    pub fn add(&mut self, slopes: &[[f64; 2]]) {
        for (sum, slope) in self.sums.iter_mut().zip(slopes) {
            (0..2).for_each(|kind| sum[kind] += slope[kind]);
        }
    }

    /// The slope of a tracer (0) or its bend (1), summed over origins.
    pub fn sum(&self, tracer: usize, kind: usize) -> f64 {
        self.sums[tracer][kind]
    }
}
