//! Static-sphere surfaces.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::{ParticleId, SpeciesId};

/// A static-sphere surface: immobile spheres that cover a shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StaticSurface {
    /// Its name, or its number among the static surfaces.
    pub name: String,
    /// The static species.
    pub species: SpeciesId,
    /// Ids of its spheres.
    pub particles: Range<u32>,
    /// Largest circumradius of a hole between them `[length]`; `None` for spheres at given positions.
    pub hole: Option<f64>,
    /// The spheres along each of its open rims.
    pub rims: Vec<Vec<ParticleId>>,
}
