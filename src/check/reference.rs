//! The reference engine: the algorithm of the paper as printed, for checking and for reading.
//!
//! Algorithm 1 predicts the events of every pair from the overlap functions of the pair, without cells, delayed states
//! or discarded predictions. After each event, all particles move to the new time, and all events of the two particles
//! are predicted again. The cost grows with the square of the number of particles; use a few hundred.
//!
//! ```
//! use carom::{Vector, check::reference::Reference, model::space::{Boundary, Space}, scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft}};
//!
//! let scene = SceneBuilder::new("head-on")
//!     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
//!     .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
//!     .space(Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(8.0) })
//!     .particle("A", Vector::new(0.0, 0.0, 0.0), Vector::new(1.0, 0.0, 0.0))
//!     .particle("A", Vector::new(3.0, 0.0, 0.0), Vector::new(-1.0, 0.0, 0.0))
//!     .build()?;
//! let mut reference = Reference::new(&scene)?;
//! assert_eq!(reference.step_before(10.0).map(|event| event.time), Some(1.0));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod algorithm_1;
mod event;
mod execute;
mod moving;
mod response;
mod rest;
mod rough;
mod rules;
mod surfaces;

pub(super) use algorithm_1::first_on;
pub use algorithm_1::{Polynomial, next_event};
pub use event::{Event, EventKind};
pub(super) use moving::Passage;
pub use response::Outcome;
pub use rules::Side;
pub(super) use surfaces::{Across, Barrier, Extents, Feature, Motion, Touch, features};

use std::cmp::Reverse;
use std::collections::BTreeMap;

use ordered_float::OrderedFloat;
use priority_queue::PriorityQueue;
use thiserror::Error;

use self::moving::LONGEST_SEARCH;
use self::response::TcModel;
use self::rest::Sleepers;
use self::rules::seen;
use crate::Vector;
use crate::base::numbers::id;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Face};
use crate::model::surface_motion::Timeline;
use crate::model::{Interaction, InteractionId, Particle, ParticleId, Scene, Species};

/// Reason why the reference engine cannot simulate a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Unsupported {
    /// The box of the scene is sheared.
    #[error("the reference engine has no sheared boxes")]
    Shear,
    /// A wall has a temperature.
    #[error("the reference engine has no thermal walls")]
    ThermalWalls,
    /// The scene has surfaces other than the walls of its box, and the box is periodic.
    #[error("the reference engine has no surfaces in a periodic box")]
    PeriodicSurfaces,
    /// The scene has inlets.
    #[error("the reference engine has no inlets")]
    Inlets,
    /// A stage or the measured part of the run has a thermostat, growth or swap moves.
    #[error("the reference engine has no thermostats, no growth and no swap moves")]
    DrivenStages,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Candidate {
    Pair(u32, u32, Side),
    /// A pair may have moved so far that another periodic image is closer. The pair is predicted again.
    LookAgain(u32, u32),
    /// A particle reaches the lower or the upper (`true`) wall of an axis.
    Wall(u32, u8, bool),
    Surface(u32, u32),
    /// The search for contacts with moving surfaces has reached its time limit and must continue.
    SearchAgain(u32),
    /// A search for particles at rest.
    Rest,
}

/// A simulation that tests all pairs by Algorithm 1 of the paper.
#[derive(Debug)]
pub struct Reference {
    scene: Scene,
    /// Species of each particle, with the diameter and mass of the particle.
    own: Vec<Species>,
    tc_model: Option<TcModel>,
    /// Interaction and state of each interacting pair `(i, j)` of particles, with `i < j`.
    pairs: BTreeMap<(u32, u32), (InteractionId, usize)>,
    time: f64,
    positions: Vec<Vector>,
    velocities: Vec<Vector>,
    spins: Vec<Vector>,
    /// False for removed particles, whose ids remain valid indices.
    is_present: Vec<bool>,
    features: Vec<Feature>,
    timelines: Vec<Option<Timeline>>,
    sleepers: Option<Sleepers>,
    queue: PriorityQueue<Candidate, Reverse<(OrderedFloat<f64>, Candidate)>>,
}

impl Reference {
    /// Predicts the events of every pair of a scene.
    ///
    /// # Errors
    /// [`Unsupported`] if the scene has a sheared box, thermal walls, surfaces in a periodic box, inlets, a thermostat,
    /// growth or swap moves.
    pub fn new(scene: &Scene) -> Result<Self, Unsupported> {
        let is_periodic = scene.space.boundary.contains(&Boundary::Periodic);
        for (is_asked, unsupported) in [
            (scene.shear_rate.is_some(), Unsupported::Shear),
            (scene.has_thermal_walls(), Unsupported::ThermalWalls),
            (!scene.surfaces.is_empty() && is_periodic, Unsupported::PeriodicSurfaces),
            (!scene.inlets.is_empty(), Unsupported::Inlets),
            (scene.run.is_driven() || scene.run.has_swaps(), Unsupported::DrivenStages),
        ] {
            if is_asked {
                return Err(unsupported);
            }
        }
        let count = scene.particles.len();
        let mut reference = Self {
            scene: scene.clone(),
            own: scene.particles.iter().map(|particle| scene.own_species(particle).into_owned()).collect(),
            tc_model: scene.contact_time.map(|contact_time| TcModel::new(contact_time, count).with(scene.tc_rule)),
            pairs: BTreeMap::new(),
            time: 0.0,
            positions: scene.particles.iter().map(|p| p.position).collect(),
            velocities: scene.particles.iter().map(|p| p.velocity).collect(),
            spins: scene.particles.iter().map(|p| p.spin).collect(),
            is_present: vec![true; count],
            features: features(&scene.surfaces),
            timelines: scene
                .surfaces
                .iter()
                .map(|surface| surface.moves().then(|| Timeline::of(&surface.motions)))
                .collect(),
            sleepers: Sleepers::of(scene),
            queue: PriorityQueue::new(),
        };
        let bonds: BTreeMap<_, _> = scene.bonds.iter().map(|b| ((b.pair[0].0, b.pair[1].0), b.interaction)).collect();
        for i in 0..id(count) {
            for j in i + 1..id(count) {
                // A bond replaces the interaction of the two species.
                let [a, b] = [i, j].map(|p| scene.particles[p as usize].species.0 as usize);
                reference.pair(i, j, bonds.get(&(i, j)).copied().or(scene.table.get(a, b)));
            }
        }
        for i in 0..id(count) {
            reference.predict(i);
        }
        reference.schedule_search();
        Ok(reference)
    }

    /// Returns the initial state of a pair: the number of radii of the potential that are larger than the distance. If
    /// the distance equals a radius within round-off, the direction of motion decides the side.
    fn first_state(&self, potential: &Potential, i: u32, j: u32) -> usize {
        let (apart, [i, j]) = (self.nearest_image(i, j), [i as usize, j as usize]);
        let (distance, radial) = (apart.norm(), apart.dot(&(self.velocities[i] - self.velocities[j])));
        let largest = self.periods().fold(self.positions[i].amax().max(self.positions[j].amax()), f64::max);
        let is_at = |radius: f64| (distance - radius).abs() <= 32.0 * f64::EPSILON * largest;
        let is_inside = |radius: &f64| if is_at(*radius) && radial != 0.0 { radial < 0.0 } else { distance < *radius };
        let states = potential.accessible_states();
        let inside = potential.radii().iter().filter(|radius| is_inside(radius)).count();
        inside.clamp(*states.start(), *states.end())
    }

    /// Inserts a particle at the current time, and returns its id. Ids are never used again.
    pub fn insert(&mut self, particle: Particle) -> ParticleId {
        let i = id(self.positions.len());
        self.own.push(self.scene.own_species(&particle).into_owned());
        self.scene.particles.push(particle);
        self.positions.push(particle.position);
        self.velocities.push(particle.velocity);
        self.spins.push(particle.spin);
        self.is_present.push(true);
        if let Some(tc_model) = &mut self.tc_model {
            tc_model.meet_newcomer();
        }
        if let Some(sleepers) = &mut self.sleepers {
            sleepers.meet_newcomer(&self.own[i as usize], particle.position);
        }
        for j in 0..i {
            if !self.is_present[j as usize] {
                continue;
            }
            let [a, b] = [i, j].map(|p| self.scene.particles[p as usize].species.0 as usize);
            self.pair(j, i, self.scene.table.get(a, b));
        }
        self.predict(i);
        ParticleId(i)
    }

    /// Removes a particle at the current time.
    pub fn remove(&mut self, particle: ParticleId) {
        let ParticleId(gone) = particle;
        self.wake_neighbours(gone);
        self.is_present[gone as usize] = false;
        self.pairs.retain(|&(i, j), _| i != gone && j != gone);
        let names = |candidate: &Candidate| match *candidate {
            Candidate::Pair(i, j, _) | Candidate::LookAgain(i, j) => i == gone || j == gone,
            Candidate::Wall(i, ..) | Candidate::Surface(i, _) | Candidate::SearchAgain(i) => i == gone,
            Candidate::Rest => false,
        };
        self.queue.retain(|candidate, _| !names(candidate));
    }

    fn pair(&mut self, i: u32, j: u32, interaction: Option<InteractionId>) {
        let Some(id) = interaction.filter(|_| !(self.species(i).is_static() && self.species(j).is_static())) else {
            return;
        };
        let state = self.first_state(&self.interaction(id, [i, j]).potential, i, j);
        self.pairs.insert((i, j), (id, state));
    }

    /// Current simulated time `[time]`.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.scene.start_time + self.time
    }

    /// Current positions, unwrapped along periodic axes.
    #[must_use]
    pub fn positions(&self) -> &[Vector] {
        &self.positions
    }

    /// Current velocities.
    #[must_use]
    pub fn velocities(&self) -> &[Vector] {
        &self.velocities
    }

    /// Current spins.
    #[must_use]
    pub fn spins(&self) -> &[Vector] {
        &self.spins
    }

    /// Executes the next event if it is before a simulated time; otherwise moves all particles to that time.
    pub fn step_before(&mut self, limit: f64) -> Option<Event> {
        let limit = limit - self.scene.start_time;
        loop {
            if let Some(event) = self.sleepers.as_mut().and_then(|sleepers| sleepers.executed.pop_front()) {
                return Some(event);
            }
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
                    self.wake_if_hit(i, j);
                    let event = self.execute_pair(i, j, side)?;
                    return Some(self.after(event));
                }
                Candidate::SearchAgain(i) => self.predict(i),
                Candidate::Wall(i, axis, is_upper) => {
                    let event = self.execute_wall(i, axis, is_upper)?;
                    return Some(self.after(event));
                }
                Candidate::Surface(i, feature) => {
                    let event = self.execute_surface(i, feature)?;
                    return Some(self.after(event));
                }
                Candidate::Rest => self.search_for_rest(),
            }
        }
    }

    /// Predicts the particles of an event. Returns the first event that has not been returned yet.
    fn after(&mut self, event: Event) -> Event {
        for i in [Some(event.particle), event.partner].into_iter().flatten() {
            if self.is_present[i.0 as usize] {
                self.predict(i.0);
            }
        }
        let Some(sleepers) = &mut self.sleepers else { return event };
        sleepers.executed.push_back(event);
        sleepers.executed.pop_front().unwrap_or(event)
    }

    /// The species of a particle. While the particle sleeps, this is a static species.
    fn species(&self, i: u32) -> &Species {
        match &self.sleepers {
            Some(sleepers) if sleepers.is_asleep[i as usize] => &sleepers.still[i as usize],
            _ => &self.own[i as usize],
        }
    }

    /// The interaction of two particles, with distances scaled to their diameters.
    fn interaction(&self, id: InteractionId, [i, j]: [u32; 2]) -> Interaction {
        let interaction = &self.scene.interactions[id.0 as usize];
        let pair = [i, j].map(|k| (self.scene.particles[k as usize].species, 0.5 * self.own[k as usize].diameter));
        Interaction { potential: self.scene.potential_between(id, pair).into_owned(), ..interaction.clone() }
    }

    fn is_periodic(&self, axis: usize) -> bool {
        self.scene.space.boundary[axis] == Boundary::Periodic
    }

    fn periods(&self) -> impl Iterator<Item = f64> {
        (0..3).filter(|&k| self.is_periodic(k)).map(|k| self.scene.space.size[k])
    }

    /// Moves every particle to `time` (paper, equation 1).
    fn stream(&mut self, time: f64) {
        let dt = time - self.time;
        for i in 0..self.positions.len() {
            let a = self.species(id(i)).acceleration;
            self.positions[i] += self.velocities[i] * dt + a * (0.5 * dt * dt);
            self.velocities[i] += a * dt;
        }
        self.time = time;
    }

    /// Returns `r_ij` for the nearest image.
    fn nearest_image(&self, i: u32, j: u32) -> Vector {
        self.nearest(self.positions[i as usize] - self.positions[j as usize])
    }

    fn nearest(&self, apart: Vector) -> Vector {
        let size = &self.scene.space.size;
        Vector::from_fn(|k, _| match self.is_periodic(k) {
            true => apart[k] - size[k] * (apart[k] / size[k]).round(),
            false => apart[k],
        })
    }

    fn relative_motion(&self, i: u32, j: u32) -> (Vector, Vector) {
        let velocity = self.velocities[i as usize] - self.velocities[j as usize];
        (velocity, self.species(i).acceleration - self.species(j).acceleration)
    }

    fn predict(&mut self, i: u32) {
        for j in (0..id(self.positions.len())).filter(|&j| j != i) {
            self.predict_pair(i.min(j), i.max(j));
        }
        if !self.species(i).is_static() {
            self.predict_walls(i);
            self.predict_surfaces(i);
        }
    }

    /// Predicts the events of a pair for the nearest image and its neighbours. The prediction is repeated before other
    /// images can come near.
    fn predict_pair(&mut self, i: u32, j: u32) {
        let Some(&(interaction, state)) = self.pairs.get(&(i, j)) else { return };
        let nearest = self.nearest_image(i, j);
        let (velocity, acceleration) = self.relative_motion(i, j);
        let horizon = self.horizon(&velocity, &acceleration);
        for side in [Side::Positive, Side::Negative] {
            let mut first = None;
            if let Some(seen) = seen(&self.interaction(interaction, [i, j]).potential, state, side) {
                // Inside a discontinuity, only the nearest image of the partner can interact.
                let images = if side == Side::Positive { self.images() } else { vec![Vector::zeros()] };
                for image in images {
                    let f = Polynomial::overlap(side, seen.distance, &(nearest + image), &velocity, &acceleration);
                    if let Some(dt) = next_event(&f).filter(|dt| *dt <= horizon) {
                        first = Some(first.map_or(dt, |earlier: f64| earlier.min(dt)));
                    }
                }
            }
            self.put(Candidate::Pair(i, j, side), first);
        }
        self.put(Candidate::LookAgain(i, j), horizon.is_finite().then_some(horizon));
    }

    /// Returns the time in which the separation of a pair changes by at most half of the shortest period.
    fn horizon(&self, velocity: &Vector, acceleration: &Vector) -> f64 {
        let shortest = self.periods().map(|period| 0.5 * period).fold(f64::INFINITY, f64::min);
        let (v, a) = (velocity.norm(), acceleration.norm());
        if shortest == f64::INFINITY || (v == 0.0 && a == 0.0) {
            return f64::INFINITY;
        }
        // The positive solution t of v t + a t^2 / 2 = shortest.
        2.0 * shortest / (v + (v * v + 2.0 * a * shortest).sqrt())
    }

    fn images(&self) -> Vec<Vector> {
        let mut images = vec![Vector::zeros()];
        for k in (0..3).filter(|&k| self.is_periodic(k)) {
            let mut shift = Vector::zeros();
            shift[k] = self.scene.space.size[k];
            images = images.iter().flat_map(|image| [image - shift, *image, image + shift]).collect();
        }
        images
    }

    fn predict_walls(&mut self, i: u32) {
        let radius = 0.5 * self.species(i).diameter;
        for (axis, k) in (0..).zip(0..3) {
            let Boundary::Bounded { lower, upper } = self.scene.space.boundary[k] else { continue };
            let [from_lower, from_upper] =
                [self.scene.space.lower[k], self.scene.space.upper()[k]].map(|at| self.positions[i as usize][k] - at);
            for (is_upper, face, height) in [(false, lower, from_lower), (true, upper, -from_upper)] {
                if matches!(face, Face::Wall(_)) {
                    let inwards = if is_upper { -1.0 } else { 1.0 };
                    let f = Polynomial::new(&[
                        height - radius,
                        inwards * self.velocities[i as usize][k],
                        0.5 * inwards * self.species(i).acceleration[k],
                    ]);
                    self.put(Candidate::Wall(i, axis, is_upper), next_event(&f));
                }
            }
        }
    }

    fn predict_surfaces(&mut self, i: u32) {
        let motion = self.motion(i);
        let kind = self.scene.particles[i as usize].species;
        for (index, feature) in (0..).zip(self.features.clone()) {
            if self.scene.surfaces[feature.surface].meets(kind) {
                let dt = match &self.timelines[feature.surface] {
                    Some(timeline) => feature.next_event_moving(&motion, timeline, self.time(), LONGEST_SEARCH),
                    None => feature.next_event(&motion),
                };
                self.put(Candidate::Surface(i, index), dt);
            }
        }
        if self.timelines.iter().any(Option::is_some) && !self.species(i).is_static() {
            self.put(Candidate::SearchAgain(i), Some(LONGEST_SEARCH));
        }
    }

    fn motion(&self, i: u32) -> Motion {
        let Species { acceleration, diameter, .. } = *self.species(i);
        let [position, velocity] = [&self.positions, &self.velocities].map(|of| of[i as usize]);
        Motion { position, velocity, acceleration, radius: 0.5 * diameter }
    }

    fn put(&mut self, candidate: Candidate, dt: Option<f64>) {
        match dt {
            Some(dt) => drop(self.queue.push(candidate, Reverse((OrderedFloat(self.time + dt), candidate)))),
            None => drop(self.queue.remove(&candidate)),
        }
    }
}

#[cfg(test)]
mod tests;
