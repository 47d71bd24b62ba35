//! The surfaces of a scene: which there are, who meets them, and which are near.

use super::tree::Tree;
use super::wall::Wall;
use super::{Law, Shape, Surface, features};
use crate::Vector;
use crate::model::space::{Boundary, Face, Space};
use crate::model::{Scene, SceneSurface, SpeciesId, SurfaceLaw};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

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
    /// By surface, whether it is there now.
    is_present: Vec<bool>,
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
        let present = origin.surfaces.iter().zip(FIRST_SURFACE..).zip(&origin.is_present);
        for ((surface, number), _) in present.filter(|(_, is_present)| **is_present) {
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
        let stage = scene.run.first_stage();
        Self::of_parts((&scene.space, &scene.wall_temperatures), &scene.surfaces, species, stage)
    }

    /// The surfaces of the parts of a scene that are there in a stage.
    pub fn of_parts(
        (space, temperatures): (&Space, &[[Option<f64>; 2]; 3]),
        surfaces: &[SceneSurface],
        species: &[SpeciesId],
        stage: &str,
    ) -> Self {
        let is_present = surfaces.iter().map(|surface| surface.is_in(stage)).collect();
        let (space, surfaces, species) = (space.clone(), surfaces.to_vec(), species.to_vec());
        Self::from(Origin { space, temperatures: *temperatures, surfaces, species, is_present })
    }

    /// Surfaces of another stage; none if these are the same.
    pub fn in_stage(&self, stage: &str) -> Option<Self> {
        let is_present: Vec<bool> = self.origin.surfaces.iter().map(|surface| surface.is_in(stage)).collect();
        (is_present != self.origin.is_present).then(|| Self::from(Origin { is_present, ..(*self.origin).clone() }))
    }

    /// Whether some are thermal, now or in another stage.
    pub fn are_ever_thermal(&self) -> bool {
        let has_temperature = |surface: &SceneSurface| surface.law.temperature().is_some();
        self.all.iter().any(|placed| matches!(placed.law, Law::Thermal { .. }))
            || self.origin.surfaces.iter().any(has_temperature)
    }

    /// Surfaces of the scene, without the walls.
    pub fn of_scene(&self) -> &[SceneSurface] {
        &self.origin.surfaces
    }

    /// All of them, each at the index that predictions name.
    #[cfg(test)]
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
            if let Face::Wall { restitution } = *side {
                let wall = Wall { axis, is_upper, at };
                let law =
                    temperature.map_or(Law::Reflecting { restitution }, |temperature| Law::Thermal { temperature });
                walls.push(Placed { number: wall.number(), feature: 0, shape: Shape::Wall(wall), law });
            }
        }
    }
    walls
}
