//! Proofs that a flight never reaches a discontinuity, from distances instead of roots. On a very long path, rounded
//! coefficients decide whether a polynomial has a root, so a search without a result proves nothing.

use super::approach::{Approach, Boundary};
use super::rules::Side;

/// Rounding error of a position, relative to the lengths that were added to compute it.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

const MOST_PIECES: u32 = 10_000;

/// Factor by which computed distances and times are increased, so that rounding cannot make them too small.
const BEYOND: f64 = 1.01;

impl Approach {
    /// Whether the flight provably has no later event. The rounded coordinates are as large as `size` `[length]`.
    /// Inside a sphere, no proof is needed: [`Self::next_event`] finds the event, unless the pair is at rest.
    pub fn is_clear(&self, size: f64) -> bool {
        // The proof needs a constant acceleration, but a surface that oscillates or turns changes it.
        if self.swing.is_some() {
            return false;
        }
        match self.boundary {
            Boundary::Plane => self.is_clear_of_plane(size),
            Boundary::Sphere { distance, side: Side::Positive } => self.recedes() || self.passes(distance, size),
            Boundary::Sphere { side: Side::Negative, .. } => true,
        }
    }

    fn is_clear_of_plane(&self, size: f64) -> bool {
        let (height, v, a) = (self.position.x, self.velocity.x, self.acceleration.x);
        if a <= 0.0 {
            return a == 0.0 && v >= 0.0;
        }
        let deepest = 0.5 * v * v / a;
        v >= 0.0 || height - deepest > ROUNDING * (size + height.abs() + deepest)
    }

    /// Returns true if the squared distance has no negative coefficient. The distance then never falls.
    fn recedes(&self) -> bool {
        let (r, v, a) = (&self.position, &self.velocity, &self.acceleration);
        v.dot(r) >= 0.0 && a.dot(r) + v.norm_squared() >= 0.0 && a.dot(v) >= 0.0
    }

    /// Whether the flight provably passes a sphere without contact. After a certain time, it is surely beyond the
    /// sphere. Until then, it is divided into pieces so short that bounds on speed and acceleration exclude a contact.
    fn passes(&self, distance: f64, size: f64) -> bool {
        let [length, speed, push] = [&self.position, &self.velocity, &self.acceleration].map(|vector| vector.norm());
        let from_rest = (length + distance) * BEYOND;
        let end = if push > 0.0 {
            (speed + (speed * speed + 2.0 * push * from_rest).sqrt()) / push
        } else {
            from_rest / speed
        };
        let mut pieces = vec![(0.5 * end * BEYOND, 0.5 * end * BEYOND)];
        for _ in 0..MOST_PIECES {
            let Some((middle, half)) = pieces.pop() else { return true };
            let Self { position, velocity, .. } = self.streamed(self.since + middle);
            let until = middle + half;
            let path = (speed + 0.5 * push * until) * until;
            let above = position.norm() - distance - ROUNDING * (size + length + distance + path);
            if !above.is_finite() || above <= 0.0 {
                return false;
            }
            if above <= (velocity.norm() + 0.5 * push * half) * half {
                let half = 0.5 * half;
                pieces.extend([(middle - half, half), (middle + half, half)]);
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    fn flight(position: [f64; 3], velocity: [f64; 3], gravity: f64, boundary: Boundary) -> Approach {
        let acceleration = Vector::new(0.0, 0.0, -gravity);
        let (position, velocity) = (position.into(), velocity.into());
        Approach { since: 2.0, position, velocity, acceleration, boundary, foot: None, swing: None }
    }

    #[test]
    fn a_pass_is_shown_unless_rounding_could_make_it_a_collision() {
        let outside = Boundary::Sphere { distance: 1.0, side: Side::Positive };
        for (position, velocity, gravity, expected) in [
            ([3.0, 1.1, 0.0], [-1.0, 0.0, 0.0], 0.0, true),
            ([3.0, 0.9, 0.0], [-1.0, 0.0, 0.0], 0.0, false),
            ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0], 0.0, true),
            ([0.5, 0.0, 0.0], [0.0, 0.0, 0.0], 0.0, true),
            ([1e7, 1.0 + 1e-5, 0.0], [-1.0, 0.0, 0.0], 0.0, true),
            ([1e7, 1.0 + 1e-9, 0.0], [-1.0, 0.0, 0.0], 0.0, false),
            ([2.0, 0.0, 3.0], [0.0, 0.0, 0.0], 1.0, true),
            ([0.9, 0.0, 3.0], [0.0, 0.0, 0.0], 1.0, false),
            ([-1.0, 0.0, 1.0], [1.0, 0.0, 1.0], 1.0, true),
            ([0.0, 0.0, 6.0], [0.0, 0.0, 1.0], 1e-9, false),
            ([0.0, 3.0, 6.0], [0.0, 0.0, 1.0], 1e-9, true),
        ] {
            let flight = flight(position, velocity, gravity, outside);
            assert_eq!(flight.is_clear(20.0), expected, "{flight:?}");
        }
        let close = flight([3.0, 1.1, 0.0], [-1.0, 0.0, 0.0], 0.0, outside);
        assert!(!close.is_clear(1e15), "round-off is too large at coordinates of 1e15");
    }

    #[test]
    fn plane_is_missed_by_receding_or_turning_flights() {
        for (height, velocity, gravity, expected) in [
            (1.0, 0.0, 0.0, true),
            (1.0, -1e-9, 0.0, false),
            (1.0, 1.0, 1e-9, false),
            (3.0, -2.0, -1.0, true),
            (2.0, -2.0, -1.0, false),
        ] {
            let mut flight = flight([height, 0.0, 0.0], [velocity, 0.0, 0.0], 0.0, Boundary::Plane);
            flight.acceleration.x = -gravity;
            assert_eq!(flight.is_clear(10.0), expected, "{flight:?}");
        }
    }
}
