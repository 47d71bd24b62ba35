//! Stretches of time in which an overlap function asks for an event, and the extents of a feature that the event has to be on.

use super::plane;
use crate::Vector;
use crate::physics::motion::RelativeState;

/// A stretch of time, `[from, until)`, in which an overlap function is not positive and falls.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Its beginning, from now `[time]`.
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
        // Times are compared, not values: at a corner, rounding may leave either of two extents negative when the other one rises.
        let mut at = self.from;
        // Each extent rises once at most, and may have to be asked again for all others.
        for _ in 0..=extents.len() {
            for extent in extents {
                at = extent.first_on(self.from, at).filter(|at| *at < self.until)?;
            }
        }
        Some(at)
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

    /// The first time from `at` on at which it is not negative, of those after `from`; none if it stays negative.
    fn first_on(&self, from: f64, at: f64) -> Option<f64> {
        let [_, b, c] = self.0;
        let (value, rate) = (self.value(from), b + 2.0 * c * from);
        let root = || (rate * rate - 4.0 * c * value).sqrt();
        if value < 0.0 {
            let rises = from + plane::next_event(-value, -rate, -2.0 * c)?;
            // Bent downwards it ends where it falls again.
            let is_on = c >= 0.0 || at <= from + (rate + root()) / (-2.0 * c);
            return is_on.then_some(at.max(rises));
        }
        // Bent upwards it may dip below zero and come back.
        let ends = plane::next_event(value, rate, 2.0 * c).map(|after| from + after);
        match ends {
            Some(ends) if at > ends => (c > 0.0).then(|| at.max(from + (root() - rate) / (2.0 * c))),
            _ => Some(at),
        }
    }
}
