//! The distance of a pair from a discontinuity, or of a particle from a wall or a surface, as a function of time.

use super::foot::Foot;
use super::rules::{Side, fly};
use super::swing::Swing;
use super::world::World;
use crate::Vector;
use crate::check::reference::{Polynomial, first_on, next_event};
use crate::engine::States;
use std::sync::Arc;

/// The overlap function is a quartic, so its derivative has at most three roots.
const MOST_TURNS: usize = 3;
/// Relative offset from a computed root, larger than the rounding error of the root.
const BESIDE: f64 = 8.0 * f64::EPSILON;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Boundary {
    /// A sphere of this radius around the partner `[length]`, approached from one side.
    Sphere { distance: f64, side: Side },
    /// The plane on which the first coordinate is zero.
    Plane,
}

/// A relative flight that begins at a certain time in the window.
#[derive(Debug, Clone)]
pub(super) struct Approach {
    /// Time in the window at which the flight begins `[time]`.
    pub since: f64,
    pub position: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    pub boundary: Boundary,
    /// Projection of the particle onto a feature with ends. The discontinuity exists only between the ends.
    pub foot: Option<Foot>,
    /// The motion beside a surface that oscillates or turns; `None` if the acceleration is constant.
    pub swing: Option<Arc<Swing>>,
}

impl Approach {
    pub fn of_pair(world: &World, states: &States, [i, j]: [u32; 2], since: f64, boundary: Boundary) -> Self {
        let of = |values: &[Vector]| values[i as usize] - values[j as usize];
        let position = world.nearest(states, i, j);
        let (velocity, acceleration) = (of(&states.velocities), of(&world.accelerations));
        Self { since, position, velocity, acceleration, boundary, foot: None, swing: None }
    }

    /// Returns the time of the next event; `None` if no event occurs up to `until`. Times are counted in the window.
    pub fn next_event(&self, until: f64) -> Option<f64> {
        if let Some(swing) = &self.swing {
            return swing.next_event(self.since, until);
        }
        let f = self.polynomial();
        let after = match &self.foot {
            Some(foot) => first_on(&f, &foot.polynomials()),
            None => next_event(&f),
        };
        after.map(|dt| self.since + dt).filter(|time| *time <= until)
    }

    /// Whether the projection of the particle is on the feature. Always true for a feature without ends.
    pub fn is_on(&self, time: f64) -> bool {
        match &self.swing {
            Some(swing) => swing.at(time).is_on_now(),
            None => self.foot.is_none_or(|foot| foot.within(time - self.since) >= 0.0),
        }
    }

    pub fn is_on_now(&self) -> bool {
        self.foot.is_none_or(|foot| foot.within(0.0) >= 0.0)
    }

    /// Returns the distance from the discontinuity at a time in the window, positive on the valid side `[length]`. It
    /// is computed from positions, because the overlap function is inaccurate for a small gap.
    pub fn gap(&self, time: f64) -> f64 {
        self.streamed(time).gap_now()
    }

    pub fn gap_now(&self) -> f64 {
        match self.boundary {
            Boundary::Sphere { distance, side } => side.sign() * (self.position.norm() - distance),
            Boundary::Plane => self.position.x,
        }
    }

    /// Returns the smallest gap between two times in the window. Except at `from`, only gaps on the feature count.
    pub fn lowest(&self, from: f64, to: f64) -> f64 {
        if let Some(swing) = &self.swing {
            return swing.lowest(from, to);
        }
        let mut lowest = self.gap(from);
        let mut look = |time: f64| {
            if self.is_on(time) {
                lowest = lowest.min(self.gap(time));
            }
        };
        look(to);
        // The gap is smallest at a turning point of the overlap function, or at an end of the feature.
        let turns = self.polynomial().derivative();
        let ends = self.foot.iter().flat_map(Foot::polynomials);
        for polynomial in [turns].into_iter().chain(ends) {
            let mut after = from - self.since;
            for _ in 0..MOST_TURNS {
                let Some(at) = polynomial.next_root(after).filter(|at| *at < to - self.since) else { break };
                look(self.since + at * (1.0 - BESIDE));
                // The exact root may be slightly later than the computed root, and must not be found again.
                after = at * (1.0 + BESIDE);
                look(self.since + after);
            }
        }
        lowest
    }

    /// Speed towards the invalid side at a time in the window `[length / time]`.
    pub fn closing(&self, time: f64) -> f64 {
        self.streamed(time).closing_now()
    }

    pub fn closing_now(&self) -> f64 {
        let Self { position: at, velocity, .. } = self;
        match self.boundary {
            Boundary::Sphere { side, .. } => -side.sign() * velocity.dot(at) / at.norm().max(f64::MIN_POSITIVE),
            Boundary::Plane => -velocity.x,
        }
    }

    /// Returns the same flight, starting at a later time in the window.
    pub fn streamed(&self, time: f64) -> Self {
        if let Some(swing) = &self.swing {
            return swing.at(time);
        }
        let dt = time - self.since;
        let (position, velocity) = fly(&self.position, &self.velocity, &self.acceleration, dt);
        Self { since: time, position, velocity, foot: self.foot.map(|foot| foot.streamed(dt)), ..self.clone() }
    }

    /// Magnitude of the second time derivative of the gap at the start of the flight `[length / time^2]`.
    pub fn curvature(&self) -> f64 {
        let Self { position, velocity, .. } = self;
        match self.boundary {
            Boundary::Sphere { .. } => {
                let distance = position.norm().max(f64::MIN_POSITIVE);
                let normal = velocity.dot(position) / distance;
                let tangential = velocity.norm_squared() - normal * normal;
                (tangential / distance + self.acceleration.dot(position) / distance).abs()
            }
            Boundary::Plane => self.acceleration.x.abs(),
        }
    }

    /// The overlap function of the time since the start of the flight: `|r + v t + a t^2 / 2|^2 - s^2`, or its negative
    /// if the pair is inside the discontinuity.
    fn polynomial(&self) -> Polynomial {
        let (r, v, a) = (&self.position, &self.velocity, &self.acceleration);
        match self.boundary {
            Boundary::Sphere { distance, side } => {
                let coefficients = [
                    r.norm_squared() - distance * distance,
                    2.0 * v.dot(r),
                    a.dot(r) + v.norm_squared(),
                    a.dot(v),
                    0.25 * a.norm_squared(),
                ];
                Polynomial::new(&coefficients.map(|c| side.sign() * c))
            }
            Boundary::Plane => Polynomial::new(&[r.x, v.x, 0.5 * a.x]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn falling(height: f64, velocity: f64) -> Approach {
        Approach {
            since: 1.0,
            position: Vector::new(height, 0.0, 0.0),
            velocity: Vector::new(velocity, 0.0, 0.0),
            acceleration: Vector::new(-1.0, 0.0, 0.0),
            boundary: Boundary::Plane,
            foot: None,
            swing: None,
        }
    }

    #[test]
    fn ball_reaches_the_floor_at_the_exact_time() {
        let ball = falling(0.5, 0.0);
        assert_eq!(ball.next_event(f64::INFINITY), Some(2.0));
        assert_eq!((ball.gap(1.0), ball.gap(2.0), ball.closing(2.0)), (0.5, 0.0, 1.0));
    }

    #[test]
    fn the_lowest_gap_is_found_between_the_ends() {
        // The particles pass each other at a distance of 1/2, at time 3.
        let pair = Approach {
            since: 1.0,
            position: Vector::new(-2.0, 0.5, 0.0),
            velocity: Vector::new(1.0, 0.0, 0.0),
            acceleration: Vector::zeros(),
            boundary: Boundary::Sphere { distance: 1.0, side: Side::Positive },
            foot: None,
            swing: None,
        };
        assert_eq!(pair.lowest(1.0, 5.0), -0.5);
        assert_eq!(pair.lowest(4.0, 5.0), pair.gap(4.0));
        assert!(pair.next_event(f64::INFINITY).is_some_and(|time| pair.gap(time).abs() < 1e-15));
    }
    #[test]
    fn a_feature_is_met_between_its_ends_only() {
        // At the time `1 + t`, the height is `1 - t^2 / 2`, and the projection is at `3 - t` on a feature from 0 to 2.
        let to_end = Foot { extents: [[3.0, -1.0, 0.0], [-1.0, 1.0, 0.0], [0.0; 3], [0.0; 3]], slenderness: 1.0 };
        let ball = Approach { foot: Some(to_end), ..falling(1.0, 0.0) };
        assert_eq!(ball.next_event(f64::INFINITY), Some(1.0 + 2.0_f64.sqrt()));
        assert!(!ball.is_on(1.5) && ball.is_on(2.0) && ball.is_on(4.0) && !ball.is_on(4.5));
        let later = ball.streamed(2.5);
        assert!(later.is_on(2.5) && later.is_on(4.0) && !later.is_on(4.5));
        // The gap is smallest at time 4, when the projection reaches the end of the feature.
        assert!((ball.lowest(3.0, 5.0) - (1.0 - 4.5)).abs() < 1e-13);
        assert_eq!(ball.lowest(3.0, 3.5), ball.gap(3.5));
    }
}
