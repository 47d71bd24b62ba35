//! Surfaces besides the walls of the box: planes, spheres, cylinders, capsules and triangle meshes.

use serde::{Deserialize, Serialize};

use super::{SpeciesId, SurfaceMotion, SurfaceVelocity, TriangleMesh};
use crate::Vector;
use crate::physics::response::ContactLaw;

/// A surface: its shape, the species that collide with it, its law of contact, and its motions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SceneSurface {
    /// Name, unique among the surfaces of the scene.
    pub name: String,
    /// Shape of the surface.
    pub shape: SurfaceShape,
    /// Species that collide with the surface; all species if empty.
    pub species: Vec<SpeciesId>,
    /// Law of contact between particles and the surface.
    pub law: SurfaceLaw,
    /// Names of the stages with the surface; all stages if empty. `measurement` is everything after the listed stages.
    pub stages: Vec<String>,
    /// Motions of the surface, in order of time and without overlap. `shape` is the shape before the first motion.
    pub motions: Vec<SurfaceMotion>,
    /// Velocity of the material along the surface, which friction passes on to particles; `None` if it is at rest in the
    /// frame of the shape.
    pub surface_velocity: Option<SurfaceVelocity>,
}

impl SceneSurface {
    /// Creates a surface that is present in all stages and collides with all species.
    #[must_use]
    pub fn new(name: &str, shape: SurfaceShape, law: SurfaceLaw) -> Self {
        let (species, stages, motions) = (Vec::new(), Vec::new(), Vec::new());
        Self { name: name.to_owned(), shape, species, law, stages, motions, surface_velocity: None }
    }

    /// Whether the surface is present in the stage with this name.
    #[must_use]
    pub fn is_in(&self, stage: &str) -> bool {
        self.stages.is_empty() || self.stages.iter().any(|name| name == stage)
    }

    /// Whether the surface is present in some stages only.
    #[must_use]
    pub fn comes_and_goes(&self) -> bool {
        !self.stages.is_empty()
    }

    /// Whether the surface moves at some time.
    #[must_use]
    pub fn moves(&self) -> bool {
        !self.motions.is_empty()
    }

    /// Whether particles of this species collide with the surface.
    #[must_use]
    pub fn meets(&self, species: SpeciesId) -> bool {
        self.species.is_empty() || self.species.contains(&species)
    }
}

/// Law of contact of a surface.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum SurfaceLaw {
    /// Reflection.
    Reflecting(ContactLaw),
    /// A thermal surface. Particles leave it with velocities from the flux distribution of a gas at this temperature.
    Thermal {
        /// Temperature of the gas `[energy]`.
        temperature: f64,
    },
    /// An outlet: a particle that touches the surface leaves the system.
    Outlet,
}

impl SurfaceLaw {
    /// Temperature of a thermal surface `[energy]`; `None` for other surfaces.
    #[must_use]
    pub fn temperature(&self) -> Option<f64> {
        match *self {
            Self::Thermal { temperature } => Some(temperature),
            Self::Reflecting(_) | Self::Outlet => None,
        }
    }

    /// Contact law of a reflecting surface; `None` for other surfaces.
    #[must_use]
    pub fn contact(&self) -> Option<ContactLaw> {
        match *self {
            Self::Reflecting(law) => Some(law),
            Self::Thermal { .. } | Self::Outlet => None,
        }
    }

    /// Whether particles lose kinetic energy in a contact with the surface.
    #[must_use]
    pub fn dissipates(&self) -> bool {
        matches!(self, Self::Reflecting(law) if law.dissipates())
    }
}

/// The shape of a surface. A particle touches the surface when its centre is one particle radius away.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum SurfaceShape {
    /// A half space bounded by a plane. Particles are on the side to which the normal points.
    Plane {
        /// A point on the plane `[length]`.
        point: Vector,
        /// Direction towards the particles, of any length.
        normal: Vector,
    },
    /// A sphere, with particles outside or inside.
    Sphere {
        /// `[length]`
        centre: Vector,
        /// `[length]`
        radius: f64,
        /// Whether particles are inside the surface.
        is_inside: bool,
    },
    /// An infinite cylinder, with particles outside or inside.
    Cylinder {
        /// A point on the axis of the cylinder `[length]`.
        point: Vector,
        /// Direction of the axis of the cylinder, of any length.
        axis: Vector,
        /// `[length]`
        radius: f64,
        /// Whether particles are inside the surface.
        is_inside: bool,
    },
    /// All points within a distance from the line segment between two ends: a cylinder with hemispherical ends.
    /// Particles are outside. Radius 0 gives a bare line segment.
    Capsule {
        /// `[length]`
        ends: [Vector; 2],
        /// `[length]`
        radius: f64,
    },
    /// A triangle mesh. Particles collide with both sides of its triangles.
    Mesh(TriangleMesh),
}
