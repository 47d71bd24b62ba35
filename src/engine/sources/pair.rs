//! Execution of contacts between two particles.

use crate::Vector;
use crate::engine::contact::apply::{Change, With};
use crate::engine::contact::frame::Frame;
use crate::engine::event::CountedKind;
use crate::engine::observe::Observe;
use crate::engine::pairs::rules::Discontinuity;
use crate::engine::parts::Engine;
use crate::engine::{Invariant, InvariantBroken};
use crate::model::ParticleId;
use crate::physics::overlap::Side;
use crate::physics::response::{Approach, ContactLaw, Outcome, Rattle, Response};
use crate::physics::rough::Roughness;
use std::ops::ControlFlow;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline(always)]
    pub(in crate::engine) fn stream(&mut self, particle: u32, time: f64) {
        let (position, velocity) = self.state_at(particle, time);
        let body = &mut self.state.bodies[particle as usize];
        (body.position, body.velocity, body.time) = (position, velocity, time);
    }

    /// Inlined to keep the velocity change in registers.
    #[inline(always)]
    pub(in crate::engine) fn execute_pair(
        &mut self,
        [i, j]: [u32; 2],
        side: Side,
        time: f64,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let mut flown = [i, j].map(|particle| time - self.state.bodies[particle as usize].time);
        self.stream(i, time);
        if self.is_static(j) {
            // A static particle never moves. Contacts do not write its state, because several threads may read it.
            flown[1] = flown[0];
        } else {
            self.stream(j, time);
        }
        let mut woken = ControlFlow::Continue(());
        if TABLE && self.sources.sleepers.is_some() && self.is_asleep(j) {
            woken = self.wake_if_hit(j, i, observe);
        }
        let (state, interaction) = self.pair_state(i, j);
        let Some((seen, law, opening_speed)) = self.discontinuity([i, j], (state, interaction), side, time) else {
            return Err(self.broken(i, Some(j), Invariant::Discontinuity));
        };
        let pair = self.frame(i, j, side, opening_speed);
        self.note_state(&pair, &seen, flown);
        let (outcome, change, roughness) = self.respond(&pair, &seen, &law, time);
        self.set_state_after(i, j, outcome, state, interaction)?;
        let flow = match roughness {
            None => self.apply(&change, observe),
            Some(rough) => self.apply_to_rough_pair(change, pair, rough, observe),
        };
        Ok(if woken.is_break() { woken } else { flow })
    }

    /// Returns the outcome and the smooth part of the change. For a rough contact, also returns the roughness, and the
    /// rule by which energy lost to friction returns to the normal motion.
    #[inline(always)]
    fn respond(
        &mut self,
        pair: &Frame,
        seen: &Discontinuity,
        law: &ContactLaw,
        time: f64,
    ) -> (Outcome, Change, Option<(Roughness, Rattle)>) {
        // In a multicanonical simulation, weights replace the energy step of the potential.
        let felt = self.weighted(seen);
        let Response { outcome, radial: leaving, tangential_scale, roughness, is_lifted, rattle } =
            self.response_to(pair, &felt, law, time);
        let Approach { radial, squared, reduced_mass } = pair.approach;
        // The relative velocity changes by `change` times the vector between the centres.
        let change = (leaving - radial) / squared;
        let impulse = reduced_mass * change;
        let is_barrier = seen.energy_step == f64::INFINITY || outcome == Outcome::Bounce;
        let before = [pair.i, pair.j].map(|particle| self.state.bodies[particle as usize].velocity);
        let after = self.reflected(pair, &before, change, tangential_scale, is_barrier);
        let (counted, energy_step) = match outcome {
            Outcome::Core => (CountedKind::Core, 0.0),
            Outcome::Capture => (CountedKind::Capture, seen.energy_step),
            Outcome::Release => (CountedKind::Release, seen.energy_step),
            Outcome::Bounce if seen.energy_step == f64::INFINITY => (CountedKind::Bond, 0.0),
            Outcome::Bounce => (CountedKind::Bounce, 0.0),
        };
        let is_crossed = matches!(outcome, Outcome::Capture | Outcome::Release);
        let by_weights = if is_crossed { self.pay(seen.energy_step, felt.energy_step) } else { 0.0 };
        let mut impulse_of_i = pair.line * impulse;
        if tangential_scale != 1.0 {
            impulse_of_i = (after[0] - before[0]) / pair.inverse_masses[0];
        }
        let change = Change {
            counted: Some(counted),
            particle: pair.i,
            other: With::Particle(pair.j),
            impulse: impulse_of_i,
            torques: [Vector::zeros(); 2],
            line: pair.line,
            squared,
            distance: seen.distance,
            virial: reduced_mass * (leaving - radial) / pair.stretch,
            energy_step,
            dissipated: if is_crossed || tangential_scale != 1.0 { 0.0 } else { -0.5 * impulse * (radial + leaving) },
            is_lifted,
            supplied: self.supplied(pair, &before, &after[0], impulse) + by_weights,
            after,
        };
        (outcome, change, roughness.map(|roughness| (roughness, rattle)))
    }

    /// Energy that sliding images and growing diameters supply in a contact.
    #[inline(always)]
    pub(in crate::engine) fn supplied(&self, pair: &Frame, before: &[Vector; 2], after: &Vector, impulse: f64) -> f64 {
        let mut supplied = 0.0;
        if self.images.are_sliding() {
            // The contact conserves energy between the first particle and the image of the second particle. The image
            // and the second particle have different velocities.
            let faster = (before[0] - before[1]) - pair.velocity;
            supplied = faster.dot(&((after - before[0]) / pair.inverse_masses[0]));
        }
        if pair.opening_speed != 0.0 {
            supplied += impulse * pair.opening_speed * pair.approach.squared.sqrt();
        }
        supplied
    }

    #[inline]
    fn set_state_after(
        &mut self,
        i: u32,
        j: u32,
        outcome: Outcome,
        state: u16,
        interaction: u16,
    ) -> Result<(), InvariantBroken> {
        if TABLE {
            match outcome {
                Outcome::Capture => self.set_pair_state(i, j, state + 1, interaction),
                Outcome::Release if state > 1 => self.set_pair_state(i, j, state - 1, interaction),
                Outcome::Release => self.release(i, j, interaction)?,
                Outcome::Core | Outcome::Bounce => {}
            }
        }
        Ok(())
    }

    pub(in crate::engine) fn state_of_pair(&self, a: ParticleId, b: ParticleId) -> u16 {
        self.pair_state(self.number(a), self.number(b)).0
    }

    /// Returns the state of a pair and the index of its interaction. An uncaptured pair has state 0.
    #[inline]
    pub(in crate::engine) fn pair_state(&self, i: u32, j: u32) -> (u16, u16) {
        if !TABLE {
            return (0, 0);
        }
        let (keeper, other) = if self.is_static(i) { (j, i) } else { (i, j) };
        self.pairs.states.get(keeper, other).map_or_else(
            || (0, self.pairs.rules.meeting(self.row(i), self.row(j)).interaction),
            |captured| (captured.state, captured.interaction),
        )
    }

    /// Returns the inner discontinuity of a pair if `side` is positive, otherwise the outer discontinuity. Also returns
    /// the contact law, and the speed at which the discontinuity moves outwards.
    #[inline]
    fn discontinuity(
        &self,
        pair: [u32; 2],
        (state, interaction): (u16, u16),
        side: Side,
        time: f64,
    ) -> Option<(Discontinuity, ContactLaw, f64)> {
        let interaction = if TABLE { interaction } else { self.pairs.rules.meeting(0, 0).interaction };
        let steps = &self.pairs.rules.steps[usize::from(interaction)];
        let mut seen = steps.seen_from(state, side)?;
        let [distance, opening_speed] = self.distances.at(self.distance_of_pair(seen.distance, pair), time);
        if self.has_sizes() || !self.distances.are_constant() {
            (seen.distance, seen.squared) = (distance, distance * distance);
        }
        Some((seen, steps.law, opening_speed))
    }

    /// Sets the state of a pair to 0. Only a pair with its own interaction, such as a bond, remains stored.
    fn release(&mut self, i: u32, j: u32, interaction: u16) -> Result<(), InvariantBroken> {
        let meeting = self.pairs.rules.meeting(self.row(i), self.row(j));
        if meeting.exists && meeting.interaction == interaction {
            return self.remove_pair_state(i, j);
        }
        self.set_pair_state(i, j, 0, interaction);
        Ok(())
    }
}
