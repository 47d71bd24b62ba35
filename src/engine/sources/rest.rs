//! Particles at rest fall asleep. Sleeping particles are static, and cost no events until they wake up.
//!
//! At regular intervals, a search examines all particles. A particle falls asleep if it is slow, has hardly moved since
//! the previous search, and has made enough contacts since then. Sleeping particles have their own rows in the
//! interaction table, with infinite mass and without gravity, so the event loop treats them as static. They wake up if
//! another particle hits them fast or often enough, or if a neighbour moves away.

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
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Data that decide whether a particle falls asleep.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::engine) struct Watched {
    /// Place of the particle at the previous search, or where it fell asleep.
    place: Vector,
    /// Version of its motion at the previous search. Each event since then has increased the version by 1.
    version: u32,
    /// Whether the particle has touched a surface that moves, or whose material moves, since the previous search.
    is_driven: bool,
}

impl From<&Body> for Watched {
    fn from(body: &Body) -> Self {
        Self { place: body.position, version: body.version, is_driven: false }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct Sleepers {
    pub plan: Sleep,
    /// A particle with fewer contacts since the previous search does not fall asleep.
    fewest_contacts: f64,
    /// A particle with more contacts since the previous search wakes the sleeping particles that it hits.
    most_contacts: f64,
    /// Time of the next search since the epoch; infinite if all particles sleep or fly away.
    next: f64,
    /// One entry per particle, in the order in memory.
    pub watched: Vec<Watched>,
}

impl Sleepers {
    /// Returns `None` if particles never sleep.
    pub fn of(scene: &Scene, state: &State) -> Option<Self> {
        let plan = scene.sleep?;
        Some(Self {
            plan,
            fewest_contacts: plan.fewest_contacts(scene.contact_time?),
            most_contacts: plan.most_contacts(scene.contact_time?),
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

    /// Excludes the latest event of each particle from its number of contacts, because the event was not a contact.
    pub fn skip_event(&mut self) {
        self.watched.iter_mut().for_each(|watched| watched.version = watched.version.wrapping_add(1));
    }

    pub fn next(&self) -> f64 {
        self.next
    }

    pub fn shift(&mut self, shift: f64) {
        self.next -= shift;
    }
}

impl Simulation {
    /// Ids of the grains that sleep, ascending.
    #[must_use]
    pub fn sleeping(&self) -> Vec<ParticleId> {
        with_engine!(&self.engine, engine => {
            engine.by_id().filter(|&particle| engine.is_asleep(particle)).map(|particle| engine.id(particle)).collect()
        })
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Searches for particles at rest, which fall asleep, and for sleeping particles that have lost a neighbour, which
    /// wake up.
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
        for &particle in particles.iter().filter(|&&particle| !self.is_asleep(particle)) {
            let (place, _) = self.state_at(particle, now);
            let version = self.state.bodies[particle as usize].version;
            sleepers.watched[particle as usize] = Watched { place, version, is_driven: false };
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
            // Predicted contacts with particles that have just fallen asleep are outdated.
            woken = particles.iter().copied().filter(|&particle| !self.is_asleep(particle)).collect();
        }
        let next = if woken.is_empty() && self.need_no_search(&particles) { f64::INFINITY } else { self.next_search() };
        if let Some(sleepers) = &mut self.sources.sleepers {
            sleepers.next = next;
        }
        Ok((Repredict::Some(woken), flow))
    }

    /// Whether no further search is needed: all particles sleep, or the awake particles will have no further event.
    fn need_no_search(&self, particles: &[u32]) -> bool {
        let mut awake = particles.iter().filter(|&&particle| !self.is_asleep(particle)).peekable();
        let flies_on = |particle: u32| self.schedule.predictions[particle as usize].due_time() == f64::INFINITY;
        awake.peek().is_none() || awake.all(|&particle| flies_on(particle)) && self.is_over()
    }

    /// Whether the next search would wake particles, because they have lost a neighbour.
    pub(in crate::engine) fn will_wake_some(&self) -> bool {
        let Some(sleepers) = &self.sources.sleepers else { return false };
        let mut near = Candidates::default();
        self.particles().filter(|&particle| !self.is_static(particle)).any(|particle| {
            let place = &sleepers.watched[particle as usize].place;
            self.find_touching(particle, place, sleepers.plan.distance, &mut near);
            near.found().iter().any(|&other| self.is_asleep(other))
        })
    }

    /// Time of the next search after now, since the epoch. Searches are at the multiples of the interval.
    fn next_search(&self) -> f64 {
        let Some(sleepers) = &self.sources.sleepers else { return f64::INFINITY };
        let (interval, epoch) = (sleepers.plan.interval, self.clock.epoch);
        // A search is at a multiple of the interval within round-off.
        let done = ((epoch + self.clock.now) / interval + 1e-6).floor();
        ((done + 1.0) * interval - epoch).max(self.clock.now.next_up())
    }

    /// Schedules a search if none is scheduled. Called after a particle has entered or woken up.
    pub(in crate::engine) fn search_again(&mut self) {
        let next = self.next_search();
        if let Some(sleepers) = &mut self.sources.sleepers
            && sleepers.next == f64::INFINITY
        {
            sleepers.next = next;
            self.schedule_global();
        }
    }

    /// Sets the number of contacts of a particle to zero.
    pub(in crate::engine) fn forget_contacts(&mut self, particle: u32) {
        if let Some(sleepers) = &mut self.sources.sleepers {
            sleepers.watched[particle as usize].version = self.state.bodies[particle as usize].version;
        }
    }

    /// Returns which particles are at rest, and which particles have lost a neighbour.
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
            let contacts = self.state.bodies[particle as usize].version.wrapping_sub(watched.version);
            rests[particle as usize] = f64::from(contacts) >= sleepers.fewest_contacts
                && self.acceleration(particle) != Vector::zeros()
                && velocity.norm() <= plan.wake_speed
                && !watched.is_driven;
        }
        [rests, is_disturbed]
    }

    /// Finds the neighbours of a particle at `place`: particles whose surfaces are at most `distance` away.
    fn find_touching(&self, particle: u32, place: &Vector, distance: f64, near: &mut Candidates) {
        self.neighbours.find_candidates_at(place, self.row(particle), near);
        near.retain(|other| {
            let range = self.range_between((self.row(particle), self.radius(particle)), other);
            let (there, _) = self.state_at(other, self.clock.now);
            let apart = self.nearest(place - there, Vector::zeros(), self.clock.now).0.position.norm();
            other != particle && range >= 0.0 && apart <= range + distance
        });
    }

    /// Records that a particle touches a surface that moves, or whose material moves. The particle does not fall asleep
    /// at the next search.
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
        // The torque leaves a rounding error.
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
        self.forget_contacts(particle);
        self.search_again();
        flow
    }

    /// Wakes a sleeping particle that `other` is about to hit, if `other` is fast or has made many contacts since the
    /// previous search.
    #[cold]
    #[inline(never)]
    pub(in crate::engine) fn wake_if_hit(
        &mut self,
        sleeping: u32,
        other: u32,
        observe: &mut Observe<'_>,
    ) -> ControlFlow<()> {
        let Some(sleepers) = &self.sources.sleepers else { return ControlFlow::Continue(()) };
        let body = &self.state.bodies[other as usize];
        let contacts = body.version.wrapping_sub(sleepers.watched[other as usize].version);
        let is_hit = body.velocity.norm() > sleepers.plan.wake_speed || f64::from(contacts) > sleepers.most_contacts;
        if is_hit { self.wake(sleeping, observe) } else { ControlFlow::Continue(()) }
    }

    /// Wakes the neighbours of a particle that leaves the system.
    pub(in crate::engine) fn wake_neighbours(&mut self, particle: u32, observe: &mut Observe<'_>) -> ControlFlow<()> {
        let Some(sleepers) = &self.sources.sleepers else { return ControlFlow::Continue(()) };
        let (place, distance) = (sleepers.watched[particle as usize].place, sleepers.plan.distance);
        let mut near = Candidates::default();
        self.find_touching(particle, &place, distance, &mut near);
        near.retain(|other| self.is_asleep(other));
        self.wake_some(near.found().to_vec(), observe)
    }

    /// Wakes all particles, for example because gravity has changed.
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
        particles.sort_unstable_by_key(|&particle| self.id(particle));
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
        verlet.find_neighbours_within(&centre, species, |other| self.row(other), &mut near);
        if let Some(lists) = self.neighbours.lists_mut() {
            lists.withdraw(particle);
            near.found().iter().filter(|&&other| other != particle).for_each(|&other| lists.remove(other, particle));
        }
    }
}

#[cfg(test)]
mod tests;
