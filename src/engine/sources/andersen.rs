//! The Andersen thermostat: collisions with particles of a heat bath at random times (Andersen, J. Chem.
//! Phys. 72, 2384, 1980).

use serde::{Deserialize, Serialize};

use super::Repredict;
use crate::engine::contact::apply::{Change, With};
use crate::engine::event::CountedKind;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::{Invariant, InvariantBroken};
use crate::model::random::{Purpose, Random};
use crate::model::space::Boundary;
use crate::model::state_point::StatePoint;
use std::ops::ControlFlow;

/// A heat bath. Each particle collides with the bath at a constant rate. A collision gives the particle a new velocity.
/// The intervals between collisions of the whole system have an exponential distribution.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct Andersen {
    random: Random,
    bath: Bath,
    /// Total collision rate of all mobile particles `[1 / time]`.
    rate: f64,
    /// Time of the next collision, since the epoch.
    next: f64,
}

impl Andersen {
    /// Creates a heat bath that acts from the time `now` on. Each stage of a run has its own random numbers.
    pub fn new(seed: u64, stage: usize, now: f64, particles: usize, bath: Bath) -> Self {
        let seed = StatePoint::new(seed).with(&[bath.temperature, bath.rate]);
        let random = Random::new(seed.number(), Purpose::Thermostat, stage);
        let mut andersen = Self { random, bath, rate: 0.0, next: now };
        andersen.act_on(particles, now);
        andersen
    }

    /// Sets the number of mobile particles, and draws a new time for the next collision. The result has the right
    /// distribution, because a Poisson process has no memory.
    pub fn act_on(&mut self, particles: usize, now: f64) {
        self.rate = self.bath.rate * particles as f64;
        self.next = now;
        self.wait();
    }

    pub fn bath(&self) -> Bath {
        self.bath
    }

    #[inline]
    pub fn next_collision(&self) -> f64 {
        self.next
    }

    pub fn shift(&mut self, shift: f64) {
        self.next -= shift;
    }

    fn wait(&mut self) {
        self.next += if self.rate > 0.0 { self.random.exponential() / self.rate } else { f64::INFINITY };
    }

    /// Draws the next collision and the time of the following collision. The loop ends, because a particle is mobile.
    fn draw(&mut self, ids: usize, is_moving: impl Fn(usize) -> bool) -> Collision {
        let time = self.next;
        let id = loop {
            let id = self.random.below(ids);
            if is_moving(id) {
                break id;
            }
        };
        let normal = std::array::from_fn(|axis| self.bath.axes[axis].then(|| self.random.normal()));
        self.wait();
        Collision { time, id, temperature: self.bath.temperature, normal }
    }
}

#[derive(Debug, Clone, Copy)]
pub(in crate::engine) struct Collision {
    pub time: f64,
    pub id: usize,
    temperature: f64,
    /// A normally distributed random number for each axis. `None` if the velocity along the axis does not change.
    normal: [Option<f64>; 3],
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Bath {
    /// Temperature `[energy]`.
    pub temperature: f64,
    /// Collision rate of each particle `[1 / time]`.
    pub rate: f64,
    pub axes: [bool; 3],
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub(in crate::engine) fn andersen_collision(
        &mut self,
        observe: &mut Observe<'_>,
    ) -> Result<(Repredict, ControlFlow<()>), InvariantBroken> {
        // Particles that have left must not be drawn.
        self.close_gaps();
        let Some(mut bath) = self.sources.andersen.take() else {
            return Err(self.broken(0, None, Invariant::GlobalEvent));
        };
        let collision = self.draw_collision(&mut bath);
        self.sources.andersen = Some(bath);
        self.clock.now = collision.time;
        // Ids do not depend on the order in memory.
        let particle = self.state.numbers[collision.id];
        let flow = self.collide(particle, &collision, observe);
        Ok((Repredict::One(particle), flow))
    }

    /// Draws the next collisions with a bath, up to and including the time `stop`.
    pub(in crate::engine) fn collisions_until(&self, bath: &mut Option<Andersen>, stop: f64) -> Vec<Collision> {
        let mut collisions = Vec::new();
        while let Some(bath) = bath.as_mut().filter(|bath| bath.next <= stop) {
            collisions.push(self.draw_collision(bath));
        }
        collisions
    }

    /// Sets the bath after its next collisions have been drawn elsewhere.
    pub(in crate::engine) fn put_bath(&mut self, bath: Option<Andersen>) {
        self.sources.andersen = bath;
        self.schedule_global();
    }

    fn draw_collision(&self, bath: &mut Andersen) -> Collision {
        let numbers = &self.state.numbers;
        bath.draw(numbers.len(), |id| !self.is_static(numbers[id]))
    }

    pub(in crate::engine) fn collide(
        &mut self,
        particle: u32,
        collision: &Collision,
        observe: &mut Observe<'_>,
    ) -> ControlFlow<()> {
        self.stream(particle, collision.time);
        let inverse_mass = self.inverse_mass(particle);
        let width = (collision.temperature * inverse_mass).sqrt();
        let before = self.state.bodies[particle as usize].velocity;
        let streaming = self.streaming_velocity(&self.state.bodies[particle as usize].position);
        let mut after = before;
        for axis in 0..3 {
            if let Some(normal) = collision.normal[axis] {
                after[axis] = streaming[axis] + width * normal;
            }
        }
        let change = Change::of_one(With::Bath, particle, &before, after, inverse_mass);
        self.apply(&Change { counted: Some(CountedKind::Thermostat), ..change }, observe)
    }

    pub(in crate::engine) fn set_bath(&mut self, bath: Option<Bath>, seed: u64, stage: usize) {
        self.join();
        let moving = self.state.moving;
        let boundary = self.state.space.boundary;
        let bath = bath.map(|bath| Bath {
            axes: std::array::from_fn(|axis| bath.axes[axis] && boundary[axis] != Boundary::Flat),
            ..bath
        });
        let may_act = moving > 0 || self.sources.inlets.is_some();
        let bath = bath.filter(|bath| may_act && bath.axes.contains(&true));
        self.sources.andersen = bath.map(|bath| Andersen::new(seed, stage, self.clock.now, moving, bath));
        self.schedule_global();
    }
}
