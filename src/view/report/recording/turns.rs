//! Orientations of rotating particles, which the player shows by a mark on each particle.
//!
//! A trajectory contains the spins of the particles, but not their orientations. All particles start with the same
//! orientation. Between two frames, each particle turns with the mean of its two spins. The result is approximate: a
//! particle that turns by more than half a turn between two frames appears to turn more slowly or backwards.

use nalgebra::UnitQuaternion;

use crate::Vector;
use crate::base::numbers::trunc_to_i8;
use crate::trajectory::Frame;

/// Number of bytes of an orientation.
pub(super) const BYTES: usize = 4;

/// Returns the spins of the moving particles; `None` if the frame has no spins.
pub(super) fn spins(frame: &Frame) -> Option<Vec<Vector>> {
    let all = frame.particles.iter().zip(frame.spins()?);
    Some(all.filter(|(particle, _)| !frame.is_static(particle)).map(|(_, spin)| spin).collect())
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Turns {
    time: f64,
    spins: Vec<Vector>,
    orientations: Vec<UnitQuaternion<f64>>,
}

impl Turns {
    /// Starts with a frame; `None` if it has no spins.
    pub fn of(frame: &Frame) -> Option<Self> {
        let spins = spins(frame)?;
        Some(Self { time: frame.time, orientations: vec![UnitQuaternion::identity(); spins.len()], spins })
    }

    /// Turns the particles up to a later frame. A frame without spins changes nothing.
    pub fn advance(&mut self, frame: &Frame) {
        let Some(spins) = spins(frame) else { return };
        let half = 0.5 * (frame.time - self.time);
        for ((orientation, before), after) in self.orientations.iter_mut().zip(&self.spins).zip(&spins) {
            let turned = UnitQuaternion::from_scaled_axis((before + after) * half) * *orientation;
            // Spins that are too large for floating-point numbers are left out.
            if turned.coords.iter().all(|part| part.is_finite()) {
                *orientation = UnitQuaternion::new_normalize(turned.into_inner());
            }
        }
        (self.time, self.spins) = (frame.time, spins);
    }

    /// Appends the components x, y, z and w of each quaternion, in 1/127.
    pub fn encode(&self, bytes: &mut Vec<u8>) {
        let components = self.orientations.iter().flat_map(|orientation| orientation.coords.iter());
        bytes.extend(components.map(|part| trunc_to_i8((part * 127.0).round()).to_le_bytes()[0]));
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_1_SQRT_2, PI};

    use super::super::tests::frame;
    use super::*;
    use crate::analysis::instruments::Scalar;
    use crate::trajectory::frame::SPINS;

    fn spinning(time: f64, spin: [f64; 3]) -> Frame {
        let mut frame = frame(time, 2);
        // The second grain does not turn, and the pivot is static.
        frame.scalars = (0..3).map(|axis| Scalar::new(SPINS[axis], vec![spin[axis], 0.0, 7.0])).collect();
        frame
    }

    fn bytes(turns: &Turns) -> Vec<i8> {
        let mut bytes = Vec::new();
        turns.encode(&mut bytes);
        bytes.into_iter().map(|byte| i8::from_le_bytes([byte])).collect()
    }

    #[test]
    fn particles_turn_with_the_mean_spin_of_two_frames() {
        let mut turns = Turns::of(&spinning(1.0, [0.0, 0.0, 0.0])).unwrap();
        assert_eq!(bytes(&turns), [0, 0, 0, 127, 0, 0, 0, 127]);
        // A quarter turn about z, then half a turn about x, in the frame of the laboratory.
        turns.advance(&spinning(3.0, [0.0, 0.0, 0.5 * PI]));
        let quarter = trunc_to_i8((127.0 * FRAC_1_SQRT_2).round());
        assert_eq!(bytes(&turns), [0, 0, quarter, quarter, 0, 0, 0, 127]);
        turns.spins[0] = Vector::new(PI, 0.0, 0.0);
        turns.advance(&spinning(4.0, [PI, 0.0, 0.0]));
        assert_eq!(bytes(&turns), [quarter, -quarter, 0, 0, 0, 0, 0, 127]);
        turns.advance(&spinning(5.0, [1e308, 1e308, 0.0]));
        assert_eq!(bytes(&turns)[..4], [quarter, -quarter, 0, 0]);
    }

    #[test]
    fn frames_without_spins_have_no_orientations() {
        assert_eq!(Turns::of(&frame(0.0, 2)), None);
        let mut incomplete = spinning(0.0, [1.0; 3]);
        incomplete.scalars.pop();
        assert_eq!(spins(&incomplete), None);
    }
}
