//! Overlap functions: positive in valid states, negative in invalid states, zero on the discontinuity.
//!
//! The overlap function of a pair outside the distance `s` is `f+(dt) = |r_ij(dt)|^2 - s^2`. The overlap function of a
//! pair inside is `f- = -f+` (paper, equation 5). Without relative acceleration, the function is a [`Quadratic`], with
//! relative acceleration a [`Quartic`].

use crate::Vector;
use crate::physics::motion::RelativeState;
use serde::{Deserialize, Serialize};

/// Valid side of a discontinuity for a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Side {
    /// Outside the discontinuity. The overlap function is `f+` (Core, Capture).
    Positive,
    /// Inside the discontinuity. The overlap function is `f-` (Bounce, Release).
    Negative,
}

impl Side {
    /// `+1` or `-1`, the factor that turns `f+` into the overlap function of this side.
    #[inline]
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

/// `f+` of a pair without relative acceleration: `V2 dt^2 + 2 B dt + R2` (paper, equation 8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadratic {
    /// `R2 = |r|^2 - s^2` `[length^2]`.
    pub r2: f64,
    /// `B = v . r` `[length^2 / time]`.
    pub b: f64,
    /// `V2 = |v|^2` `[length^2 / time^2]`.
    pub v2: f64,
}

impl Quadratic {
    /// Creates the overlap function from a relative state and the squared distance of the discontinuity `[length^2]`.
    #[inline]
    #[must_use]
    pub fn new(state: &RelativeState, distance_squared: f64) -> Self {
        Self {
            r2: state.position.norm_squared() - distance_squared,
            b: state.velocity.dot(&state.position),
            v2: state.velocity.norm_squared(),
        }
    }

    /// `f+(dt)`.
    #[inline]
    #[must_use]
    pub fn value(&self, dt: f64) -> f64 {
        (self.v2 * dt + 2.0 * self.b) * dt + self.r2
    }

    /// Derivative of `f+` at the time `dt`: `2 (V2 dt + B)`.
    #[inline]
    #[must_use]
    pub fn derivative(&self, dt: f64) -> f64 {
        2.0 * (self.v2 * dt + self.b)
    }
}

/// `f+` of a pair with relative acceleration (paper, equation 6):
/// `(A2/4) dt^4 + (a.v) dt^3 + (a.r + V2) dt^2 + 2 B dt + R2`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quartic {
    /// Coefficients, constant first.
    pub coefficients: [f64; 5],
    /// Squared distance of the discontinuity, `s^2` `[length^2]`. It sets the scale of Algorithm 6.
    pub distance_squared: f64,
}

impl Quartic {
    /// Creates the overlap function from the relative state and acceleration, and the squared distance `[length^2]`.
    #[inline]
    #[must_use]
    pub fn new(state: &RelativeState, acceleration: &Vector, distance_squared: f64) -> Self {
        let RelativeState { position: r, velocity: v } = state;
        Self {
            coefficients: [
                r.norm_squared() - distance_squared,
                2.0 * v.dot(r),
                acceleration.dot(r) + v.norm_squared(),
                acceleration.dot(v),
                0.25 * acceleration.norm_squared(),
            ],
            distance_squared,
        }
    }

    /// `f+(dt)`.
    #[inline]
    #[must_use]
    pub fn value(&self, dt: f64) -> f64 {
        let c = &self.coefficients;
        (((c[4] * dt + c[3]) * dt + c[2]) * dt + c[1]) * dt + c[0]
    }

    /// Coefficients of `df+/dt` (paper, equation 7), constant first: `2 B, 2 (a.r + V2), 3 (a.v), A2`.
    #[inline]
    #[must_use]
    pub fn derivative(&self) -> [f64; 4] {
        let c = &self.coefficients;
        [c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::motion::stream_position;

    #[test]
    fn overlap_function_equals_distance_after_free_flight() {
        let state = RelativeState { position: Vector::new(1.5, -0.25, 0.5), velocity: Vector::new(-1.0, 0.5, 0.125) };
        let acceleration = Vector::new(0.25, 0.0, -1.0);
        let zero = Vector::zeros();
        for dt in [0.0, 0.5, 1.0, 3.0] {
            // All inputs are small binary fractions, so every operation is exact.
            let at = stream_position(&state.position, &state.velocity, &zero, dt);
            assert_eq!(Quadratic::new(&state, 1.0).value(dt), at.norm_squared() - 1.0);
            let at = stream_position(&state.position, &state.velocity, &acceleration, dt);
            assert_eq!(Quartic::new(&state, &acceleration, 1.0).value(dt), at.norm_squared() - 1.0);
        }
    }

    #[test]
    fn overlap_derivatives_match_finite_differences() {
        let state = RelativeState { position: Vector::new(1.0, 2.0, 0.5), velocity: Vector::new(-1.0, 0.5, 0.25) };
        let quadratic = Quadratic::new(&state, 1.0);
        // For a quadratic function, a central difference is exact.
        assert_eq!(quadratic.derivative(0.5), (quadratic.value(1.0) - quadratic.value(0.0)) / 1.0);
        let quartic = Quartic::new(&state, &Vector::new(0.0, 0.0, -1.0), 1.0);
        let c = quartic.coefficients;
        assert_eq!(quartic.derivative(), [c[1], 2.0 * c[2], 3.0 * c[3], 4.0 * c[4]]);
    }
}
