//! Free flights: particles without an event between two frames.
//!
//! The position and velocity of a free particle follow from the previous frame and the acceleration. The player
//! computes the path from the two positions, with the nearest image along periodic axes.

use crate::Vector;
use crate::base::numbers::trunc_to_u8;
use crate::model::Scene;
use crate::trajectory::Frame;

/// Largest relative deviation of a free flight. It allows for millions of moves, each with a relative round-off of
/// `2^-53`. Collisions with a smaller effect are not noticed.
const ROUNDING: f64 = 1e-9;

/// Longest displacement along a periodic axis, in 1/500 of a period. Below half a period, the nearest image is correct.
const FARTHEST: f64 = 240.0;
const PERIOD: f64 = 500.0;

#[derive(Debug, Clone, PartialEq)]
struct Moment {
    time: f64,
    /// Wrapped position, velocity and species index of each moving particle.
    states: Vec<(Vector, Vector, usize)>,
}

impl Moment {
    fn of(frame: &Frame) -> Self {
        let moving = frame.particles.iter().filter(|particle| !frame.is_static(particle));
        let state = moving.map(|one| (frame.wrapped(&one.position), one.velocity, one.species.0 as usize));
        Self { time: frame.time, states: state.collect() }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Flights {
    /// Index in [`FlightFinder::falls`] of the accelerations.
    pub fall: usize,
    /// Upper bound of each particle's displacement along any periodic axis, in 1/500 of a period. It is 0 if the
    /// particle had an event or moved too far.
    ways: Vec<u8>,
}

impl Flights {
    /// Joins these flights with the flights of the next interval, which must have the same acceleration.
    pub fn then(mut self, next: &Self) -> Self {
        let joined = |(first, second): (&mut u8, &u8)| {
            let is_flight = *first > 0 && *second > 0 && self.fall == next.fall;
            let way = first.saturating_add(*second);
            *first = if is_flight && f64::from(way) <= FARTHEST { way } else { 0 };
        };
        self.ways.iter_mut().zip(&next.ways).for_each(joined);
        self
    }

    pub fn count(&self) -> usize {
        self.ways.iter().filter(|way| **way > 0).count()
    }

    /// Returns one bit per particle, lowest bit first: 1 for a free flight.
    pub fn bits(&self) -> impl Iterator<Item = u8> + '_ {
        self.ways
            .chunks(8)
            .map(|ways| (0..).zip(ways).fold(0, |bits, (place, way)| bits | (u8::from(*way > 0) << place)))
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) struct FlightFinder {
    /// Accelerations of each species: first with the scene's gravity, then with the gravity of stages.
    pub falls: Vec<Vec<Vector>>,
    /// Velocity along x of a particle relative to its next image along y, due to shear.
    pub slide: f64,
    last: Option<Moment>,
}

impl FlightFinder {
    pub fn of(frame: &Frame, scene: Option<&Scene>) -> Self {
        let own = |scene: &Scene| scene.species.iter().map(|species| species.acceleration).collect();
        let mut falls = vec![scene.map_or_else(Vec::new, own)];
        for gravity in scene.iter().flat_map(|scene| scene.run.gravities()) {
            let fall = vec![gravity; frame.species.len()];
            if !falls.contains(&fall) {
                falls.push(fall);
            }
        }
        falls.iter_mut().for_each(|fall| fall.resize(frame.species.len(), Vector::zeros()));
        let rate = scene.and_then(|scene| scene.shear_rate).unwrap_or(0.0);
        Self { falls, slide: rate * frame.size.y, last: None }
    }

    /// Returns the flights since the previous frame.
    pub fn next(&mut self, frame: &Frame) -> Option<Flights> {
        let now = Moment::of(frame);
        let last = self.last.replace(now)?;
        let now = self.last.as_ref()?;
        let all = (0..self.falls.len()).map(|fall| self.flights(frame, [&last, now], fall));
        // If stages have different gravity, the accelerations with the largest number of flights are used.
        all.reduce(|best, other| if other.count() > best.count() { other } else { best })
    }

    fn flights(&self, frame: &Frame, [last, now]: [&Moment; 2], fall: usize) -> Flights {
        let time = now.time - last.time;
        let ways = last.states.iter().zip(&now.states).map(|((from, start, species), (to, end, _))| {
            let acceleration = self.falls[fall].get(*species).copied().unwrap_or_else(Vector::zeros);
            let gained = acceleration * time;
            let flown = (start + gained * 0.5) * time;
            let (way, up) = nearest_way(frame, to - from);
            let expected = start + gained - Vector::new(up * self.slide, 0.0, 0.0);
            let scale = from.amax().max(to.amax()).max(flown.amax()).max(frame.size.amax());
            let speed = start.amax().max(end.amax()).max(gained.amax()).max(self.slide.abs());
            let is_flight =
                time > 0.0 && (way - flown).amax() <= ROUNDING * scale && (end - expected).amax() <= ROUNDING * speed;
            if is_flight { parts_of_period(frame, &flown) } else { 0 }
        });
        Flights { fall, ways: ways.collect() }
    }
}

/// Returns the shortest displacement between periodic images of two points, and the number of periods by which the end
/// point was moved along y. `way` is the displacement between any two images. `frame` is the later frame.
fn nearest_way(frame: &Frame, way: Vector) -> (Vector, f64) {
    let mut way = way;
    let up = if frame.periodic[1] { -(way.y / frame.size.y).round() } else { 0.0 };
    way.x += up * frame.displacement;
    for axis in 0..3 {
        if frame.periodic[axis] {
            way[axis] -= frame.size[axis] * (way[axis] / frame.size[axis]).round();
        }
    }
    (way, up)
}

/// Returns an upper bound of a displacement along any periodic axis, in 1/500 of a period; 0 if it is too long.
fn parts_of_period(frame: &Frame, way: &Vector) -> u8 {
    let parts = (0..3).filter(|axis| frame.periodic[*axis]).map(|axis| way[axis].abs() / frame.size[axis] * PERIOD);
    let most = parts.fold(0.0, f64::max).ceil() + 1.0;
    if most <= FARTHEST { trunc_to_u8(most) } else { 0 }
}

#[cfg(test)]
mod tests;
