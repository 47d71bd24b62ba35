//! Executes the events of the reference engine.

use super::response::Encounter;
use super::rules::{Discontinuity, seen};
use super::{Event, EventKind, Outcome, Reference, Side};
use crate::Vector;
use crate::model::space::{Boundary, Face};
use crate::model::{ContactLaw, Interaction, ParticleId, Species, SurfaceLaw};

impl Reference {
    pub(super) fn execute_pair(&mut self, i: u32, j: u32, side: Side) -> Option<Event> {
        let (interaction, state) = *self.pairs.get(&(i, j))?;
        let Interaction { ref potential, law, .. } = *self.interaction(interaction);
        let seen = seen(potential, state, side)?;
        let apart = self.nearest_image(i, j);
        let (velocity, acceleration) = self.relative_motion(i, j);
        // Two particles at the same point have no line of centres. The line of approach replaces it.
        let normal = apart.try_normalize(0.0).or_else(|| (-velocity).try_normalize(0.0)).unwrap_or(Vector::x());
        let [wi, wj] = [i, j].map(|p| self.species(p).inverse_mass());
        let reduced_mass = 1.0 / (wi + wj);
        let curvature = 1.0 / apart.norm().max(f64::MIN_POSITIVE);
        let encounter = Encounter { seen, side, normal, velocity, acceleration, curvature, reduced_mass, law };
        // Like a wall, a static particle has no memory of its contacts in the TC model.
        let moving: Vec<u32> = [i, j].into_iter().filter(|&p| !self.species(p).is_static()).collect();
        let (outcome, after) = encounter.leave(self.tc_model.as_mut(), &moving, self.time);

        let impulse = (after - velocity) * reduced_mass;
        let before = [i, j].map(|p| self.velocities[p as usize]);
        self.velocities[i as usize] += impulse * wi;
        self.velocities[j as usize] -= impulse * wj;
        let (next, energy_step) = match outcome {
            Outcome::Capture => (state + 1, seen.energy_step),
            Outcome::Release => (state - 1, seen.energy_step),
            Outcome::Core | Outcome::Bounce => (state, 0.0),
        };
        self.pairs.insert((i, j), (interaction, next));
        let lost = 0.5 * reduced_mass * (velocity.norm_squared() - after.norm_squared());
        Some(Event {
            time: self.time(),
            kind: EventKind::Pair(outcome),
            particle: ParticleId(i),
            partner: Some(ParticleId(j)),
            normal,
            impulse: impulse.dot(&normal),
            energy_step,
            dissipated: if next == state { lost } else { 0.0 },
            before,
            after: [i, j].map(|p| self.velocities[p as usize]),
        })
    }

    pub(super) fn execute_wall(&mut self, i: u32, axis: u8, is_upper: bool) -> Option<Event> {
        let k = usize::from(axis);
        let Boundary::Bounded { lower, upper } = self.scene.space.boundary[k] else { return None };
        let Face::Wall(law) = (if is_upper { upper } else { lower }) else { return None };
        let mut normal = Vector::zeros();
        normal[k] = if is_upper { -1.0 } else { 1.0 };
        let encounter = self.encounter_at_rest(i, normal, law);
        Some(self.reflect(i, &encounter, EventKind::Wall { axis, is_upper }))
    }

    pub(super) fn execute_surface(&mut self, i: u32, feature: u32) -> Option<Event> {
        let feature = *self.features.get(feature as usize)?;
        let SurfaceLaw::Reflecting(law) = self.scene.surfaces[feature.surface].law else { return None };
        let (place, before) = (self.positions[i as usize], self.velocities[i as usize]);
        let moment = self.timelines[feature.surface].as_ref().map(|timeline| timeline.at(self.time()));
        let (position, velocity) = moment.map_or((place, before), |moment| moment.seen(&place, &before));
        let contact = feature.contact(&position);
        let curvature = contact.curvature_for(&velocity);
        let encounter = self.encounter_at_rest(i, contact.normal, law);
        let push = encounter.acceleration;
        let acceleration = moment.map_or(push, |moment| moment.acceleration_seen(&place, &before, &push));
        let encounter = Encounter { side: contact.side, curvature, velocity, acceleration, ..encounter };
        let mass = encounter.reduced_mass;
        let event = self.reflect(i, &encounter, EventKind::Surface { number: feature.surface });
        // The event's normal points from the surface to the particle, even if the surface surrounds the particle.
        let sign = contact.side.sign();
        let event = Event { normal: event.normal * sign, impulse: event.impulse * sign, ..event };
        let Some(moment) = moment else { return Some(event) };
        let after = moment.velocity_of(&place, &event.after[0]);
        self.velocities[i as usize] = after;
        Some(Event {
            normal: moment.pose.direction(&event.normal),
            energy_step: mass * (after - before).dot(&moment.velocity_at(&place)),
            before: [before, Vector::zeros()],
            after: [after, Vector::zeros()],
            ..event
        })
    }

    fn encounter_at_rest(&self, i: u32, normal: Vector, law: ContactLaw) -> Encounter {
        let Species { diameter, mass, acceleration, .. } = *self.species(i);
        Encounter {
            seen: Discontinuity { distance: 0.5 * diameter, energy_step: f64::INFINITY },
            side: Side::Positive,
            normal,
            velocity: self.velocities[i as usize],
            acceleration,
            curvature: 0.0,
            reduced_mass: mass,
            law,
        }
    }

    /// Executes the contact of a particle with a barrier at rest. A moving surface is at rest in its own frame.
    fn reflect(&mut self, i: u32, encounter: &Encounter, kind: EventKind) -> Event {
        let Encounter { velocity: before, normal, reduced_mass: mass, .. } = *encounter;
        let (_, after) = encounter.leave(self.tc_model.as_mut(), &[i], self.time);
        self.velocities[i as usize] = after;
        Event {
            time: self.time(),
            kind,
            particle: ParticleId(i),
            partner: None,
            normal,
            impulse: mass * (after - before).dot(&normal),
            energy_step: 0.0,
            dissipated: 0.5 * mass * (before.norm_squared() - after.norm_squared()),
            before: [before, Vector::zeros()],
            after: [after, Vector::zeros()],
        }
    }
}
