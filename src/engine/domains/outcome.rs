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

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Tally {
    /// Number of engine steps of owned particles in this window, and total number of engine steps.
    pub done: u64,
    pub done_in_all: u64,
    /// Time of the last step of an owned particle in this window.
    pub latest: f64,
    pub events: Vec<Seen>,
    /// Times of the latest events of owned particles, and of the transitions after the last event.
    pub last: Vec<f64>,
    pub quiet: Vec<f64>,
}

impl Tally {
    pub fn new() -> Self {
        Self {
            done: 0,
            done_in_all: 0,
            latest: f64::NEG_INFINITY,
            events: Vec::new(),
            last: Vec::new(),
            quiet: Vec::new(),
        }
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

/// Returns the time of the last event of a window, and the number of transitions after it.
pub fn quiet(outcomes: &[Outcome]) -> (Option<f64>, u64) {
    let last = outcomes.iter().filter_map(|outcome| outcome.tally.last.last().copied()).max_by(f64::total_cmp);
    let after =
        |outcome: &Outcome| outcome.tally.quiet.iter().filter(|time| last.is_none_or(|last| **time > last)).count();
    (last, outcomes.iter().map(after).sum::<usize>() as u64)
}

/// Returns the new fields `since` and `events` of the watch. Returns `None` if too few event times are known, or if
/// time stands still.
pub fn standstill(outcomes: &[Outcome], watch: &StandstillWatch, span: f64) -> Option<(f64, u64)> {
    let shortest = span * SHORTEST_ADVANCE;
    let is_complete = |outcome: &Outcome| outcome.counts.executed == outcome.tally.last.len() as u64;
    let mut times: Vec<f64> = outcomes.iter().flat_map(|outcome| outcome.tally.last.iter().copied()).collect();
    times.sort_by(f64::total_cmp);
    let mut standstill = (watch.since, watch.events);
    let known = outcomes.iter().filter(|outcome| !is_complete(outcome));
    if let Some(first) = known.filter_map(|outcome| outcome.tally.last.first().copied()).max_by(f64::total_cmp) {
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
