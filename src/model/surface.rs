//! Surfaces that particles meet, besides the walls of the box: planes, spheres, cylinders, capsules and meshes of triangles.

use serde::{Deserialize, Serialize};

use super::{SpeciesId, SurfaceMotion, TriangleMesh};
use crate::Vector;

/// A surface: a shape, the species that meet it, how it answers a contact, and how it moves.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SceneSurface {
    /// Name, unique among the surfaces of the scene.
    pub name: String,
    /// Its shape.
    pub shape: SurfaceShape,
    /// The species that meet it; empty for all.
    pub species: Vec<SpeciesId>,
    /// How it answers a contact.
    pub law: SurfaceLaw,
    /// Names of the stages in which it is there, `measurement` for what comes after those that are listed; empty for all.
    pub stages: Vec<String>,
    /// Its motions in order of time. They do not overlap. The shape is that before the first one.
    pub motions: Vec<SurfaceMotion>,
}

impl SceneSurface {
    /// A surface that all species meet, in all stages.
    #[must_use]
    pub fn new(name: &str, shape: SurfaceShape, law: SurfaceLaw) -> Self {
        Self { name: name.to_owned(), shape, species: Vec::new(), law, stages: Vec::new(), motions: Vec::new() }
    }

    /// Whether it is there in a stage of this name.
    #[must_use]
    pub fn is_in(&self, stage: &str) -> bool {
        self.stages.is_empty() || self.stages.iter().any(|name| name == stage)
    }

    /// Whether it is there in some stages only.
    #[must_use]
    pub fn comes_and_goes(&self) -> bool {
        !self.stages.is_empty()
    }

    /// Whether it ever moves.
    #[must_use]
    pub fn moves(&self) -> bool {
        !self.motions.is_empty()
    }

    /// Whether a species meets it.
    #[must_use]
    pub fn meets(&self, species: SpeciesId) -> bool {
        self.species.is_empty() || self.species.contains(&species)
    }
}

/// How a surface answers a contact.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum SurfaceLaw {
    /// It reflects.
    Reflecting {
        /// Ratio of the normal speeds after and before, in `[0, 1]`.
        restitution: f64,
    },
    /// It gives velocities from the flux of a gas of this temperature.
    Thermal {
        /// `[energy]`
        temperature: f64,
    },
}

impl SurfaceLaw {
    /// The temperature, if it has one `[energy]`.
    #[must_use]
    pub fn temperature(&self) -> Option<f64> {
        match *self {
            Self::Thermal { temperature } => Some(temperature),
            Self::Reflecting { .. } => None,
        }
    }

    /// Whether a contact loses energy.
    #[must_use]
    pub fn dissipates(&self) -> bool {
        matches!(*self, Self::Reflecting { restitution } if restitution < 1.0)
    }
}

/// The shape of a surface. Spheres touch it where the distance of their centre is their radius.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum SurfaceShape {
    /// A half space: particles are on the side that the normal points to.
    Plane {
        /// A point of the plane `[length]`.
        point: Vector,
        /// Direction towards the particles, of any length.
        normal: Vector,
    },
    /// A sphere, met from outside or from inside.
    Sphere {
        /// `[length]`
        centre: Vector,
        /// `[length]`
        radius: f64,
        /// Whether particles are inside.
        is_inside: bool,
    },
    /// A cylinder without ends, met from outside or from inside.
    Cylinder {
        /// A point of its axis `[length]`.
        point: Vector,
        /// Direction of the axis, of any length.
        axis: Vector,
        /// `[length]`
        radius: f64,
        /// Whether particles are inside.
        is_inside: bool,
    },
    /// The places at a distance from a line between two ends: a cylinder with half spheres at its ends, met from outside; a bare line for radius 0.
    Capsule {
        /// `[length]`
        ends: [Vector; 2],
        /// `[length]`
        radius: f64,
    },
    /// Triangles, met from both sides.
    Mesh(TriangleMesh),
}
