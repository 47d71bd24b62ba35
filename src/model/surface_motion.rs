//! Motions of surfaces: translations, oscillations and rotations, in sequence.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use crate::Vector;
use crate::base::numbers::trunc_to_usize;

/// A motion of a surface from one time to another. Between its motions, a surface is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SurfaceMotion {
    /// Simulated time at which the motion begins `[time]`.
    pub from: f64,
    /// Simulated time at which the motion ends `[time]`; may be infinite.
    #[serde(with = "endless")]
    pub until: f64,
    /// Kind of motion.
    pub kind: MotionKind,
}

/// A motion as a function of the time `t` since it began.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum MotionKind {
    /// Displacement `u(t) = v t + a t^2 / 2`.
    Translation {
        /// Velocity `v` at the beginning of the motion `[length / time]`.
        velocity: Vector,
        /// Constant acceleration `a` `[length / time^2]`.
        acceleration: Vector,
    },
    /// Displacement `u(t) = A (sin(2 pi (f t + phase)) - sin(2 pi phase))`.
    Oscillation {
        /// `A` `[length]`.
        amplitude: Vector,
        /// Periods per time, `f` `[1 / time]`.
        frequency: f64,
        /// Phase in turns. At a phase of 1/4, the motion starts at the positive end, `A`.
        phase: f64,
    },
    /// Rotation by the angle `2 pi f t`, counterclockwise as seen from the tip of the axis.
    Rotation {
        /// A point on the axis of rotation `[length]`.
        point: Vector,
        /// Direction of the axis of rotation. Its length is irrelevant.
        axis: Vector,
        /// Turns per time, `f` `[1 / time]`.
        frequency: f64,
    },
}

impl MotionKind {
    /// Whether free flight relative to the surface is a parabola or a straight line.
    #[must_use]
    pub fn is_polynomial(&self) -> bool {
        matches!(self, Self::Translation { .. })
    }

    /// Number of periods or turns per unit time, never negative `[1 / time]`; `None` for a translation.
    #[must_use]
    pub fn frequency(&self) -> Option<f64> {
        match self {
            Self::Translation { .. } => None,
            Self::Oscillation { frequency, .. } | Self::Rotation { frequency, .. } => Some(frequency.abs()),
        }
    }
}

/// A time that may be infinite, which JSON cannot represent as a number.
mod endless {
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    pub fn serialize<S: Serializer>(time: &f64, serializer: S) -> Result<S::Ok, S::Error> {
        Some(*time).filter(|time| time.is_finite()).serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
        Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
    }
}

/// Pose of a surface: the point `x` of its shape is at `R x + d` in space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Rotation matrix `R`.
    pub rotation: Matrix3<f64>,
    /// Whether `R` differs from the identity.
    pub is_turned: bool,
    /// Displacement `d` `[length]`.
    pub displacement: Vector,
}

impl Default for Pose {
    fn default() -> Self {
        Self { rotation: Matrix3::identity(), is_turned: false, displacement: Vector::zeros() }
    }
}

impl Pose {
    /// Converts a point from the frame of the shape to the frame of space.
    #[must_use]
    pub fn place(&self, position: &Vector) -> Vector {
        self.direction(position) + self.displacement
    }

    /// Converts a direction from the frame of the shape to the frame of space.
    #[must_use]
    pub fn direction(&self, vector: &Vector) -> Vector {
        if self.is_turned { self.rotation * vector } else { *vector }
    }

    /// Converts a point from the frame of space to the frame of the shape.
    #[must_use]
    pub fn place_of_shape(&self, position: &Vector) -> Vector {
        self.direction_of_shape(&(position - self.displacement))
    }

    /// Converts a direction from the frame of space to the frame of the shape.
    #[must_use]
    pub fn direction_of_shape(&self, vector: &Vector) -> Vector {
        if self.is_turned { self.rotation.tr_mul(vector) } else { *vector }
    }

    fn moved(self, by: &Vector) -> Self {
        Self { displacement: self.displacement + by, ..self }
    }

    fn turned(&self, point: &Vector, turn: &Matrix3<f64>) -> Self {
        Self {
            rotation: turn * self.rotation,
            is_turned: true,
            displacement: point + turn * (self.displacement - point),
        }
    }
}

/// Pose, velocity and acceleration of a surface at one time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Pose of the surface.
    pub pose: Pose,
    /// Velocity of the surface at the point `origin` `[length / time]`.
    pub velocity: Vector,
    /// Acceleration of the surface at the point `origin` `[length / time^2]`.
    pub acceleration: Vector,
    /// Angular velocity `[1 / time]`.
    pub spin: Vector,
    /// The point to which `velocity` and `acceleration` refer. For a rotation, it is a point on the axis `[length]`.
    pub origin: Vector,
}

impl Moment {
    /// Velocity of the surface at a point in space `[length / time]`.
    #[must_use]
    pub fn velocity_at(&self, position: &Vector) -> Vector {
        self.velocity + self.spin.cross(&(position - self.origin))
    }

    /// Converts a position and a velocity in space to the frame of the surface.
    #[must_use]
    pub fn seen(&self, position: &Vector, velocity: &Vector) -> (Vector, Vector) {
        let apart = velocity - self.velocity_at(position);
        (self.pose.place_of_shape(position), self.pose.direction_of_shape(&apart))
    }

    /// Converts a velocity at a point from the frame of the surface to space `[length / time]`.
    #[must_use]
    pub fn velocity_of(&self, position: &Vector, seen: &Vector) -> Vector {
        self.pose.direction(seen) + self.velocity_at(position)
    }

    /// Returns the acceleration in the frame of the surface, `a - A - W x (W x r) - 2 W x v'` `[length / time^2]`. `A`
    /// and `W` are the acceleration and the angular velocity of the surface, `a` is the acceleration of the particle,
    /// and `r` and `v'` are its position and velocity relative to the surface.
    #[must_use]
    pub fn acceleration_seen(&self, position: &Vector, velocity: &Vector, acceleration: &Vector) -> Vector {
        let arm = position - self.origin;
        let apart = velocity - self.velocity_at(position);
        let turning = self.spin.cross(&self.spin.cross(&arm)) + self.spin.cross(&apart) * 2.0;
        self.pose.direction_of_shape(&(acceleration - self.acceleration - turning))
    }
}

/// An interval of time in which a surface has one motion or is at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// Beginning of the interval `[time]`.
    pub from: f64,
    /// End of the interval `[time]`.
    pub until: f64,
    start: Pose,
    /// Motion of the surface; `None` at rest.
    pub kind: Option<MotionKind>,
}

impl Piece {
    /// Pose and motion of the surface at a time within this piece.
    #[must_use]
    pub fn at(&self, time: f64) -> Moment {
        let still = Moment {
            pose: self.start,
            velocity: Vector::zeros(),
            acceleration: Vector::zeros(),
            spin: Vector::zeros(),
            origin: Vector::zeros(),
        };
        // A rest can begin at minus infinity, so the time since the beginning is not used.
        let Some(kind) = &self.kind else { return still };
        let t = time - self.from;
        match *kind {
            MotionKind::Translation { velocity, acceleration } => Moment {
                pose: self.start.moved(&((velocity + acceleration * (0.5 * t)) * t)),
                velocity: velocity + acceleration * t,
                acceleration,
                ..still
            },
            MotionKind::Oscillation { amplitude, frequency, phase } => {
                let (sin, cos) = sine_and_cosine(frequency * t + phase);
                let (first, _) = sine_and_cosine(phase);
                let rate = TAU * frequency;
                Moment {
                    pose: self.start.moved(&(amplitude * (sin - first))),
                    velocity: amplitude * (rate * cos),
                    acceleration: amplitude * (-rate * rate * sin),
                    ..still
                }
            }
            MotionKind::Rotation { point, axis, frequency } => {
                let axis = axis.try_normalize(0.0).unwrap_or_else(Vector::z);
                let turn = turn(&axis, sine_and_cosine(frequency * t));
                let spin = axis * (TAU * frequency);
                Moment { pose: self.start.turned(&point, &turn), spin, origin: point, ..still }
            }
        }
    }
}

/// Sine and cosine of an angle in turns. Precise after many turns, and equal bit for bit on every machine.
pub(crate) fn sine_and_cosine(turns: f64) -> (f64, f64) {
    let quarters = 4.0 * (turns - turns.floor());
    if quarters == quarters.floor() {
        // Multiples of a right angle are exact.
        return [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][trunc_to_usize(quarters) % 4];
    }
    libm::sincos(TAU * (turns - turns.round()))
}

/// Returns the matrix of a rotation about an axis of length 1 (Rodrigues' formula).
pub(crate) fn turn(axis: &Vector, (sin, cos): (f64, f64)) -> Matrix3<f64> {
    let mut matrix = axis.cross_matrix() * sin + axis * axis.transpose() * (1.0 - cos);
    for k in 0..3 {
        // In this form, the diagonal element is exactly 1 if the axis of rotation is along `k`.
        matrix[(k, k)] = 1.0 - (1.0 - cos) * (1.0 - axis[k] * axis[k]);
    }
    matrix
}

/// The motions of a surface and the rests between them, without gaps.
#[derive(Debug, Clone, PartialEq)]
pub struct Timeline {
    first: Piece,
    later: Vec<Piece>,
}

impl Timeline {
    /// Creates the timeline of motions, which must be in order of time and must not overlap.
    #[must_use]
    pub fn of(motions: &[SurfaceMotion]) -> Self {
        let rest = |from: f64, start: Pose| Piece { from, until: f64::INFINITY, start, kind: None };
        let mut timeline = Self { first: rest(f64::NEG_INFINITY, Pose::default()), later: Vec::new() };
        for SurfaceMotion { from, until, kind } in motions.iter().copied() {
            let before = timeline.later.last_mut().unwrap_or(&mut timeline.first);
            before.until = from;
            // An oscillation or rotation with frequency 0 is a rest.
            let kind = Some(kind).filter(|kind| kind.frequency() != Some(0.0));
            let moving = Piece { from, until, start: before.at(from).pose, kind };
            timeline.later.push(moving);
            if until < f64::INFINITY {
                timeline.later.push(rest(until, moving.at(until).pose));
            }
        }
        timeline
    }

    /// Returns the piece that contains a time.
    #[must_use]
    pub fn piece_at(&self, time: f64) -> &Piece {
        let begun = self.later.partition_point(|piece| piece.from <= time);
        self.later.get(begun.wrapping_sub(1)).unwrap_or(&self.first)
    }

    /// Pose and motion of the surface at a time.
    #[must_use]
    pub fn at(&self, time: f64) -> Moment {
        self.piece_at(time).at(time)
    }

    /// Whether the surface rests forever from this time on.
    #[must_use]
    pub fn rests_from(&self, time: f64) -> bool {
        let piece = self.piece_at(time);
        piece.kind.is_none() && piece.until == f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn piston() -> Timeline {
        let kind = MotionKind::Translation { velocity: Vector::z(), acceleration: Vector::zeros() };
        let turns = MotionKind::Rotation { point: Vector::x(), axis: Vector::z() * 3.0, frequency: 0.25 };
        Timeline::of(&[
            SurfaceMotion { from: 1.0, until: 3.0, kind },
            SurfaceMotion { from: 4.0, until: 5.0, kind: turns },
        ])
    }

    #[test]
    fn a_surface_rests_between_its_motions() {
        let piston = piston();
        for (time, height, speed) in
            [(0.0, 0.0, 0.0), (1.0, 0.0, 1.0), (2.5, 1.5, 1.0), (3.0, 2.0, 0.0), (9.0, 2.0, 0.0)]
        {
            let moment = piston.at(time);
            assert_eq!(moment.pose.place(&Vector::x()), Vector::new(1.0, 0.0, height));
            assert_eq!(moment.velocity_at(&Vector::zeros()), Vector::z() * speed);
        }
        assert!(!piston.rests_from(4.9) && piston.rests_from(5.0));
    }

    #[test]
    fn rotation_starts_from_the_current_surface_position() {
        // A quarter turn about the axis through (1, 0) moves the point (3, 0) to (1, 2).
        let end = piston().at(5.0).pose;
        assert!((end.place(&Vector::new(3.0, 0.0, 0.0)) - Vector::new(1.0, 2.0, 2.0)).norm() < 1e-15);
        let place = Vector::new(0.3, -0.7, 1.1);
        assert!((end.place_of_shape(&end.place(&place)) - place).norm() < 1e-15);
    }

    #[test]
    fn velocity_and_acceleration_are_derivatives_of_position() {
        let oscillation = MotionKind::Oscillation { amplitude: Vector::new(0.1, 0.0, 0.3), frequency: 1.7, phase: 0.1 };
        let rotation = MotionKind::Rotation { point: Vector::x(), axis: Vector::new(1.0, 2.0, -0.5), frequency: -0.4 };
        for kind in [oscillation, rotation] {
            let timeline = Timeline::of(&[SurfaceMotion { from: 0.5, until: f64::INFINITY, kind }]);
            let (place, time, step) = (Vector::new(0.2, -0.4, 1.3), 2.3, 1e-4);
            let (position, velocity) = (|t: f64| place + Vector::new(0.3, 0.2, -0.1) * t, Vector::new(0.3, 0.2, -0.1));
            let seen = |t: f64| timeline.at(time + t).pose.place_of_shape(&position(t));
            let moment = timeline.at(time);
            let rate = (seen(step) - seen(-step)) / (2.0 * step);
            assert!((moment.seen(&position(0.0), &velocity).1 - rate).norm() < 1e-6);
            let second = (seen(step) + seen(-step) - seen(0.0) * 2.0) / (step * step);
            let acceleration = moment.acceleration_seen(&position(0.0), &velocity, &Vector::zeros());
            assert!((acceleration - second).norm() < 1e-5, "{acceleration} {second}");
        }
    }
}
