//! The reference engine: the paper as it is printed, for checking and for reading.
//!
//! All pairs are predicted by Algorithm 1, on whatever overlap function they have. There are no cells, no delayed states
//! and no discarded predictions: after each event every particle is moved to its time, and every prediction of the two
//! particles is made anew. The cost grows with the square of the number of particles; use it for some hundreds.
//!
//! ```
//! use carom::{Vector, check::reference::Reference, model::Potential, model::space::{Boundary, Space}, scene::SceneBuilder};
//!
//! let scene = SceneBuilder::new("head-on")
//!     .species("A", 1.0, 1.0)
//!     .interaction("A", "A", Potential::hard_sphere(1.0)?, 1.0)
//!     .space(Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(8.0) })
//!     .particle("A", Vector::new(0.0, 0.0, 0.0), Vector::new(1.0, 0.0, 0.0))
//!     .particle("A", Vector::new(3.0, 0.0, 0.0), Vector::new(-1.0, 0.0, 0.0))
//!     .build()?;
//! let mut reference = Reference::new(&scene);
//! assert_eq!(reference.step_before(10.0).map(|event| event.time), Some(1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod algorithm_1;

pub use algorithm_1::{Polynomial, next_event};

use crate::Vector;
use crate::base::numbers::id;
use crate::engine::event::{Event, EventKind};
use crate::engine::pairs::contacts::ContactTimes;
use crate::engine::pairs::rules::{Discontinuity, Rules, Steps};
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Face};
use crate::model::{InteractionId, ParticleId, Scene};
use crate::physics::motion::{RelativeState, stream_position};
use crate::physics::overlap::{Quartic, Side};
use crate::physics::response::{Approach, Leaving, Outcome, respond, tc_contact};
use ordered_float::OrderedFloat;
use priority_queue::PriorityQueue;
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Something that may happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Candidate {
    /// A pair reaches one of its discontinuities; 0 is the positive side, 1 the negative.
    Pair(u32, u32, u8),
    /// A pair has moved so far that other periodic images may be nearer: look again.
    LookAgain(u32, u32),
    /// A particle reaches a wall: axis, and 1 for the upper one.
    Wall(u32, u8, u8),
}

/// A simulation of all pairs by Algorithm 1.
#[derive(Debug)]
pub struct Reference {
    rules: Rules,
    boundary: [Boundary; 3],
    lower: Vector,
    size: Vector,
    contact_times: Option<ContactTimes>,
    species: Vec<usize>,
    /// Interaction and state of every pair that interacts, by `(i, j)` with `i < j`.
    pairs: BTreeMap<(u32, u32), (InteractionId, u16)>,
    start: f64,
    time: f64,
    positions: Vec<Vector>,
    velocities: Vec<Vector>,
    queue: PriorityQueue<Candidate, Reverse<(OrderedFloat<f64>, Candidate)>>,
}

impl Reference {
    /// Predicts every pair of a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let count = scene.particles.len();
        let rules = Rules::new(scene);
        let species: Vec<usize> = scene.particles.iter().map(|p| p.species.0 as usize).collect();
        let mut reference = Self {
            boundary: scene.space.boundary,
            lower: scene.space.lower,
            size: scene.space.size,
            contact_times: scene.contact_time.map(|contact_time| ContactTimes::new(contact_time, count)),
            pairs: BTreeMap::new(),
            start: scene.start_time,
            time: 0.0,
            positions: scene.particles.iter().map(|p| p.position).collect(),
            velocities: scene.particles.iter().map(|p| p.velocity).collect(),
            queue: PriorityQueue::new(),
            rules,
            species,
        };
        let bonds: BTreeMap<_, _> = scene.bonds.iter().map(|b| ((b.pair[0].0, b.pair[1].0), b.interaction)).collect();
        for i in 0..id(count) {
            for j in i + 1..id(count) {
                if reference.is_static(i) && reference.is_static(j) {
                    continue;
                }
                let of_species =
                    scene.interaction_of(scene.particles[i as usize].species, scene.particles[j as usize].species);
                if let Some(id) = bonds.get(&(i, j)).copied().or(of_species) {
                    let state = reference.first_state(&scene.interactions[id.0 as usize].potential, i, j);
                    reference.pairs.insert((i, j), (id, u16::try_from(state).unwrap_or(u16::MAX)));
                }
            }
        }
        for i in 0..id(count) {
            reference.predict(i);
        }
        reference
    }

    /// The state of a pair at the start: how many radii it is inside of. Of one that it is at, but for 32 roundings of the coordinates, it is on the side
    /// that it moves into.
    fn first_state(&self, potential: &Potential, i: u32, j: u32) -> usize {
        let (apart, [i, j]) = (self.nearest_image(i, j), [i as usize, j as usize]);
        let (distance, radial) = (apart.norm(), apart.dot(&(self.velocities[i] - self.velocities[j])));
        let periods = (0..3).filter(|&k| self.boundary[k] == Boundary::Periodic).map(|k| self.size[k]);
        let largest = periods.fold(self.positions[i].amax().max(self.positions[j].amax()), f64::max);
        let is_at = |radius: f64| (distance - radius).abs() <= 32.0 * f64::EPSILON * largest;
        let is_inside = |radius: &f64| if is_at(*radius) && radial != 0.0 { radial < 0.0 } else { distance < *radius };
        let states = potential.accessible_states();
        let inside = potential.radii().iter().filter(|radius| is_inside(radius)).count();
        inside.clamp(*states.start(), *states.end())
    }

    /// Simulated time now `[time]`.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.start + self.time
    }

    /// Positions now; along periodic axes unwrapped.
    #[must_use]
    pub fn positions(&self) -> &[Vector] {
        &self.positions
    }

    /// Velocities now.
    #[must_use]
    pub fn velocities(&self) -> &[Vector] {
        &self.velocities
    }

    /// Executes the next event, if there is one before a simulated time; otherwise moves all particles to that time.
    pub fn step_before(&mut self, limit: f64) -> Option<Event> {
        let limit = limit - self.start;
        loop {
            let next = self.queue.peek().map(|(candidate, Reverse((time, _)))| (*candidate, time.0));
            let Some((candidate, time)) = next.filter(|(_, time)| *time < limit) else {
                if limit.is_finite() {
                    self.stream(limit);
                }
                return None;
            };
            self.queue.pop();
            self.stream(time);
            match candidate {
                Candidate::LookAgain(i, j) => self.predict_pair(i, j),
                Candidate::Pair(i, j, side) => {
                    let side = if side == 0 { Side::Positive } else { Side::Negative };
                    let event = self.execute_pair(i, j, side)?;
                    self.predict(i);
                    self.predict(j);
                    return Some(event);
                }
                Candidate::Wall(i, axis, upper) => {
                    let event = self.execute_wall(i, axis, upper == 1);
                    self.predict(i);
                    return Some(event);
                }
            }
        }
    }

    fn is_static(&self, i: u32) -> bool {
        self.rules.species[self.species[i as usize]].is_static()
    }

    fn acceleration(&self, i: u32) -> Vector {
        self.rules.species[self.species[i as usize]].acceleration
    }

    fn steps(&self, pair: (InteractionId, u16)) -> &Steps {
        &self.rules.steps[pair.0.0 as usize]
    }

    /// Moves every particle to `time`.
    fn stream(&mut self, time: f64) {
        let dt = time - self.time;
        for i in 0..self.positions.len() {
            let acceleration = self.rules.species[self.species[i]].acceleration;
            self.positions[i] = stream_position(&self.positions[i], &self.velocities[i], &acceleration, dt);
            self.velocities[i] += acceleration * dt;
        }
        self.time = time;
    }

    fn nearest_image(&self, i: u32, j: u32) -> Vector {
        let apart = self.positions[i as usize] - self.positions[j as usize];
        Vector::from_fn(|k, _| match self.boundary[k] {
            Boundary::Periodic => apart[k] - self.size[k] * (apart[k] / self.size[k]).round(),
            _ => apart[k],
        })
    }

    /// Predicts everything about a particle anew.
    fn predict(&mut self, i: u32) {
        for j in (0..id(self.positions.len())).filter(|&j| j != i) {
            self.predict_pair(i.min(j), i.max(j));
        }
        if !self.is_static(i) {
            self.predict_walls(i);
        }
    }

    /// Predicts a pair in its nearest image and the ones around it, as far ahead as no other image can come near.
    fn predict_pair(&mut self, i: u32, j: u32) {
        let Some(&pair) = self.pairs.get(&(i, j)) else { return };
        let nearest = self.nearest_image(i, j);
        let velocity = self.velocities[i as usize] - self.velocities[j as usize];
        let acceleration = self.acceleration(i) - self.acceleration(j);
        let horizon = self.horizon(&velocity, &acceleration);
        for (number, side) in [(0, Side::Positive), (1, Side::Negative)] {
            let mut first = None;
            if let Some(seen) = self.steps(pair).seen_from(pair.1, side) {
                // A pair inside of a discontinuity only knows its nearest image.
                let images = if side == Side::Positive { self.images() } else { vec![Vector::zeros()] };
                for image in images {
                    let state = RelativeState { position: nearest + image, velocity };
                    let f = Polynomial::overlap(&Quartic::new(&state, &acceleration, seen.squared), side);
                    if let Some(dt) = next_event(&f).filter(|dt| *dt <= horizon) {
                        first = Some(first.map_or(dt, |earlier: f64| earlier.min(dt)));
                    }
                }
            }
            self.put(Candidate::Pair(i, j, number), first);
        }
        self.put(Candidate::LookAgain(i, j), horizon.is_finite().then_some(horizon));
    }

    /// For how long a pair moves by less than half a period.
    fn horizon(&self, velocity: &Vector, acceleration: &Vector) -> f64 {
        let shortest = (0..3)
            .filter(|&k| self.boundary[k] == Boundary::Periodic)
            .map(|k| 0.5 * self.size[k])
            .fold(f64::INFINITY, f64::min);
        let (v, a) = (velocity.norm(), acceleration.norm());
        if shortest == f64::INFINITY || (v == 0.0 && a == 0.0) {
            return f64::INFINITY;
        }
        // v t + a t^2 / 2 = shortest
        2.0 * shortest / (v + (v * v + 2.0 * a * shortest).sqrt())
    }

    fn images(&self) -> Vec<Vector> {
        let mut images = vec![Vector::zeros()];
        for k in (0..3).filter(|&k| self.boundary[k] == Boundary::Periodic) {
            let mut shift = Vector::zeros();
            shift[k] = self.size[k];
            images = images.iter().flat_map(|image| [image - shift, *image, image + shift]).collect();
        }
        images
    }

    fn predict_walls(&mut self, i: u32) {
        for axis in 0..3_u8 {
            for (upper, height, inwards) in self.wall_heights(i, usize::from(axis)) {
                let f = Polynomial::new(&[
                    height,
                    inwards * self.velocities[i as usize][usize::from(axis)],
                    0.5 * inwards * self.acceleration(i)[usize::from(axis)],
                ]);
                let dt = next_event(&f);
                self.put(Candidate::Wall(i, axis, upper), dt);
            }
        }
    }

    /// The walls of an axis: which, the particle's height above contact, and the direction away from it.
    fn wall_heights(&self, i: u32, axis: usize) -> Vec<(u8, f64, f64)> {
        let Boundary::Bounded { lower, upper } = self.boundary[axis] else { return Vec::new() };
        let radius = self.rules.species[self.species[i as usize]].radius;
        let at = self.positions[i as usize][axis];
        let is_wall = |face| matches!(face, Face::Wall { .. });
        let (low, high) = (self.lower[axis], self.lower[axis] + self.size[axis]);
        let mut walls = Vec::new();
        if is_wall(lower) {
            walls.push((0, at - low - radius, 1.0));
        }
        if is_wall(upper) {
            walls.push((1, high - at - radius, -1.0));
        }
        walls
    }

    fn put(&mut self, candidate: Candidate, dt: Option<f64>) {
        match dt {
            Some(dt) => drop(self.queue.push(candidate, Reverse((OrderedFloat(self.time + dt), candidate)))),
            None => drop(self.queue.remove(&candidate)),
        }
    }

    fn execute_pair(&mut self, i: u32, j: u32, side: Side) -> Option<Event> {
        let (id, state) = *self.pairs.get(&(i, j))?;
        let Discontinuity { distance: s, energy_step, .. } = self.steps((id, state)).seen_from(state, side)?;
        let restitution = self.steps((id, state)).restitution;
        let apart = self.nearest_image(i, j);
        let normal = apart.try_normalize(0.0).unwrap_or(Vector::x());
        let velocity = self.velocities[i as usize] - self.velocities[j as usize];
        let vn = velocity.dot(&normal);
        let before = [i, j].map(|p| self.velocities[p as usize]);
        let weight = |p: u32| self.rules.species[self.species[p as usize]].inverse_mass;
        let (wi, wj) = (weight(i), weight(j));
        let mu = 1.0 / (wi + wj);
        let response =
            respond(side, energy_step, &Approach { radial: vn, squared: 1.0, reduced_mass: mu }, restitution);
        let mut leaving_vn = response.radial;
        let mut tangential = velocity - normal * vn;
        if energy_step == f64::INFINITY {
            let closing = -side.sign()
                * ((self.acceleration(i) - self.acceleration(j)).dot(&normal)
                    + tangential.norm_squared() / apart.norm());
            let approach = (-side.sign() * vn).max(0.0);
            // As a wall, a static particle has no contact of its own.
            let moving: Vec<u32> = [i, j].into_iter().filter(|&particle| !self.is_static(particle)).collect();
            if let Some(leaving) = self.tc_model(&moving, restitution, approach, tangential.norm(), closing) {
                leaving_vn = side.sign() * if leaving.speed == approach { vn.abs() } else { leaving.speed };
                tangential *= leaving.tangential_scale;
            }
        }
        let after = normal * leaving_vn + tangential;
        // Shares that add up to 1: those rounded one by one would change the restitution, in every event by the same amount.
        let less = (after - velocity) * (wi.min(wj) / (wi + wj));
        let more = (after - velocity) - less;
        let (of_i, of_j) = if wi < wj { (less, more) } else { (more, less) };
        self.velocities[i as usize] += of_i;
        self.velocities[j as usize] -= of_j;
        let next = match response.outcome {
            Outcome::Capture => state + 1,
            Outcome::Release => state - 1,
            Outcome::Core | Outcome::Bounce => state,
        };
        self.pairs.insert((i, j), (id, next));
        let steps_over = next != state;
        Some(Event {
            time: self.time(),
            kind: EventKind::Pair(response.outcome),
            particle: ParticleId(i),
            partner: Some(ParticleId(j)),
            normal,
            impulse: mu * (leaving_vn - vn),
            distance: s,
            energy_step: if steps_over { energy_step } else { 0.0 },
            dissipated: if steps_over { 0.0 } else { 0.5 * mu * (velocity.norm_squared() - after.norm_squared()) },
            positions: [i, j].map(|p| self.positions[p as usize]),
            before,
            after: [i, j].map(|p| self.velocities[p as usize]),
        })
    }

    fn execute_wall(&mut self, i: u32, axis: u8, is_upper: bool) -> Event {
        let k = usize::from(axis);
        let inwards = if is_upper { -1.0 } else { 1.0 };
        let restitution = match self.boundary[k] {
            Boundary::Bounded { lower, upper } => match if is_upper { upper } else { lower } {
                Face::Wall { restitution } => restitution,
                Face::Open => 1.0,
            },
            _ => 1.0,
        };
        let before = self.velocities[i as usize];
        let vn = inwards * before[k];
        let mut tangential = before;
        tangential[k] = 0.0;
        let mut speed = if vn < 0.0 { -restitution * vn } else { vn };
        let closing = -inwards * self.acceleration(i)[k];
        let approach = (-vn).max(0.0);
        if let Some(leaving) = self.tc_model(&[i], restitution, approach, tangential.norm(), closing) {
            speed = if leaving.speed == approach { vn.abs() } else { leaving.speed };
            tangential *= leaving.tangential_scale;
        }
        let mut after = tangential;
        after[k] = inwards * speed;
        self.velocities[i as usize] = after;
        let mut normal = Vector::zeros();
        normal[k] = inwards;
        let species = self.rules.species[self.species[i as usize]];
        let mass = species.inverse_mass.recip();
        Event {
            time: self.time(),
            kind: EventKind::Wall { axis, is_upper },
            particle: ParticleId(i),
            partner: None,
            normal,
            impulse: mass * (speed - vn),
            distance: species.radius,
            energy_step: 0.0,
            dissipated: 0.5 * mass * (before.norm_squared() - after.norm_squared()),
            positions: [self.positions[i as usize], Vector::zeros()],
            before: [before, Vector::zeros()],
            after: [after, Vector::zeros()],
        }
    }

    fn tc_model(
        &mut self,
        particles: &[u32],
        restitution: f64,
        approach: f64,
        tangential: f64,
        closing: f64,
    ) -> Option<Leaving> {
        let times = self.contact_times.as_mut()?;
        let is_recent = times.note(particles, self.time);
        Some(tc_contact(restitution, is_recent, approach, tangential, closing, times.contact_time))
    }
}
