//! The motion of a particle beside a surface that oscillates or turns. Distances are not polynomials of the time, so
//! contacts and smallest gaps are found by bisection. Bounds on speed and acceleration exclude most time intervals.

use super::approach::Approach;
use super::facet::approach_of;
use crate::check::reference::{Motion, Passage};
use std::sync::Arc;

/// Tolerance of the smallest gap, relative to the magnitude of coordinates.
const RESOLUTION: f64 = 8.0 * f64::EPSILON;
/// Largest number of intervals in one search for the next event. A longer search, as for a particle that stays on a
/// surface, is continued later.
const MOST_LOOKS: u64 = 1 << 17;

/// A particle beside a feature of a surface that oscillates or turns.
#[derive(Debug)]
pub(super) struct Swing {
    passage: Passage,
    /// Error of the feature's normal in units of round-off.
    slenderness: f64,
    /// Time in the window at which `passage` begins `[time]`.
    since: f64,
}

#[derive(Debug, Clone, Copy)]
struct Stretch {
    from: f64,
    to: f64,
}

impl Swing {
    pub fn new(passage: Passage, slenderness: f64, since: f64) -> Self {
        Self { passage, slenderness, since }
    }

    pub fn at(self: &Arc<Self>, time: f64) -> Approach {
        Approach { swing: Some(Arc::clone(self)), ..self.snapshot(time) }
    }

    pub fn next_event(&self, from: f64, until: f64) -> Option<f64> {
        let found = self.passage.first_between(from - self.since, until - self.since, MOST_LOOKS);
        found.filter(|_| from <= until).map(|after| self.since + after)
    }

    /// Returns the smallest gap in an interval of the window. After the time `from`, gaps off the feature are ignored.
    pub fn lowest(&self, from: f64, to: f64) -> f64 {
        let mut lowest = self.snapshot(from).gap_now();
        let end = self.snapshot(to);
        if end.is_on_now() {
            lowest = lowest.min(end.gap_now());
        }
        let mut stretches = vec![Stretch { from, to }];
        while let Some(stretch) = stretches.pop() {
            let Stretch { from, to } = stretch;
            let half = 0.5 * (to - from);
            let middle = from + half;
            let seen = self.passage.seen(middle - self.since);
            let at = self.approach(&seen, middle);
            let (speed, acceleration) = self.passage.bounds(from - self.since, to - self.since);
            if at.foot.is_some_and(|foot| foot.within(0.0) < -speed * half) {
                continue;
            }
            if at.is_on_now() {
                lowest = lowest.min(at.gap_now());
            }
            let above = self.passage.feature.across(&seen).lowest_gap_within(half, speed, acceleration);
            let resolution = RESOLUTION * (seen.position.norm() + seen.radius);
            if above < lowest - resolution && from < middle && middle < to {
                stretches.extend([Stretch { from, to: middle }, Stretch { from: middle, to }]);
            }
        }
        lowest
    }

    fn snapshot(&self, time: f64) -> Approach {
        self.approach(&self.passage.seen(time - self.since), time)
    }

    fn approach(&self, seen: &Motion, time: f64) -> Approach {
        approach_of(&self.passage.feature, self.slenderness, seen, time)
    }
}
