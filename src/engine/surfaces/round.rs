//! Round surfaces: spheres, cylinders, edges and corners. A round surface contains all points at a given distance from
//! a point or a line.

use super::{Flight, Surface};
use crate::Vector;
use crate::engine::neighbours::grid::Grid;
use crate::physics::detection::feature::{self, across};
use crate::physics::detection::never::{self, Doubt};
use crate::physics::motion::RelativeState;
use crate::physics::overlap::Side;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Round {
    pub centre: Vector,
    /// Unit vector along the line, or `None` for a point.
    pub axis: Option<Vector>,
    /// Length of the line `[length]`. Infinite if the line has no ends.
    pub length: f64,
    /// Distance of the surface from the point or line `[length]`. Zero for edges and corners.
    pub radius: f64,
    /// Whether particles are inside the surface. If so, a line has no ends.
    pub is_inside: bool,
}

impl Round {
    /// Distance between a sphere's centre and the point or line at contact `[length]`.
    #[inline]
    fn contact(&self, radius: f64) -> f64 {
        if self.is_inside { self.radius - radius } else { self.radius + radius }
    }

    #[inline]
    fn side(&self) -> Side {
        if self.is_inside { Side::Negative } else { Side::Positive }
    }

    #[inline]
    fn across(&self, vector: &Vector) -> Vector {
        self.axis.map_or(*vector, |axis| across(&axis, vector))
    }

    /// Vector to a position, from the point or from the nearest point of the infinite line.
    #[inline]
    fn apart(&self, position: &Vector) -> Vector {
        self.across(&(position - self.centre))
    }

    fn has_ends(&self) -> bool {
        self.axis.is_some() && self.length.is_finite()
    }

    /// Whether the projection of a position onto the line is between the ends of the line. Always true for a point and
    /// for a line without ends.
    fn holds(&self, position: &Vector) -> bool {
        !self.has_ends()
            || self.axis.is_none_or(|axis| (0.0..=self.length).contains(&axis.dot(&(position - self.centre))))
    }

    fn state(&self, flight: &Flight<'_>) -> RelativeState {
        RelativeState { position: flight.position - self.centre, velocity: *flight.velocity }
    }

    /// The bounding box of the surface. It may be infinite.
    pub fn around(&self) -> [Vector; 2] {
        let [lower, upper] = self.bounds();
        let around = Vector::repeat(self.radius);
        [lower - around, upper + around]
    }

    fn bounds(&self) -> [Vector; 2] {
        let Some(axis) = self.axis else { return [self.centre; 2] };
        let reach = |n: f64| if n == 0.0 { 0.0 } else { n * self.length };
        let end = self.centre + axis.map(reach);
        let start = if self.length.is_finite() { self.centre } else { self.centre - axis.map(reach) };
        [start.inf(&end), start.sup(&end)]
    }
}

impl Surface for Round {
    fn gap(&self, position: &Vector, radius: f64) -> f64 {
        if !self.holds(position) {
            return f64::INFINITY;
        }
        self.side().sign() * (self.apart(position).norm() - self.contact(radius))
    }

    fn normal(&self, position: &Vector) -> Vector {
        let sign = self.side().sign();
        self.apart(position).try_normalize(0.0).map_or(Vector::zeros(), |normal| normal * sign)
    }

    /// Unit vectors from a square root are too long on average and would heat a gas, so no unit vector is used.
    fn with_normal_speed(&self, position: &Vector, velocity: &Vector, speed: f64) -> Vector {
        let apart = self.apart(position);
        let squared = apart.norm_squared();
        if squared == 0.0 {
            return *velocity;
        }
        velocity + apart * ((self.side().sign() * speed * squared.sqrt() - velocity.dot(&apart)) / squared)
    }

    fn is_closing(&self, position: &Vector, velocity: &Vector) -> bool {
        let rate = self.apart(position).dot(&self.across(velocity));
        if self.is_inside { rate >= 0.0 } else { rate < 0.0 }
    }

    fn bend(&self, position: &Vector, velocity: &Vector, radius: f64) -> f64 {
        let (velocity, normal) = (self.across(velocity), self.normal(position));
        let vn = normal.dot(&velocity);
        let tangential = (velocity.norm_squared() - vn * vn).max(0.0);
        self.side().sign() * tangential / self.contact(radius)
    }

    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64> {
        let (state, contact) = (self.state(flight), self.contact(flight.radius));
        match self.axis {
            None => feature::point(&state, flight.acceleration, contact * contact, self.side()),
            Some(axis) if self.has_ends() => {
                feature::segment(&axis, self.length, &state, flight.acceleration, contact * contact)
            }
            Some(axis) => feature::line(&axis, &state, flight.acceleration, contact * contact, self.side()),
        }
    }

    fn is_never_met(&self, flight: &Flight<'_>, mut doubt: Doubt) -> bool {
        // A particle at rest never meets the surface. A moving particle inside the surface is assumed to meet the
        // surface.
        let rests = *flight.velocity == Vector::zeros() && *flight.acceleration == Vector::zeros();
        if self.is_inside || rests {
            return rests;
        }
        doubt.position += Doubt::of(self.terms(flight.position), 0.0).position;
        let state = self.state(flight);
        let state = RelativeState { position: self.across(&state.position), velocity: self.across(&state.velocity) };
        let contact = self.contact(flight.radius);
        if *flight.acceleration == Vector::zeros() {
            return never::inertial(&state, &doubt, contact);
        }
        let push = self.across(flight.acceleration);
        // If the acceleration is parallel to the line, its perpendicular component may be pure round-off and must not
        // be used.
        push.norm() > 1e-9 * flight.acceleration.norm() && never::accelerated(&state, &push, &doubt, contact)
    }

    fn terms(&self, position: &Vector) -> f64 {
        position.lp_norm(1) + self.centre.lp_norm(1) + self.radius
    }

    fn is_near(&self, grid: &Grid, cell: u32, radius: f64) -> bool {
        let [lower, upper] = grid.bounds(cell);
        if self.is_inside {
            // The surface surrounds the particles, so it is near every cell.
            return true;
        }
        let reach = (self.radius + radius) * (1.0 + 1e-6) + 1e-6 * self.centre.amax();
        let [start, end] = self.bounds();
        (0..3).all(|k| start[k] - reach <= upper[k] && end[k] + reach >= lower[k])
    }

    fn overlap(&self, position: &Vector, velocity: &Vector, radius: f64) -> (f64, f64) {
        let (apart, contact, sign) = (self.apart(position), self.contact(radius), self.side().sign());
        let gap = (apart.norm() - contact) * (apart.norm() + contact);
        (sign * gap, sign * 2.0 * apart.dot(&self.across(velocity)))
    }

    /// The second time derivative of `|r|^2` is `2 v^2 + 2 r . a`.
    fn second_rate_bound(&self, position: &Vector, within: f64, speed: f64, acceleration: f64) -> f64 {
        2.0 * (speed * speed + (self.apart(position).norm() + within) * acceleration)
    }

    fn beyond(&self, position: &Vector) -> f64 {
        let Some(axis) = self.axis.filter(|_| self.has_ends()) else { return 0.0 };
        let along = axis.dot(&(position - self.centre));
        (-along).max(along - self.length)
    }

    fn extent(&self) -> Option<[Vector; 2]> {
        let is_limited = !self.is_inside && (self.axis.is_none() || self.length.is_finite());
        is_limited.then(|| self.around())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segment_gap_is_finite_only_beside_the_segment() {
        let edge = Round {
            centre: Vector::new(1.0, 0.0, 0.0),
            axis: Some(Vector::x()),
            length: 2.0,
            radius: 0.0,
            is_inside: false,
        };
        assert_eq!(edge.gap(&Vector::new(2.0, 3.0, 4.0), 1.0), 4.0);
        assert_eq!(edge.gap(&Vector::new(3.5, 3.0, 4.0), 1.0), f64::INFINITY);
        assert_eq!(edge.normal(&Vector::new(2.0, 3.0, 4.0)), Vector::new(0.0, 0.6, 0.8));
    }

    #[test]
    fn cavity_contact_is_at_cavity_radius_minus_sphere_radius() {
        let cavity = Round { centre: Vector::zeros(), axis: None, length: 0.0, radius: 3.0, is_inside: true };
        let (position, velocity, none) = (Vector::new(1.0, 0.0, 0.0), Vector::new(2.0, 0.0, 0.0), Vector::zeros());
        let flight = Flight { position: &position, velocity: &velocity, acceleration: &none, radius: 1.0 };
        assert_eq!(cavity.next_contact(&flight), Some(0.5));
        assert_eq!(cavity.gap(&position, 1.0), 1.0);
        assert_eq!(cavity.normal(&position), -Vector::x());
        assert_eq!(cavity.with_normal_speed(&position, &velocity, 2.0), -velocity);
        let pipe = Round { axis: Some(Vector::x()), length: f64::INFINITY, ..cavity };
        assert_eq!(pipe.next_contact(&flight), None);
    }
}
