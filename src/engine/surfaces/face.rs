//! Flat triangular faces. Particles can meet a face from either side.

use super::{Flight, Surface};
use crate::Vector;
use crate::engine::neighbours::grid::Grid;
use crate::physics::detection::feature;
use crate::physics::detection::never::{self, Doubt};
use crate::physics::detection::stretch::Parabola;
use crate::physics::motion::RelativeState;

/// A triangle without edges and corners, which are separate surfaces.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    /// Corners in counterclockwise order, seen from the side to which the normal points `[length]`.
    pub corners: [Vector; 3],
    pub normal: Vector,
    /// For each edge, the unit vector in the plane that is perpendicular to the edge and points into the face.
    pub inwards: [Vector; 3],
    /// For each edge, true if positions are measured from its second corner. Two coplanar faces use the same corner of
    /// a common edge, so round-off leaves no gap between the faces.
    pub from_second: [bool; 3],
}

impl Face {
    #[inline]
    fn end(&self, side: usize) -> &Vector {
        &self.corners[(side + usize::from(self.from_second[side])) % 3]
    }

    fn extents(&self, flight: &Flight<'_>) -> [Parabola; 3] {
        [0, 1, 2].map(|side| {
            let position = flight.position - self.end(side);
            let state = RelativeState { position, velocity: *flight.velocity };
            Parabola::along(&self.inwards[side], &state, flight.acceleration)
        })
    }

    #[inline]
    fn height(&self, position: &Vector) -> f64 {
        self.normal.dot(&(position - self.corners[0]))
    }

    /// Returns true if the projection of a position onto the plane lies in the face or on an edge.
    fn holds(&self, position: &Vector) -> bool {
        (0..3).all(|side| self.inwards[side].dot(&(position - self.end(side))) >= 0.0)
    }

    /// Returns 1 if a position is in the plane or on the side to which the normal points, otherwise -1.
    #[inline]
    fn side(&self, position: &Vector) -> f64 {
        if self.height(position) < 0.0 { -1.0 } else { 1.0 }
    }

    fn bounds(&self) -> [Vector; 2] {
        let [a, b, c] = self.corners;
        [a.inf(&b).inf(&c), a.sup(&b).sup(&c)]
    }
}

impl Surface for Face {
    fn gap(&self, position: &Vector, radius: f64) -> f64 {
        if self.holds(position) { self.height(position).abs() - radius } else { f64::INFINITY }
    }

    fn normal(&self, position: &Vector) -> Vector {
        self.normal * self.side(position)
    }

    fn with_normal_speed(&self, position: &Vector, velocity: &Vector, speed: f64) -> Vector {
        velocity + self.normal * (self.side(position) * speed - self.normal.dot(velocity))
    }

    fn is_closing(&self, position: &Vector, velocity: &Vector) -> bool {
        self.side(position) * self.normal.dot(velocity) < 0.0
    }

    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64> {
        let position = flight.position - self.corners[0];
        let state = RelativeState { position, velocity: *flight.velocity };
        let height = Parabola::along(&self.normal, &state, flight.acceleration);
        feature::face(&height, flight.radius, &self.extents(flight))
    }

    fn is_never_met(&self, flight: &Flight<'_>, mut doubt: Doubt) -> bool {
        doubt.position += Doubt::of(self.terms(flight.position), 0.0).position;
        let sign = self.side(flight.position);
        let along = |vector: &Vector| sign * self.normal.dot(vector);
        let height = sign * self.height(flight.position) - flight.radius;
        if never::plane(height, along(flight.velocity), along(flight.acceleration), &doubt) {
            return true;
        }
        let [lower, upper] = self.bounds();
        let (middle, radius) = (0.5 * (lower + upper), 0.5 * (upper - lower).norm() + flight.radius);
        let state = RelativeState { position: flight.position - middle, velocity: *flight.velocity };
        if *flight.acceleration == Vector::zeros() {
            never::inertial(&state, &doubt, radius)
        } else {
            never::accelerated(&state, flight.acceleration, &doubt, radius)
        }
    }

    /// The overlap function is `h^2 - R^2`, where `h` is the height above the plane.
    fn overlap(&self, position: &Vector, velocity: &Vector, radius: f64) -> (f64, f64) {
        let (height, rate) = (self.height(position), self.normal.dot(velocity));
        ((height - radius) * (height + radius), 2.0 * height * rate)
    }

    fn second_rate_bound(&self, position: &Vector, within: f64, speed: f64, acceleration: f64) -> f64 {
        2.0 * (speed * speed + (self.height(position).abs() + within) * acceleration)
    }

    fn beyond(&self, position: &Vector) -> f64 {
        (0..3).map(|side| -self.inwards[side].dot(&(position - self.end(side)))).fold(f64::NEG_INFINITY, f64::max)
    }

    fn terms(&self, position: &Vector) -> f64 {
        position.lp_norm(1) + self.corners[0].lp_norm(1)
    }

    /// The tree has selected the faces near the particle.
    fn is_near(&self, _: &Grid, _: u32, _: f64) -> bool {
        true
    }

    fn extent(&self) -> Option<[Vector; 2]> {
        Some(self.bounds())
    }
}
