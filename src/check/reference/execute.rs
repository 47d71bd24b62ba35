//! Executes the events of the reference engine.

use super::response::Encounter;
use super::rough::Rub;
use super::rules::{Discontinuity, seen};
use super::{Event, EventKind, Outcome, Reference, Side};
use crate::Vector;
use crate::model::space::{Boundary, Face};
use crate::model::{ContactLaw, Interaction, ParticleId, Species, SurfaceLaw};

impl Reference {
    pub(super) fn execute_pair(&mut self, i: u32, j: u32, side: Side) -> Option<Event> {
        let (interaction, state) = *self.pairs.get(&(i, j))?;
        let Interaction { potential, law, .. } = self.interaction(interaction, [i, j]);
        let seen = seen(&potential, state, side)?;
        let apart = self.nearest_image(i, j);
        let (velocity, acceleration) = self.relative_motion(i, j);
        // Two particles at the same point have no line of centres. The relative velocity defines the normal instead.
        let normal = apart.try_normalize(0.0).or_else(|| (-velocity).try_normalize(0.0)).unwrap_or(Vector::x());
        let [wi, wj] = [i, j].map(|p| self.species(p).inverse_mass());
        let reduced_mass = 1.0 / (wi + wj);
        let curvature = 1.0 / apart.norm().max(f64::MIN_POSITIVE);
        let encounter =
            Encounter { seen, side, normal, velocity, acceleration, curvature, reduced_mass, law, sliding: None };
        // A static particle has no memory of its contacts in the TC model.
        let moving: Vec<u32> = [i, j].into_iter().filter(|&p| !self.species(p).is_static()).collect();
        moving.iter().for_each(|&p| self.note_contact(p, false));
        let (outcome, after, rough) = encounter.leave(self.tc_model.as_mut(), &moving, self.time);

        let mut impulse = (after - velocity) * reduced_mass;
        let mut torques = [Vector::zeros(); 2];
        let mut lost = 0.5 * reduced_mass * (velocity.norm_squared() - after.norm_squared());
        // The end of a bond is smooth, because the particles do not touch there.
        if let Some((roughness, rattle)) = rough.filter(|_| outcome == Outcome::Core) {
            let [a, b] = [i, j].map(|p| self.species(p).diameter);
            let radii = [a, b].map(|diameter| seen.distance * diameter / (a + b));
            let kick = (after - velocity).dot(&normal);
            let turning = Vector::zeros();
            let rub = Rub { particle: i, partner: Some(j), radii, normal, velocity, turning, kick, rattle };
            let rubbed = self.rub(&rub, &roughness);
            impulse += rubbed.impulse;
            torques = rubbed.torques;
            lost += rubbed.dissipated;
        }
        let before = [i, j].map(|p| self.velocities[p as usize]);
        self.velocities[i as usize] += impulse * wi;
        self.velocities[j as usize] -= impulse * wj;
        let (next, energy_step) = match outcome {
            Outcome::Capture => (state + 1, seen.energy_step),
            Outcome::Release => (state - 1, seen.energy_step),
            Outcome::Core | Outcome::Bounce => (state, 0.0),
        };
        self.pairs.insert((i, j), (interaction, next));
        Some(Event {
            time: self.time(),
            kind: EventKind::Pair(outcome),
            particle: ParticleId(i),
            partner: Some(ParticleId(j)),
            normal,
            impulse: impulse.dot(&normal),
            torques,
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
        self.note_contact(i, false);
        Some(self.reflect(i, &encounter, Vector::zeros(), EventKind::Wall { axis, is_upper }))
    }

    pub(super) fn execute_surface(&mut self, i: u32, feature: u32) -> Option<Event> {
        let feature = *self.features.get(feature as usize)?;
        let law = match self.scene.surfaces[feature.surface].law {
            SurfaceLaw::Reflecting(law) => law,
            SurfaceLaw::Outlet => return Some(self.leave(i, feature.surface)),
            SurfaceLaw::Thermal { .. } => return None,
        };
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
        let to_shape = |vector: &Vector| moment.map_or(*vector, |moment| moment.pose.direction_of_shape(vector));
        let turning = moment.map_or(Vector::zeros(), |moment| moment.pose.direction_of_shape(&moment.spin));
        // The event's normal points from the surface to the particle, even inside a sphere or cylinder.
        let sign = contact.side.sign();
        let outwards = contact.normal * sign;
        let place_of_contact = position - outwards * encounter.seen.distance;
        let sliding = self.scene.surfaces[feature.surface].surface_velocity;
        let sliding = sliding.map(|velocity| velocity.at(&place_of_contact, &outwards));
        let encounter = Encounter { sliding: sliding.or(moment.map(|_| Vector::zeros())), ..encounter };
        let spin = self.spins[i as usize];
        self.note_contact(i, encounter.sliding.is_some());
        self.spins[i as usize] = to_shape(&spin);
        let event = self.reflect(i, &encounter, turning, EventKind::Surface { number: feature.surface });
        if let Some(moment) = &moment {
            self.spins[i as usize] = moment.pose.direction(&self.spins[i as usize]);
        }
        let gained = self.spins[i as usize] - spin;
        let event = Event { normal: event.normal * sign, impulse: event.impulse * sign, ..event };
        let work = event.energy_step;
        let Some(moment) = moment else { return Some(event) };
        let after = moment.velocity_of(&place, &event.after[0]);
        self.velocities[i as usize] = after;
        Some(Event {
            normal: moment.pose.direction(&event.normal),
            torques: event.torques.map(|torque| moment.pose.direction(&torque)),
            energy_step: work
                + mass * (after - before).dot(&moment.velocity_at(&place))
                + self.angular_momentum(i, &gained).dot(&moment.spin),
            before: [before, Vector::zeros()],
            after: [after, Vector::zeros()],
            ..event
        })
    }

    fn leave(&mut self, i: u32, number: usize) -> Event {
        let velocity = self.velocities[i as usize];
        self.remove(ParticleId(i));
        Event {
            time: self.time(),
            kind: EventKind::Exit { number },
            particle: ParticleId(i),
            partner: None,
            normal: Vector::zeros(),
            impulse: 0.0,
            torques: [Vector::zeros(); 2],
            energy_step: 0.0,
            dissipated: 0.0,
            before: [velocity, Vector::zeros()],
            after: [Vector::zeros(); 2],
        }
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
            sliding: None,
        }
    }

    /// Executes the contact of a particle with a surface at rest. A moving surface is at rest in its own frame.
    fn reflect(&mut self, i: u32, encounter: &Encounter, turning: Vector, kind: EventKind) -> Event {
        let Encounter { velocity: before, normal, reduced_mass: mass, seen, side, sliding, .. } = *encounter;
        let sliding = sliding.unwrap_or_default();
        let (_, mut after, rough) = encounter.leave(self.tc_model.as_mut(), &[i], self.time);
        let mut torques = [Vector::zeros(); 2];
        let mut dissipated = 0.5 * mass * ((before - sliding).norm_squared() - (after - sliding).norm_squared());
        if let Some((roughness, rattle)) = rough {
            let normal = normal * side.sign();
            let kick = (after - before).dot(&normal);
            let radii = [seen.distance, 0.0];
            let velocity = before - sliding;
            let rub = Rub { particle: i, partner: None, radii, normal, velocity, turning, kick, rattle };
            let rubbed = self.rub(&rub, &roughness);
            after += rubbed.impulse / mass;
            torques = rubbed.torques;
            dissipated += rubbed.dissipated;
        }
        self.velocities[i as usize] = after;
        Event {
            time: self.time(),
            kind,
            particle: ParticleId(i),
            partner: None,
            normal,
            impulse: mass * (after - before).dot(&normal),
            torques,
            energy_step: mass * (after - before).dot(&sliding),
            dissipated,
            before: [before, Vector::zeros()],
            after: [after, Vector::zeros()],
        }
    }
}
