//! One system on several cores: domains that run alone for a window and are compared exactly afterwards.
//!
//! The box is cut into slabs. Each domain is an ordinary engine over the particles that it *owns* and copies of those around them. In a window of
//! simulated time each runs alone; what copies at its edge do is wrong sooner or later, because their neighbours are missing. At the end, each step of a
//! copy that an owned particle can have read is compared with the owner's. If all agree, everything owned is right to the bit:
//!
//! *Proof.* Take the earliest step of any owned particle, in any domain, that differs from that of one engine for all. Something that it read differed
//! before: an owned particle (but this was the earliest), a copy that can be read (but it agrees with its owner, whose steps before this one are right), or
//! a particle of which the domain has no copy (but its owner, whose steps are right, has seen that it did not come where it can be read).
//!
//! If they do not agree, the window is undone and ends before the first difference. What cannot be told apart this way (simultaneous events of
//! two domains that someone watches, time that stands still, the end of a run at a number of events) is left to the one engine.

mod domain;
mod exchange;
mod regions;

use super::observe::Observe;
use super::parts::Engine;
use super::{EngineError, Reason, Until};
use crate::engine::clock::SHORTEST_ADVANCE;
use domain::{Domain, Seen};
pub(super) use exchange::hash;
use exchange::{Compared, Published};
use regions::{Halo, MOST_DOMAINS, Regions};
use std::fmt;
use std::thread;
use std::time::{Duration, Instant};

/// Steps of a window in each domain, at most and at the start.
const MOST_STEPS: f64 = 40_000.0;

/// Steps of the one engine where the domains cannot go on.
const SERIAL_STEPS: u64 = 2_000;

/// The halo that is as wide as windows of so many steps need.
const HALO: Halo = Halo { slack: 0.5, margin: 1.5 };

/// Why a system runs in one thread.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SingleThread {
    /// Particles of a heat bath are drawn among all.
    HeatBath,
    /// Diameters grow.
    Growth,
    /// The sides of the box slide past each other.
    SlidingImages,
    /// Some pairs have interactions of their own that the neighbour search does not reach, or may start further apart than they reach.
    LongInteractions,
}

impl fmt::Display for SingleThread {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::HeatBath => "a heat bath acts on all particles",
            Self::Growth => "the diameters grow",
            Self::SlidingImages => "the box is sheared",
            Self::LongInteractions => "bonds or starts reach further than the neighbour search",
        })
    }
}

/// How the work of domains went.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct DomainWork {
    /// Windows whose steps agreed.
    pub windows: u64,
    /// Windows that ended before a difference.
    pub differences: u64,
    /// Windows that ended because a particle came too far.
    pub uncovered: u64,
    /// Times that the domains were cut anew.
    pub cuts: u64,
    /// Stretches that one engine did for all.
    pub serial: u64,
    /// Steps of all particles, and of all domains together, which do those of copies, too.
    pub steps: [u64; 2],
    /// Wall time in the steps of windows.
    pub simulating: Duration,
    /// Wall time in the comparison of domains.
    pub comparing: Duration,
    /// Wall time in the exchange of copies.
    pub exchanging: Duration,
    /// Wall time until one engine has all.
    pub gathering: Duration,
    /// Wall time until domains have what one engine has.
    pub cutting: Duration,
}

/// The domains of a system.
#[derive(Debug, Clone)]
pub struct Domains<const FALLING: bool, const TABLE: bool> {
    count: usize,
    threads: usize,
    halo: Halo,
    /// Steps in a window, of each domain.
    steps_of_window: f64,
    /// Length of the next window `[time]`.
    length: f64,
    /// Empty while the one engine has all.
    cut: Option<Cut<FALLING, TABLE>>,
    pub work: DomainWork,
}

/// A system that is cut.
#[derive(Debug, Clone)]
struct Cut<const FALLING: bool, const TABLE: bool> {
    regions: Regions,
    domains: Vec<Domain<FALLING, TABLE>>,
    /// Up to where all domains have come, since the epoch.
    now: f64,
    /// Steps of the epoch so far.
    steps: u64,
    /// Whether the one engine has what the domains have.
    is_settled: bool,
    /// Whether no window has agreed yet.
    is_fresh: bool,
    /// By domain, what has come of the last comparison.
    compared: Vec<Compared>,
}

/// How a window ended.
enum End {
    /// All agree.
    Agreed,
    /// Nothing can be done before this: a difference of copies, or a particle that came too far.
    Difference(f64),
    Uncovered(f64),
}

/// How the domains go on.
enum Next {
    Done,
    Serial,
    Return(Reason),
}

impl fmt::Display for DomainWork {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { windows, differences, uncovered, cuts, serial, steps, .. } = self;
        let undone = differences + uncovered;
        let [own, all] = steps.map(|steps| steps as f64);
        let times = [self.simulating, self.comparing, self.exchanging, self.gathering, self.cutting];
        let [simulating, comparing, exchanging, gathering, cutting] = times.map(|time| time.as_secs_f64());
        write!(
            f,
            "{windows} windows, {undone} undone; domains cut {cuts} times, {serial} stretches in one thread\n\
             {:.2} steps for each one needed; {simulating:.1} s simulating, {comparing:.1} s comparing, {exchanging:.1} s exchanging, \
             {gathering:.1} s gathering, {cutting:.1} s cutting",
            if own > 0.0 { all / own } else { 1.0 },
        )
    }
}

impl<const FALLING: bool, const TABLE: bool> Domains<FALLING, TABLE> {
    pub fn new(count: usize, threads: usize, halo: Halo) -> Self {
        Self { count, threads, halo, steps_of_window: MOST_STEPS, length: 0.0, cut: None, work: DomainWork::default() }
    }

    /// Why a system cannot be cut, if it cannot.
    pub fn obstacle(engine: &Engine<FALLING, TABLE>) -> Option<SingleThread> {
        let reaches = engine.pairs.has_own_interactions || !engine.ranges.are_captured_near();
        match () {
            () if engine.sources.andersen.is_some() => Some(SingleThread::HeatBath),
            () if !engine.distances.are_constant() => Some(SingleThread::Growth),
            () if engine.images.slide() => Some(SingleThread::SlidingImages),
            () if reaches || engine.ranges.may_be_overstretched => Some(SingleThread::LongInteractions),
            () => None,
        }
    }

    /// Goes on as [`Engine::advance_for`] does, with the same bits. Where it pauses, the one engine is behind until [`Self::settle`].
    pub fn advance_for(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        let mut left = steps;
        loop {
            if left == 0 {
                return Ok(None);
            }
            if let Some(broken) = whole.broken {
                return Err(broken.into());
            }
            let next = if Self::obstacle(whole).is_none() {
                let done = whole.counts.totals.transition + whole.counts.executed;
                let next = self.window(whole, until, observe)?;
                left = left.saturating_sub((whole.counts.totals.transition + whole.counts.executed - done).max(1));
                next
            } else {
                Next::Serial
            };
            match next {
                Next::Done => {}
                Next::Return(reason) => return Ok(Some(reason)),
                Next::Serial => {
                    self.work.serial += 1;
                    self.join(whole);
                    if let Some(reason) = whole.advance_for(left.min(SERIAL_STEPS), until, observe)? {
                        return Ok(Some(reason));
                    }
                    left = left.saturating_sub(SERIAL_STEPS);
                }
            }
        }
    }

    /// Has the domains run a window, up to the end of the run or of the epoch at most.
    fn window(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Next, EngineError> {
        if whole.counts.executed >= until.events {
            return Ok(Next::Serial);
        }
        let end = whole.since_epoch(until.time);
        let mut cut = match self.cut.take() {
            Some(cut) => cut,
            None => self.cut_up(whole),
        };
        let tick = whole.schedule.queue.next_tick(cut.now);
        let mut stop = (cut.now + self.length).min(tick.next_down()).min(end);
        // A window that is undone ends the second time before what was wrong.
        for _ in 0..2 {
            match cut.run(self.threads, stop, observe.is_some(), &mut self.work) {
                End::Agreed => {
                    return self.finish(whole, cut, (stop, end, tick), until, observe);
                }
                End::Difference(time) => {
                    self.work.differences += 1;
                    self.steps_of_window *= 0.7;
                    cut.undo(self.threads);
                    stop = time.next_down();
                }
                End::Uncovered(time) => {
                    self.work.uncovered += 1;
                    cut.undo(self.threads);
                    stop = time.next_down();
                }
            }
            if stop <= cut.now {
                break;
            }
        }
        // Nothing can be done with these domains: with others perhaps, and the one engine can do anything.
        let is_fresh = cut.is_fresh;
        self.cut = Some(cut);
        self.join(whole);
        Ok(if is_fresh { Next::Serial } else { Next::Done })
    }

    /// Accepts a window whose steps agree, unless it is for the one engine to end it.
    fn finish(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        mut cut: Cut<FALLING, TABLE>,
        (stop, end, tick): (f64, f64, f64),
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Next, EngineError> {
        let executed = cut.domains.iter().map(|domain| domain.engine.counts.executed).sum::<u64>();
        let events = merged(&mut cut.domains);
        let standstill = cut.standstill(whole);
        let (Some(events), Some(standstill)) = (events, standstill) else {
            return Ok(self.give_up(cut));
        };
        if whole.counts.executed + executed >= until.events {
            return Ok(self.give_up(cut));
        }
        if let Some(observe) = observe {
            for (shown, seen) in (1..).zip(&events) {
                if observe(&seen.event).is_break() {
                    let executed = whole.counts.executed + shown;
                    let _ = self.give_up(cut);
                    self.join(whole);
                    whole.advance(Until { events: executed, ..until }, &mut None)?;
                    return Ok(Next::Return(Reason::Observer));
                }
            }
        }
        let (last, quiet) = cut.quiet();
        for domain in &mut cut.domains {
            cut.steps += domain.done;
            self.work.steps[0] += domain.done;
            self.work.steps[1] += domain.done_in_all;
            whole.counts.merge(&domain.engine.counts);
            *domain.engine.counts = domain.engine.no_counts();
            domain.engine.counts.accepted_overlap = whole.counts.accepted_overlap;
        }
        if last.is_some() {
            whole.counts.transitions_at_event = whole.counts.totals.transition.wrapping_sub(quiet);
        }
        (whole.clock.standstill.since, whole.clock.standstill.events) = standstill;
        let done = cut.domains.iter().map(|domain| domain.done).sum::<u64>() as f64 / self.count as f64;
        self.work.windows += 1;
        self.steps_of_window = (self.steps_of_window * 1.01).min(MOST_STEPS);
        let length = stop - cut.now;
        if stop < end && stop < tick.next_down() {
            self.length = length * (self.steps_of_window / done.max(1.0)).clamp(0.5, 2.0);
        }
        let begin = Instant::now();
        cut.exchange(self.threads);
        self.work.exchanging += begin.elapsed();
        (cut.now, cut.is_settled, cut.is_fresh) = (stop, false, false);
        whole.clock.now = stop;
        let is_tick = stop == tick.next_down();
        let steps = cut.steps;
        if is_tick && !whole.schedule.queue.ends_at(tick, steps) {
            cut.now = tick;
        }
        self.cut = Some(cut);
        if stop == end {
            self.settle(whole);
            return Ok(Next::Return(Reason::Time));
        }
        if is_tick && whole.schedule.queue.ends_at(tick, steps) {
            return Ok(self.move_epoch(whole, until));
        }
        if self.cut.iter().flat_map(|cut| &cut.domains).any(Domain::has_grown) {
            self.join(whole);
        }
        Ok(Next::Done)
    }

    /// Ends the epoch as the event loop does, and has the domains follow.
    fn move_epoch(&mut self, whole: &mut Engine<FALLING, TABLE>, until: Until) -> Next {
        self.gather(whole);
        if until.time == f64::INFINITY && whole.is_shown_to_be_over() {
            return Next::Return(Reason::Idle);
        }
        let Some(cut) = &mut self.cut else { return Next::Done };
        whole.schedule.queue.resume(cut.now, cut.steps);
        let Some(moved) = whole.move_epoch() else {
            if until.time == f64::INFINITY {
                return Next::Return(Reason::Idle);
            }
            whole.clock.now = whole.since_epoch(until.time);
            return Next::Return(Reason::Time);
        };
        if moved.is_rearranged {
            self.cut = None;
        } else {
            let begin = Instant::now();
            (cut.now, cut.steps) = (whole.clock.now, 0);
            let whole = &*whole;
            in_parallel(self.threads, cut.domains.iter_mut().collect(), |domain| domain.follow(whole, moved));
            self.work.cutting += begin.elapsed();
        }
        Next::Done
    }

    /// Undoes a window that the one engine is to do.
    fn give_up(&mut self, mut cut: Cut<FALLING, TABLE>) -> Next {
        cut.undo(self.threads);
        self.cut = Some(cut);
        Next::Serial
    }

    /// Cuts the system.
    fn cut_up(&mut self, whole: &Engine<FALLING, TABLE>) -> Cut<FALLING, TABLE> {
        self.work.cuts += 1;
        let begin = Instant::now();
        let regions = Regions::of(whole, self.count, self.halo);
        let numbers: Vec<u8> = (0..).take(self.count).collect();
        let queue = &whole.schedule.queue;
        let share = self.steps_of_window * self.count as f64 / queue.target() as f64;
        if self.length == 0.0 {
            self.length = queue.span() * share.min(1.0);
        }
        let domains = in_parallel(self.threads, numbers, |number| Domain::of(whole, &regions, number));
        self.work.cutting += begin.elapsed();
        Cut {
            domains,
            regions,
            now: whole.clock.now,
            steps: queue.steps(),
            is_settled: true,
            is_fresh: true,
            compared: Vec::new(),
        }
    }

    /// Gives the one engine what the domains have.
    pub fn settle(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        if self.gather(whole) {
            for particle in whole.particles() {
                whole.enqueue(particle);
            }
        }
    }

    /// Gives the one engine what the domains have, but entries for its queue; whether there was anything to give.
    fn gather(&mut self, whole: &mut Engine<FALLING, TABLE>) -> bool {
        let Some(cut) = self.cut.as_mut().filter(|cut| !cut.is_settled) else { return false };
        let begin = Instant::now();
        cut.is_settled = true;
        whole.clock.now = cut.now;
        whole.schedule.queue.resume(cut.now, cut.steps);
        for domain in &mut cut.domains {
            for particle in domain
                .engine
                .particles()
                .filter(|&particle| domain.held[particle as usize].is_owned())
                .collect::<Vec<_>>()
            {
                let mut record = domain.engine.record(particle);
                record.renumber(|number| domain.held.get(number as usize).map(|held| held.whole));
                whole.write_record(domain.held[particle as usize].whole, &record);
            }
        }
        if let Some(lists) = whole.neighbours.lists_mut() {
            let mut list = Vec::new();
            for domain in &cut.domains {
                let Some(verlet) = domain.engine.neighbours.verlet() else { continue };
                for particle in domain.engine.particles().filter(|&particle| domain.held[particle as usize].is_owned())
                {
                    list.clear();
                    list.extend(verlet.lists.of(particle).iter().map(|&other| domain.held[other as usize].whole));
                    lists.set(domain.held[particle as usize].whole, &list);
                }
            }
        }
        self.work.gathering += begin.elapsed();
        true
    }

    /// Leaves everything to the one engine.
    pub fn join(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        self.settle(whole);
        self.cut = None;
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Runs in so many domains on so many threads from now on; in one without any of this.
    pub(super) fn set_domains(&mut self, domains: usize, threads: usize) {
        self.join();
        let domains = domains.clamp(1, MOST_DOMAINS);
        self.domains = (domains > 1).then(|| Box::new(Domains::new(domains, threads, HALO)));
    }

    /// Goes on as [`Self::advance_for`] does, in domains if there are some. Then it is behind them until [`Self::settle`].
    pub(super) fn advance_on_cores(
        &mut self,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        let Some(mut domains) = self.domains.take() else { return self.advance_for(steps, until, observe) };
        let reason = domains.advance_for(self, steps, until, observe);
        self.domains = Some(domains);
        reason
    }

    /// Takes over what the domains have.
    pub(super) fn settle(&mut self) {
        if let Some(mut domains) = self.domains.take() {
            domains.settle(self);
            self.domains = Some(domains);
        }
    }

    /// Takes over what the domains have before it is changed from outside.
    pub(super) fn join(&mut self) {
        if let Some(mut domains) = self.domains.take() {
            domains.join(self);
            self.domains = Some(domains);
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Cut<FALLING, TABLE> {
    /// Has each domain run alone, and compares.
    fn run(&mut self, threads: usize, stop: f64, is_observed: bool, work: &mut DomainWork) -> End {
        let regions = &self.regions;
        let begin = Instant::now();
        let trouble = in_parallel(threads, self.domains.iter_mut().collect(), |domain| {
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
        self.compared = in_parallel(threads, domains.iter().collect(), |domain| domain.compare(regions, domains));
        work.comparing += begin.elapsed();
        let differences = self.compared.iter().map(|compared| compared.difference).collect();
        earliest(differences).map_or(End::Agreed, End::Difference)
    }

    fn undo(&mut self, threads: usize) {
        let now = self.now;
        in_parallel(threads, self.domains.iter_mut().collect(), |domain| domain.undo(now));
    }

    /// Makes all copies what their owners have.
    fn exchange(&mut self, threads: usize) {
        let with_compared = self.domains.iter().zip(&self.compared);
        let published: Vec<Vec<Published>> =
            in_parallel(threads, with_compared.collect(), |(domain, compared)| domain.publish(&compared.to_publish));
        let compared = &self.compared;
        in_parallel(threads, self.domains.iter_mut().enumerate().collect(), |(number, domain)| {
            domain.refresh(&published, compared, number);
        });
    }

    /// The time of the last event of this window, and how many transitions came after it.
    fn quiet(&self) -> (Option<f64>, u64) {
        let last = self.domains.iter().filter_map(|domain| domain.last.last().copied()).max_by(f64::total_cmp);
        let after = |domain: &Domain<FALLING, TABLE>| {
            domain.quiet.iter().filter(|time| last.is_none_or(|last| **time > last)).count() as u64
        };
        (last, self.domains.iter().map(after).sum())
    }

    /// Since when time stands still, and the number of events since then; none if that cannot be told.
    fn standstill(&self, whole: &Engine<FALLING, TABLE>) -> Option<(f64, u64)> {
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
fn merged<const FALLING: bool, const TABLE: bool>(domains: &mut [Domain<FALLING, TABLE>]) -> Option<Vec<Seen>> {
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

/// Does something with each of some items on so many threads, and collects the results in their order.
fn in_parallel<I: Send, R: Send>(threads: usize, items: Vec<I>, work: impl Fn(I) -> R + Sync) -> Vec<R> {
    if threads < 2 || items.len() < 2 {
        return items.into_iter().map(work).collect();
    }
    let each = items.len().div_ceil(threads);
    let mut shares: Vec<Vec<I>> = Vec::new();
    let mut items = items.into_iter();
    loop {
        let share: Vec<I> = items.by_ref().take(each).collect();
        if share.is_empty() {
            break;
        }
        shares.push(share);
    }
    let work = &work;
    thread::scope(|scope| {
        let last = shares.pop();
        let others: Vec<_> = shares
            .into_iter()
            .map(|share| scope.spawn(move || share.into_iter().map(work).collect::<Vec<R>>()))
            .collect();
        let last: Vec<R> = last.into_iter().flatten().map(work).collect();
        let mut results: Vec<R> = Vec::new();
        for other in others {
            match other.join() {
                Ok(some) => results.extend(some),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        results.extend(last);
        results
    })
}

#[cfg(test)]
mod tests;
