//! Static-sphere surfaces.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{ParticleId, SpeciesId};

/// A static-sphere surface: immobile spheres that cover a shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StaticSurface {
    /// Name of the surface; by default its number among the static surfaces.
    pub name: String,
    /// Species of the spheres.
    pub species: SpeciesId,
    /// Ids of the spheres.
    pub particles: Range<u32>,
    /// Largest circumradius of a hole between the spheres `[length]`; `None` if the scene lists their positions.
    pub hole: Option<f64>,
    /// For each open rim of the shape, the ids of the spheres along it.
    pub rims: Vec<Vec<ParticleId>>,
}
