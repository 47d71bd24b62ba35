//! Surfaces that particles meet: the walls of the box, and the features of the surfaces of a scene.
//!
//! A surface is a shape ([`Surface`]) with a law of contact ([`Law`]), or many of them: the faces, edges and corners of a mesh ([`features`]). Prediction
//! asks a shape for the next contact of a particle, execution for the normal there; the audit, the proof that nothing happens any more and
//! the checks of a start ask it for gaps. Nothing else knows which shapes there are: a new one is a file beside [`wall`] and [`plane`], and a variant of
//! [`Shape`]. Shapes of a limited extent are found by a [`tree`] of boxes around them.

pub(crate) mod face;
pub(crate) mod features;
pub(crate) mod plane;
pub(crate) mod round;
mod tree;
pub(super) mod wall;

use super::neighbours::grid::Grid;
use crate::Vector;
use crate::model::space::{self, Boundary, Space};
use crate::model::{Scene, SceneSurface, SpeciesId, SurfaceLaw};
use crate::physics::detection::never::Doubt;
use face::Face;
use plane::Plane;
use round::Round;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use tree::Tree;
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

impl Flight<'_> {
    /// The corners of a box around the sphere until a time from now `[length]`.
    #[inline]
    pub fn swept(&self, duration: f64) -> [Vector; 2] {
        // Contact is at the radius, as far as coordinates can tell.
        let around = self.radius * (1.0 + 1e-6) + 1e-12 * self.position.amax();
        let along = |k: usize| {
            // Nothing moves to infinity at rest.
            let path = |rate: f64| if rate == 0.0 { 0.0 } else { rate * duration };
            let (by_speed, by_fall) = (path(self.velocity[k]), path(0.5 * path(self.acceleration[k])));
            [by_speed.min(0.0) + by_fall.min(0.0) - around, by_speed.max(0.0) + by_fall.max(0.0) + around]
        };
        let [x, y, z] = [0, 1, 2].map(along);
        [0, 1].map(|end| self.position + Vector::new(x[end], y[end], z[end]))
    }
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

    /// Whether a velocity brings a sphere in contact further in, in the numbers that prediction will see; walls reflect without rounding.
    fn is_closing(&self, _position: &Vector, _velocity: &Vector) -> bool {
        false
    }

    /// Acceleration with which the surface bends away from straight flight along it, negative where it bends towards it `[length / time^2]`.
    fn bend(&self, _position: &Vector, _velocity: &Vector, _radius: f64) -> f64 {
        0.0
    }

    /// The corners of a box around it; none if it has no limited extent `[length]`.
    fn extent(&self) -> Option<[Vector; 2]> {
        None
    }

    /// The side of the box that it is, as axis and whether at the upper corner.
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
    /// A flat face with three sides.
    Face(Face),
}

/// Runs an expression with a shape, whatever its type.
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

    fn extent(&self) -> Option<[Vector; 2]> {
        with_shape!(self, surface => surface.extent())
    }

    #[inline]
    fn side(&self) -> Option<(u8, bool)> {
        with_shape!(self, surface => surface.side())
    }
}

/// How a surface answers a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Law {
    /// It reflects: ratio of the normal speeds after and before.
    Reflecting { restitution: f64 },
    /// It gives velocities from the flux of a gas of this temperature `[energy]`.
    Thermal { temperature: f64 },
}

/// A wall, a surface of a scene, or one feature of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    /// Number of the surface in events: for the walls of the box `2 axis + is_upper`, from [`FIRST_SURFACE`] on for those of the scene.
    pub number: u32,
    /// Number among the features of the surface.
    pub feature: u32,
    pub shape: Shape,
    pub law: Law,
}

/// So many triangles a scene has at most: with their edges and corners they have numbers of 32 bits, also their images in a periodic box.
pub(crate) const MOST_FEATURES: usize = 1 << 26;

/// Walls have the numbers below this one.
pub(crate) const FIRST_SURFACE: u32 = 6;

/// Parts of a scene that surfaces are made of, which a saved state has in their place.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Origin {
    space: Space,
    temperatures: [[Option<f64>; 2]; 3],
    surfaces: Vec<SceneSurface>,
    /// By row of the tables.
    species: Vec<SpeciesId>,
}

/// The surfaces of a scene: those of no limited extent, walls first, then the features of others.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(from = "Origin", into = "Origin")]
pub(crate) struct Surfaces {
    origin: Arc<Origin>,
    all: Arc<Vec<Placed>>,
    /// How many have no limited extent.
    unlimited: usize,
    /// By surface of the scene and row of the species, whether the two meet; empty for a surface that all meet.
    meets: Vec<Vec<bool>>,
    /// Where the others are, if there are any.
    tree: Option<Arc<Tree>>,
}

impl From<Origin> for Surfaces {
    fn from(origin: Origin) -> Self {
        let mut all = walls(&origin.space, &origin.temperatures);
        let mut limited = Vec::new();
        for (surface, number) in origin.surfaces.iter().zip(FIRST_SURFACE..) {
            let law = match surface.law {
                SurfaceLaw::Reflecting { restitution } => Law::Reflecting { restitution },
                SurfaceLaw::Thermal { temperature } => Law::Thermal { temperature },
            };
            for (shape, feature) in features::within(&origin.space, &surface.shape) {
                let placed = Placed { number, feature, shape, law };
                if shape.extent().is_some() { limited.push(placed) } else { all.push(placed) }
            }
        }
        let meets = |surface: &SceneSurface| match surface.species.is_empty() {
            true => Vec::new(),
            false => origin.species.iter().map(|species| surface.meets(*species)).collect(),
        };
        let unlimited = all.len();
        let tree = (!limited.is_empty()).then(|| Arc::new(Tree::of(&mut limited, unlimited)));
        all.append(&mut limited);
        let meets = origin.surfaces.iter().map(meets).collect();
        Self { origin: Arc::new(origin), all: Arc::new(all), unlimited, meets, tree }
    }
}

impl From<Surfaces> for Origin {
    fn from(surfaces: Surfaces) -> Self {
        Arc::unwrap_or_clone(surfaces.origin)
    }
}

impl Surfaces {
    /// The surfaces of a scene, for tables with rows of these species. Whatever asks which there are asks here.
    pub fn of(scene: &Scene, species: &[SpeciesId]) -> Self {
        Self::of_parts(&scene.space, &scene.wall_temperatures, &scene.surfaces, species)
    }

    /// The surfaces of the parts of a scene.
    pub fn of_parts(
        space: &Space,
        temperatures: &[[Option<f64>; 2]; 3],
        surfaces: &[SceneSurface],
        species: &[SpeciesId],
    ) -> Self {
        let (space, surfaces, species) = (space.clone(), surfaces.to_vec(), species.to_vec());
        Self::from(Origin { space, temperatures: *temperatures, surfaces, species })
    }

    /// Those of the scene, without the walls.
    pub fn of_scene(&self) -> &[SceneSurface] {
        &self.origin.surfaces
    }

    /// All of them, each at the index that predictions name.
    pub fn all(&self) -> &[Placed] {
        &self.all
    }

    /// One of them.
    #[inline]
    pub fn get(&self, index: u32) -> Option<&Placed> {
        self.all.get(index as usize)
    }

    /// The name of a surface of the scene, by its number; empty for walls.
    pub fn name(&self, number: u32) -> &str {
        let of_scene = number.checked_sub(FIRST_SURFACE);
        of_scene.and_then(|number| self.origin.surfaces.get(number as usize)).map_or("", |surface| &surface.name)
    }

    /// Whether there are any.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Whether some have a limited extent, and are met near to it only.
    #[inline]
    pub fn has_features(&self) -> bool {
        self.tree.is_some()
    }

    /// Calls `visit(index, surface)` for the surfaces without a limited extent that particles of a row meet.
    #[inline]
    pub fn for_each_unlimited(&self, row: u16, mut visit: impl FnMut(u32, &Placed)) {
        for (index, placed) in (0..).zip(&self.all[..self.unlimited]) {
            if self.meet(placed, row) {
                visit(index, placed);
            }
        }
    }

    /// Calls `visit(index, feature)` for the features that may reach into a box and that particles of a row meet, in an order that is that of no box.
    #[inline]
    pub fn for_each_feature(&self, within: &[Vector; 2], row: u16, mut visit: impl FnMut(u32, &Placed)) {
        let Some(tree) = &self.tree else { return };
        tree.for_each(within, |index| {
            let placed = &self.all[index as usize];
            if self.meet(placed, row) {
                visit(index, placed);
            }
        });
    }

    /// Calls `visit(index, surface)` for all that a sphere at a position may touch or overlap.
    pub fn for_each_near(&self, position: &Vector, radius: f64, row: u16, mut visit: impl FnMut(u32, &Placed)) {
        self.for_each_unlimited(row, &mut visit);
        let around = Vector::repeat(radius);
        self.for_each_feature(&[position - around, position + around], row, visit);
    }

    /// Whether particles of a row meet a surface.
    #[inline]
    fn meet(&self, placed: &Placed, row: u16) -> bool {
        let of_scene = placed.number.checked_sub(FIRST_SURFACE);
        let rows = of_scene.and_then(|number| self.meets.get(number as usize));
        rows.is_none_or(|rows| rows.is_empty() || rows.get(usize::from(row)).copied().unwrap_or(false))
    }
}

/// The walls of a box, of which those with a temperature are thermal.
fn walls(space: &Space, temperatures: &[[Option<f64>; 2]; 3]) -> Vec<Placed> {
    let mut walls = Vec::new();
    for (axis, boundary) in (0_u8..).zip(&space.boundary) {
        let Boundary::Bounded { lower, upper } = boundary else { continue };
        let k = usize::from(axis);
        let sides = [(false, lower, space.lower[k]), (true, upper, space.upper()[k])];
        for ((is_upper, side, at), temperature) in sides.into_iter().zip(temperatures[k]) {
            if let space::Face::Wall { restitution } = *side {
                let wall = Wall { axis, is_upper, at };
                let law =
                    temperature.map_or(Law::Reflecting { restitution }, |temperature| Law::Thermal { temperature });
                walls.push(Placed { number: wall.number(), feature: 0, shape: Shape::Wall(wall), law });
            }
        }
    }
    walls
}

#[cfg(test)]
mod tests;
