//! Execution: a predicted contact becomes an event.

use super::engine::Engine;
use crate::Vector;
use crate::event::{Event, EventKind};
use crate::interaction::rules::Discontinuity;
use crate::neighbours::cells::Face;
use crate::overlap::Side;
use crate::response::{Leaving, Outcome, respond, tc_contact};
use crate::scene::ParticleId;
use crate::space::minimum_image;

/// Positions carry the rounding of the coordinates, and of the time that they were streamed to, some times over: each of the
/// six coordinates of a pair in one streaming, one event time and one wrap, all below two units in the last place.
const ROUNDINGS: f64 = 32.0;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Moves a particle along its free flight to `time`.
    #[inline]
    fn stream(&mut self, particle: u32, time: f64) {
        let (position, velocity) = self.state_at(particle, time);
        let body = &mut self.bodies[particle as usize];
        (body.position, body.velocity, body.time) = (position, velocity, time);
    }

    /// A pair reaches a discontinuity.
    pub(super) fn execute_pair(&mut self, i: u32, j: u32, side: Side, time: f64) -> Event {
        self.stream(i, time);
        self.stream(j, time);
        let (state, interaction) = self.pair_state(i, j);
        let (seen, restitution) = self.discontinuity(state, interaction, side);
        let (wi, wj) = (self.inverse_mass(i), self.inverse_mass(j));
        let reduced_mass = 1.0 / (wi + wj);

        let (a, b) = (&self.bodies[i as usize], &self.bodies[j as usize]);
        let apart = minimum_image(a.position - b.position, &self.periods);
        let velocity = a.velocity - b.velocity;
        let distance = apart.norm();
        let normal = if distance > 0.0 { apart / distance } else { any_normal(&velocity) };
        // From the overlap function's own B, so that the sign is the one that detection saw.
        let vn = if distance > 0.0 { velocity.dot(&apart) / distance } else { velocity.dot(&normal) };
        let depth = side.sign() * (seen.distance - distance);
        if depth > 0.0 {
            let scale = a.position.amax() + b.position.amax() + velocity.amax() * time.abs() + seen.distance;
            self.note_overlap(depth, seen.distance, scale);
        }
        if vn * side.sign() >= 0.0 {
            self.tally.turning_point += 1;
        }

        let mut response = respond(side, seen.energy_step, reduced_mass, vn, restitution);
        let is_barrier = seen.energy_step == f64::INFINITY;
        let mut tangential_scale = 1.0;
        if is_barrier && self.contact_times.is_some() {
            let acceleration = (self.acceleration(i) - self.acceleration(j)).dot(&normal);
            let tangential = (velocity.norm_squared() - vn * vn).max(0.0);
            let closing = -side.sign() * (acceleration + tangential / distance.max(f64::MIN_POSITIVE));
            let approach = (-side.sign() * vn).max(0.0);
            let leaving = self.tc_model(&[i, j], restitution, approach, tangential.sqrt(), closing, time);
            response.normal_velocity = side.sign() * leaving.speed;
            tangential_scale = leaving.tangential_scale;
        }
        let impulse = reduced_mass * (response.normal_velocity - vn);
        self.apply_impulse(i, j, &(normal * impulse));
        if tangential_scale != 1.0 {
            let tangential = velocity - normal * vn;
            self.apply_impulse(i, j, &(tangential * (reduced_mass * (tangential_scale - 1.0))));
        }
        if is_barrier || response.outcome == Outcome::Bounce {
            self.separate(i, j, side, &apart, reduced_mass);
        }
        self.bodies[i as usize].events = self.bodies[i as usize].events.wrapping_add(1);
        if wj > 0.0 {
            self.bodies[j as usize].events = self.bodies[j as usize].events.wrapping_add(1);
        }

        self.tally.count(response.outcome);
        self.tally.virial += impulse * distance;
        let (energy_step, dissipated) = match response.outcome {
            Outcome::Capture | Outcome::Release => (seen.energy_step, 0.0),
            _ if tangential_scale != 1.0 => (0.0, 0.0),
            _ => (0.0, 0.5 * reduced_mass * (vn - response.normal_velocity) * (vn + response.normal_velocity)),
        };
        if dissipated != 0.0 {
            self.tally.dissipate(dissipated);
        }
        if TABLE {
            match response.outcome {
                Outcome::Capture => self.know(i, j, state + 1, interaction),
                Outcome::Release if state > 1 => self.know(i, j, state - 1, interaction),
                Outcome::Release => self.release(i, j, interaction),
                Outcome::Core | Outcome::Bounce => {}
            }
        }
        Event {
            time: self.time(),
            kind: EventKind::Pair(response.outcome),
            particle: ParticleId(i),
            partner: Some(ParticleId(j)),
            normal,
            impulse,
            distance: seen.distance,
            energy_step,
            dissipated,
        }
    }

    #[inline]
    fn apply_impulse(&mut self, i: u32, j: u32, impulse: &Vector) {
        let (wi, wj) = (self.inverse_mass(i), self.inverse_mass(j));
        self.bodies[i as usize].velocity += impulse * wi;
        self.bodies[j as usize].velocity -= impulse * wj;
    }

    /// Rounds a reflection outwards: the pair must leave the discontinuity in the numbers that detection will see.
    ///
    /// An impulse below the spacing of the velocities' floats does nothing, and the same event would be due again for ever.
    /// Impulses of one such spacing, doubled until they count, change the energy by round-off only. At relative rest a pair
    /// outside of its core stays where it is, but one at the end of its bond must come inside.
    fn separate(&mut self, i: u32, j: u32, side: Side, apart: &Vector, reduced_mass: f64) {
        let closing = |engine: &Self| {
            let velocity = engine.bodies[i as usize].velocity - engine.bodies[j as usize].velocity;
            match side {
                Side::Positive => velocity.dot(apart) < 0.0,
                Side::Negative => velocity.dot(apart) >= 0.0,
            }
        };
        let speed = self.bodies[i as usize].velocity.amax().max(self.bodies[j as usize].velocity.amax());
        let mut impulse = side.sign() * f64::EPSILON * reduced_mass * speed;
        let Some(normal) = apart.try_normalize(0.0) else { return };
        // 52 doublings take a float's spacing to the float itself.
        for _ in 0..52 {
            if !closing(self) {
                return;
            }
            self.apply_impulse(i, j, &(normal * impulse));
            impulse *= 2.0;
        }
    }

    /// A particle reaches a wall.
    pub(super) fn execute_wall(&mut self, i: u32, face: Face, time: f64) -> Event {
        self.stream(i, time);
        let axis = usize::from(face.axis);
        let inwards = if face.is_upper { -1.0 } else { 1.0 };
        let (at, restitution) =
            self.walls.iter().find(|w| w.face == face).map_or((0.0, 1.0), |w| (w.at, w.restitution));
        let species = self.rules.species[usize::from(self.species[i as usize])];
        let body = self.bodies[i as usize];
        let vn = inwards * body.velocity[axis];
        let depth = species.radius - inwards * (body.position[axis] - at);
        if depth > 0.0 {
            let scale = body.position.amax() + body.velocity.amax() * time.abs() + at.abs();
            // A point particle has no length of its own to compare with.
            let unit = if species.radius > 0.0 { species.radius } else { 1.0 };
            self.note_overlap(depth, unit, scale);
        }
        if vn >= 0.0 {
            self.tally.turning_point += 1;
        }
        let mut after = if vn < 0.0 { -restitution * vn } else { vn };
        let mut tangential_scale = 1.0;
        if self.contact_times.is_some() {
            let closing = -inwards * species.acceleration[axis];
            let tangential = (body.velocity.norm_squared() - vn * vn).max(0.0).sqrt();
            let leaving = self.tc_model(&[i], restitution, (-vn).max(0.0), tangential, closing, time);
            (after, tangential_scale) = (leaving.speed, leaving.tangential_scale);
        }
        let body = &mut self.bodies[i as usize];
        if tangential_scale != 1.0 {
            body.velocity *= tangential_scale;
        }
        body.velocity[axis] = inwards * after;
        body.events = body.events.wrapping_add(1);
        self.tally.wall += 1;
        let dissipated =
            if tangential_scale == 1.0 { 0.5 / species.inverse_mass * (vn - after) * (vn + after) } else { 0.0 };
        self.tally.dissipate(dissipated);
        let mut normal = Vector::zeros();
        normal[axis] = inwards;
        Event {
            time: self.time(),
            kind: EventKind::Wall { axis: face.axis, is_upper: face.is_upper },
            particle: ParticleId(i),
            partner: None,
            normal,
            impulse: (after - vn) / species.inverse_mass,
            distance: species.radius,
            energy_step: 0.0,
            dissipated,
        }
    }

    /// State and interaction of a pair: what the moving one of them remembers, or a stranger's.
    pub(super) fn pair_state(&self, i: u32, j: u32) -> (u16, u16) {
        if !TABLE {
            return (0, 0);
        }
        let (keeper, other) = if self.is_static(i) { (j, i) } else { (i, j) };
        self.memory.get(keeper, other).map_or_else(
            || (0, self.rules.meeting(self.species[i as usize], self.species[j as usize]).interaction),
            |known| (known.state, known.interaction),
        )
    }

    fn discontinuity(&self, state: u16, interaction: u16, side: Side) -> (Discontinuity, f64) {
        let interaction = if TABLE { interaction } else { self.rules.meeting(0, 0).interaction };
        let steps = &self.rules.steps[usize::from(interaction)];
        // A prediction is only ever made for a discontinuity that the pair's state has.
        let seen = steps.seen_from(state, side).unwrap_or(Discontinuity {
            distance: 0.0,
            squared: 0.0,
            energy_step: f64::INFINITY,
        });
        (seen, steps.restitution)
    }

    /// A pair in state 0 again: strangers, unless a bond of its own keeps its interaction.
    fn release(&mut self, i: u32, j: u32, interaction: u16) {
        let meeting = self.rules.meeting(self.species[i as usize], self.species[j as usize]);
        if meeting.exists && meeting.interaction == interaction {
            self.forget(i, j);
        } else {
            self.know(i, j, 0, interaction);
        }
    }

    #[inline]
    fn inverse_mass(&self, particle: u32) -> f64 {
        let species = if TABLE { self.species[particle as usize] } else { 0 };
        self.rules.species[usize::from(species)].inverse_mass
    }

    fn note_overlap(&mut self, depth: f64, unit: f64, scale: f64) {
        self.tally.deepest_overlap = self.tally.deepest_overlap.max(depth / unit);
        if depth > ROUNDINGS * f64::EPSILON * scale {
            self.tally.in_invalid_state += 1;
        }
    }

    /// A contact under the TC model, and its entry in the model's memory.
    fn tc_model(
        &mut self,
        particles: &[u32],
        restitution: f64,
        approach: f64,
        tangential: f64,
        closing: f64,
        time: f64,
    ) -> Leaving {
        let Some(times) = &mut self.contact_times else {
            return Leaving { speed: restitution * approach, tangential_scale: 1.0 };
        };
        let mut is_recent = false;
        for &particle in particles {
            let last = &mut times.last[particle as usize];
            is_recent |= time - *last < times.contact_time;
            *last = time;
        }
        let leaving = tc_contact(restitution, is_recent, approach, tangential, closing, times.contact_time);
        self.tally.tc_altered += u64::from(leaving.speed != restitution * approach || leaving.tangential_scale != 1.0);
        leaving
    }
}

/// A direction for two particles at the same point: the one in which they approach.
fn any_normal(velocity: &Vector) -> Vector {
    velocity.try_normalize(0.0).map_or(Vector::x(), |direction| -direction)
}
