//! Combines the events and transitions of several threads or domains in the order of their times. Finds whether time
//! stands still, and how many transitions follow the last event.

use super::clock::{SHORTEST_ADVANCE, StandstillWatch};
use super::event::Event;
use serde::{Deserialize, Serialize};

/// Number of event times that are kept, to detect that time stands still.
const LAST_EVENTS: usize = 32;

/// An observed event, with the time since the epoch.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Seen {
    pub time: f64,
    pub event: Event,
}

/// Returns the observed events of all domains or threads in time order. Returns `None` if events of two of them were
/// simultaneous.
pub fn merged<'a>(all: impl Iterator<Item = &'a [Seen]>) -> Option<Vec<Event>> {
    let mut events: Vec<(usize, &Seen)> = Vec::new();
    for (number, seen) in all.enumerate() {
        events.extend(seen.iter().map(|seen| (number, seen)));
    }
    events.sort_by(|(_, one), (_, other)| one.time.total_cmp(&other.time));
    let is_tied = |pair: &[(usize, &Seen)]| pair[0].1.time == pair[1].1.time && pair[0].0 != pair[1].0;
    let is_unordered = events.windows(2).any(is_tied);
    (!is_unordered).then(|| events.into_iter().map(|(_, seen)| seen.event).collect())
}

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
