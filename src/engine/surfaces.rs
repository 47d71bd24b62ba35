//! Surfaces that particles meet: the walls of the box, and the surfaces of a scene.
//!
//! A surface has a shape ([`Surface`]) and a law of contact ([`crate::model::SurfaceLaw`]). A mesh consists of several
//! shapes: its faces, edges and corners ([`features`]). To add a shape, write a file like [`plane`], or [`round`] for
//! a curved shape, and add a variant to [`Shape`]. A curved shape must define
//! `is_closing`, `bend`, `overlap` and `second_rate_bound`. A shape of limited size must define `extent` and `beyond`.
//! The defaults suit a flat, unlimited shape. [`features`] moves surfaces.
//!
//! [`set`] holds the surfaces of a scene. A [`tree`] of boxes finds the surfaces of limited extent.

pub(crate) mod face;
pub(crate) mod features;
mod moving;
pub(crate) mod plane;
pub(crate) mod round;
pub(crate) mod set;
mod tree;
pub(super) mod wall;

use super::neighbours::grid::Grid;
use crate::Vector;
use crate::physics::detection::never::Doubt;
use face::Face;
pub(crate) use moving::{Found, search_steps};
use plane::Plane;
use round::Round;
pub(crate) use set::{FIRST_SURFACE, MOST_FEATURES, Placed, Surfaces};
use wall::Wall;

/// A sphere in free flight.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flight<'a> {
    pub position: &'a Vector,
    pub velocity: &'a Vector,
    pub acceleration: &'a Vector,
    pub radius: f64,
}

impl Flight<'_> {
    /// Returns the corners of a box that contains the sphere for the given duration `[length]`.
    #[inline]
    pub fn swept(&self, duration: f64) -> [Vector; 2] {
        // The margin allows for the round-off of coordinates.
        let around = self.radius * (1.0 + 1e-6) + 1e-12 * self.position.amax();
        let along = |k: usize| {
            // A zero rate times an infinite duration would be NaN.
            let path = |rate: f64| if rate == 0.0 { 0.0 } else { rate * duration };
            let (by_speed, by_fall) = (path(self.velocity[k]), path(0.5 * path(self.acceleration[k])));
            [by_speed.min(0.0) + by_fall.min(0.0) - around, by_speed.max(0.0) + by_fall.max(0.0) + around]
        };
        let [x, y, z] = [0, 1, 2].map(along);
        [0, 1].map(|end| self.position + Vector::new(x[end], y[end], z[end]))
    }
}

pub(crate) trait Surface {
    /// Distance between the surface and a sphere `[length]`. Negative if the sphere overlaps the surface.
    fn gap(&self, position: &Vector, radius: f64) -> f64;

    /// Unit vector from the surface to a sphere in contact.
    fn normal(&self, position: &Vector) -> Vector;

    /// Replaces the component of a velocity along the normal by `speed`.
    fn with_normal_speed(&self, position: &Vector, velocity: &Vector, speed: f64) -> Vector;

    /// Returns the time until a sphere reaches the surface `[time]`. See [`crate::physics::detection`].
    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64>;

    /// Whether a sphere certainly never reaches the surface. `doubt` is the uncertainty of position and velocity.
    fn is_never_met(&self, flight: &Flight<'_>, doubt: Doubt) -> bool;

    /// Returns the sum of the magnitudes of all terms of the gap `[length]`, which determines its round-off.
    fn terms(&self, position: &Vector) -> f64;

    /// Whether a sphere may touch the surface while its centre is in a cell.
    fn is_near(&self, grid: &Grid, cell: u32, radius: f64) -> bool;

    /// Whether a velocity moves a sphere in contact further into the surface, with the rounding of the next prediction.
    /// Walls reflect without rounding, so they need no such test.
    fn is_closing(&self, _position: &Vector, _velocity: &Vector) -> bool {
        false
    }

    /// Returns the second time derivative of the gap if a sphere in contact flies straight on `[length / time^2]`. The
    /// result is negative if the surface curves towards the flight path.
    fn bend(&self, _position: &Vector, _velocity: &Vector, _radius: f64) -> f64 {
        0.0
    }

    /// Returns a smooth overlap function and its rate of change. The function is positive if there is no overlap.
    fn overlap(&self, position: &Vector, velocity: &Vector, radius: f64) -> (f64, f64) {
        (self.gap(position, radius), self.normal(position).dot(velocity))
    }

    /// Returns an upper bound of the second time derivative of the overlap function, for all positions up to the
    /// distance `within` from `position`. The arguments `speed` and `acceleration` are upper bounds.
    fn second_rate_bound(&self, _position: &Vector, _within: f64, _speed: f64, acceleration: f64) -> f64 {
        acceleration
    }

    /// Returns how far a position lies beyond the ends of the surface `[length]`. Zero or negative between the ends.
    fn beyond(&self, _position: &Vector) -> f64 {
        0.0
    }

    /// Returns the corners of the bounding box of the surface `[length]`, or `None` for an unbounded surface.
    fn extent(&self) -> Option<[Vector; 2]> {
        None
    }

    /// Returns the axis of a wall of the box, and whether it is the upper wall. `None` for other surfaces.
    fn side(&self) -> Option<(u8, bool)> {
        None
    }
}

#[derive(Debug, Clone, Copy)]
pub(crate) enum Shape {
    Wall(Wall),
    Plane(Plane),
    /// A sphere, a cylinder, an edge or a corner.
    Round(Round),
    Face(Face),
}

macro_rules! with_shape {
    ($shape:expr, $surface:ident => $body:expr) => {
        match $shape {
            Shape::Wall($surface) => $body,
            Shape::Plane($surface) => $body,
            Shape::Round($surface) => $body,
            Shape::Face($surface) => $body,
        }
    };
}

impl Surface for Shape {
    #[inline]
    fn gap(&self, position: &Vector, radius: f64) -> f64 {
        with_shape!(self, surface => surface.gap(position, radius))
    }

    #[inline]
    fn normal(&self, position: &Vector) -> Vector {
        with_shape!(self, surface => surface.normal(position))
    }

    #[inline]
    fn with_normal_speed(&self, position: &Vector, velocity: &Vector, speed: f64) -> Vector {
        with_shape!(self, surface => surface.with_normal_speed(position, velocity, speed))
    }

    #[inline(always)]
    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64> {
        with_shape!(self, surface => surface.next_contact(flight))
    }

    fn is_never_met(&self, flight: &Flight<'_>, doubt: Doubt) -> bool {
        with_shape!(self, surface => surface.is_never_met(flight, doubt))
    }

    fn terms(&self, position: &Vector) -> f64 {
        with_shape!(self, surface => surface.terms(position))
    }

    #[inline]
    fn is_near(&self, grid: &Grid, cell: u32, radius: f64) -> bool {
        with_shape!(self, surface => surface.is_near(grid, cell, radius))
    }

    #[inline]
    fn is_closing(&self, position: &Vector, velocity: &Vector) -> bool {
        with_shape!(self, surface => surface.is_closing(position, velocity))
    }

    #[inline]
    fn bend(&self, position: &Vector, velocity: &Vector, radius: f64) -> f64 {
        with_shape!(self, surface => surface.bend(position, velocity, radius))
    }

    fn overlap(&self, position: &Vector, velocity: &Vector, radius: f64) -> (f64, f64) {
        with_shape!(self, surface => surface.overlap(position, velocity, radius))
    }

    fn second_rate_bound(&self, position: &Vector, within: f64, speed: f64, acceleration: f64) -> f64 {
        with_shape!(self, surface => surface.second_rate_bound(position, within, speed, acceleration))
    }

    fn beyond(&self, position: &Vector) -> f64 {
        with_shape!(self, surface => surface.beyond(position))
    }

    fn extent(&self) -> Option<[Vector; 2]> {
        with_shape!(self, surface => surface.extent())
    }

    #[inline]
    fn side(&self) -> Option<(u8, bool)> {
        with_shape!(self, surface => surface.side())
    }
}

#[cfg(test)]
mod tests;
