//! A sphere and a fixed feature of a surface: a point, a line or a face, unbounded or bounded.
//!
//! The overlap function depends only on the motion perpendicular to the feature: three components for a point, two for
//! a line, one for a face. If the feature is bounded, the extent `b_k` is the signed distance from the end `k` to the
//! foot of the perpendicular. It is negative beyond the end. A contact is possible while the foot is on the feature or
//! at an end. The rule of [`crate::physics::detection`] then becomes:
//!
//! > The first time at which `f <= 0`, `df/dt < 0`, and no extent `b_k < 0`.
//!
//! At an end that two features share, either feature may report a contact. If rounding moves the foot off a face, the
//! line along the edge of the face still reports the contact. The foot moves along a parabola, so the extents are
//! `b(t) = b0 + b1 t + b2 t^2`.

use super::stretch::Parabola;
use super::{accelerated, inertial, plane};
use crate::Vector;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::{Quadratic, Quartic, Side};

/// Returns the time when a particle reaches the distance `s` from the origin, coming from the given side of this
/// distance. The argument `squared` is `s^2`.
#[inline]
#[must_use]
pub fn point(state: &RelativeState, acceleration: &Vector, squared: f64, side: Side) -> Option<f64> {
    if *acceleration == Vector::zeros() {
        inertial::next_event(&Quadratic::new(state, squared), side)
    } else {
        accelerated::next_event(&Quartic::new(state, acceleration, squared), side)
    }
}

/// Returns the component of a vector perpendicular to a unit vector.
#[inline]
#[must_use]
pub fn across(direction: &Vector, vector: &Vector) -> Vector {
    vector - direction * direction.dot(vector)
}

/// Returns the time of the next contact with an infinite line through the origin.
#[inline]
#[must_use]
pub fn line(direction: &Vector, state: &RelativeState, acceleration: &Vector, squared: f64, side: Side) -> Option<f64> {
    let (state, acceleration) = motion_across(direction, state, acceleration);
    point(&state, &acceleration, squared, side)
}

fn motion_across(direction: &Vector, state: &RelativeState, acceleration: &Vector) -> (RelativeState, Vector) {
    let RelativeState { position, velocity } = state;
    let state = RelativeState { position: across(direction, position), velocity: across(direction, velocity) };
    // If the acceleration is along the line, its perpendicular part is only round-off.
    let beside = across(direction, acceleration);
    let is_none = beside.norm() <= 4.0 * f64::EPSILON * acceleration.norm();
    (state, if is_none { Vector::zeros() } else { beside })
}

/// Returns the time of the next contact, from outside, with a segment that begins at the origin.
#[must_use]
pub fn segment(
    direction: &Vector,
    length: f64,
    state: &RelativeState,
    acceleration: &Vector,
    squared: f64,
) -> Option<f64> {
    let foot = Parabola::along(direction, state, acceleration);
    let extents = [foot, foot.from_end(length)];
    let (state, acceleration) = motion_across(direction, state, acceleration);
    if acceleration == Vector::zeros() {
        return inertial::falling_stretch(&Quadratic::new(&state, squared))?.first_on(&extents);
    }
    let f = Quartic::new(&state, &acceleration, squared);
    accelerated::falling_stretches(&f).into_iter().flatten().find_map(|stretch| stretch.first_on(&extents))
}

/// Returns the time of the next contact with a face, from either side. `height` is the signed distance of the particle
/// from the plane of the face, `distance` is the absolute height at contact, and no extent is negative at the contact.
#[must_use]
pub fn face(height: &Parabola, distance: f64, extents: &[Parabola]) -> Option<f64> {
    let [position, velocity, half] = height.0;
    let on_side = |sign: f64| {
        let (height, velocity, acceleration) = (sign * position, sign * velocity, sign * 2.0 * half);
        plane::falling_stretch(height, distance, velocity, acceleration)?.first_on(extents)
    };
    match (on_side(1.0), on_side(-1.0)) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod tests;
