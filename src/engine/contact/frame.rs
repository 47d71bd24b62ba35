//! The frame of a pair contact: the line of centres and the relative motion.

use crate::Vector;
use crate::engine::audit::{Meeting, is_surely_round_off};
use crate::engine::pairs::rules::Discontinuity;
use crate::engine::parts::Engine;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::Side;
use crate::physics::response::Approach;

#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Frame {
    pub i: u32,
    pub j: u32,
    pub side: Side,
    /// `r_ij`.
    pub apart: Vector,
    /// `r_ij` times `stretch`. If `r_ij` is zero, a unit vector opposite to the relative velocity.
    pub line: Vector,
    /// Factor of `r_ij`, see [`stretch`].
    pub stretch: f64,
    /// `v_ij`.
    pub velocity: Vector,
    /// Speed at which the discontinuity moves outwards `[length / time]`.
    pub opening_speed: f64,
    /// Inverse masses of the two particles; 0 for a static particle.
    pub inverse_masses: [f64; 2],
    /// Approach along `line`.
    pub approach: Approach,
}

/// Returns a factor for the line of centres, which keeps the squared length away from powers of two.
///
/// The contact law divides by this squared length. For spheres of diameter 1, `|r|^2` at contact differs from 1 by a
/// few floats. A division by `1 + k eps` rounds up more often than down, with a mean bias of a twentieth of a rounding
/// error per event, which heats a fluid. A division by `9/16 |r|^2` has no such bias, and head-on collisions with
/// simple numbers remain exact. If `9/16 |r|^2` is close to a power of two, as for the diameter 4/3, the line keeps its
/// length.
#[inline]
pub(in crate::engine) fn stretch(squared: f64) -> f64 {
    // The mantissa of `9/16 |r|^2`, plus a constant. Near a power of two, the sum is small, because it wraps around.
    let digits = (0.5625 * squared).to_bits().wrapping_add(NEAR_POWER_OF_TWO) & DIGITS;
    if digits < 2 * NEAR_POWER_OF_TWO { 1.0 } else { 0.75 }
}

const DIGITS: u64 = (1 << (f64::MANTISSA_DIGITS - 1)) - 1;

/// A number is close to a power of two if fewer floats than this lie between them. At a contact, round-off changes the
/// distance of a pair by at most a few tens of floats.
const NEAR_POWER_OF_TWO: u64 = 1 << 16;

impl Frame {
    /// Adds `change` to the relative velocity `v_i - v_j`, at constant total momentum.
    ///
    /// The heavier particle gets the share `w / (w_i + w_j)`, where `w` is its inverse mass. The lighter particle gets
    /// the remainder. If both shares were rounded, their sum would have the same error in every event, as if the
    /// restitution were `1 +- eps`.
    #[inline(always)]
    pub fn change_relative_velocity(&self, change: &Vector, velocities: &mut [Vector; 2]) {
        let [wi, wj] = self.inverse_masses;
        let less = change * (wi.min(wj) / (wi + wj));
        let more = change - less;
        let (of_i, of_j) = if wi < wj { (less, more) } else { (more, less) };
        velocities[0] += of_i;
        velocities[1] -= of_j;
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Both particles must have been streamed to the same time, unless they are static.
    #[inline]
    pub(in crate::engine) fn frame(&self, i: u32, j: u32, side: Side, opening_speed: f64) -> Frame {
        let (a, b) = (&self.state.bodies[i as usize], &self.state.bodies[j as usize]);
        let (state, _) = self.nearest(a.position - b.position, a.velocity - b.velocity, a.time);
        let RelativeState { position: apart, velocity } = state;
        let stretch = stretch(apart.norm_squared());
        let mut line = apart * stretch;
        if line.norm_squared() < f64::MIN_POSITIVE {
            line = any_normal(&velocity) * stretch;
        }
        let inverse_masses = [i, j].map(|particle| self.inverse_mass(particle));
        let reduced_mass = 1.0 / (inverse_masses[0] + inverse_masses[1]);
        let squared = line.norm_squared();
        let radial = velocity.dot(&line) - opening(opening_speed, squared);
        let approach = Approach { radial, squared, reduced_mass };
        Frame { i, j, side, apart, line, stretch, velocity, opening_speed, inverse_masses, approach }
    }

    /// Records an overlap or a turning point. `flown` holds the times since the two states were written.
    #[inline]
    pub(in crate::engine) fn note_state(&mut self, pair: &Frame, seen: &Discontinuity, flown: [f64; 2]) {
        let sign = pair.side.sign();
        let squared = pair.apart.norm_squared();
        if (squared - seen.squared) * sign < 0.0 {
            let depth = sign * (seen.distance - squared.sqrt());
            self.counts.totals.deepest_overlap = self.counts.totals.deepest_overlap.max(depth / seen.distance);
            if !is_surely_round_off(depth, seen.distance) {
                let &Frame { i, j, velocity, opening_speed, .. } = pair;
                let meeting = Meeting { pair: [i, j], velocity, flown, distance: seen.distance, opening_speed };
                self.note_overlap(depth, seen.distance, self.round_off_of_pair(&meeting));
            }
        }
        if (pair.velocity.dot(&pair.apart) - opening(pair.opening_speed, squared)) * sign >= 0.0 {
            self.counts.totals.turning_point += 1;
        }
    }
}

/// Returns `|r| u` for a discontinuity that moves outwards at the speed `u`. `squared` is `|r|^2`.
#[inline]
pub(super) fn opening(speed: f64, squared: f64) -> f64 {
    if speed == 0.0 { 0.0 } else { speed * squared.sqrt() }
}

/// Returns a unit vector opposite to the relative velocity, which replaces `r_ij` if `r_ij` is zero.
fn any_normal(velocity: &Vector) -> Vector {
    velocity.try_normalize(0.0).map_or(Vector::x(), |direction| -direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scaled_squared_length_is_never_near_a_power_of_two() {
        for diameter in [1.0, 4.0 / 3.0, 2.0 / 3.0, 8.0 / 3.0, 0.7, 1e-3, 1e9, 1.5, std::f64::consts::SQRT_2] {
            let contact: f64 = diameter * diameter;
            for ulps in -40..=40_i64 {
                let squared = f64::from_bits(contact.to_bits().wrapping_add_signed(ulps));
                let stretch = stretch(squared);
                let digits = (stretch * stretch * squared).to_bits() & DIGITS;
                assert!(digits > 1000 && digits < DIGITS - 1000, "{diameter} {ulps}");
            }
        }
        assert_eq!((stretch(1.0), stretch((4.0_f64 / 3.0).powi(2))), (0.75, 1.0));
    }
}
