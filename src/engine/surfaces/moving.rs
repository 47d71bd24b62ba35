//! Contacts with moving surfaces.
//!
//! Everything is computed in the frame of the surface. If the surface accelerates uniformly, distances are polynomials
//! in time. If it oscillates or turns, contacts are found by conservative advancement. With a bound `|f''| <= M`, the
//! overlap function `f` has no root within the time `h = (f' + sqrt(f'^2 + 2 M f)) / M`. Steps by `h` approach the
//! first root and never pass a root.

use super::tree::Tree;
use super::{Flight, Placed, Surface};
use crate::Vector;
use crate::model::MotionKind;
use crate::model::surface_motion::{Moment, Piece, Timeline};
use crate::physics::motion::stream_position;
use std::cell::Cell;
use std::f64::consts::TAU;
use std::ops::Range;

/// Maximum number of steps in a search for a contact. Afterwards, the search continues at a later time.
const MOST_STEPS: u32 = 1_000;

const MOST_INTERVALS: u32 = 200;

/// Longest interval of a search, as a fraction of the period of the motion. Longer intervals have weak bounds.
const SHARE: f64 = 0.125;

thread_local! {
    static STEPS: Cell<u64> = const { Cell::new(0) };
}

/// Returns the number of steps of all searches in this thread, which is the cost of surfaces that oscillate or turn.
pub(crate) fn search_steps() -> u64 {
    STEPS.get()
}

/// A moving surface. The list of all features contains its features consecutively, at their initial positions.
#[derive(Debug, Clone)]
pub(super) struct Moving {
    pub timeline: Timeline,
    pub features: Range<usize>,
    pub unlimited: Range<usize>,
    pub tree: Option<Tree>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Found {
    /// The first contact: the index of the feature, and the time from now `[time]`.
    Contact(u32, f64),
    /// There is no contact until this time from now `[time]`. The search must then continue.
    NoneUntil(f64),
}

/// The free flight of a particle during one piece of a surface's motion. The flight begins at the time `now`.
#[derive(Debug, Clone, Copy)]
struct Passage<'a> {
    flight: &'a Flight<'a>,
    now: f64,
    piece: &'a Piece,
}

/// Position of a particle in the frame of a surface at the beginning of an interval, and bounds for the interval.
#[derive(Debug, Clone, Copy)]
struct Seen {
    position: Vector,
    /// Upper bounds of speed `[length / time]` and acceleration `[length / time^2]`.
    speed: f64,
    acceleration: f64,
    /// Upper bound of the distance from `position` during the interval `[length]`.
    path: f64,
}

impl Moving {
    /// Returns the first contact of a sphere within the time `horizon`. The list `all` contains all features.
    pub fn next_contact(
        &self,
        all: &[Placed],
        meets: impl Fn(&Placed) -> bool,
        (flight, now): (&Flight<'_>, f64),
        horizon: f64,
    ) -> Option<Found> {
        let mut after = 0.0;
        loop {
            let piece = self.timeline.piece_at(now + after);
            let passage = Passage { flight, now, piece };
            let end = horizon.min(piece.until - now);
            let found = match piece.kind {
                Some(kind) if !kind.is_polynomial() => self.search(all, &meets, &passage, (after, end)),
                _ => self.solve(all, &meets, &passage, (after, end)),
            };
            if found.is_some() || end >= horizon {
                return found;
            }
            // Because of round-off, an interval may end at or before its beginning.
            after = if end > after { end } else { after + 2.0 * f64::EPSILON * (now.abs() + after.abs()) };
        }
    }

    /// Calls `visit` for the features within `reach` of a sphere. The position is in the frame of the surface.
    pub fn for_each_within(
        &self,
        all: &[Placed],
        (position, radius): (&Vector, f64),
        reach: f64,
        mut visit: impl FnMut(u32, &Placed),
    ) {
        let around = Vector::repeat((reach + radius) * (1.0 + 1e-6) + 1e-12 * position.amax());
        self.for_each_in(all, &[position - around, position + around], |index, placed| {
            // For an overlapping plane, the gap is negative and the condition is always true.
            if !self.unlimited.contains(&(index as usize)) || placed.shape.gap(position, radius) <= reach {
                visit(index, placed);
            }
        });
    }

    fn for_each_in(&self, all: &[Placed], within: &[Vector; 2], mut visit: impl FnMut(u32, &Placed)) {
        for (index, placed) in (0..).zip(all).skip(self.unlimited.start).take(self.unlimited.len()) {
            visit(index, placed);
        }
        let Some(tree) = &self.tree else { return };
        tree.for_each(within, |index| {
            if let Some(placed) = all.get(index as usize) {
                visit(index, placed);
            }
        });
    }

    /// Finds the first contact while overlap functions are polynomials.
    fn solve(
        &self,
        all: &[Placed],
        meets: &impl Fn(&Placed) -> bool,
        passage: &Passage<'_>,
        (after, end): (f64, f64),
    ) -> Option<Found> {
        let Passage { flight, now, piece } = *passage;
        let (position, velocity) = passage.state(after);
        let moment = piece.at(now + after);
        let (position, velocity) = moment.seen(&position, &velocity);
        let acceleration = moment.pose.direction_of_shape(&(flight.acceleration - moment.acceleration));
        let seen = Flight { position: &position, velocity: &velocity, acceleration: &acceleration, ..*flight };
        let mut first = end - after;
        let mut found = None;
        self.for_each_in(all, &seen.swept(end - after), |index, placed| {
            if let Some(dt) = placed.shape.next_contact(&seen).filter(|dt| *dt < first && meets(placed)) {
                (first, found) = (dt, Some(Found::Contact(index, after + dt)));
            }
        });
        found
    }

    /// Finds the first contact while overlap functions are not polynomials.
    fn search(
        &self,
        all: &[Placed],
        meets: &impl Fn(&Placed) -> bool,
        passage: &Passage<'_>,
        stretch: (f64, f64),
    ) -> Option<Found> {
        let mut steps = 0;
        let found = self.search_in_intervals(all, meets, passage, stretch, &mut steps);
        STEPS.set(STEPS.get().wrapping_add(steps));
        found
    }

    /// Divides the search into intervals. In each interval, only features near the flight are tested.
    fn search_in_intervals(
        &self,
        all: &[Placed],
        meets: &impl Fn(&Placed) -> bool,
        passage: &Passage<'_>,
        (mut after, end): (f64, f64),
        steps: &mut u64,
    ) -> Option<Found> {
        let longest = passage.longest();
        let size = self.tree.as_ref().map_or(f64::INFINITY, Tree::size);
        let mut step = (end - after).min(64.0 * longest);
        for _ in 0..MOST_INTERVALS {
            if after >= end {
                return None;
            }
            *steps += 1;
            step = step.min(end - after);
            let seen = passage.seen(after, step);
            let is_short = step <= longest && seen.path <= 0.125 * size + 4.0 * passage.flight.radius;
            let (mut is_near, mut first, mut found) = (false, after + step, None);
            self.for_each_within(all, (&seen.position, passage.flight.radius), seen.path, |index, placed| {
                is_near |= meets(placed);
                if is_short && meets(placed) {
                    match passage.advance((index, placed), &seen, (after, first), steps) {
                        Some(earlier @ (Found::Contact(_, at) | Found::NoneUntil(at))) => {
                            (first, found) = (at, Some(earlier));
                        }
                        None => {}
                    }
                }
            });
            if found.is_some() {
                return found;
            }
            if is_near && !is_short {
                step *= 0.5;
                continue;
            }
            after += step;
            step *= 2.0;
        }
        Some(Found::NoneUntil(after))
    }
}

impl Passage<'_> {
    /// Returns the position and the velocity at the time `after` from now.
    fn state(&self, after: f64) -> (Vector, Vector) {
        let Flight { position, velocity, acceleration, .. } = *self.flight;
        (stream_position(position, velocity, acceleration, after), velocity + acceleration * after)
    }

    fn moment(&self, after: f64) -> Moment {
        self.piece.at(self.now + after)
    }

    /// Duration of the longest interval in which the bounds are useful `[time]`.
    fn longest(&self) -> f64 {
        match self.piece.kind {
            Some(MotionKind::Oscillation { frequency, .. } | MotionKind::Rotation { frequency, .. }) => {
                SHARE / frequency.abs().max(f64::MIN_POSITIVE)
            }
            _ => f64::INFINITY,
        }
    }

    /// Returns the state of the particle in the frame of the surface, at the time `after` from now. The bounds are
    /// valid for the next `interval`.
    fn seen(&self, after: f64, interval: f64) -> Seen {
        let (position, velocity) = self.state(after);
        let moment = self.moment(after);
        let (seen_position, seen_velocity) = moment.seen(&position, &velocity);
        let push = self.flight.acceleration.norm();
        let fastest = velocity.norm() + push * interval;
        let flown = fastest * interval;
        let (speed, acceleration, path) = match self.piece.kind {
            Some(MotionKind::Oscillation { amplitude, frequency, .. }) => {
                let (rate, amplitude) = (TAU * frequency.abs(), amplitude.norm());
                let speed = fastest + rate * amplitude;
                (speed, push + rate * rate * amplitude, flown + amplitude * (rate * interval).min(2.0))
            }
            Some(MotionKind::Rotation { point, frequency, .. }) => {
                let (rate, arm) = (TAU * frequency.abs(), (position - point).norm() + flown);
                let speed = fastest + rate * arm;
                let acceleration = push + rate * rate * arm + 2.0 * rate * speed;
                (speed, acceleration, flown + arm * (rate * interval).min(2.0))
            }
            _ => (seen_velocity.norm() + push * interval, push, f64::INFINITY),
        };
        Seen { position: seen_position, speed, acceleration, path }
    }

    /// Finds the first contact with one feature between the times `after` and `end`, with the bounds in `seen`.
    fn advance(
        &self,
        (index, placed): (u32, &Placed),
        seen: &Seen,
        (after, end): (f64, f64),
        steps: &mut u64,
    ) -> Option<Found> {
        let shape = &placed.shape;
        let bound = shape.second_rate_bound(&seen.position, seen.path, seen.speed, seen.acceleration);
        let bound = bound.max(f64::MIN_POSITIVE);
        let mut at = after;
        for _ in 0..MOST_STEPS {
            if at >= end {
                return None;
            }
            *steps += 1;
            let (position, velocity) = self.state(at);
            let (position, velocity) = self.moment(at).seen(&position, &velocity);
            let (f, rate) = shape.overlap(&position, &velocity, self.flight.radius);
            // Shorter steps would be lost in the round-off of the simulated time.
            let shortest = 4.0 * f64::EPSILON * (self.now.abs() + at + self.longest());
            let step = if f > 0.0 {
                let root = (rate * rate + 2.0 * bound * f).sqrt();
                if rate > 0.0 { (rate + root) / bound } else { 2.0 * f / (root - rate) }
            } else if rate >= 0.0 {
                rate / bound
            } else {
                0.0
            };
            if rate < 0.0 && step <= shortest {
                let beyond = shape.beyond(&position);
                if beyond <= 0.0 {
                    return Some(Found::Contact(index, at));
                }
                at += (beyond / seen.speed).max(shortest);
                continue;
            }
            at += step.max(shortest);
        }
        (at < end).then_some(Found::NoneUntil(at))
    }
}
