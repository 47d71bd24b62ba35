//! Stretches of time in which an overlap function asks for an event, and the extents of a feature that the event has to be on.

use super::plane;
use crate::Vector;
use crate::physics::motion::RelativeState;

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
            let mut others = extents.iter().enumerate().filter(|(other, _)| *other != k);
            others.all(|(_, other)| other.value(at) >= 0.0).then_some(at)
        };
        extents.iter().enumerate().filter_map(enters).reduce(f64::min)
    }
}

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
