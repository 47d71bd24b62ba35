//! How overlaps were removed from the start of a scene.

use serde::{Deserialize, Serialize};

/// Overlaps that were removed from the start of a scene, and the moves that this needed.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Separated {
    /// Number of overlaps: pairs of particles, and particles in walls and surfaces.
    pub overlaps: u64,
    /// Deepest overlap `[length]`.
    pub deepest: f64,
    /// Longest distance by which a particle was moved `[length]`.
    pub farthest: f64,
}
