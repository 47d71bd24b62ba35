//! Walls of the box: planes normal to an axis.

use super::{Flight, Surface};
use crate::Vector;
use crate::engine::neighbours::grid::Grid;
use crate::physics::detection::{never, plane};
use never::Doubt;

#[derive(Debug, Clone, Copy)]
pub(crate) struct Wall {
    /// Axis normal to the wall: 0, 1 or 2.
    pub axis: u8,
    pub is_upper: bool,
    /// Coordinate of the wall along the axis `[length]`.
    pub at: f64,
}

impl Wall {
    pub fn number(&self) -> u32 {
        2 * u32::from(self.axis) + u32::from(self.is_upper)
    }

    /// The component of a vector along the normal, which points into the box.
    #[inline]
    fn inwards(&self, vector: &Vector) -> f64 {
        self.sign() * vector[usize::from(self.axis)]
    }

    #[inline]
    fn sign(&self) -> f64 {
        if self.is_upper { -1.0 } else { 1.0 }
    }
}

impl Surface for Wall {
    #[inline]
    fn gap(&self, position: &Vector, radius: f64) -> f64 {
        self.sign() * (position[usize::from(self.axis)] - self.at) - radius
    }

    #[inline]
    fn normal(&self, _: &Vector) -> Vector {
        let mut normal = Vector::zeros();
        normal[usize::from(self.axis)] = self.sign();
        normal
    }

    #[inline]
    fn with_normal_speed(&self, _: &Vector, velocity: &Vector, speed: f64) -> Vector {
        let mut with = *velocity;
        with[usize::from(self.axis)] = self.sign() * speed;
        with
    }

    #[inline(always)]
    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64> {
        let gap = self.gap(flight.position, flight.radius);
        plane::next_event(gap, self.inwards(flight.velocity), self.inwards(flight.acceleration))
    }

    fn is_never_met(&self, flight: &Flight<'_>, mut doubt: Doubt) -> bool {
        doubt.position += Doubt::of(self.at.abs(), 0.0).position;
        let gap = self.gap(flight.position, flight.radius);
        never::plane(gap, self.inwards(flight.velocity), self.inwards(flight.acceleration), &doubt)
    }

    fn terms(&self, position: &Vector) -> f64 {
        position[usize::from(self.axis)].abs() + self.at.abs()
    }

    /// A wall is only near the outermost cells. The grid ends at walls, and cells are wider than particles.
    #[inline]
    fn is_near(&self, grid: &Grid, cell: u32, _: f64) -> bool {
        let [is_first, is_last] = grid.is_outermost(cell, usize::from(self.axis));
        if self.is_upper { is_last } else { is_first }
    }

    #[inline]
    fn side(&self) -> Option<(u8, bool)> {
        Some((self.axis, self.is_upper))
    }
}
