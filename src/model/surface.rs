//! Surfaces that particles meet, besides the walls of the box: planes, spheres, cylinders, capsules and
//! triangle meshes.

use serde::{Deserialize, Serialize};

use super::{SpeciesId, SurfaceMotion, TriangleMesh};
use crate::Vector;

/// A surface: a shape, the species that meet it, its law of contact, and its motion.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SceneSurface {
    /// Name, unique among the surfaces of the scene.
    pub name: String,
    /// Its shape.
    pub shape: SurfaceShape,
    /// The species that meet it; empty for all.
    pub species: Vec<SpeciesId>,
    /// Its law of contact.
    pub law: SurfaceLaw,
    /// Names of the stages in which it is present; `measurement` for everything after the listed stages;
    /// empty for all.
    pub stages: Vec<String>,
    /// Its motions in order of time. They do not overlap. `shape` is the shape before the first motion.
    pub motions: Vec<SurfaceMotion>,
}

impl SceneSurface {
    /// A surface that all species meet, in all stages.
    #[must_use]
    pub fn new(name: &str, shape: SurfaceShape, law: SurfaceLaw) -> Self {
        Self { name: name.to_owned(), shape, species: Vec::new(), law, stages: Vec::new(), motions: Vec::new() }
    }

    /// Whether it is present in a stage of this name.
    #[must_use]
    pub fn is_in(&self, stage: &str) -> bool {
        self.stages.is_empty() || self.stages.iter().any(|name| name == stage)
    }

    /// Whether it is present in some stages only.
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

/// Law of contact of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum SurfaceLaw {
    /// Reflection.
    Reflecting {
        /// Ratio of the normal speeds after and before, in `[0, 1]`.
        restitution: f64,
    },
    /// Velocities from the flux of a gas at this temperature.
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

/// The shape of a surface. Spheres touch it when their centre is one radius away.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum SurfaceShape {
    /// A half space. Particles are on the side to which the normal points.
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
    /// An infinite cylinder, met from outside or from inside.
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
    /// All points within a distance from the line segment between two ends: a cylinder with hemispherical
    /// ends, met from outside. Radius 0 gives a bare line segment.
    Capsule {
        /// `[length]`
        ends: [Vector; 2],
        /// `[length]`
        radius: f64,
    },
    /// Triangles, met from both sides.
    Mesh(TriangleMesh),
}
