//! Checks that grains fall asleep and wake up as the rules of the scene demand.

use super::bounds::rounded;
use super::contact::Contact;
use super::rules::fly;
use super::verifier::{Verifier, check_count};
use super::violation::{Fault, Quantity};
use super::world::World;
use crate::Vector;
use crate::engine::event::{Event, EventKind};
use crate::engine::{Elapsed, States};
use crate::model::{ParticleId, Scene, Sleep};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// What decides whether grains fall asleep.
#[derive(Debug)]
pub(super) struct SleepWatch {
    plan: Sleep,
    fewest_contacts: f64,
    /// A grain with more contacts since the previous search wakes the sleeping grains that it hits.
    most_contacts: f64,
    /// Number of searches so far.
    searches: f64,
    /// False until the first search of a proof that begins in the middle of a run.
    is_known: bool,
    /// Places at the previous search; for sleeping grains, where they sleep.
    places: Vec<Vector>,
    /// Number of contacts since the previous search.
    contacts: Vec<u32>,
    /// Whether the grain has touched a surface whose material moves.
    is_driven: Vec<bool>,
    /// Grains that wake up at the current contact.
    waking: Vec<u32>,
}

impl SleepWatch {
    pub fn new(scene: &Scene, states: &States, is_known: bool) -> Option<Self> {
        let (plan, contact_time) = (scene.sleep?, scene.contact_time?);
        let count = states.positions.len();
        Some(Self {
            plan,
            fewest_contacts: (plan.interval / (4.0 * contact_time)).ceil(),
            most_contacts: 64.0 * (plan.interval / contact_time),
            searches: (states.elapsed.total() / plan.interval).floor(),
            is_known,
            places: states.positions.clone(),
            contacts: vec![0; count],
            is_driven: vec![false; count],
            waking: Vec::new(),
        })
    }

    fn next(&self) -> f64 {
        (self.searches + 1.0) * self.plan.interval
    }

    pub fn note(&mut self, particles: &[u32], is_driven: bool) {
        for &particle in particles {
            self.contacts[particle as usize] += 1;
            self.is_driven[particle as usize] |= is_driven;
        }
    }

    fn forget(&mut self, particle: u32) {
        (self.contacts[particle as usize], self.is_driven[particle as usize]) = (0, false);
    }

    /// Returns the grains that must fall asleep (true) or wake up (false) at a search.
    fn expected(&self, world: &World, states: &States) -> BTreeMap<u32, bool> {
        let plan = &self.plan;
        let moved = |i: u32| world.shortest(states.positions[i as usize] - self.places[i as usize]).norm();
        let mut disturbed = vec![false; states.positions.len()];
        for &i in world.moving.iter().filter(|&&i| moved(i) > plan.distance) {
            for (j, at) in (0..).zip(&states.positions).filter(|(j, _)| *j != i) {
                let apart = world.shortest(self.places[i as usize] - at).norm();
                disturbed[j as usize] |= world.touches(i, j, apart - plan.distance);
            }
        }
        let rests = |i: u32| {
            let k = i as usize;
            moved(i) <= plan.distance
                && f64::from(self.contacts[k]) >= self.fewest_contacts
                && states.velocities[k].norm() <= plan.wake_speed
                && world.accelerations[k] != Vector::zeros()
                && !self.is_driven[k]
                && !disturbed[k]
        };
        let asleep = world.asleep().filter(|&i| disturbed[i as usize]).map(|i| (i, false));
        world.moving.iter().copied().filter(|&i| rests(i)).map(|i| (i, true)).chain(asleep).collect()
    }

    fn search(&mut self, world: &World, states: &States) {
        self.searches += 1.0;
        self.is_known = true;
        for &i in &world.moving {
            self.places[i as usize] = states.positions[i as usize];
            self.forget(i);
        }
    }
}

impl Verifier {
    /// Proves that no grain had to fall asleep or wake up before a time.
    pub(super) fn pass_searches(&mut self, until: &Elapsed) -> Result<(), Fault> {
        while let Some(sleep) = &self.sleep
            && sleep.next() < until.total() - rounded(until.total())
        {
            let mut states = self.states.clone();
            let dt = sleep.next() - states.elapsed.total();
            for i in 0..states.positions.len() {
                let motion = (&states.positions[i], &states.velocities[i], &self.world.accelerations[i]);
                (states.positions[i], states.velocities[i]) = fly(motion.0, motion.1, motion.2, dt);
            }
            if let Some((&i, &sleeps)) = sleep.expected(&self.world, &states).iter().next()
                && sleep.is_known
            {
                return Err(missed(i, sleeps));
            }
            if let Some(sleep) = &mut self.sleep {
                sleep.search(&self.world, &states);
            }
        }
        Ok(())
    }

    /// Proves the events of a search: grains that fall asleep or wake up at the same time. They lead to the states
    /// `after`.
    fn witness_search(
        &mut self,
        events: &[Event],
        after: &States,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<(), Fault> {
        let count = self.states.positions.len();
        check_count(count, after)?;
        if let Some(event) = events.iter().find(|event| event.particle.0 as usize >= count || !is_sleep(event)) {
            return Err(Fault::Unknown { contact: Contact::of(event), distance: event.distance, state: 0 });
        }
        self.pass_searches(&after.elapsed)?;
        self.pass_to(&after.elapsed, None, watch)?;
        let found: BTreeMap<u32, bool> =
            events.iter().map(|event| (event.particle.0, event.kind == EventKind::Rest)).collect();
        let Some(sleep) = &self.sleep else { return Err(wrong(events[0].particle.0, found[&events[0].particle.0])) };
        let total = after.elapsed.total();
        if sleep.is_known {
            let expected = sleep.expected(&self.world, &self.before);
            let is_search = (sleep.next() - total).abs() <= rounded(total);
            if let Some((&i, &sleeps)) = found.iter().find(|&(i, sleeps)| !is_search || expected.get(i) != Some(sleeps))
            {
                return Err(wrong(i, sleeps));
            }
            if let Some((&i, &sleeps)) = expected.iter().find(|(i, _)| !found.contains_key(i)) {
                return Err(missed(i, sleeps));
            }
        }
        for event in events {
            self.check_sleep(event, after)?;
        }
        self.check_flights(after, |i| found.contains_key(&i))?;
        if let Some(sleep) = &mut self.sleep {
            sleep.search(&self.world, &self.before);
        }
        for (&i, &sleeps) in &found {
            if sleeps { self.world.fall_asleep(i) } else { self.wake(i) }
        }
        let changed: Vec<u32> = found.into_keys().collect();
        self.go_on(after, &changed, &changed)
    }

    /// Proves events that happened at the same time: a contact after the grains that it woke, or the events of a search.
    pub(super) fn witness_all(
        &mut self,
        events: &[Event],
        after: &States,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<(), Fault> {
        match events {
            [woken @ .., contact] if !is_sleep(contact) => {
                if let Some(sleep) = &mut self.sleep {
                    sleep.waking = woken.iter().map(|event| event.particle.0).collect();
                }
                self.witness_watched(contact, after, watch)
            }
            _ => self.witness_search(events, after, watch),
        }
    }

    /// Checks which grain a contact wakes, and wakes it.
    pub(super) fn wake_at(&mut self, contact: &Contact) -> Result<(), Fault> {
        let Some(sleep) = &mut self.sleep else { return Ok(()) };
        let found = std::mem::take(&mut sleep.waking);
        let limit = sleep.plan.wake_speed;
        let both: Vec<u32> = contact.particles().collect();
        let speed = both.iter().map(|&i| self.before.velocities[i as usize].norm()).fold(0.0, f64::max);
        // Before the first search, the number of contacts since the previous one is not known.
        let rattles = both.iter().any(|&i| f64::from(sleep.contacts[i as usize]) > sleep.most_contacts);
        let is_open = !sleep.is_known && speed <= limit;
        let wakes = speed > limit || rattles;
        let asleep = both.into_iter().filter(|&i| self.world.is_asleep(i));
        let expected: Vec<u32> = asleep.filter(|i| if is_open { found.contains(i) } else { wakes }).collect();
        if let Some(&i) = found.iter().find(|i| !expected.contains(i)) {
            return Err(wrong(i, false));
        }
        if let Some(&i) = expected.iter().find(|i| !found.contains(i)) {
            return Err(missed(i, false));
        }
        expected.into_iter().for_each(|i| self.wake(i));
        Ok(())
    }

    fn wake(&mut self, i: u32) {
        self.world.wake(i);
        if let Some(sleep) = &mut self.sleep {
            sleep.forget(i);
        }
    }

    /// Wakes all grains now, because gravity or the surfaces have changed.
    pub(super) fn wake_all(&mut self) {
        for i in self.world.asleep().collect::<Vec<_>>() {
            self.last_event[i as usize] = self.states.elapsed;
            self.wake(i);
        }
    }

    /// Checks the numbers of an event at which a grain falls asleep or wakes up.
    fn check_sleep(&self, event: &Event, after: &States) -> Result<(), Fault> {
        let i = event.particle.0 as usize;
        let contact = Contact::of(event);
        let flight = self.flight(event.particle.0);
        let inverse = |of: &[f64]| if of[i] > 0.0 { of[i].recip() } else { 0.0 };
        let (mass, inertia) = (inverse(&self.world.inverse_masses), inverse(&self.world.inverse_inertias));
        let sleeps = event.kind == EventKind::Rest;
        let velocity = if sleeps { self.before.velocities[i] } else { Vector::zeros() };
        let spin = self.before.spins.get(i).copied().filter(|_| sleeps).unwrap_or_default();
        let speed = flight.velocity();
        let energy = 0.5 * mass * velocity.norm_squared() + 0.5 * inertia * spin.norm_squared();
        let after_spin = after.spins.get(i).map_or(0.0, Vector::norm);
        for (quantity, by, bound) in [
            (Quantity::Velocity, (event.before[0] - velocity).norm(), speed),
            (Quantity::Velocity, after.velocities[i].norm() + event.after[0].norm() + after_spin, 0.0),
            (Quantity::Impulse, (event.impulse + velocity * mass).norm(), mass * (speed + rounded(velocity.norm()))),
            (Quantity::Torque, (event.torques[0] + spin * inertia).norm(), rounded(inertia * spin.norm())),
            (
                Quantity::Dissipation,
                (event.dissipated - energy).abs(),
                mass * velocity.norm() * speed + rounded(energy),
            ),
        ] {
            if by.is_nan() || by > bound {
                return Err(Fault::WrongNumbers { contact, quantity, by, bound });
            }
        }
        Ok(())
    }
}

pub(super) fn is_sleep(event: &Event) -> bool {
    matches!(event.kind, EventKind::Rest | EventKind::Wake)
}

fn wrong(i: u32, sleeps: bool) -> Fault {
    let particle = ParticleId(i);
    if sleeps { Fault::FellAsleep { particle } } else { Fault::WokeUp { particle } }
}

fn missed(i: u32, sleeps: bool) -> Fault {
    let particle = ParticleId(i);
    if sleeps { Fault::StayedAwake { particle } } else { Fault::StayedAsleep { particle } }
}
