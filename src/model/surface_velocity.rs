//! Surfaces whose material moves along them, like a belt or a turning drum.

use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use crate::Vector;

/// Motion of the material of a surface, while the shape stays where it is. Only the component along the surface acts.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum SurfaceVelocity {
    /// The same velocity everywhere, as on a belt.
    Translation {
        /// `[length / time]`
        velocity: Vector,
    },
    /// A rotation, as of a drum. Rotations are counterclockwise if the axis points at the viewer.
    Rotation {
        /// A point on the axis `[length]`.
        point: Vector,
        /// Direction of the axis, of any length.
        axis: Vector,
        /// Turns per time `[1 / time]`; negative values reverse the rotation.
        frequency: f64,
    },
}

impl SurfaceVelocity {
    /// Angular velocity of the material `[1 / time]`; zero for a translation.
    #[must_use]
    pub fn spin(&self) -> Vector {
        match *self {
            Self::Translation { .. } => Vector::zeros(),
            Self::Rotation { axis, frequency, .. } => axis.try_normalize(0.0).unwrap_or_default() * (TAU * frequency),
        }
    }

    /// The numbers that define the velocity, for the state point of a scene.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        match *self {
            Self::Translation { velocity } => velocity.as_slice().to_vec(),
            Self::Rotation { point, axis, frequency } => [point.as_slice(), axis.as_slice(), &[frequency]].concat(),
        }
    }

    /// Velocity of the material at a place of the surface with this unit normal, along the surface `[length / time]`.
    /// For a surface with motions, all arguments and the result are in the frame of its shape.
    #[must_use]
    pub fn at(&self, place: &Vector, normal: &Vector) -> Vector {
        let velocity = match *self {
            Self::Translation { velocity } => velocity,
            Self::Rotation { point, .. } => self.spin().cross(&(place - point)),
        };
        velocity - normal * velocity.dot(normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_component_along_the_surface_acts() {
        let belt = SurfaceVelocity::Translation { velocity: Vector::new(2.0, 0.5, 7.0) };
        assert_eq!(belt.at(&Vector::zeros(), &Vector::z()), Vector::new(2.0, 0.5, 0.0));
        assert_eq!(belt.at(&Vector::zeros(), &-Vector::x()), Vector::new(0.0, 0.5, 7.0));
    }

    #[test]
    fn a_drum_turns_counterclockwise_about_its_axis() {
        let axis = Vector::z() * 3.0;
        let drum = SurfaceVelocity::Rotation { point: Vector::new(1.0, 0.0, 5.0), axis, frequency: 0.5 };
        // Half a turn per time at a distance of 2 from the axis: the speed is 2 pi.
        let velocity = drum.at(&Vector::new(3.0, 0.0, 0.0), &-Vector::x());
        assert!((velocity - Vector::y() * TAU).norm() < 1e-14, "{velocity}");
        assert_eq!(drum.spin(), Vector::z() * (0.5 * TAU));
    }
}
