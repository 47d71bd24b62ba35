//! Particles at rest fall asleep. Sleeping particles are static, and cost no events until they wake up.
//!
//! From time to time, all particles are looked at. A particle that has hardly moved since the previous search, and was
//! always in contact, falls asleep. Sleeping particles have their own rows in the interaction table, with an infinite
//! mass and without gravity, so that the event loop treats them as static. They wake up if a particle hits them fast
//! enough, or if a particle that they touched has moved away.

use super::Repredict;
use crate::Vector;
use crate::engine::contact::apply::{Change, With};
use crate::engine::event::CountedKind;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::engine::snapshot::rotational_energy;
use crate::engine::state::{Body, State};
use crate::engine::{Chosen, Invariant, InvariantBroken, Simulation};
use crate::model::{ParticleId, Scene, Sleep};
use crate::physics::overlap::Side;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// What decides whether a particle falls asleep.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::engine) struct Watched {
    /// Place of the particle at the previous search, or where it fell asleep.
    place: Vector,
    /// Number of its events up to the previous search.
    events: u32,
    /// Whether it has touched a surface since then whose material moves.
    is_driven: bool,
}

impl From<&Body> for Watched {
    fn from(body: &Body) -> Self {
        Self { place: body.position, events: body.events, is_driven: false }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct Sleepers {
    plan: Sleep,
    /// The smallest number of contacts of a particle at rest between two searches.
    fewest_contacts: f64,
    start_time: f64,
    /// Number of searches so far.
    searches: u32,
    /// Time of the next search since the epoch.
    next: f64,
    /// By the numbers of the particles in memory.
    pub watched: Vec<Watched>,
}

impl Sleepers {
    /// Returns `None` if particles never sleep.
    pub fn of(scene: &Scene, state: &State) -> Option<Self> {
        let plan = scene.sleep?;
        Some(Self {
            plan,
            fewest_contacts: plan.fewest_contacts(scene.contact_time?),
            start_time: scene.start_time,
            searches: 0,
            next: plan.interval,
            watched: state.bodies.iter().map(Watched::from).collect(),
        })
    }

    /// Returns a copy for particles in another order.
    pub fn with(&self, watched: Vec<Watched>) -> Self {
        Self { watched, ..*self }
    }

    pub fn are_those_of(&self, plan: Option<Sleep>) -> bool {
        Some(self.plan) == plan
    }

    /// Discounts an event of each particle that is not a contact.
    pub fn skip_event(&mut self) {
        self.watched.iter_mut().for_each(|watched| watched.events = watched.events.wrapping_add(1));
    }

    pub fn next(&self) -> f64 {
        self.next
    }

    pub fn shift(&mut self, shift: f64) {
        self.next -= shift;
    }
}

impl Simulation {
    /// Number of grains that sleep.
    #[must_use]
    pub fn asleep(&self) -> usize {
        with_engine!(&self.engine, engine => engine.particles().filter(|&particle| engine.is_asleep(particle)).count())
    }

    /// Ids of the grains that sleep, ascending.
    #[must_use]
    pub fn sleeping(&self) -> Vec<ParticleId> {
        with_engine!(&self.engine, engine => {
            engine.by_id().filter(|&particle| engine.is_asleep(particle)).map(|particle| engine.name(particle)).collect()
        })
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Searches for particles that are at rest, and for sleeping particles whose neighbours have moved away.
    pub(in crate::engine) fn look_for_rest(
        &mut self,
        observe: &mut Observe<'_>,
    ) -> Result<(Repredict, ControlFlow<()>), InvariantBroken> {
        self.close_gaps();
        let Some(mut sleepers) = self.sources.sleepers.take() else {
            return Err(self.broken(0, None, Invariant::GlobalEvent));
        };
        let now = sleepers.next;
        self.clock.now = now;
        let particles: Vec<u32> = self.by_id().filter(|&particle| !self.is_of_static_species(particle)).collect();
        let [rests, is_disturbed] = self.looked_at(&particles, &sleepers);
        sleepers.searches += 1;
        let next = sleepers.start_time + f64::from(sleepers.searches + 1) * sleepers.plan.interval;
        sleepers.next = self.since_epoch(next);
        for &particle in particles.iter().filter(|&&particle| !self.is_asleep(particle)) {
            let (place, _) = self.state_at(particle, now);
            let events = self.state.bodies[particle as usize].events;
            sleepers.watched[particle as usize] = Watched { place, events, is_driven: false };
        }
        self.sources.sleepers = Some(sleepers);
        let (mut woken, mut flow, mut any_sleeps) = (Vec::new(), ControlFlow::Continue(()), false);
        for &particle in &particles {
            let (rests, is_disturbed) = (rests[particle as usize], is_disturbed[particle as usize]);
            let change = match (self.is_asleep(particle), rests, is_disturbed) {
                (true, _, true) => {
                    woken.push(particle);
                    self.wake(particle, observe)
                }
                (false, true, false) => {
                    any_sleeps = true;
                    self.fall_asleep(particle, observe)
                }
                _ => continue,
            };
            if change.is_break() {
                flow = change;
            }
        }
        if any_sleeps {
            // Particles meet sleeping particles earlier or later than they would have met moving ones.
            woken = particles.into_iter().filter(|&particle| !self.is_asleep(particle)).collect();
        }
        Ok((Repredict::Some(woken), flow))
    }

    /// Returns which particles are at rest, and which particles touched a particle that has moved away.
    fn looked_at(&self, particles: &[u32], sleepers: &Sleepers) -> [Vec<bool>; 2] {
        let (plan, now) = (&sleepers.plan, self.clock.now);
        let mut rests = vec![false; self.state.bodies.len()];
        let mut is_disturbed = rests.clone();
        let mut near = Candidates::default();
        for &particle in particles.iter().filter(|&&particle| !self.is_asleep(particle)) {
            let watched = &sleepers.watched[particle as usize];
            let (position, velocity) = self.state_at(particle, now);
            let moved = self.nearest(position - watched.place, Vector::zeros(), now).0.position.norm();
            if moved > plan.distance {
                self.find_touching(particle, &watched.place, plan.distance, &mut near);
                near.found().iter().for_each(|&other| is_disturbed[other as usize] = true);
                continue;
            }
            let contacts = self.state.bodies[particle as usize].events.wrapping_sub(watched.events);
            rests[particle as usize] = f64::from(contacts) >= sleepers.fewest_contacts
                && self.acceleration(particle) != Vector::zeros()
                && velocity.norm() <= plan.wake_speed
                && !watched.is_driven;
        }
        [rests, is_disturbed]
    }

    /// Finds all other particles within `distance` of touching `particle` at `place`.
    fn find_touching(&self, particle: u32, place: &Vector, distance: f64, near: &mut Candidates) {
        let rows = self.pairs.rules.rows.species().len();
        self.neighbours.find_candidates_at(place, near);
        near.retain(|other| {
            let range = self.ranges.between[usize::from(self.row(particle)) * rows + usize::from(self.row(other))];
            let (there, _) = self.state_at(other, self.clock.now);
            let apart = self.nearest(place - there, Vector::zeros(), self.clock.now).0.position.norm();
            other != particle && range >= 0.0 && apart <= range + distance
        });
    }

    /// Notes a contact with a surface that moves, or whose material moves. The particle does not fall asleep.
    #[cold]
    #[inline(never)]
    pub(in crate::engine) fn note_drive(&mut self, particle: u32) {
        if let Some(sleepers) = &mut self.sources.sleepers {
            sleepers.watched[particle as usize].is_driven = true;
        }
    }

    /// Stops a particle, and makes it static. Its kinetic energy is dissipated.
    fn fall_asleep(&mut self, particle: u32, observe: &mut Observe<'_>) -> ControlFlow<()> {
        self.stream(particle, self.clock.now);
        let (inverse_mass, inverse_inertia) = (self.inverse_mass(particle), self.inverse_inertia(particle));
        let (before, spin) = (self.state.bodies[particle as usize].velocity, self.spin(particle));
        let change = Change::of_one(With::Program, particle, &before, Vector::zeros(), inverse_mass);
        let dissipated = -change.supplied + rotational_energy(&spin, inverse_inertia);
        let of_spin = if inverse_inertia > 0.0 { -spin / inverse_inertia } else { Vector::zeros() };
        let torques = [of_spin, Vector::zeros()];
        let counted = Some(CountedKind::Rest);
        let flow = self.apply(&Change { counted, supplied: 0.0, dissipated, torques, ..change }, observe);
        if let Some(spin) = self.state.spins.get_mut(particle as usize) {
            *spin = Vector::zeros();
        }
        self.leave_lists(particle);
        self.state.rows[particle as usize] = self.pairs.rules.rows.asleep(self.row(particle));
        self.fill_list(particle);
        self.schedule.predictions[particle as usize] = Prediction::NONE;
        flow
    }

    /// Wakes a particle, which must be predicted afterwards.
    fn wake(&mut self, particle: u32, observe: &mut Observe<'_>) -> ControlFlow<()> {
        self.stream(particle, self.clock.now);
        self.leave_lists(particle);
        self.state.rows[particle as usize] = self.pairs.rules.rows.awake(self.row(particle));
        self.fill_list(particle);
        let (zero, inverse_mass) = (Vector::zeros(), self.inverse_mass(particle));
        let change = Change::of_one(With::Program, particle, &zero, zero, inverse_mass);
        let flow = self.apply(&Change { counted: Some(CountedKind::Wake), ..change }, observe);
        let events = self.state.bodies[particle as usize].events;
        if let Some(sleepers) = &mut self.sources.sleepers {
            sleepers.watched[particle as usize].events = events;
        }
        flow
    }

    /// Executes a contact with a sleeping particle. If it is fast enough, the particle wakes up first.
    #[cold]
    #[inline(never)]
    pub(in crate::engine) fn hit_sleeper(
        &mut self,
        [i, j]: [u32; 2],
        side: Side,
        time: f64,
        flown: [f64; 2],
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, InvariantBroken> {
        let wake_speed = self.sources.sleepers.as_ref().map_or(f64::INFINITY, |sleepers| sleepers.plan.wake_speed);
        let mut flow = ControlFlow::Continue(());
        if self.state.bodies[i as usize].velocity.norm() > wake_speed {
            flow = self.wake(j, observe);
        }
        let met = self.meet([i, j], side, time, flown, observe)?;
        Ok(if flow.is_break() { flow } else { met })
    }

    /// Wakes all particles that touch a particle at its last known place, before it leaves the system.
    pub(in crate::engine) fn wake_neighbours(&mut self, particle: u32, observe: &mut Observe<'_>) -> ControlFlow<()> {
        let Some(sleepers) = &self.sources.sleepers else { return ControlFlow::Continue(()) };
        let (place, distance) = (sleepers.watched[particle as usize].place, sleepers.plan.distance);
        let mut near = Candidates::default();
        self.find_touching(particle, &place, distance, &mut near);
        near.retain(|other| self.is_asleep(other));
        self.wake_some(near.found().to_vec(), observe)
    }

    /// Wakes all particles, because something else than their neighbours may have changed.
    pub(in crate::engine) fn wake_all(&mut self) {
        if self.sources.sleepers.is_some() {
            let asleep = self.particles().filter(|&particle| self.is_asleep(particle)).collect();
            let _ = self.wake_some(asleep, &mut None);
        }
    }

    pub(in crate::engine) fn wake_some(
        &mut self,
        mut particles: Vec<u32>,
        observe: &mut Observe<'_>,
    ) -> ControlFlow<()> {
        particles.sort_unstable_by_key(|&particle| self.name(particle));
        let mut flow = ControlFlow::Continue(());
        for &particle in &particles {
            if self.wake(particle, observe).is_break() {
                flow = ControlFlow::Break(());
            }
        }
        for particle in particles {
            self.repredict(particle, self.clock.now);
        }
        flow
    }

    /// Takes a particle out of the neighbour lists of all particles. The list of the particle becomes empty.
    fn leave_lists(&mut self, particle: u32) {
        let Some(verlet) = self.neighbours.verlet() else { return };
        let mut near = Candidates::default();
        let species = self.row(particle);
        let centre = verlet.centres[particle as usize];
        verlet.find_neighbours_within(&centre, species, &self.state.rows, &mut near);
        if let Some(lists) = self.neighbours.lists_mut() {
            lists.withdraw(particle);
            near.found().iter().filter(|&&other| other != particle).for_each(|&other| lists.remove(other, particle));
        }
    }
}

#[cfg(test)]
mod tests;
