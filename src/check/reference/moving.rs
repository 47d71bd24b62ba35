//! Moving surfaces. If the gap is a polynomial of time in the frame of the surface, Algorithm 1 finds the contact.
//! Otherwise, time intervals are halved down to round-off. An interval is skipped if bounds on speed and acceleration
//! exclude a contact. This method is slow, but independent of the engine.

use super::rules::Side;
use super::surfaces::{Across, Barrier, Feature, Motion};
use crate::Vector;
use crate::model::MotionKind;
use crate::model::surface_motion::{Piece, Timeline};
use std::f64::consts::TAU;

/// Longest time that one search covers `[time]`.
pub(super) const LONGEST_SEARCH: f64 = 2.0;

/// The motion of a particle beside a surface that oscillates or turns.
#[derive(Debug, Clone, Copy)]
pub(in super::super) struct Passage {
    pub feature: Feature,
    pub motion: Motion,
    pub piece: Piece,
    pub now: f64,
}

impl Motion {
    pub fn after(&self, time: f64) -> Self {
        let Self { position, velocity, acceleration, .. } = *self;
        let position = position + (velocity + acceleration * (0.5 * time)) * time;
        Self { position, velocity: velocity + acceleration * time, ..*self }
    }

    /// Returns the motion in the frame of a moving surface at a simulated time.
    pub fn seen(&self, piece: &Piece, time: f64) -> Self {
        let moment = piece.at(time);
        let (position, velocity) = moment.seen(&self.position, &self.velocity);
        let acceleration = moment.acceleration_seen(&self.position, &self.velocity, &self.acceleration);
        Self { position, velocity, acceleration, ..*self }
    }
}

impl Feature {
    /// Returns the time from `now` to the next event with a feature of a moving surface. `None` without an event until
    /// `horizon`.
    pub fn next_event_moving(&self, motion: &Motion, timeline: &Timeline, now: f64, horizon: f64) -> Option<f64> {
        let mut after = 0.0;
        while after < horizon {
            let piece = timeline.piece_at(now + after);
            let end = horizon.min(piece.until - now);
            let found = match piece.kind {
                Some(kind) if !kind.is_polynomial() => {
                    Passage { feature: *self, motion: *motion, piece: *piece, now }.first_between(after, end, u64::MAX)
                }
                _ => {
                    let seen = motion.after(after).seen(piece, now + after);
                    self.next_event(&seen).map(|dt| after + dt).filter(|time| *time < end)
                }
            };
            if found.is_some() {
                return found;
            }
            after = end.max(after + 4.0 * f64::EPSILON * (now.abs() + after));
        }
        None
    }
}

impl Passage {
    pub fn seen(&self, after: f64) -> Motion {
        self.motion.after(after).seen(&self.piece, self.now + after)
    }

    /// Returns the time of the first event in an interval. After `most` tests, returns the time that was reached.
    pub fn first_between(&self, from: f64, to: f64, most: u64) -> Option<f64> {
        // The shortest interval is the rounding error of simulated times.
        Search { passage: self, shortest: 4.0 * f64::EPSILON * (self.now.abs() + to.abs()), left: most }.first(from, to)
    }

    pub fn bounds(&self, from: f64, to: f64) -> (f64, f64) {
        let (fastest, push) = {
            let [one, other] = [from, to].map(|time| self.motion.after(time).velocity.norm());
            (one.max(other), self.motion.acceleration.norm())
        };
        match self.piece.kind {
            Some(MotionKind::Oscillation { amplitude, frequency, .. }) => {
                let (rate, amplitude) = (TAU * frequency.abs(), amplitude.norm());
                (fastest + rate * amplitude, push + rate * rate * amplitude)
            }
            Some(MotionKind::Rotation { point, frequency, .. }) => {
                let arm = (self.motion.after(from).position - point).norm() + fastest * (to - from);
                let rate = TAU * frequency.abs();
                let speed = fastest + rate * arm;
                (speed, push + rate * rate * arm + 2.0 * rate * speed)
            }
            _ => (f64::INFINITY, f64::INFINITY),
        }
    }
}

struct Search<'a> {
    passage: &'a Passage,
    /// Intervals as short as this are not halved further `[time]`.
    shortest: f64,
    left: u64,
}

impl Search<'_> {
    fn first(&mut self, from: f64, to: f64) -> Option<f64> {
        let Some(left) = self.left.checked_sub(1) else { return Some(from) };
        self.left = left;
        let half = 0.5 * (to - from);
        let middle = from + half;
        let feature = &self.passage.feature;
        let seen = self.passage.seen(middle);
        let across = feature.across(&seen);
        let (speed, acceleration) = self.passage.bounds(from, to);
        let foot = feature
            .extents(&seen)
            .map_or(0.0, |extents| extents.iter().map(|extent| extent[0]).fold(f64::INFINITY, f64::min));
        if across.lowest_gap_within(half, speed, acceleration) > 0.0 || foot < -speed * half {
            return None;
        }
        // Upper bound for the derivative of the opening rate. If the opening rate in the middle exceeds
        // `change * half`, the gap increases during the whole interval.
        let change = match across.barrier {
            Barrier::Flat => acceleration,
            Barrier::Round { .. } => speed * speed + (across.position.norm() + speed * half) * acceleration,
        };
        if gap_and_opening(&across).1 > change * half {
            return None;
        }
        if to - from <= self.shortest || middle <= from || middle >= to {
            let (gap, opening) = gap_and_opening(&feature.across(&self.passage.seen(to)));
            return (gap <= 0.0 && opening < 0.0 && foot >= -speed * half).then_some(to);
        }
        self.first(from, middle).or_else(|| self.first(middle, to))
    }
}

impl Across {
    /// Returns a lower bound of the gap within `time` before and after now, from bounds on speed and acceleration.
    pub fn lowest_gap_within(&self, time: f64, speed: f64, acceleration: f64) -> f64 {
        let (gap, opening) = gap_and_opening(self);
        let length = self.position.norm();
        let (opening, bend) = match self.barrier {
            Barrier::Flat => (opening, acceleration),
            Barrier::Round { side: Side::Positive, .. } => (opening / length, acceleration),
            // Inside a round barrier, motion along the barrier also decreases the gap.
            Barrier::Round { side: Side::Negative, .. } => {
                let nearest = length - speed * time;
                let around = if nearest > 0.0 { speed * speed / nearest } else { f64::INFINITY };
                (opening / length, acceleration + around)
            }
        };
        let by_rate = opening.abs() + 0.5 * bend * time;
        // At the centre of a sphere, the gap has no direction, so only the speed limits its change.
        gap - if by_rate < speed { by_rate } else { speed } * time
    }
}

/// Returns the gap and the opening rate. For a round feature, the rate is multiplied by the distance from the centre.
fn gap_and_opening(across: &Across) -> (f64, f64) {
    let Across { position, velocity, .. } = across;
    match across.barrier {
        Barrier::Flat => (position.x, velocity.x),
        Barrier::Round { distance, side } => {
            let sign = Side::sign(side);
            (sign * (position.norm() - distance), sign * Vector::dot(position, velocity))
        }
    }
}
