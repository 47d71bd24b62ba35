//! Surfaces that particles meet: the walls of the box, and the features of a scene's surfaces.
//!
//! A surface is a shape ([`Surface`]) with a law of contact ([`Law`]), or several such shapes: the faces,
//! edges and corners of a mesh ([`features`]). A shape provides data to several users. Prediction gets the
//! time of a particle's next contact, and execution gets the normal. The audit, the proof that the dynamics
//! have ended, and the checks of a start get gaps. A new shape is a file next to [`wall`] and [`plane`], and
//! a variant of [`Shape`]. [`set`] holds the surfaces of a scene. A [`tree`] of boxes finds the surfaces of
//! limited extent.

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
    /// Present position of the centre `[length]`.
    pub position: &'a Vector,
    /// Present velocity `[length / time]`.
    pub velocity: &'a Vector,
    /// Constant acceleration `[length / time^2]`.
    pub acceleration: &'a Vector,
    /// Radius `[length]`.
    pub radius: f64,
}

impl Flight<'_> {
    /// Corners of a box that contains the sphere for the given duration `[length]`.
    #[inline]
    pub fn swept(&self, duration: f64) -> [Vector; 2] {
        // Contact is at the radius, within the precision of coordinates.
        let around = self.radius * (1.0 + 1e-6) + 1e-12 * self.position.amax();
        let along = |k: usize| {
            // Avoids 0 times infinity for a particle at rest.
            let path = |rate: f64| if rate == 0.0 { 0.0 } else { rate * duration };
            let (by_speed, by_fall) = (path(self.velocity[k]), path(0.5 * path(self.acceleration[k])));
            [by_speed.min(0.0) + by_fall.min(0.0) - around, by_speed.max(0.0) + by_fall.max(0.0) + around]
        };
        let [x, y, z] = [0, 1, 2].map(along);
        [0, 1].map(|end| self.position + Vector::new(x[end], y[end], z[end]))
    }
}

/// The shape of a surface, with particles on one side.
pub(crate) trait Surface {
    /// Distance between the surface and the surface of a sphere; negative if they overlap `[length]`.
    fn gap(&self, position: &Vector, radius: f64) -> f64;

    /// Unit vector from the surface to a sphere in contact.
    fn normal(&self, position: &Vector) -> Vector;

    /// The velocity with its normal component replaced.
    fn with_normal_speed(&self, position: &Vector, velocity: &Vector, speed: f64) -> Vector;

    /// Returns the time until the gap closes with the sphere approaching, by the rule of
    /// [`crate::physics::detection`] `[time]`.
    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64>;

    /// Whether a sphere provably never reaches the surface, given the uncertainty `doubt` of position and
    /// velocity.
    fn is_never_met(&self, flight: &Flight<'_>, doubt: Doubt) -> bool;

    /// Returns the sum of the absolute values of the terms of the gap `[length]`. The gap is rounded at units
    /// in the last place of this sum.
    fn terms(&self, position: &Vector) -> f64;

    /// Whether a particle in a cell may meet the surface before it leaves the cell.
    fn is_near(&self, grid: &Grid, cell: u32, radius: f64) -> bool;

    /// Returns whether a velocity moves a sphere in contact further into the surface, in the same rounded
    /// numbers that prediction will use. Walls reflect without rounding.
    fn is_closing(&self, _position: &Vector, _velocity: &Vector) -> bool {
        false
    }

    /// Returns the acceleration with which the surface curves away from straight flight along it
    /// `[length / time^2]`; negative if the surface curves towards the flight path.
    fn bend(&self, _position: &Vector, _velocity: &Vector, _radius: f64) -> f64 {
        0.0
    }

    /// A smooth overlap function, positive outside contact, and its rate of change: the gap, or the
    /// difference of squared distances.
    fn overlap(&self, position: &Vector, velocity: &Vector, radius: f64) -> (f64, f64) {
        (self.gap(position, radius), self.normal(position).dot(velocity))
    }

    /// Bound of the second derivative of the overlap function within a distance of a place, from bounds of
    /// speed and acceleration.
    fn second_rate_bound(&self, _position: &Vector, _within: f64, _speed: f64, acceleration: f64) -> f64 {
        acceleration
    }

    /// Returns how far the foot of the perpendicular from a position lies beyond the ends of the surface
    /// `[length]`; zero or negative within the ends.
    fn beyond(&self, _position: &Vector) -> f64 {
        0.0
    }

    /// Returns the corners of the bounding box of the surface `[length]`; `None` if the surface is unbounded.
    fn extent(&self) -> Option<[Vector; 2]> {
        None
    }

    /// Returns the axis of a wall of the box, and whether it is the upper wall; `None` for other surfaces.
    fn side(&self) -> Option<(u8, bool)> {
        None
    }
}

/// All shapes.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Shape {
    /// A wall of the box.
    Wall(Wall),
    /// A plane in any direction.
    Plane(Plane),
    /// A sphere, a cylinder, an edge, a corner.
    Round(Round),
    /// A flat triangular face.
    Face(Face),
}

/// Evaluates an expression for a shape of any type.
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

/// The law of contact of a surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Law {
    /// Reflection, with the ratio of the normal speeds after and before.
    Reflecting { restitution: f64 },
    /// Velocities from the flux of a gas at this temperature `[energy]`.
    Thermal { temperature: f64 },
}

#[cfg(test)]
mod tests;
