//! Velocities from outside: kicks at random times, and scaling.

use serde::{Deserialize, Serialize};

use super::event_loop::Engine;
use crate::Vector;
use crate::engine::event::{CountedKind, Event, EventKind};
use crate::model::ParticleId;
use crate::model::random::{Purpose, Random};

/// Particles that get new velocities from a heat bath, one at a time.
///
/// Each gets one at a constant rate, so that the times between two of all are exponential.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Kicks {
    random: Random,
    /// Temperature `[energy]`.
    temperature: f64,
    /// Of all particles together `[1 / time]`.
    rate: f64,
    axes: [bool; 3],
    /// Time of the next one, since the epoch.
    pub next: f64,
}

impl Kicks {
    /// From `now` on, for a number of particles. `stage` tells the random numbers of one stage from those of another.
    pub fn new(seed: u64, stage: usize, now: f64, particles: usize, bath: Bath) -> Self {
        let random = Random::new(seed, Purpose::Thermostat, stage);
        let rate = bath.rate * particles as f64;
        let mut kicks = Self { random, temperature: bath.temperature, rate, axes: bath.axes, next: now };
        kicks.wait();
        kicks
    }

    /// Draws the time of the next one.
    fn wait(&mut self) {
        self.next += self.random.exponential() / self.rate;
    }
}

/// What gives the kicks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bath {
    /// Temperature `[energy]`.
    pub temperature: f64,
    /// Of each particle `[1 / time]`.
    pub rate: f64,
    /// Components that are drawn anew.
    pub axes: [bool; 3],
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// When the next kick comes, since the epoch; infinite for none.
    #[inline]
    pub(super) fn next_kick(&self) -> f64 {
        self.kicks.as_ref().map_or(f64::INFINITY, |kicks| kicks.next)
    }

    /// Gives one particle a new velocity.
    pub(super) fn kick(&mut self) -> Option<Event> {
        let mut kicks = self.kicks.take()?;
        let time = kicks.next;
        self.now = time;
        // By id, so that the order in memory decides nothing. There is one that moves, or there were no kicks.
        let particle = loop {
            let id = kicks.random.below(self.numbers.len());
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a scene has at most MOST_PARTICLES, by affordable of scene/limits.rs"
            )]
            let particle = self.number(ParticleId(id as u32));
            if !self.is_static(particle) {
                break particle;
            }
        };
        self.stream(particle, time);
        let inverse_mass = self.rules.species[usize::from(self.species[particle as usize])].inverse_mass;
        let width = (kicks.temperature * inverse_mass).sqrt();
        let before = self.bodies[particle as usize].velocity;
        let mut after = before;
        let streaming = self.streaming_velocity(&self.bodies[particle as usize].position);
        for axis in (0..3).filter(|&axis| kicks.axes[axis]) {
            after[axis] = streaming[axis] + width * kicks.random.normal();
        }
        kicks.wait();
        self.kicks = Some(kicks);
        let body = &mut self.bodies[particle as usize];
        body.velocity = after;
        body.events = body.events.wrapping_add(1);
        let position = body.position;
        self.note_confined_change(particle, &before);
        let gained = 0.5 / inverse_mass * (after - before).dot(&(after + before));
        self.tally.supplied.add(gained);
        self.tally.kick += 1;
        if TABLE {
            self.counts.note_single(usize::from(self.species[particle as usize]), CountedKind::Thermostat);
        }
        self.predict(particle, time);
        self.schedule(particle);
        let change = after - before;
        Some(Event {
            time: self.time(),
            kind: EventKind::Thermostat,
            particle: self.name(particle),
            partner: None,
            normal: change.try_normalize(0.0).unwrap_or_else(Vector::zeros),
            impulse: change.norm() / inverse_mass,
            distance: 0.0,
            energy_step: gained,
            dissipated: 0.0,
            positions: [position, Vector::zeros()],
            before: [before, Vector::zeros()],
            after: [after, Vector::zeros()],
        })
    }

    /// Starts or ends kicks.
    pub(super) fn set_bath(&mut self, bath: Option<Bath>, seed: u64, stage: usize) {
        let moving = self.particles().filter(|&particle| !self.is_static(particle)).count();
        let bath = bath.filter(|_| moving > 0);
        self.kicks = bath.map(|bath| Kicks::new(seed, stage, self.now, moving, bath));
        self.find_interlude();
    }

    /// Multiplies all velocities, relative to `drift` and to what streams, by a factor.
    pub(super) fn scale_velocities(&mut self, factor: f64, drift: &Vector) {
        for particle in self.particles().filter(|&p| !self.is_static(p)).collect::<Vec<_>>() {
            self.stream(particle, self.now);
            let inverse_mass = self.rules.species[usize::from(self.species[particle as usize])].inverse_mass;
            let body = self.bodies[particle as usize];
            let streaming = self.streaming_velocity(&body.position) + drift;
            let after = streaming + (body.velocity - streaming) * factor;
            self.tally.supplied.add(0.5 / inverse_mass * (after - body.velocity).dot(&(after + body.velocity)));
            self.bodies[particle as usize].velocity = after;
            self.note_confined_change(particle, &body.velocity);
        }
        self.start_anew();
    }

    /// Predicts everything anew, after all velocities have changed.
    pub(super) fn start_anew(&mut self) {
        for body in &mut self.bodies {
            body.events = body.events.wrapping_add(1);
        }
        self.queue.clear();
        for particle in self.particles() {
            if !self.is_static(particle) {
                self.predict(particle, self.now);
                self.schedule(particle);
            }
        }
    }
}
