//! A sphere and a fixed feature of a surface: a point, a line or a face, whole or of a limited extent.
//!
//! The overlap function of a feature sees the part of the motion across it only: all of it for a point, two directions for a line, one for a face. Where
//! the feature has ends, the rule of [`crate::physics::detection`] counts while the foot of the perpendicular is on it, ends included:
//!
//! > The first time at which `f <= 0`, `df/dt < 0`, and no extent `b_k < 0`.
//!
//! Nothing is assigned to one of two features that share an end: where rounding lets the foot miss a face, the line along its edge is there.
//! Feet move along parabolas, so extents are `b(t) = b0 + b1 t + b2 t^2` (theory: the stable rule, feature by feature).

use super::{accelerated, inertial, plane};
use crate::Vector;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::{Quadratic, Quartic, Side};

/// A polynomial of degree two in time, constant first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parabola(pub [f64; 3]);

impl Parabola {
    /// The component of a motion along a direction, from a point that the motion's position is relative to.
    #[inline]
    #[must_use]
    pub fn along(direction: &Vector, state: &RelativeState, acceleration: &Vector) -> Self {
        Self([direction.dot(&state.position), direction.dot(&state.velocity), 0.5 * direction.dot(acceleration)])
    }

    /// Its value.
    #[inline]
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        (self.0[2] * t + self.0[1]) * t + self.0[0]
    }

    /// The polynomial with the opposite sign, from a constant: `constant - b(t)`.
    #[inline]
    #[must_use]
    pub fn from_end(&self, constant: f64) -> Self {
        Self([constant - self.0[0], -self.0[1], -self.0[2]])
    }

    /// The first time after `from` at which it comes back to positive values; none if it does not.
    fn next_rise(&self, from: f64) -> Option<f64> {
        let [_, b, c] = self.0;
        let (value, rate) = (self.value(from), b + 2.0 * c * from);
        let after = if value < 0.0 {
            plane::next_event(-value, -rate, -2.0 * c)?
        } else {
            // Positive now: it may dip below zero, if it falls and bends upwards.
            let discriminant = rate * rate - 4.0 * c * value;
            if !(c > 0.0 && rate < 0.0 && discriminant > 0.0) {
                return None;
            }
            (discriminant.sqrt() - rate) / (2.0 * c)
        };
        Some(from + after)
    }
}

/// A stretch of time, `[from, until)`, in which an overlap function is not positive and falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Its beginning, from now on.
    pub from: f64,
    /// Its end.
    pub until: f64,
}

impl Stretch {
    /// The first time of the stretch at which no extent is negative.
    #[must_use]
    pub fn first_on(&self, extents: &[Parabola]) -> Option<f64> {
        if self.from >= self.until {
            return None;
        }
        if extents.iter().all(|extent| extent.value(self.from) >= 0.0) {
            return Some(self.from);
        }
        // The foot comes onto the feature during the stretch: only where rounding, or a bend of rounding, let an edge through.
        let enters = |(k, extent): (usize, &Parabola)| {
            let at = extent.next_rise(self.from).filter(|at| *at < self.until)?;
            let others = extents.iter().enumerate().filter(|(other, _)| *other != k);
            others.into_iter().all(|(_, other)| other.value(at) >= 0.0).then_some(at)
        };
        extents.iter().enumerate().filter_map(enters).reduce(f64::min)
    }
}

/// The next contact with a point at the origin, from outside of the distance `s` or from inside.
#[inline]
#[must_use]
pub fn point(state: &RelativeState, acceleration: &Vector, squared: f64, side: Side) -> Option<f64> {
    if *acceleration == Vector::zeros() {
        inertial::next_event(&Quadratic::new(state, squared), side)
    } else {
        accelerated::next_event(&Quartic::new(state, acceleration, squared), side)
    }
}

/// The part of a vector across a direction of length 1.
#[inline]
#[must_use]
pub fn across(direction: &Vector, vector: &Vector) -> Vector {
    vector - direction * direction.dot(vector)
}

/// The next contact with a line through the origin, of an endless extent.
#[inline]
#[must_use]
pub fn line(direction: &Vector, state: &RelativeState, acceleration: &Vector, squared: f64, side: Side) -> Option<f64> {
    let (state, acceleration) = motion_across(direction, state, acceleration);
    point(&state, &acceleration, squared, side)
}

fn motion_across(direction: &Vector, state: &RelativeState, acceleration: &Vector) -> (RelativeState, Vector) {
    let RelativeState { position, velocity } = state;
    let state = RelativeState { position: across(direction, position), velocity: across(direction, velocity) };
    // An acceleration along the line is none: what rounding leaves of it would be a fall of 1e16 diameters.
    let beside = across(direction, acceleration);
    let is_none = beside.norm() <= 4.0 * f64::EPSILON * acceleration.norm();
    (state, if is_none { Vector::zeros() } else { beside })
}

/// The next contact, from outside, with the part of a line from the origin to a length along its direction.
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
        let f = Quadratic::new(&state, squared);
        let from = inertial::positive(&f)?;
        // It falls until the shortest distance; of a contact that grazes that may be rounded to its beginning.
        let until = (-f.b / f.v2).max(from.next_up());
        return Stretch { from, until }.first_on(&extents);
    }
    let f = Quartic::new(&state, &acceleration, squared);
    accelerated::falling_stretches(&f).into_iter().flatten().find_map(|stretch| stretch.first_on(&extents))
}

/// The next contact with a face through the origin, on either side of it, whose foot is where no extent is negative.
#[must_use]
pub fn face(height: &Parabola, distance: f64, extents: &[Parabola]) -> Option<f64> {
    let [position, velocity, half] = height.0;
    let on_side = |sign: f64| {
        let (height, velocity, acceleration) = (sign * position, sign * velocity, sign * 2.0 * half);
        let from = plane::next_event(height - distance, velocity, acceleration)?;
        let until = plane::next_event(height, velocity, acceleration).unwrap_or_else(|| {
            // It turns before the face itself.
            if acceleration > 0.0 { -velocity / acceleration } else { f64::INFINITY }
        });
        Stretch { from, until }.first_on(extents)
    };
    match (on_side(1.0), on_side(-1.0)) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

#[cfg(test)]
mod meshes;
#[cfg(test)]
mod tests;
