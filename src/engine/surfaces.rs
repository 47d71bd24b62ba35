//! Surfaces that particles meet: the walls of the box, and planes in any direction.
//!
//! A surface is a shape ([`Surface`]) with a law of contact ([`Law`]). Prediction asks a shape for the next contact of a particle, execution for the
//! normal there; the audit, the proof that nothing happens any more and the checks of a start ask it for gaps. Nothing else knows which
//! shapes there are: a new one is a file beside [`wall`] and [`plane`], and a variant of [`Shape`].

pub(crate) mod plane;
pub(super) mod wall;

use super::neighbours::grid::Grid;
use crate::Vector;
use crate::model::Scene;
use crate::model::space::{Boundary, Face, Space};
use crate::physics::detection::never::Doubt;
use plane::Plane;
use serde::{Deserialize, Serialize};
use wall::Wall;

/// A sphere in free flight, as a surface sees it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Flight<'a> {
    /// Position of the centre now `[length]`.
    pub position: &'a Vector,
    /// Velocity now `[length / time]`.
    pub velocity: &'a Vector,
    /// Constant acceleration `[length / time^2]`.
    pub acceleration: &'a Vector,
    /// Radius `[length]`.
    pub radius: f64,
}

/// The shape of a surface, of which one side is for particles.
pub(crate) trait Surface {
    /// Distance from the surface to that of a sphere, negative where the two overlap `[length]`.
    fn gap(&self, position: &Vector, radius: f64) -> f64;

    /// Unit vector from the surface to a sphere that touches it.
    fn normal(&self, position: &Vector) -> Vector;

    /// A velocity with another component along the normal.
    fn with_normal_speed(&self, position: &Vector, velocity: &Vector, speed: f64) -> Vector;

    /// Time from now until the gap is closed and closing, by the rule of [`crate::physics::detection`] `[time]`.
    fn next_contact(&self, flight: &Flight<'_>) -> Option<f64>;

    /// Whether a sphere is shown never to come to the surface, though position and velocity may be wrong by `doubt`.
    fn is_never_met(&self, flight: &Flight<'_>, doubt: Doubt) -> bool;

    /// Sum of the terms of the gap, each without its sign: the gap is rounded in units in the last place of it `[length]`.
    fn terms(&self, position: &Vector) -> f64;

    /// Whether a particle in a cell may meet the surface before it leaves the cell.
    fn is_near(&self, grid: &Grid, cell: u32, radius: f64) -> bool;

    /// The side of the box that it is, as axis and whether at the upper corner.
    fn side(&self) -> Option<(u8, bool)> {
        None
    }
}

/// All shapes.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) enum Shape {
    /// A wall of the box.
    Wall(Wall),
    /// A plane in any direction.
    Plane(Plane),
}

/// Runs an expression with a shape, whatever its type.
macro_rules! with_shape {
    ($shape:expr, $surface:ident => $body:expr) => {
        match $shape {
            Shape::Wall($surface) => $body,
            Shape::Plane($surface) => $body,
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
    fn side(&self) -> Option<(u8, bool)> {
        with_shape!(self, surface => surface.side())
    }
}

/// How a surface answers a contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) enum Law {
    /// It reflects: ratio of the normal speeds after and before.
    Reflecting { restitution: f64 },
    /// It gives velocities from the flux of a gas of this temperature `[energy]`.
    Thermal { temperature: f64 },
}

/// A surface of a scene.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(crate) struct Placed {
    /// Its number in events and predictions: for the walls of the box `2 axis + is_upper`.
    pub number: u32,
    pub shape: Shape,
    pub law: Law,
}

/// Surfaces of a scene. Whatever asks which there are asks here.
pub(super) fn of(scene: &Scene) -> Vec<Placed> {
    of_parts(&scene.space, &scene.wall_temperatures)
}

/// Surfaces of the parts of a scene: the walls of its box, of which those with a temperature are thermal.
pub(crate) fn of_parts(space: &Space, temperatures: &[[Option<f64>; 2]; 3]) -> Vec<Placed> {
    let mut walls = Vec::new();
    for (axis, boundary) in (0_u8..).zip(&space.boundary) {
        let Boundary::Bounded { lower, upper } = boundary else { continue };
        let k = usize::from(axis);
        let sides = [(false, lower, space.lower[k]), (true, upper, space.upper()[k])];
        for ((is_upper, face, at), temperature) in sides.into_iter().zip(temperatures[k]) {
            if let Face::Wall { restitution } = *face {
                let wall = Wall { axis, is_upper, at };
                let law =
                    temperature.map_or(Law::Reflecting { restitution }, |temperature| Law::Thermal { temperature });
                walls.push(Placed { number: wall.number(), shape: Shape::Wall(wall), law });
            }
        }
    }
    walls
}

#[cfg(test)]
mod tests;
