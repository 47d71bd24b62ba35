//! A system that is cut into domains: a window of all of them, and what is decided over all.

use super::domain::{Domain, Seen};
use super::exchange::{Compared, Published};
use super::regions::Regions;
use super::work::DomainWork;
use super::workers::Workers;
use crate::engine::clock::{Moved, SHORTEST_ADVANCE};
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::parts::Engine;
use crate::engine::sources::andersen::Andersen;
use std::time::Instant;

/// A system that is cut.
#[derive(Debug, Clone)]
pub struct Cut<const FALLING: bool, const TABLE: bool> {
    pub regions: Regions,
    pub domains: Vec<Domain<FALLING, TABLE>>,
    /// Up to where all domains have come, since the epoch.
    pub now: f64,
    /// When the last step of all was.
    pub latest: f64,
    /// Steps of the epoch so far.
    pub steps: u64,
    /// Whether the one engine has the state that the domains have, and whether it has all that it needs to go on from there.
    pub is_settled: bool,
    pub is_complete: bool,
    /// Whether no window has agreed yet.
    pub is_fresh: bool,
    /// By domain, what has come of the last comparison.
    pub compared: Vec<Compared>,
    /// The heat bath as it was before this window.
    pub bath: Option<Andersen>,
}

/// How a window ended.
pub enum End {
    /// All agree.
    Agreed,
    /// Nothing can be done before this: a difference of copies, or a particle that came too far.
    Difference(f64),
    Uncovered(f64),
}

impl<const FALLING: bool, const TABLE: bool> Cut<FALLING, TABLE> {
    /// Draws the collisions with the heat bath of a window, for the domains that have their particles.
    pub fn draw_collisions(&mut self, whole: &mut Engine<FALLING, TABLE>, stop: f64) {
        self.bath.clone_from(&whole.sources.andersen);
        if self.bath.is_none() {
            return;
        }
        let collisions = whole.draw_collisions(stop);
        for domain in &mut self.domains {
            let of_domain = collisions.iter().rev().map(|collision| {
                let number = whole.state.numbers[collision.id];
                (domain.here[number as usize], *collision)
            });
            domain.collisions = of_domain.filter(|(here, _)| *here != NO_PARTICLE).collect();
        }
    }

    /// Has each domain run alone, and compares.
    pub fn run(&mut self, workers: &Workers, stop: f64, is_observed: bool, work: &mut DomainWork) -> End {
        let regions = &self.regions;
        let begin = Instant::now();
        let trouble = workers.each(self.domains.iter_mut().collect(), |domain| {
            domain.begin_window();
            domain.run(regions, stop, is_observed);
            domain.trouble
        });
        work.simulating += begin.elapsed();
        let begin = Instant::now();
        let earliest = |times: Vec<Option<f64>>| times.into_iter().flatten().min_by(f64::total_cmp);
        if let Some(time) = earliest(trouble) {
            return End::Uncovered(time);
        }
        let domains = &self.domains;
        self.compared = workers.each(domains.iter().collect(), |domain| domain.compare(regions, domains));
        work.comparing += begin.elapsed();
        let differences = self.compared.iter().map(|compared| compared.difference).collect();
        earliest(differences).map_or(End::Agreed, End::Difference)
    }

    pub fn undo(&mut self, whole: &mut Engine<FALLING, TABLE>, workers: &Workers) {
        if self.bath.is_some() {
            whole.sources.andersen.clone_from(&self.bath);
            whole.schedule_global();
        }
        let now = self.now;
        workers.each(self.domains.iter_mut().collect(), |domain| domain.undo(now));
    }

    /// Makes all copies what their owners have.
    pub fn exchange(&mut self, workers: &Workers) {
        let with_compared = self.domains.iter().zip(&self.compared);
        let published: Vec<Vec<Published>> =
            workers.each(with_compared.collect(), |(domain, compared)| domain.publish(&compared.to_publish));
        let compared = &self.compared;
        workers.each(self.domains.iter_mut().collect(), |domain| domain.refresh(&published, compared));
    }

    /// Has all domains follow the whole into the next epoch.
    pub fn follow(&mut self, whole: &Engine<FALLING, TABLE>, moved: Moved, workers: &Workers) {
        let to_publish = workers.each(self.domains.iter_mut().collect(), |domain| domain.follow(whole, moved));
        self.compared =
            to_publish.into_iter().map(|to_publish| Compared { to_publish, ..Compared::default() }).collect();
        self.exchange(workers);
    }

    /// The time of the last event of this window, and how many transitions came after it.
    pub fn quiet(&self) -> (Option<f64>, u64) {
        let last = self.domains.iter().filter_map(|domain| domain.last.last().copied()).max_by(f64::total_cmp);
        let after = |domain: &Domain<FALLING, TABLE>| {
            domain.quiet.iter().filter(|time| last.is_none_or(|last| **time > last)).count() as u64
        };
        (last, self.domains.iter().map(after).sum())
    }

    /// Since when time stands still, and the number of events since then; none if that cannot be told.
    pub fn standstill(&self, whole: &Engine<FALLING, TABLE>) -> Option<(f64, u64)> {
        let shortest = whole.schedule.queue.span() * SHORTEST_ADVANCE;
        let is_complete = |domain: &Domain<FALLING, TABLE>| domain.engine.counts.executed == domain.last.len() as u64;
        let mut times: Vec<f64> = self.domains.iter().flat_map(|domain| domain.last.iter().copied()).collect();
        times.sort_by(f64::total_cmp);
        let mut standstill = (whole.clock.standstill.since, whole.clock.standstill.events);
        let known = self.domains.iter().filter(|domain| !is_complete(domain));
        if let Some(first) = known.filter_map(|domain| domain.last.first().copied()).max_by(f64::total_cmp) {
            times.retain(|time| *time >= first);
            let moves = (1..times.len()).rev().find(|&k| times[k] - times[k - 1] > shortest)?;
            standstill = (times[moves], 0);
            times.drain(..=moves);
        }
        for time in times {
            standstill = if time - standstill.0 > shortest { (time, 0) } else { (standstill.0, standstill.1 + 1) };
            if standstill.1 > whole.clock.standstill.most {
                return None;
            }
        }
        Some(standstill)
    }
}

/// The events of all domains in the order in which they happened; none if two happened at the same time in two domains.
pub fn merged<const FALLING: bool, const TABLE: bool>(domains: &mut [Domain<FALLING, TABLE>]) -> Option<Vec<Seen>> {
    let mut events: Vec<(usize, Seen)> = Vec::new();
    for (number, domain) in domains.iter_mut().enumerate() {
        events.extend(domain.events.drain(..).map(|seen| (number, seen)));
    }
    events.sort_by(|(_, one), (_, other)| one.time.total_cmp(&other.time));
    let is_tied = |pair: &[(usize, Seen)]| pair[0].1.time == pair[1].1.time && pair[0].0 != pair[1].0;
    if events.windows(2).any(is_tied) {
        return None;
    }
    Some(events.into_iter().map(|(_, seen)| seen).collect())
}
