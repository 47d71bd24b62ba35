//! Free flight: the motion of a particle between events, and the relative motion of two particles.

use crate::Vector;

/// Position after free flight for a time `dt` (paper, equation 1): `r(t + dt) = r + dt v + dt^2/2 a`.
#[inline]
#[must_use]
pub fn stream_position(position: &Vector, velocity: &Vector, acceleration: &Vector, dt: f64) -> Vector {
    position + (velocity + acceleration * (0.5 * dt)) * dt
}

/// The motion of particle i relative to particle j: `r_ij = r_i - r_j`, `v_ij = v_i - v_j`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelativeState {
    /// Separation `r_ij` `[length]`.
    pub position: Vector,
    /// Relative velocity `v_ij` `[length / time]`.
    pub velocity: Vector,
}
