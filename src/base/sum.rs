//! Sums that compensate for rounding errors.

use serde::{Deserialize, Serialize};

/// Compensated sum (Neumaier). Without it, round-off would hide errors of the dynamics in the balance of a long run.
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

    /// Returns the sum of all terms so far.
    #[inline]
    #[must_use]
    pub fn total(&self) -> f64 {
        self.sum + self.correction
    }
}
