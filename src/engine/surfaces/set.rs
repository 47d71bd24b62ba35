//! The surfaces of a scene. Finds the surfaces that are present, collide with a species, and are near a particle.

use super::moving::{Found, Moving};
use super::tree::Tree;
use super::wall::Wall;
use super::{Flight, Shape, Surface, features};
use crate::Vector;
use crate::base::numbers::id;
use crate::model::space::{Boundary, Face, Space};
use crate::model::surface_motion::{Moment, Pose, Timeline};
use crate::model::triangle_mesh::LARGEST_COORDINATE;
use crate::model::{Scene, SceneSurface, SpeciesId, SurfaceLaw, SurfaceShape, TriangleMesh};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A wall, a surface of a scene, or one feature of such a surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    /// Number of the surface in events. The walls of the box have the numbers `2 axis + is_upper`. The surfaces of the
    /// scene have numbers from [`FIRST_SURFACE`] on.
    pub number: u32,
    /// Number of the feature within the surface. Periodic images have the same number.
    pub feature: u32,
    pub shape: Shape,
    pub law: SurfaceLaw,
    /// Index among the moving surfaces, or [`AT_REST`].
    pub moving: u32,
    /// Whether the material moves along the surface.
    pub has_velocity: bool,
}

impl Placed {
    #[inline]
    pub fn is_at_rest(&self) -> bool {
        self.moving == AT_REST
    }
}

const AT_REST: u32 = u32::MAX;

/// Largest total number of triangles in all meshes. The number of features and periodic images must fit in 32 bits.
pub(crate) const MOST_FEATURES: usize = 1 << 26;

pub(crate) const FIRST_SURFACE: u32 = 6;

/// The data from which surfaces are created. A saved state contains these data instead of the surfaces.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
struct Origin {
    space: Space,
    temperatures: [[Option<f64>; 2]; 3],
    start_time: f64,
    surfaces: Vec<SceneSurface>,
    /// Species of each row of the interaction table.
    species: Vec<SpeciesId>,
    is_present: Vec<bool>,
}

/// The surfaces of a scene: first walls and other unbounded surfaces, then the features of bounded surfaces.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Stored", into = "Origin")]
pub(crate) struct Surfaces {
    origin: Arc<Origin>,
    all: Arc<Vec<Placed>>,
    unlimited: usize,
    /// Whether a surface collides with the species of each table row. Empty for a surface that collides with all
    /// species.
    meets: Vec<Vec<bool>>,
    tree: Option<Arc<Tree>>,
    /// The moving surfaces. Their features are at the end of `all`.
    moving: Arc<Vec<Moving>>,
}

impl From<Origin> for Surfaces {
    fn from(origin: Origin) -> Self {
        let mut all = walls(&origin.space, &origin.temperatures);
        let present = origin.surfaces.iter().zip(FIRST_SURFACE..).zip(&origin.is_present);
        let present: Vec<(&SceneSurface, u32)> =
            present.filter(|(_, is_present)| **is_present).map(|(numbered, _)| numbered).collect();
        let mut limited = Vec::new();
        for (surface, number) in present.iter().filter(|(surface, _)| !surface.moves()) {
            sort((&origin.space, surface, *number, AT_REST), &mut all, &mut limited);
        }
        let meets = |surface: &SceneSurface| match surface.species.is_empty() {
            true => Vec::new(),
            false => origin.species.iter().map(|species| surface.meets(*species)).collect(),
        };
        let unlimited = all.len();
        let tree = (!limited.is_empty()).then(|| Arc::new(Tree::of(&mut limited, unlimited)));
        // Moves the features instead of copying them, because there may be many.
        limited.splice(0..0, all);
        let mut all = std::mem::take(&mut limited);
        let mut moving = Vec::new();
        for (surface, number) in present.iter().filter(|(surface, _)| surface.moves()) {
            let first = all.len();
            sort((&origin.space, surface, *number, id(moving.len())), &mut all, &mut limited);
            let unlimited = first..all.len();
            let tree = (!limited.is_empty()).then(|| Tree::of(&mut limited, unlimited.end));
            all.append(&mut limited);
            let features = first..all.len();
            moving.push(Moving { timeline: Timeline::of(&surface.motions), features, unlimited, tree });
        }
        let meets = origin.surfaces.iter().map(meets).collect();
        Self { origin: Arc::new(origin), all: Arc::new(all), unlimited, meets, tree, moving: Arc::new(moving) }
    }
}

/// Data from a file, not yet validated.
#[derive(Deserialize)]
#[serde(transparent)]
struct Stored(Origin);

impl TryFrom<Stored> for Surfaces {
    type Error = &'static str;

    fn try_from(Stored(origin): Stored) -> Result<Self, Self::Error> {
        if origin.is_present.len() != origin.surfaces.len() {
            return Err("the list of present surfaces");
        }
        let all_are_sound = origin.surfaces.iter().all(|surface| match &surface.shape {
            SurfaceShape::Mesh(mesh) => mesh.is_sound() && has_few_images(&origin.space, mesh),
            SurfaceShape::Capsule { ends, .. } => ends.iter().all(|end| end.amax() <= LARGEST_COORDINATE),
            _ => true,
        });
        if all_are_sound { Ok(Self::from(origin)) } else { Err("the surfaces") }
    }
}

fn has_few_images(space: &Space, mesh: &TriangleMesh) -> bool {
    let images = |axis: usize| {
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for vertex in &mesh.vertices {
            (lowest, highest) = (lowest.min(vertex[axis]), highest.max(vertex[axis]));
        }
        ((highest - lowest).max(0.0) / space.periods()[axis] + 4.0).max(1.0)
    };
    (mesh.triangles.len() as f64) * images(0) * images(1) * images(2) <= MOST_FEATURES as f64
}

impl From<Surfaces> for Origin {
    fn from(surfaces: Surfaces) -> Self {
        Arc::unwrap_or_clone(surfaces.origin)
    }
}

impl Surfaces {
    /// Creates the surfaces for the first stage of a scene. `species` holds the species of each row of the interaction
    /// table.
    pub fn of(scene: &Scene, species: &[SpeciesId]) -> Self {
        let stage = scene.run.first_stage();
        Self::of_parts((&scene.space, &scene.wall_temperatures, scene.start_time), &scene.surfaces, species, stage)
    }

    pub fn of_parts(
        (space, temperatures, start_time): (&Space, &[[Option<f64>; 2]; 3], f64),
        surfaces: &[SceneSurface],
        species: &[SpeciesId],
        stage: &str,
    ) -> Self {
        let is_present = surfaces.iter().map(|surface| surface.is_in(stage)).collect();
        let (space, surfaces, species) = (space.clone(), surfaces.to_vec(), species.to_vec());
        Self::from(Origin { space, temperatures: *temperatures, start_time, surfaces, species, is_present })
    }

    /// Whether each surface of the scene is present now. Empty if all surfaces are always present.
    pub fn presence(&self) -> Vec<bool> {
        let come_and_go = self.origin.surfaces.iter().any(SceneSurface::comes_and_goes);
        if come_and_go { self.origin.is_present.clone() } else { Vec::new() }
    }

    /// Returns the surfaces of another stage, or `None` if nothing changes.
    pub fn in_stage(&self, stage: &str) -> Option<Self> {
        let is_present: Vec<bool> = self.origin.surfaces.iter().map(|surface| surface.is_in(stage)).collect();
        (is_present != self.origin.is_present).then(|| Self::from(Origin { is_present, ..(*self.origin).clone() }))
    }

    pub fn are_ever_thermal(&self) -> bool {
        let has_temperature = |surface: &SceneSurface| surface.law.temperature().is_some();
        self.all.iter().any(|placed| placed.law.temperature().is_some())
            || self.origin.surfaces.iter().any(has_temperature)
    }

    pub fn have_outlets(&self) -> bool {
        self.origin.surfaces.iter().any(|surface| surface.law == SurfaceLaw::Outlet)
    }

    pub fn dissipate(&self) -> bool {
        self.all.iter().any(|placed| placed.law.dissipates())
    }

    pub fn start_time(&self) -> f64 {
        self.origin.start_time
    }

    pub fn of_scene(&self) -> &[SceneSurface] {
        &self.origin.surfaces
    }

    #[cfg(test)]
    pub fn all(&self) -> &[Placed] {
        &self.all
    }

    #[inline]
    pub fn get(&self, index: u32) -> Option<&Placed> {
        self.all.get(index as usize)
    }

    /// The name of a surface of the scene. Walls have no names.
    pub fn name(&self, number: u32) -> &str {
        let of_scene = number.checked_sub(FIRST_SURFACE);
        of_scene.and_then(|number| self.origin.surfaces.get(number as usize)).map_or("", |surface| &surface.name)
    }

    #[inline]
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// Velocity of the material along a surface, where a sphere with its centre at `position` touches it. Positions and
    /// velocities are in the frame of the surface. `None` for a surface without such a velocity.
    #[cold]
    pub fn material_velocity(&self, placed: &Placed, position: &Vector, radius: f64) -> Option<Vector> {
        let surface = self.origin.surfaces.get(placed.number.checked_sub(FIRST_SURFACE)? as usize)?;
        let normal = placed.shape.normal(position);
        surface.surface_velocity.map(|velocity| velocity.at(&(position - normal * radius), &normal))
    }

    /// Whether contacts must be searched for, because there are bounded features or moving surfaces.
    #[inline]
    pub fn has_features(&self) -> bool {
        self.tree.is_some() || !self.moving.is_empty()
    }

    /// Position and motion of a surface at a simulated time. `None` for a surface that never moves.
    #[inline]
    pub fn moment(&self, placed: &Placed, time: f64) -> Option<Moment> {
        self.moving.get(placed.moving as usize).map(|moving| moving.timeline.at(time))
    }

    pub fn for_each_moving(&self, row: u16, time: f64, mut visit: impl FnMut(&Pose, &Placed)) {
        for moving in self.moving.iter() {
            let pose = moving.timeline.at(time).pose;
            let features = self.all.get(moving.features.clone()).unwrap_or_default().iter();
            features.filter(|placed| self.meet(placed, row)).for_each(|placed| visit(&pose, placed));
        }
    }

    pub fn rest_from(&self, time: f64) -> bool {
        self.moving.iter().all(|moving| moving.timeline.rests_from(time))
    }

    /// Index in the scene of the first surface that is moving at `time`.
    pub fn moving_at(&self, time: f64) -> Option<u32> {
        let moving = self.moving.iter().find(|moving| moving.timeline.piece_at(time).kind.is_some())?;
        self.all.get(moving.features.start)?.number.checked_sub(FIRST_SURFACE)
    }

    /// Calls `visit` with the next contact of a particle and each moving surface, if it occurs within `horizon`.
    /// `visit` returns the horizon for the next surface. `now` is the simulated time.
    pub fn next_moving_contacts(
        &self,
        flight: &Flight<'_>,
        row: u16,
        now: f64,
        horizon: f64,
        mut visit: impl FnMut(Found) -> f64,
    ) {
        let mut horizon = horizon;
        for moving in self.moving.iter() {
            if let Some(found) = moving.next_contact(&self.all, |placed| self.meet(placed, row), (flight, now), horizon)
            {
                horizon = visit(found);
            }
        }
    }

    #[inline]
    pub fn for_each_unlimited(&self, row: u16, mut visit: impl FnMut(u32, &Placed)) {
        for (index, placed) in (0..).zip(&self.all[..self.unlimited]) {
            if self.meet(placed, row) {
                visit(index, placed);
            }
        }
    }

    /// Calls `visit(index, feature)` for the features that may reach into the box `within` and that collide with the
    /// species of a table row. The order of features does not depend on the box.
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

    /// Calls `visit(surface, position)` for every surface or feature that a sphere may touch or overlap at a simulated
    /// time. The position passed to `visit` is in the frame of the surface.
    pub fn for_each_near(
        &self,
        (position, radius): (&Vector, f64),
        row: u16,
        time: f64,
        mut visit: impl FnMut(&Placed, &Vector),
    ) {
        self.for_each_unlimited(row, |_, placed| visit(placed, position));
        let around = Vector::repeat(radius);
        self.for_each_feature(&[position - around, position + around], row, |_, placed| visit(placed, position));
        for moving in self.moving.iter() {
            let position = moving.timeline.at(time).pose.place_of_shape(position);
            moving.for_each_within(&self.all, (&position, radius), 0.0, |_, placed| {
                if self.meet(placed, row) {
                    visit(placed, &position);
                }
            });
        }
    }

    #[inline]
    fn meet(&self, placed: &Placed, row: u16) -> bool {
        let of_scene = placed.number.checked_sub(FIRST_SURFACE);
        let rows = of_scene.and_then(|number| self.meets.get(number as usize));
        rows.is_none_or(|rows| rows.is_empty() || rows.get(usize::from(row)).copied().unwrap_or(false))
    }
}

fn sort(
    (space, surface, number, moving): (&Space, &SceneSurface, u32, u32),
    unlimited: &mut Vec<Placed>,
    limited: &mut Vec<Placed>,
) {
    let (law, has_velocity) = (surface.law, surface.surface_velocity.is_some());
    features::for_each_within(space, &surface.shape, |shape, feature| {
        let placed = Placed { number, feature, shape, law, moving, has_velocity };
        if placed.shape.extent().is_some() { limited.push(placed) } else { unlimited.push(placed) }
    });
}

fn walls(space: &Space, temperatures: &[[Option<f64>; 2]; 3]) -> Vec<Placed> {
    let mut walls = Vec::new();
    for (axis, boundary) in (0_u8..).zip(&space.boundary) {
        let Boundary::Bounded { lower, upper } = boundary else { continue };
        let k = usize::from(axis);
        let sides = [(false, lower, space.lower[k]), (true, upper, space.upper()[k])];
        for ((is_upper, side, at), temperature) in sides.into_iter().zip(temperatures[k]) {
            if let Face::Wall(law) = *side {
                let wall = Wall { axis, is_upper, at };
                let law =
                    temperature.map_or(SurfaceLaw::Reflecting(law), |temperature| SurfaceLaw::Thermal { temperature });
                walls.push(Placed {
                    number: wall.number(),
                    feature: 0,
                    shape: Shape::Wall(wall),
                    law,
                    moving: AT_REST,
                    has_velocity: false,
                });
            }
        }
    }
    walls
}
