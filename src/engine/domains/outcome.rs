//! Outcome of a window in a domain. All processes receive the outcomes of all domains.

use crate::engine::clock::{SHORTEST_ADVANCE, StandstillWatch};
use crate::engine::event::Event;
use crate::engine::parts::Counts;
use serde::{Deserialize, Serialize};

/// An observed event, with the time since the epoch.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Seen {
    pub time: f64,
    pub event: Event,
}

/// Number of event times that are kept, to detect that time stands still.
const LAST_EVENTS: usize = 32;

/// Times of recent events and transitions.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Times {
    /// Number of events.
    pub executed: u64,
    /// Times of the latest events, and of the transitions after the last event.
    pub last: Vec<f64>,
    pub quiet: Vec<f64>,
}

impl Times {
    #[inline]
    pub fn event(&mut self, time: f64) {
        if self.last.len() == 2 * LAST_EVENTS {
            self.last.drain(..LAST_EVENTS);
        }
        self.executed += 1;
        self.last.push(time);
        self.quiet.clear();
    }

    pub fn clear(&mut self) {
        self.executed = 0;
        self.last.clear();
        self.quiet.clear();
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Tally {
    /// Number of engine steps of owned particles in this window, and total number of engine steps.
    pub done: u64,
    pub done_in_all: u64,
    /// Time of the last step of an owned particle in this window.
    pub latest: f64,
    pub events: Vec<Seen>,
    /// Times of events and transitions of owned particles.
    pub times: Times,
}

impl Tally {
    pub fn new() -> Self {
        Self { done: 0, done_in_all: 0, latest: f64::NEG_INFINITY, events: Vec::new(), times: Times::default() }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Outcome {
    /// Time of the first step in which an owned particle differs from a copy that may have affected other particles.
    pub difference: Option<f64>,
    pub counts: Box<Counts>,
    pub tally: Tally,
    /// True if the number of copies exceeds its limit. The box must then be divided anew.
    pub has_grown: bool,
}

/// Returns the time of the last event, and the number of transitions after it. Each argument is for one domain or thread.
pub fn quiet(all: &[&Times]) -> (Option<f64>, u64) {
    let last = all.iter().filter_map(|times| times.last.last().copied()).max_by(f64::total_cmp);
    let after = |times: &&Times| times.quiet.iter().filter(|time| last.is_none_or(|last| **time > last)).count();
    (last, all.iter().map(after).sum::<usize>() as u64)
}

/// Returns the new fields `since` and `events` of the watch. Returns `None` if too few event times are known, or if
/// time stands still.
pub fn standstill(all: &[&Times], watch: &StandstillWatch, span: f64) -> Option<(f64, u64)> {
    let shortest = span * SHORTEST_ADVANCE;
    let is_complete = |times: &Times| times.executed == times.last.len() as u64;
    let mut times: Vec<f64> = all.iter().flat_map(|times| times.last.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    let mut standstill = (watch.since, watch.events);
    let known = all.iter().filter(|times| !is_complete(times));
    if let Some(first) = known.filter_map(|times| times.last.first().copied()).max_by(f64::total_cmp) {
        times.retain(|time| *time >= first);
        let moves = (1..times.len()).rev().find(|&k| times[k] - times[k - 1] > shortest)?;
        standstill = (times[moves], 0);
        times.drain(..=moves);
    }
    for time in times {
        standstill = if time - standstill.0 > shortest { (time, 0) } else { (standstill.0, standstill.1 + 1) };
        if standstill.1 > watch.most {
            return None;
        }
    }
    Some(standstill)
}

/// Returns the events of all domains in time order; `None` if two domains had simultaneous events.
pub fn merged(outcomes: &mut [Outcome]) -> Option<Vec<Seen>> {
    let mut events: Vec<(usize, Seen)> = Vec::new();
    for (number, outcome) in outcomes.iter_mut().enumerate() {
        events.extend(outcome.tally.events.drain(..).map(|seen| (number, seen)));
    }
    events.sort_by(|(_, one), (_, other)| one.time.total_cmp(&other.time));
    let is_tied = |pair: &[(usize, Seen)]| pair[0].1.time == pair[1].1.time && pair[0].0 != pair[1].0;
    if events.windows(2).any(is_tied) {
        return None;
    }
    Some(events.into_iter().map(|(_, seen)| seen).collect())
}
