//! Contact laws: the velocities after a contact, computed from the frame of the contact.

use super::frame::{Frame, opening};
use crate::Vector;
use crate::engine::pairs::rules::Discontinuity;
use crate::engine::parts::Engine;
use crate::physics::overlap::Side;
use crate::physics::response::{Arrival, ContactLaw, Leaving, Response, respond, tc_contact};

/// Uncertainty of a relative velocity, divided by the sum of the two speeds.
const LOST: f64 = 2.0 * f64::EPSILON;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the outcome of a pair event, and the relative motion of the pair after the event.
    #[inline]
    pub(in crate::engine) fn response_to(
        &mut self,
        pair: &Frame,
        seen: &Discontinuity,
        law: &ContactLaw,
        time: f64,
    ) -> Response {
        let Frame { i, j, side, ref line, ref velocity, ref approach, .. } = *pair;
        let mut response = respond(side, seen.energy_step, approach, law);
        if seen.energy_step != f64::INFINITY {
            return response;
        }
        if self.pairs.contact_times.is_none() {
            if law.dissipates() {
                self.note_lost_speed(pair, law);
            }
            return response;
        }
        let length = approach.squared.sqrt();
        let vn = approach.radial / length;
        let acceleration = (self.acceleration(i) - self.acceleration(j)).dot(line) / length;
        let tangential = (velocity.norm_squared() - vn * vn).max(0.0);
        let closing_at_rest = -side.sign() * acceleration;
        let closing = -side.sign() * (acceleration + tangential * pair.stretch / length);
        let arriving = (-side.sign() * vn).max(0.0);
        // The TC model keeps no contact times of static particles and walls. Many particles collide with them, so all
        // of these contacts would become elastic.
        let moving: &[u32] = match (self.is_static(i), self.is_static(j)) {
            (true, _) => &[j],
            (_, true) => &[i],
            _ => &[i, j],
        };
        let restitution = law.restitution.at(arriving, approach.reduced_mass);
        let arrival =
            Arrival { approach: arriving, restitution, tangential: tangential.sqrt(), closing, closing_at_rest };
        let Some(leaving) = self.tc_model(moving, law, arrival, time) else { return response };
        // Elastic contacts, and contacts that the TC model does not alter, avoid the round-off of a square root.
        if leaving.speed == arriving {
            response = respond(side, seen.energy_step, approach, &ContactLaw::smooth(1.0));
        } else if leaving.speed != restitution * arriving {
            response.radial = side.sign() * leaving.speed * length;
        }
        let Leaving { tangential_scale, is_lifted, rattle, .. } = leaving;
        let roughness = leaving.roughness.filter(|_| side == Side::Positive);
        Response { tangential_scale, roughness, is_lifted, rattle, ..response }
    }

    /// Returns the normal speed after a reflection from a surface, and the factor of the tangential velocity.
    /// `velocity` is the relative velocity before the contact. `vn` is its component along the normal, which points
    /// away from the surface. `closing` is the acceleration towards the surface, and `closing_at_rest` the same without
    /// the centrifugal force.
    #[inline]
    pub(in crate::engine) fn leave_surface(
        &mut self,
        i: u32,
        (velocity, vn): (&Vector, f64),
        [closing, closing_at_rest]: [f64; 2],
        law: &ContactLaw,
        time: f64,
    ) -> Leaving {
        let tangential = (velocity.norm_squared() - vn * vn).max(0.0).sqrt();
        let arriving = (-vn).max(0.0);
        let restitution = law.restitution.at(arriving, self.inverse_mass(i).recip());
        let arrival = Arrival { approach: arriving, restitution, tangential, closing, closing_at_rest };
        let Some(leaving) = self.tc_model(&[i], law, arrival, time) else {
            let speed = if vn < 0.0 { -restitution * vn } else { vn };
            return Leaving { roughness: law.roughness, ..Leaving::smoothly(speed) };
        };
        // An elastic contact keeps the normal speed, even if the particle recedes because of round-off.
        Leaving { speed: if leaving.speed == arriving { vn.abs() } else { leaving.speed }, ..leaving }
    }

    /// Returns the velocities of a pair after a contact. The relative velocity changes by `change` times the line of
    /// centres. The tangential part is multiplied by `tangential_scale`.
    #[inline]
    pub(in crate::engine) fn reflected(
        &self,
        pair: &Frame,
        before: &[Vector; 2],
        change: f64,
        tangential_scale: f64,
        is_barrier: bool,
    ) -> [Vector; 2] {
        let Frame { ref line, ref velocity, ref approach, .. } = *pair;
        let mut after = *before;
        pair.change_relative_velocity(&(line * change), &mut after);
        if tangential_scale != 1.0 {
            let tangential = velocity - line * (approach.radial / approach.squared);
            pair.change_relative_velocity(&(tangential * (tangential_scale - 1.0)), &mut after);
        }
        if is_barrier {
            self.separate(pair, &mut after);
        }
        after
    }

    /// Records an inelastic contact whose speed is lost in the round-off of the velocities.
    ///
    /// In an inelastic collapse, each contact keeps only a fraction of the speed. In exact arithmetic, infinitely many
    /// contacts follow within a finite time. In floating-point numbers, the series ends when the relative speed falls
    /// below the round-off of the velocities. The probability that an ordinary contact is that slow is only [`LOST`]
    /// squared.
    #[inline]
    fn note_lost_speed(&mut self, pair: &Frame, law: &ContactLaw) {
        let approach = -pair.side.sign() * pair.approach.radial;
        let speed = approach / pair.approach.squared.sqrt();
        let restitution = law.restitution.at(speed, pair.approach.reduced_mass);
        let leaving = if restitution > 0.0 { restitution * approach } else { approach };
        let (a, b) = (&self.state.bodies[pair.i as usize].velocity, &self.state.bodies[pair.j as usize].velocity);
        let resolved = LOST * (a.amax() + b.amax());
        if approach > 0.0 && leaving * leaving < resolved * resolved * pair.approach.squared {
            self.clock.standstill.lost_speed = Some(speed);
        }
    }

    /// Returns `None` if the scene does not use the TC model.
    fn tc_model(&mut self, particles: &[u32], law: &ContactLaw, arrival: Arrival, time: f64) -> Option<Leaving> {
        let times = self.pairs.contact_times.as_mut()?;
        let since = times.note(particles, time);
        let leaving = tc_contact(times.rule, law, since, &arrival, times.contact_time);
        let is_recent = since < times.contact_time;
        let is_altered = leaving.speed != arrival.restitution * arrival.approach
            || leaving.roughness != law.roughness
            || leaving.tangential_scale != 1.0;
        let kept = is_altered && !(is_recent || leaving.is_sliding || leaving.is_lifted);
        let totals = &mut self.counts.totals;
        totals.tc_contacts += 1;
        totals.tc_altered += u64::from(is_altered);
        totals.tc_kept += u64::from(kept);
        totals.tc_slid += u64::from(is_altered && leaving.is_sliding);
        totals.tc_lifted += u64::from(leaving.is_lifted);
        Some(leaving)
    }

    /// Makes sure that a reflected pair moves away from the discontinuity, in spite of rounding.
    ///
    /// Rounding can undo a small velocity change, and the event would then repeat forever. Therefore, a tiny velocity
    /// is added, and doubled until the pair moves away. A pair in contact at its core may stay at relative rest. A pair
    /// at the maximum length of its bond must move inwards.
    #[inline(always)]
    pub(super) fn separate(&self, pair: &Frame, velocities: &mut [Vector; 2]) {
        let &Frame { i, j, side, ref apart, ref line, opening_speed, ref approach, .. } = pair;
        let opening = opening(opening_speed, apart.norm_squared());
        let is_closing = |velocities: &[Vector; 2]| {
            let velocity = self.relative_velocity([i, j], velocities);
            match side {
                Side::Positive => velocity.dot(apart) < opening,
                Side::Negative => velocity.dot(apart) >= opening,
            }
        };
        if !is_closing(velocities) {
            return;
        }
        let speed = velocities[0].amax().max(velocities[1].amax());
        let mut change = side.sign() * f64::EPSILON * speed;
        let normal = line / approach.squared.sqrt();
        // After 52 doublings, the change is as large as the speed.
        for _ in 0..52 {
            pair.change_relative_velocity(&(normal * change), velocities);
            if !is_closing(velocities) {
                return;
            }
            change *= 2.0;
        }
    }

    /// Returns the relative velocity of the images in contact. Across a sliding side, the velocity of an image differs
    /// from the velocity of its particle.
    #[inline]
    fn relative_velocity(&self, [i, j]: [u32; 2], velocities: &[Vector; 2]) -> Vector {
        let velocity = velocities[0] - velocities[1];
        if !self.images.are_sliding() {
            return velocity;
        }
        let [a, b] = [i, j].map(|particle| &self.state.bodies[particle as usize]);
        self.nearest(a.position - b.position, velocity, a.time).0.velocity
    }
}
