//! Planes in any direction.

use super::{Flight, Surface};
use crate::Vector;
use crate::engine::neighbours::grid::Grid;
use crate::physics::detection::{never, plane};
use never::Doubt;

/// A plane `n . x = at` with the unit normal `n`. Particles are on the side where `n . x` is larger.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    normal: Vector,
    at: f64,
}

impl Plane {
    /// Returns the plane through a point. Particles are on the side to which `direction` points. `None` if `direction`
    /// is zero.
    pub fn through(point: &Vector, direction: &Vector) -> Option<Self> {
        let normal = direction.try_normalize(0.0)?;
        Some(Self { normal, at: normal.dot(point) })
    }
}

impl Surface for Plane {
    fn gap(&self, position: &Vector, radius: f64) -> f64 {
        self.normal.dot(position) - self.at - radius
    }

    fn normal(&self, _: &Vector) -> Vector {
        self.normal
    }

    fn with_normal_speed(&self, _: &Vector, velocity: &Vector, speed: f64) -> Vector {
        velocity + self.normal * (speed - self.normal.dot(velocity))
    }

    fn is_closing(&self, _: &Vector, velocity: &Vector) -> bool {
        self.normal.dot(velocity) < 0.0
    }

    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64> {
        let gap = self.gap(flight.position, flight.radius);
        plane::next_event(gap, self.normal.dot(flight.velocity), self.normal.dot(flight.acceleration))
    }

    fn is_never_met(&self, flight: &Flight<'_>, mut doubt: Doubt) -> bool {
        doubt.position += Doubt::of(self.at.abs(), 0.0).position;
        let gap = self.gap(flight.position, flight.radius);
        never::plane(gap, self.normal.dot(flight.velocity), self.normal.dot(flight.acceleration), &doubt)
    }

    fn terms(&self, position: &Vector) -> f64 {
        self.normal.component_mul(position).lp_norm(1) + self.at.abs()
    }

    /// A cell is near if any part of the cell is behind the plane, or less than a radius in front of the plane.
    fn is_near(&self, grid: &Grid, cell: u32, radius: f64) -> bool {
        let [lower, upper] = grid.bounds(cell);
        let least = |k: usize| match self.normal[k] {
            0.0 => 0.0,
            n => (n * lower[k]).min(n * upper[k]),
        };
        // Because of round-off, a particle may be slightly outside its cell.
        let margin = radius + 1e-6 * (radius + self.at.abs());
        least(0) + least(1) + least(2) - self.at <= margin
    }
}
