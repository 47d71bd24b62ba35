//! Static-sphere surfaces.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{ParticleId, SpeciesId};

/// Immobile spheres that cover a shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StaticSurface {
    /// Name of the surface; by default its number among the static surfaces.
    pub name: String,
    /// Species of the spheres.
    pub species: SpeciesId,
    /// Ids of the spheres.
    pub particles: Range<u32>,
    /// Largest circumradius of a hole between the spheres `[length]`; `None` if the scene lists the spheres.
    pub hole: Option<f64>,
    /// Ids of the spheres along each open rim of the shape.
    pub rims: Vec<Vec<ParticleId>>,
}
