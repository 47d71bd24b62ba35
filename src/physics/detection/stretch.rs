//! Intervals of time in which an overlap function requires an event, and the extents of a feature within
//! which the foot must be.

use super::plane;
use crate::Vector;
use crate::physics::motion::RelativeState;

/// An interval of time, `[from, until)`, in which an overlap function is falling and not positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stretch {
    /// Beginning of the interval, relative to now `[time]`.
    pub from: f64,
    /// End of the interval, relative to now `[time]`.
    pub until: f64,
}

impl Stretch {
    /// The first time in the interval at which no extent is negative.
    #[must_use]
    pub fn first_on(&self, extents: &[Parabola]) -> Option<f64> {
        if self.from >= self.until {
            return None;
        }
        if extents.iter().all(|extent| extent.value(self.from) >= 0.0) {
            return Some(self.from);
        }
        // The foot reaches the feature during the interval. This happens only if rounding, or a bend due to
        // rounding, hid the contact with an edge. The code compares times instead of values, because at a
        // corner rounding may leave either extent negative at the time when the other rises.
        let mut at = self.from;
        // Each extent rises at most once. It may have to be tested again after each of the other extents.
        for _ in 0..=extents.len() {
            for extent in extents {
                at = extent.first_on(self.from, at).filter(|at| *at < self.until)?;
            }
        }
        Some(at)
    }
}

/// A quadratic polynomial in time, constant first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parabola(pub [f64; 3]);

impl Parabola {
    /// The component of a motion along a direction, relative to the origin of the motion's position.
    #[inline]
    #[must_use]
    pub fn along(direction: &Vector, state: &RelativeState, acceleration: &Vector) -> Self {
        Self([direction.dot(&state.position), direction.dot(&state.velocity), 0.5 * direction.dot(acceleration)])
    }

    /// The value of the polynomial at a time.
    #[inline]
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        (self.0[2] * t + self.0[1]) * t + self.0[0]
    }

    /// The polynomial `constant - b(t)`.
    #[inline]
    #[must_use]
    pub fn from_end(&self, constant: f64) -> Self {
        Self([constant - self.0[0], -self.0[1], -self.0[2]])
    }

    /// The first time from `at` on at which the polynomial is not negative; `None` if it stays negative. The
    /// motion is considered from `from` on.
    fn first_on(&self, from: f64, at: f64) -> Option<f64> {
        let [_, b, c] = self.0;
        let (value, rate) = (self.value(from), b + 2.0 * c * from);
        let root = || (rate * rate - 4.0 * c * value).sqrt();
        if value < 0.0 {
            let rises = from + plane::next_event(-value, -rate, -2.0 * c)?;
            // If the polynomial is curved downwards, its positive interval ends where it falls to zero again.
            let is_on = c >= 0.0 || at <= from + (rate + root()) / (-2.0 * c);
            return is_on.then_some(at.max(rises));
        }
        // If the polynomial is curved upwards, it may fall below zero and return.
        let ends = plane::next_event(value, rate, 2.0 * c).map(|after| from + after);
        match ends {
            Some(ends) if at > ends => (c > 0.0).then(|| at.max(from + (root() - rate) / (2.0 * c))),
            _ => Some(at),
        }
    }
}
