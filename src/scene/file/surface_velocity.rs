//! `surface_velocity` of a surface: a velocity, or a rotation.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::either::Either;

/// A velocity such as `[0.5, 0.0, 0.0]` `[length / time]`, or a rotation such as
/// `{ point = [0.0, 0.0, 0.0], axis = [0.0, 1.0, 0.0], frequency = 0.1 }`.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum SurfaceVelocityFile {
    Velocity([f64; 3]),
    Turning(TurningFile),
}

/// Rotation of the material of a surface, such as a drum.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct TurningFile {
    /// A point on the axis `[length]`.
    pub point: [f64; 3],
    /// Direction of the axis, of any length. Rotations are counterclockwise if the axis points at the viewer.
    pub axis: [f64; 3],
    /// Turns per unit of time `[1 / time]`; negative values reverse the rotation.
    pub frequency: f64,
}

impl<'de> Deserialize<'de> for SurfaceVelocityFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = "three components of a velocity, or { point = ..., axis = ..., frequency = ... }";
        Either { of_vector: Some(Self::Velocity), ..Either::new(expected, Self::Turning) }.deserialize(deserializer)
    }
}
