//! Grains that fall asleep and wake up.

use std::cmp::Reverse;
use std::collections::VecDeque;

use ordered_float::OrderedFloat;

use super::{Candidate, Event, EventKind, Reference};
use crate::Vector;
use crate::base::numbers::id;
use crate::model::{ParticleId, Scene, Sleep, Species};

/// What decides which particles sleep.
#[derive(Debug)]
pub(super) struct Sleepers {
    plan: Sleep,
    fewest_contacts: f64,
    most_contacts: f64,
    /// For each particle, a static species of the same diameter.
    pub still: Vec<Species>,
    searches: u32,
    pub is_asleep: Vec<bool>,
    /// Places at the previous search; for sleeping particles, where they sleep.
    places: Vec<Vector>,
    /// Number of contacts since the previous search.
    contacts: Vec<u32>,
    /// Whether the particle has touched a surface whose material moves.
    is_driven: Vec<bool>,
    /// Events that have been executed, but not yet returned.
    pub executed: VecDeque<Event>,
}

impl Sleepers {
    pub fn of(scene: &Scene) -> Option<Self> {
        let (plan, contact_time) = (scene.sleep?, scene.contact_time?);
        let count = scene.particles.len();
        Some(Self {
            plan,
            fewest_contacts: plan.fewest_contacts(contact_time),
            most_contacts: plan.most_contacts(contact_time),
            still: scene.particles.iter().map(|particle| still(&scene.own_species(particle))).collect(),
            searches: 0,
            is_asleep: vec![false; count],
            places: scene.particles.iter().map(|particle| particle.position).collect(),
            contacts: vec![0; count],
            is_driven: vec![false; count],
            executed: VecDeque::new(),
        })
    }

    fn next(&self) -> f64 {
        f64::from(self.searches + 1) * self.plan.interval
    }

    pub fn meet_newcomer(&mut self, own: &Species, place: Vector) {
        self.still.push(still(own));
        self.is_asleep.push(false);
        self.places.push(place);
        self.contacts.push(0);
        self.is_driven.push(false);
    }
}

/// A static species of the same diameter.
fn still(own: &Species) -> Species {
    Species::new(&own.name, f64::INFINITY, own.diameter)
}

impl Reference {
    pub(super) fn schedule_search(&mut self) {
        if let Some(sleepers) = &self.sleepers {
            self.queue.push(Candidate::Rest, Reverse((OrderedFloat(sleepers.next()), Candidate::Rest)));
        }
    }

    pub(super) fn note_contact(&mut self, i: u32, is_driven: bool) {
        if let Some(sleepers) = &mut self.sleepers {
            sleepers.contacts[i as usize] += 1;
            sleepers.is_driven[i as usize] |= is_driven;
        }
    }

    pub(super) fn is_asleep(&self, i: u32) -> bool {
        self.sleepers.as_ref().is_some_and(|sleepers| sleepers.is_asleep[i as usize])
    }

    /// Wakes a particle that is hit by a fast one, or by one that rattles in a narrow gap.
    pub(super) fn wake_if_hit(&mut self, i: u32, j: u32) {
        let Some(sleepers) = &self.sleepers else { return };
        for (sleeping, hits) in [(i, j), (j, i)] {
            let is_fast = self.velocities[hits as usize].norm() > sleepers.plan.wake_speed;
            let rattles = f64::from(sleepers.contacts[hits as usize]) > sleepers.most_contacts;
            if self.is_asleep(sleeping) && (is_fast || rattles) {
                return self.wake(sleeping);
            }
        }
    }

    /// Returns the neighbours of a particle at its place of the previous search: particles whose surfaces were at most the
    /// distance of the plan away.
    fn touching(&self, i: u32, sleepers: &Sleepers) -> Vec<u32> {
        let touches = |&j: &u32| {
            let [a, b] = [i, j].map(|p| self.scene.particles[p as usize].species.0 as usize);
            let Some(interaction) = self.scene.table.get(a, b).filter(|_| j != i && self.is_present[j as usize]) else {
                return false;
            };
            let range = self.interaction(interaction, [i, j]).potential.range();
            let apart = self.nearest(sleepers.places[i as usize] - self.positions[j as usize]);
            apart.norm() <= range + sleepers.plan.distance
        };
        (0..id(self.positions.len())).filter(touches).collect()
    }

    /// Searches for particles at rest, and for sleeping particles that have lost a neighbour.
    pub(super) fn search_for_rest(&mut self) {
        let Some(sleepers) = &self.sleepers else { return };
        let count = self.positions.len();
        let plan = sleepers.plan;
        let (mut rests, mut is_disturbed) = (vec![false; count], vec![false; count]);
        let moving = (0..id(count)).filter(|&i| self.is_present[i as usize] && !self.species(i).is_static());
        let awake: Vec<u32> = moving.collect();
        for &i in &awake {
            let k = i as usize;
            if self.nearest(self.positions[k] - sleepers.places[k]).norm() > plan.distance {
                self.touching(i, sleepers).into_iter().for_each(|j| is_disturbed[j as usize] = true);
            } else {
                rests[k] = f64::from(sleepers.contacts[k]) >= sleepers.fewest_contacts
                    && self.velocities[k].norm() <= plan.wake_speed
                    && self.species(i).acceleration != Vector::zeros()
                    && !sleepers.is_driven[k];
            }
        }
        if let Some(sleepers) = &mut self.sleepers {
            sleepers.searches += 1;
            for k in awake.iter().map(|&i| i as usize) {
                (sleepers.places[k], sleepers.contacts[k], sleepers.is_driven[k]) = (self.positions[k], 0, false);
            }
        }
        for i in 0..id(count) {
            let k = i as usize;
            match self.is_asleep(i) {
                true if is_disturbed[k] => self.wake(i),
                false if rests[k] && !is_disturbed[k] => self.fall_asleep(i),
                _ => {}
            }
        }
        self.schedule_search();
    }

    /// Wakes the neighbours of a particle that leaves.
    pub(super) fn wake_neighbours(&mut self, i: u32) {
        let Some(sleepers) = &self.sleepers else { return };
        let touching = self.touching(i, sleepers);
        touching.into_iter().filter(|&j| self.is_asleep(j)).collect::<Vec<_>>().into_iter().for_each(|j| self.wake(j));
    }

    fn fall_asleep(&mut self, i: u32) {
        let (velocity, spin) = (self.velocities[i as usize], self.spins[i as usize]);
        let turned = self.angular_momentum(i, &spin);
        let dissipated = 0.5 * self.species(i).mass * velocity.norm_squared() + 0.5 * spin.dot(&turned);
        (self.velocities[i as usize], self.spins[i as usize]) = (Vector::zeros(), Vector::zeros());
        self.change_sleep(i, true);
        self.queue.retain(|candidate, _| {
            !matches!(*candidate, Candidate::Wall(p, ..) | Candidate::Surface(p, _) | Candidate::SearchAgain(p) if p == i)
        });
        self.note_sleep(i, EventKind::Rest, [-turned, velocity], dissipated);
    }

    fn wake(&mut self, i: u32) {
        self.change_sleep(i, false);
        if let Some(sleepers) = &mut self.sleepers {
            (sleepers.contacts[i as usize], sleepers.is_driven[i as usize]) = (0, false);
        }
        self.note_sleep(i, EventKind::Wake, [Vector::zeros(); 2], 0.0);
    }

    fn change_sleep(&mut self, i: u32, is_asleep: bool) {
        if let Some(sleepers) = &mut self.sleepers {
            sleepers.is_asleep[i as usize] = is_asleep;
        }
    }

    fn note_sleep(&mut self, i: u32, kind: EventKind, [torque, velocity]: [Vector; 2], dissipated: f64) {
        self.predict(i);
        let zero = Vector::zeros();
        let event = Event {
            time: self.time(),
            kind,
            particle: ParticleId(i),
            partner: None,
            normal: zero,
            impulse: 0.0,
            torques: [torque, zero],
            energy_step: 0.0,
            dissipated,
            before: [velocity, zero],
            after: [zero; 2],
        };
        if let Some(sleepers) = &mut self.sleepers {
            sleepers.executed.push_back(event);
        }
    }
}
