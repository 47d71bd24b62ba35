//! Intervals in which an overlap function is falling and not positive.

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
    /// Returns the first time in the interval at which no extent is negative.
    #[must_use]
    pub fn first_on(&self, extents: &[Parabola]) -> Option<f64> {
        if self.from >= self.until {
            return None;
        }
        if extents.iter().all(|extent| extent.value(self.from) >= 0.0) {
            return Some(self.from);
        }
        // At a corner, two extents become positive together. Rounding may leave one negative, so times are compared.
        let mut at = self.from;
        // Each extent delays the time `at` at most once. After each delay, all extents are tested again.
        for _ in 0..=extents.len() {
            for extent in extents {
                at = extent.first_on(self.from, at).filter(|at| *at < self.until)?;
            }
        }
        Some(at)
    }
}

/// A quadratic polynomial in time. The first coefficient is the constant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parabola(pub [f64; 3]);

impl Parabola {
    /// Returns the component of a motion along a direction, as a function of time.
    #[inline]
    #[must_use]
    pub fn along(direction: &Vector, state: &RelativeState, acceleration: &Vector) -> Self {
        Self([direction.dot(&state.position), direction.dot(&state.velocity), 0.5 * direction.dot(acceleration)])
    }

    /// Returns the value of the polynomial at a time.
    #[inline]
    #[must_use]
    pub fn value(&self, t: f64) -> f64 {
        (self.0[2] * t + self.0[1]) * t + self.0[0]
    }

    /// Returns `constant` minus the polynomial: the extent at the other end of a feature of this length.
    #[inline]
    #[must_use]
    pub fn from_end(&self, constant: f64) -> Self {
        Self([constant - self.0[0], -self.0[1], -self.0[2]])
    }

    /// Returns the first time at or after `at` at which the polynomial is not negative; `None` if it stays negative.
    /// Only values from the time `from` on count, which must not be later than `at`.
    fn first_on(&self, from: f64, at: f64) -> Option<f64> {
        let [_, b, c] = self.0;
        let (value, rate) = (self.value(from), b + 2.0 * c * from);
        let root = || (rate * rate - 4.0 * c * value).sqrt();
        if value < 0.0 {
            let rises = from + plane::next_event(-value, -rate, -2.0 * c)?;
            // A polynomial that is curved downwards falls to zero again.
            let is_on = c >= 0.0 || at <= from + (rate + root()) / (-2.0 * c);
            return is_on.then_some(at.max(rises));
        }
        // A polynomial that is curved upwards may fall below zero and rise again.
        let ends = plane::next_event(value, rate, 2.0 * c).map(|after| from + after);
        match ends {
            Some(ends) if at > ends => (c > 0.0).then(|| at.max(from + (root() - rate) / (2.0 * c))),
            _ => Some(at),
        }
    }
}
