//! Exact numbers with bounds on their floating-point errors, by running error analysis (Higham, *Accuracy and Stability
//! of Numerical Algorithms*, section 3.3). Every operation adds a rounding error to the propagated errors of the
//! operands.

use crate::dyadic::Dyadic;
use carom::Vector;
use std::ops::{Add, Mul, Sub};

/// Unit round-off: half the distance from 1 to the next floating-point number.
pub const ROUND_OFF: f64 = 0.5 * f64::EPSILON;

/// Compensates for the rounding of the bounds.
const SLACK: f64 = 1.0 + 8.0 * f64::EPSILON;

#[derive(Debug, Clone)]
pub struct Rounded {
    pub exact: Dyadic,
    /// Upper bound on the magnitude of `exact`.
    pub size: f64,
    pub error: f64,
}

impl Rounded {
    pub fn of(x: f64) -> Self {
        Self { exact: Dyadic::from(x), size: x.abs(), error: 0.0 }
    }

    fn result(exact: Dyadic, error: f64) -> Self {
        let size = exact.to_f64().abs() * SLACK;
        Self { exact, size, error: (error + ROUND_OFF * (size + error)) * SLACK }
    }

    pub fn half(&self) -> Self {
        Self { exact: self.exact.half(), size: 0.5 * self.size, error: 0.5 * self.error }
    }

    pub fn double(&self) -> Self {
        Self { exact: &self.exact + &self.exact, size: 2.0 * self.size, error: 2.0 * self.error }
    }

    pub fn negative(&self) -> Self {
        Self { exact: -&self.exact, ..*self }
    }
}

impl Add for &Rounded {
    type Output = Rounded;
    fn add(self, other: &Rounded) -> Rounded {
        Rounded::result(&self.exact + &other.exact, self.error + other.error)
    }
}

impl Sub for &Rounded {
    type Output = Rounded;
    fn sub(self, other: &Rounded) -> Rounded {
        Rounded::result(&self.exact - &other.exact, self.error + other.error)
    }
}

impl Mul for &Rounded {
    type Output = Rounded;
    fn mul(self, other: &Rounded) -> Rounded {
        let error = self.size * other.error + self.error * (other.size + other.error);
        Rounded::result(&self.exact * &other.exact, error)
    }
}

pub type Triple = [Rounded; 3];

pub fn triple(vector: &Vector) -> Triple {
    [0, 1, 2].map(|k| Rounded::of(vector[k]))
}

pub fn dot(a: &Triple, b: &Triple) -> Rounded {
    let [x, y, z] = [0, 1, 2].map(|k| &a[k] * &b[k]);
    &(&x + &y) + &z
}

/// `x - d (d . x)`, as in `carom::physics::detection::feature::across`. Rounding may have changed the length of the
/// direction. The effect is below the rounding error of the result.
pub fn across(direction: &Triple, vector: &Triple) -> Triple {
    let along = dot(direction, vector);
    [0, 1, 2].map(|k| &vector[k] - &(&direction[k] * &along))
}
