//! A window of simulated time, with all events that Algorithm 1 predicts in it.
//!
//! At the start of the window, the next events of all pairs are computed, except for pairs that are too far apart to
//! meet within the window. After an event, the next events of its particles are computed again.

use super::approach::{Approach, Boundary};
use super::contact::{Claim, Contact};
use super::pairs::Pairs;
use super::rules::{Side, Step};
use super::violation::Fault;
use super::world::{Wall, World};
use crate::Vector;
use crate::engine::{Elapsed, States};
use crate::model::ParticleId;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Safety factor for lengths in the test that skips distant pairs. Rounding errors are far smaller.
pub(super) const MARGIN: f64 = 1.0 + 1e-12;
/// Largest number of images of one pair that are searched. Usually there are at most six along each axis.
const MOST_IMAGES: f64 = 4096.0;

/// A predicted event.
#[derive(Debug, Clone)]
pub(super) struct Due {
    /// Time of the event in the window `[time]`.
    pub time: f64,
    pub claim: Claim,
    pub approach: Approach,
    /// Versions of the two flights for which the event was computed. A changed flight has a new version.
    versions: [u32; 2],
}

impl PartialEq for Due {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Due {}

impl PartialOrd for Due {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Due {
    /// Orders events by descending time, so that a heap returns the earliest event first.
    fn cmp(&self, other: &Self) -> Ordering {
        other.time.total_cmp(&self.time).then_with(|| other.claim.cmp(&self.claim))
    }
}

#[derive(Debug)]
pub(super) struct Window {
    pub origin: Elapsed,
    pub length: f64,
    pub events: u64,
    /// Number of evaluations of Algorithm 1 in the window.
    pub asked: u64,
    due: BinaryHeap<Due>,
    versions: Vec<u32>,
}

struct Scan<'a> {
    world: &'a World,
    pairs: &'a Pairs,
    states: &'a States,
    /// Largest displacement of each particle in the rest of the window `[length]`.
    reaches: Vec<f64>,
}

impl<'a> Scan<'a> {
    fn within(world: &'a World, pairs: &'a Pairs, states: &'a States, time: f64) -> Self {
        let moves = states.velocities.iter().zip(&world.accelerations);
        let reaches = moves.map(|(velocity, acceleration)| reach(velocity, acceleration, time)).collect();
        Self { world, pairs, states, reaches }
    }
}

impl Window {
    /// Opens a window: computes the next events of all pairs, and of all particles at walls and surfaces.
    pub fn open(world: &World, pairs: &Pairs, states: &States, length: f64) -> Result<Self, Fault> {
        let length = length.min(world.motions.steady_for(&states.elapsed));
        let mut window = Self {
            origin: states.elapsed,
            length,
            events: 0,
            asked: 0,
            due: BinaryHeap::new(),
            versions: vec![0; states.positions.len()],
        };
        let scan = Scan::within(world, pairs, states, length);
        for &i in &world.moving {
            window.ask_particle(&scan, i, |j| world.is_first(i, j))?;
        }
        Ok(window)
    }

    pub fn end_by(&mut self, time: f64) {
        self.length = self.length.min(time);
    }

    /// Invalidates the predicted events of particles whose flights have changed.
    pub fn forget(&mut self, particles: impl Iterator<Item = u32>) {
        for particle in particles {
            self.versions[particle as usize] = self.versions[particle as usize].wrapping_add(1);
        }
    }

    /// Recomputes the next events of particles whose flights have changed.
    pub fn ask_changed(&mut self, world: &World, pairs: &Pairs, states: &States, changed: &[u32]) -> Result<(), Fault> {
        let left = self.length - self.time(&states.elapsed);
        let scan = Scan::within(world, pairs, states, left);
        for (at, &i) in changed.iter().enumerate() {
            self.ask_particle(&scan, i, |j| !changed[..at].contains(&j))?;
        }
        Ok(())
    }

    pub fn time(&self, elapsed: &Elapsed) -> f64 {
        elapsed.after(&self.origin)
    }

    /// Removes the predicted events before a time in the window, and returns the valid ones, earliest first.
    pub fn due_before(&mut self, time: f64) -> Vec<Due> {
        let mut due = Vec::new();
        while self.due.peek().is_some_and(|first| first.time < time) {
            due.extend(self.due.pop().filter(|first| self.is_valid(first)));
        }
        due
    }

    pub fn is_valid(&self, due: &Due) -> bool {
        self.versions_of(&due.claim.contact) == due.versions
    }

    fn versions_of(&self, contact: &Contact) -> [u32; 2] {
        let mut versions = [0; 2];
        for (version, particle) in versions.iter_mut().zip(contact.particles()) {
            *version = self.versions[particle as usize];
        }
        versions
    }

    fn ask_particle(&mut self, scan: &Scan<'_>, i: u32, is_wanted: impl Fn(u32) -> bool) -> Result<(), Fault> {
        let Scan { world, pairs, states, ref reaches } = *scan;
        for (j, state) in pairs.of(i).filter(|(j, _)| *j != i && is_wanted(*j)) {
            self.ask_pair(world, states, i, j, state)?;
        }
        let far = (world.longest_range + reaches[i as usize]) * MARGIN;
        for (j, its_reach) in (0..).zip(reaches).filter(|(j, _)| *j != i && is_wanted(*j)) {
            let reach = far + its_reach * MARGIN;
            if world.nearest(states, i, j).norm_squared() <= reach * reach && pairs.get(i, j).is_none() {
                self.ask_pair(world, states, i, j, 0)?;
            }
        }
        if !world.is_static(i) {
            self.ask_walls(world, states, i);
            self.ask_facets(world, states, i);
        }
        Ok(())
    }

    fn ask_pair(&mut self, world: &World, states: &States, i: u32, j: u32, state: usize) -> Result<(), Fault> {
        let Some(interaction) = world.interaction(i, j) else { return Ok(()) };
        let (contact, now) = (Contact::pair(ParticleId(i), ParticleId(j)), self.time(&states.elapsed));
        for side in [Side::Positive, Side::Negative] {
            let Some(seen) = Step::seen(&interaction.potential, state, side) else { continue };
            let boundary = Boundary::Sphere { distance: seen.distance, side };
            let nearest = Approach::of_pair(world, states, [i, j], now, boundary);
            // A captured pair interacts through its nearest image only.
            let images = match side {
                Side::Positive => {
                    let reaches = reach_along(&nearest.velocity, &nearest.acceleration, self.length - now);
                    let reaches = reaches.add_scalar(seen.distance) * MARGIN;
                    let images = world.images(&nearest.position, &reaches, MOST_IMAGES);
                    images.ok_or(Fault::TooFast { particle: ParticleId(i), speed: nearest.velocity.norm() })?
                }
                Side::Negative => vec![nearest.position],
            };
            for position in images {
                self.ask(Claim { contact, side }, Approach { position, ..nearest.clone() });
            }
        }
        Ok(())
    }

    fn ask_walls(&mut self, world: &World, states: &States, i: u32) {
        for wall in &world.walls {
            let approach = wall_approach(world, states, i, wall, self.time(&states.elapsed));
            let contact = Contact::Wall { particle: ParticleId(i), axis: wall.axis, is_upper: wall.is_upper };
            self.ask(Claim { contact, side: Side::Positive }, approach);
        }
    }

    fn ask_facets(&mut self, world: &World, states: &States, i: u32) {
        if world.facets.is_empty() {
            return;
        }
        let now = self.time(&states.elapsed);
        for facet in world.facets_near(states, i, self.length - now) {
            let contact = facet.contact(i);
            self.ask(Claim { contact, side: Side::Positive }, facet.approach(world, states, i, now));
        }
    }

    /// Computes the next event of a flight, and keeps it if it is within the window.
    pub fn ask(&mut self, claim: Claim, approach: Approach) {
        self.asked += 1;
        if let Some(time) = approach.next_event(self.length) {
            self.due.push(Due { time, claim, approach, versions: self.versions_of(&claim.contact) });
        }
    }
}

/// Flight towards a wall. The first coordinate is the gap.
pub(super) fn wall_approach(world: &World, states: &States, i: u32, wall: &Wall, since: f64) -> Approach {
    let (k, inwards) = (usize::from(wall.axis), wall.inwards());
    let along = |x: f64| Vector::new(inwards * x, 0.0, 0.0);
    let height = inwards * (states.positions[i as usize][k] - wall.at) - world.radius(i);
    Approach {
        since,
        position: Vector::new(height, 0.0, 0.0),
        velocity: along(states.velocities[i as usize][k]),
        acceleration: along(world.accelerations[i as usize][k]),
        boundary: Boundary::Plane,
        foot: None,
        swing: None,
    }
}

/// Returns the largest possible displacement within `time`, for a given velocity and acceleration `[length]`.
pub(super) fn reach(velocity: &Vector, acceleration: &Vector, time: f64) -> f64 {
    (velocity.norm() + 0.5 * acceleration.norm() * time) * time
}

/// Returns the largest possible displacement along each axis within `time`; 0 along an axis without motion `[length]`.
pub(super) fn reach_along(velocity: &Vector, acceleration: &Vector, time: f64) -> Vector {
    Vector::from_fn(|k, _| {
        let (v, a) = (velocity[k].abs(), acceleration[k].abs());
        let from_speed = if v > 0.0 { v * time } else { 0.0 };
        from_speed + if a > 0.0 { 0.5 * a * time * time } else { 0.0 }
    })
}
