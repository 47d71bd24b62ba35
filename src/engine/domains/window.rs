//! One window of a domain: runs its steps, and records them for a rollback and for the comparison.

use super::domain::{Domain, Touched};
use super::exchange::{Step, hash};
use super::regions::Regions;
use crate::base::numbers::id;
use crate::engine::event::Event;
use crate::engine::event_loop::Next;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::look_ahead::SELF;
use crate::engine::neighbours::Place;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::prediction::{Prediction, id_of};
use crate::engine::progress::Seen;
use crate::engine::sources::andersen::Collision;
use std::ops::ControlFlow;

/// Largest number of steps of a domain in a window. It limits the memory for a rollback.
const LONGEST_WINDOW: u64 = 100_000;

impl<const FALLING: bool, const TABLE: bool> Domain<FALLING, TABLE> {
    /// Runs this domain alone, up to and including the time `stop`.
    pub fn run(&mut self, regions: &Regions, stop: f64, is_observed: bool) {
        while self.trouble.is_none() {
            let entry = match self.engine.next_due(stop) {
                Next::Particle(entry) => Some(entry),
                Next::Void => {
                    self.engine.schedule.queue.discard();
                    continue;
                }
                // A window never extends beyond its epoch. Domains have no global events.
                Next::Stop | Next::Epoch | Next::GlobalEvent => None,
            };
            let next = entry.map_or(f64::INFINITY, |entry| entry.time);
            if let Some((particle, collision)) = self.collisions.pop_if(|(_, collision)| collision.time < next) {
                self.meet_bath(regions, particle, &collision, is_observed);
                continue;
            }
            let Some(entry) = entry else { break };
            if self.engine.hardware.looks_ahead {
                self.prefetch_held();
            }
            self.engine.schedule.queue.pop();
            self.engine.clock.now = entry.time;
            if self.owned.has(entry.particle) {
                self.tally.done += 1;
                self.tally.latest = entry.time;
            }
            self.tally.done_in_all += 1;
            if self.tally.done_in_all > LONGEST_WINDOW {
                self.trouble = Some(entry.time);
            }
            let prediction = self.engine.schedule.predictions[entry.particle as usize];
            if prediction.is_transition() {
                self.transition(regions, entry.particle, entry.time);
            } else {
                self.contact(regions, entry.particle, &prediction, is_observed);
            }
        }
        self.moved.sort_unstable();
        self.moved.dedup();
    }

    fn transition(&mut self, regions: &Regions, particle: u32, time: f64) {
        let before = regions.columns(&self.engine, particle);
        let is_done = self.log.execute_transition(&mut self.engine, particle, time);
        let after = regions.columns(&self.engine, particle);
        let is_shared = self.shared.has(particle);
        if self.owned.has(particle) {
            self.tally.times.quiet.push(time);
            if regions.holders(after) != regions.holders(before) || regions.owner(after) != self.number {
                self.moved.push(particle);
            }
            // Reads `held` for shared particles only, because it is rarely in the cache.
            let known_to = if is_shared { self.held[particle as usize].known_to } else { self.bit };
            let unknown = regions.readers(after) & !known_to;
            if regions.near(after) & self.bit == 0 || unknown != 0 {
                self.trouble = Some(time);
            }
        } else {
            self.engine.counts.totals.transition -= 1;
        }
        if !is_done {
            self.trouble = Some(time);
        }
        if is_shared {
            let place = match self.engine.neighbours.place(particle) {
                Place::Cell(cell) => u64::from(cell),
                Place::Centre(centre) => hash(1, <[f64; 3]>::from(centre).map(f64::to_bits)),
            };
            let [x, y, z] = self.engine.state.images.of(particle).map(|image| u64::from(image.cast_unsigned()));
            let hash = hash(2, [time.to_bits(), place, x, y, z]);
            self.note(particle, Some(hash), time, regions.readers(before) | regions.readers(after));
        }
    }

    fn contact(&mut self, regions: &Regions, particle: u32, prediction: &Prediction, is_observed: bool) {
        let time = self.engine.clock.now;
        let partner = prediction.partner_in_contact();
        if self.engine.is_void(prediction) {
            self.log.contact(&self.engine, particle, self.is_plain);
            self.engine.repredict(particle, time);
            if self.shared.has(particle) {
                self.note(particle, None, time, 0);
            }
            return;
        }
        if let Some(partner) = partner {
            self.log.contact(&self.engine, partner, self.is_plain);
        }
        self.log.contact(&self.engine, particle, self.is_plain);
        let first = match partner {
            Some(partner) if self.engine.id(partner) < self.engine.id(particle) => partner,
            _ => particle,
        };
        let executed =
            self.counting(first, is_observed, |engine, observe| engine.execute_contact(particle, prediction, observe));
        let has_lost_speed = self.engine.clock.standstill.lost_speed.take().is_some();
        if has_lost_speed || !matches!(executed, Ok(Some(_))) {
            self.trouble = Some(time);
            return;
        }
        if self.owned.has(first) {
            self.tally.times.event(time);
        }
        self.note_contact(regions, particle, partner, time);
        if let Some(partner) = partner {
            self.note_contact(regions, partner, Some(particle), time);
        }
    }

    /// Executes an event. Only the domain that owns the particle counts and observes the event.
    #[inline(always)]
    fn counting<R>(
        &mut self,
        particle: u32,
        is_observed: bool,
        execute: impl FnOnce(&mut Engine<FALLING, TABLE>, &mut Observe<'_>) -> R,
    ) -> R {
        let is_counted = self.owned.has(particle);
        if !is_counted {
            std::mem::swap(&mut self.engine.counts, &mut self.elsewhere);
        }
        let (events, time) = (&mut self.tally.events, self.engine.clock.now);
        let mut see = |event: &Event| {
            events.push(Seen { time, event: *event });
            ControlFlow::Continue(())
        };
        let mut observe: Observe<'_> = if is_observed && is_counted { Some(&mut see) } else { None };
        let executed = execute(&mut self.engine, &mut observe);
        if !is_counted {
            std::mem::swap(&mut self.engine.counts, &mut self.elsewhere);
        }
        executed
    }

    #[cold]
    fn meet_bath(&mut self, regions: &Regions, particle: u32, collision: &Collision, is_observed: bool) {
        self.log.contact(&self.engine, particle, self.is_plain);
        (self.engine.clock.now, self.tally.latest) = (collision.time, collision.time);
        let _ = self.counting(particle, is_observed, |engine, observe| engine.collide(particle, collision, observe));
        self.engine.repredict(particle, collision.time);
        self.note_contact(regions, particle, None, collision.time);
    }

    #[inline]
    pub fn note_contact(&mut self, regions: &Regions, particle: u32, other: Option<u32>, time: f64) {
        if !self.shared.has(particle) || self.engine.is_static(particle) {
            return;
        }
        let body = &self.engine.state.bodies[particle as usize];
        let [[x, y, z], [u, v, w]] =
            [body.position, body.velocity].map(|vector| <[f64; 3]>::from(vector).map(f64::to_bits));
        let with = other.map_or(u64::MAX, |other| {
            u64::from(self.engine.pair_state(particle, other).0) << 32 | u64::from(self.engine.id(other).0)
        });
        let mut hash_of_step = hash(3, [time.to_bits(), with, x, y, z, u, v, w]);
        // Spins can differ although velocities are equal: an impulse is rounded when it is added.
        if let Some(spin) = self.engine.state.spins.get(particle as usize) {
            hash_of_step = hash(hash_of_step, <[f64; 3]>::from(*spin).map(f64::to_bits));
        }
        self.note(particle, Some(hash_of_step), time, regions.readers(regions.columns(&self.engine, particle)));
    }

    #[inline]
    fn prefetch_held(&self) {
        if let Some((particle, prediction)) = self.engine.coming(SELF) {
            for particle in [particle, prediction.partner] {
                if particle != NO_PARTICLE && self.shared.has(particle) {
                    prefetch(&self.held, particle as usize);
                }
            }
        }
    }

    /// Records a step of a shared particle. `hash_of_step` is `None` if the step changes nothing for other domains.
    #[inline]
    pub fn note(&mut self, particle: u32, hash_of_step: Option<u64>, time: f64, readers: u64) {
        let prediction = self.engine.schedule.predictions[particle as usize];
        let partner = match prediction.partner {
            NO_PARTICLE => u64::MAX,
            partner => u64::from(id_of(partner, &self.engine.state.bodies)),
        };
        let (is_void, of_step) = (hash_of_step.is_none(), hash_of_step.unwrap_or_default());
        let due = [prediction.contact_time, prediction.transition_time].map(f64::to_bits);
        let at = self.touch(particle).unwrap_or_else(|| {
            let held = &mut self.held[particle as usize];
            held.touch = id(self.touched.len());
            self.touched.push(Touched { particle, held: *held, digest: 0 });
            self.touched.len() - 1
        });
        let Touched { held, digest, .. } = &mut self.touched[at];
        *digest = hash(*digest, [of_step, due[0], due[1], partner << 32 | u64::from(prediction.partner_version)]);
        let step = Step { particle, is_void, time, hash: of_step, readers };
        if held.is_owned() {
            self.steps.push(step);
        } else {
            self.steps_of_copies.push((held.owner, Step { particle: held.whole, ..step }));
        }
    }
}
