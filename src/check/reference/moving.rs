//! Surfaces that move: Algorithm 1 in the frame of the surface where that gives polynomials, and elsewhere a search by halves.
//!
//! A stretch of time is left out where bounds of speed and acceleration show that the gap stays open, opens, or that the foot stays off the feature; others are
//! halved down to rounding. Slow, and nothing in common with the steps of the engine.

use super::rules::Side;
use super::surfaces::{Across, Barrier, Feature, Motion};
use crate::Vector;
use crate::model::MotionKind;
use crate::model::surface_motion::{Piece, Timeline};
use std::f64::consts::TAU;

/// A search is gone on with after this time `[time]`.
pub(super) const LONGEST_SEARCH: f64 = 2.0;

/// A flight beside a surface that oscillates or turns, from a simulated time on.
struct Passage<'a> {
    feature: &'a Feature,
    motion: &'a Motion,
    piece: &'a Piece,
    now: f64,
}

impl Motion {
    /// The motion after a time.
    fn after(&self, time: f64) -> Self {
        let Self { position, velocity, acceleration, .. } = *self;
        let position = position + (velocity + acceleration * (0.5 * time)) * time;
        Self { position, velocity: velocity + acceleration * time, ..*self }
    }

    /// The motion as a surface sees it at a time of a piece.
    pub fn seen(&self, piece: &Piece, time: f64) -> Self {
        let moment = piece.at(time);
        let (position, velocity) = moment.seen(&self.position, &self.velocity);
        let acceleration = moment.acceleration_seen(&self.position, &self.velocity, &self.acceleration);
        Self { position, velocity, acceleration, ..*self }
    }
}

impl Feature {
    /// Time from a simulated time to the next event of a sphere with the feature of a surface that moves, none before a time has passed.
    pub fn next_event_moving(&self, motion: &Motion, timeline: &Timeline, now: f64, horizon: f64) -> Option<f64> {
        let mut after = 0.0;
        while after < horizon {
            let piece = timeline.piece_at(now + after);
            let end = horizon.min(piece.until - now);
            let found = match piece.kind {
                Some(kind) if !kind.is_polynomial() => {
                    Passage { feature: self, motion, piece, now }.first_between(after, end)
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

impl Passage<'_> {
    fn first_between(&self, from: f64, to: f64) -> Option<f64> {
        let half = 0.5 * (to - from);
        let middle = from + half;
        let seen = self.motion.after(middle).seen(self.piece, self.now + middle);
        let across = self.feature.across(&seen);
        let (gap, opening) = gap_and_opening(&across);
        let (speed, acceleration) = self.bounds(from, to);
        let foot = self
            .feature
            .extents(&seen)
            .map_or(0.0, |extents| extents.iter().map(|extent| extent[0]).fold(f64::INFINITY, f64::min));
        if gap > speed * half || foot < -speed * half {
            return None;
        }
        // The square of a distance opens by no less than twice this.
        let change = match across.barrier {
            Barrier::Flat => acceleration,
            Barrier::Round { .. } => speed * speed + (across.position.norm() + speed * half) * acceleration,
        };
        if opening > change * half {
            return None;
        }
        if to - from <= 4.0 * f64::EPSILON * (1.0 + self.now.abs() + to) {
            let seen = self.motion.after(to).seen(self.piece, self.now + to);
            let (gap, opening) = gap_and_opening(&self.feature.across(&seen));
            return (gap <= 0.0 && opening < 0.0 && foot >= -speed * half).then_some(to);
        }
        self.first_between(from, middle).or_else(|| self.first_between(middle, to))
    }

    /// Bounds of the speed and the acceleration that the surface sees between two times.
    fn bounds(&self, from: f64, to: f64) -> (f64, f64) {
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

/// How far the motion is from contact, and how fast that opens, for round features times the distance from their middle.
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
