//! Rough contacts: adds the tangential impulse to the change of velocities in a smooth contact, and applies the sum.
//!
//! These functions take their arguments by value and return no velocities, so the code for smooth contacts can keep all
//! numbers in registers.

use super::apply::Change;
use super::frame::Frame;
use crate::Vector;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::sources::surface::Touching;
use crate::engine::surfaces::Surface;
use crate::physics::response::Rattle;
use crate::physics::rough::{Roughness, Touch};
use std::ops::ControlFlow;

/// Push of a rough surface.
#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Push {
    pub roughness: Roughness,
    /// Normal impulse `[mass length / time]`.
    pub impulse: f64,
    /// Normal speed after the contact, without the energy lost to friction `[length / time]`.
    pub speed: f64,
    /// Rule by which this energy returns to the normal motion.
    pub rattle: Rattle,
}

/// Energy needed to increase a normal speed by `gain`, divided by the reduced mass.
fn recovered(speed: f64, gain: f64) -> f64 {
    gain * (speed + 0.5 * gain)
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Adds the tangential impulse between two particles.
    ///
    /// The point of contact divides the contact distance in the ratio of the diameters. This conserves the angular
    /// momentum even if the diameters are non-additive.
    #[cold]
    #[inline(never)]
    pub(in crate::engine) fn apply_to_rough_pair(
        &mut self,
        change: Change,
        pair: Frame,
        (roughness, rattle): (Roughness, Rattle),
        observe: &mut Observe<'_>,
    ) -> ControlFlow<()> {
        let both = [pair.i, pair.j];
        let [a, b] = both.map(|particle| self.radius(particle));
        let share = a / (a + b);
        let length = change.squared.sqrt();
        let touch = Touch {
            normal: pair.line / length,
            velocity: pair.velocity,
            spins: both.map(|particle| self.spin(particle)),
            arms: [share * change.distance, (1.0 - share) * change.distance],
            inverse_inertias: both.map(|particle| self.inverse_inertia(particle)),
            inverse_mass: 1.0 / pair.approach.reduced_mass,
        };
        let normal_impulse = change.impulse.dot(&touch.normal);
        let grip = touch.grip(&roughness, normal_impulse);
        let speed = normal_impulse * touch.inverse_mass + pair.approach.radial / length;
        let gain = rattle.gain(speed, touch.slip().norm(), grip.dissipated * touch.inverse_mass);
        self.counts.totals.tc_returned += u64::from(gain > 0.0);
        let more = gain / touch.inverse_mass;
        let impulse = if gain > 0.0 { grip.impulse + touch.normal * more } else { grip.impulse };
        let mut after = change.after;
        pair.change_relative_velocity(&(impulse * touch.inverse_mass), &mut after);
        self.separate(&pair, &mut after);
        let before = both.map(|particle| self.state.bodies[particle as usize].velocity);
        let change = Change {
            after,
            impulse: change.impulse + impulse,
            torques: grip.torques,
            virial: change.virial + more * length / pair.stretch,
            dissipated: change.dissipated + grip.dissipated - recovered(speed, gain) / touch.inverse_mass,
            supplied: self.supplied(&pair, &before, &after[0], (normal_impulse + more) / length),
            ..change
        };
        self.apply(&change, observe)
    }

    /// Adds the tangential impulse of a surface, which is computed in the frame of the surface.
    #[cold]
    #[inline(never)]
    pub(in crate::engine) fn apply_at_rough_surface(
        &mut self,
        change: Change,
        at: Touching,
        push: Push,
        observe: &mut Observe<'_>,
    ) -> ControlFlow<()> {
        let (i, inverse_mass) = (change.particle, self.inverse_mass(change.particle));
        let touch = Touch {
            normal: at.shape.normal(&at.position),
            velocity: at.material.map_or(at.velocity, |material| at.velocity - material),
            spins: [at.spin_seen(&self.spin(i)), Vector::zeros()],
            arms: [self.radius(i), 0.0],
            inverse_inertias: [self.inverse_inertia(i), 0.0],
            inverse_mass,
        };
        let grip = touch.grip(&push.roughness, push.impulse);
        let rattle = if at.does_no_work() { push.rattle } else { push.rattle.at_moving_surface(push.speed) };
        let gain = rattle.gain(push.speed, touch.slip().norm(), grip.dissipated * inverse_mass);
        self.counts.totals.tc_returned += u64::from(gain > 0.0);
        let torque = at.in_space(&grip.torques[0]);
        let turning = torque.dot(&(self.spin(i) + torque * (0.5 * self.inverse_inertia(i))));
        let after = change.after[0] + at.in_space(&grip.impulse) * inverse_mass;
        let after = at.away(if gain > 0.0 { after + at.in_space(&(touch.normal * gain)) } else { after });
        let Change { after, impulse, supplied: gained, .. } =
            Change::of_one(change.other, i, &self.state.bodies[i as usize].velocity, after, inverse_mass);
        let dissipated = change.dissipated + grip.dissipated - recovered(push.speed, gain) / inverse_mass;
        let supplied = if at.does_no_work() { 0.0 } else { gained + turning + dissipated };
        let torques = [torque, Vector::zeros()];
        self.apply(&Change { after, impulse, torques, supplied, dissipated, ..change }, observe)
    }

    /// Returns the spin of a particle; zero if the scene has no spins.
    #[inline]
    pub(in crate::engine) fn spin(&self, particle: u32) -> Vector {
        self.state.spins.get(particle as usize).copied().unwrap_or_default()
    }
}
