//! Restitution of pair contacts: constant, or by the TC model.

use super::Encounter;
use crate::engine::pairs::rules::Discontinuity;
use crate::engine::parts::Engine;
use crate::physics::response::{Leaving, Response, respond, tc_contact};

/// Relative to the speeds of two particles, what the velocities of both leave uncertain of their difference: two roundings
/// of each, of the last event and the one before.
const LOST: f64 = 2.0 * f64::EPSILON;

/// How particles come to a contact, for the TC model.
#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Arrival {
    /// Normal speed of approach `[length / time]`.
    pub speed: f64,
    /// Tangential speed `[length / time]`.
    pub tangential: f64,
    /// Normal acceleration towards each other, which brings the two together again `[length / time^2]`.
    pub closing: f64,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// The radial motion after the event, and the factor of the tangential motion.
    #[inline]
    pub(super) fn leave(
        &mut self,
        pair: &Encounter,
        seen: &Discontinuity,
        restitution: f64,
        time: f64,
    ) -> (Response, f64) {
        let Encounter { i, j, side, ref line, ref velocity, ref approach, .. } = *pair;
        let mut response = respond(side, seen.energy_step, approach, restitution);
        if seen.energy_step != f64::INFINITY {
            return (response, 1.0);
        }
        if self.pairs.contact_times.is_none() {
            if restitution < 1.0 {
                self.note_lost_speed(pair, restitution);
            }
            return (response, 1.0);
        }
        let length = approach.squared.sqrt();
        let vn = approach.radial / length;
        let acceleration = (self.acceleration(i) - self.acceleration(j)).dot(line) / length;
        let tangential = (velocity.norm_squared() - vn * vn).max(0.0);
        let closing = -side.sign() * (acceleration + tangential * pair.stretch / length);
        let arriving = (-side.sign() * vn).max(0.0);
        // A static particle has no contact of its own, as a wall has none: it would make the contacts of all its partners elastic.
        let moving: &[u32] = match (self.is_static(i), self.is_static(j)) {
            (true, _) => &[j],
            (_, true) => &[i],
            _ => &[i, j],
        };
        let leaving = self.tc_model(
            moving,
            restitution,
            Arrival { speed: arriving, tangential: tangential.sqrt(), closing },
            time,
        );
        // What the model leaves as it is, or makes elastic, goes without the rounding of a square root.
        if leaving.speed == arriving {
            response = respond(side, seen.energy_step, approach, 1.0);
        } else if leaving.speed != restitution * arriving {
            response.radial = side.sign() * leaving.speed * length;
        }
        (response, leaving.tangential_scale)
    }

    /// Takes note of an inelastic contact whose speed is lost in the rounding of the velocities.
    ///
    /// Each contact of a collapse leaves a fraction of the speed before. In exact numbers that goes on for ever, in a
    /// finite time; in rounded ones until the speeds have no digits left. Chance makes a contact that slow with a
    /// probability of the square of [`LOST`].
    #[inline]
    fn note_lost_speed(&mut self, pair: &Encounter, restitution: f64) {
        let approach = -pair.side.sign() * pair.approach.radial;
        let leaving = if restitution > 0.0 { restitution * approach } else { approach };
        let (a, b) = (&self.state.bodies[pair.i as usize].velocity, &self.state.bodies[pair.j as usize].velocity);
        let resolved = LOST * (a.amax() + b.amax());
        if approach > 0.0 && leaving * leaving < resolved * resolved * pair.approach.squared {
            self.clock.standstill.lost_speed = Some(approach / pair.approach.squared.sqrt());
        }
    }

    /// A contact under the TC model, and its entry in the model's memory.
    pub(in crate::engine) fn tc_model(
        &mut self,
        particles: &[u32],
        restitution: f64,
        arrival: Arrival,
        time: f64,
    ) -> Leaving {
        let Arrival { speed: approach, tangential, closing } = arrival;
        let Some(times) = &mut self.pairs.contact_times else {
            return Leaving { speed: restitution * approach, tangential_scale: 1.0 };
        };
        let is_recent = times.note(particles, time);
        let leaving = tc_contact(restitution, is_recent, approach, tangential, closing, times.contact_time);
        self.counts.totals.tc_contacts += 1;
        self.counts.totals.tc_altered +=
            u64::from(leaving.speed != restitution * approach || leaving.tangential_scale != 1.0);
        leaving
    }
}
