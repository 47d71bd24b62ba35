//! One system in several processes: domains run alone for a window of time and are compared exactly afterwards. Threads of
//! one process share one engine instead, see [`super::slabs`].
//!
//! The box is cut into blocks. Each domain is an ordinary engine for the particles that it *owns* and for copies of the
//! particles around them. A domain runs alone for a window of simulated time. Copies at the edge of the domain sooner
//! or later deviate from their owners, because their neighbours are missing. At the end of the window, the steps of all
//! copies that an owned particle may have read are compared with the steps of the owners. If all steps agree, every
//! owned particle is correct, bit for bit:
//!
//! *Proof.* Suppose that steps of owned particles differ from the steps of a single engine. Take the earliest such step
//! in any domain. This step read a particle that was already different. The particle is not owned, because this step is
//! the earliest. It is not a readable copy, because readable copies agree with their owners, and the earlier steps of
//! the owners are right. A particle without a copy in this domain was not read either: its owner has checked that the
//! particle did not enter the readable region, and the earlier steps of the owner are right. So there is no such step.
//!
//! If a copy differs from its owner, the window is rolled back and repeated up to the first difference. The single
//! engine takes over if events of two domains are simultaneous in an observed run, if time stands still, or if the run
//! ends at a number of events.

#[cfg(any(test, debug_assertions))]
mod checks;
mod cut;
mod domain;
mod epochs;
mod exchange;
mod gather;
mod outcome;
mod regions;
mod team;
mod window;
mod work;

use super::communicator::Communicator;
use super::observe::Observe;
use super::parts::Engine;
use super::progress::{self, Times};
use super::{EngineError, Reason, Until};
use cut::{Cut, End};
use domain::Domain;
use regions::{Halo, Regions};
use std::sync::Arc;
use std::time::Instant;
use team::Team;
pub use work::DomainWork;

/// Target number of steps of a domain in a window: the initial value and the upper limit.
const MOST_STEPS: f64 = 10_000.0;

/// Number of steps that the single engine runs when the domains cannot continue.
const SERIAL_STEPS: u64 = 2_000;

/// The single engine finishes a run that ends at a number of events. It runs at least this number of steps at a time,
/// even if the caller requests fewer.
const LEAST_SERIAL: u64 = 50_000;

/// After this many short windows in a row, the single engine runs for a while, because it is faster.
const MOST_SHORT: u32 = 8;
const FEWEST_STEPS: u64 = 8;

/// Number of recent rollbacks above which the halo is too thin.
const MOST_UNDONE: f64 = 4.0;
/// Increase of the widths of a halo that is too thin.
const WIDER: Halo = Halo { slack: 0.1, margin: 0.3 };

const HALO: Halo = Halo { slack: 0.2, margin: 1.1 };

/// A system that runs in domains.
#[derive(Debug, Clone)]
pub struct Domains<const FALLING: bool, const TABLE: bool> {
    team: Team,
    halo: Halo,
    steps_of_window: f64,
    length: f64,
    /// Recent rollbacks; decays by 5 % per accepted window.
    undone: f64,
    short: u32,
    /// Number of accepted windows at the last check; `None` without checks.
    #[cfg(any(test, debug_assertions))]
    checked: Option<u64>,
    /// The domains of the system; `None` while the single engine holds all particles.
    cut: Option<Cut<FALLING, TABLE>>,
    pub work: DomainWork,
}

enum Next {
    Done,
    /// The single engine runs this number of steps.
    Serial(u64),
    Return(Reason),
}

impl<const FALLING: bool, const TABLE: bool> Domains<FALLING, TABLE> {
    /// Creates `domains` domains for each process, at most 64 in all, which run on `threads` threads.
    pub fn new(domains: usize, threads: usize, communicator: Option<Arc<dyn Communicator>>) -> Self {
        Self::with(Team::new(domains, threads, communicator), HALO)
    }

    fn with(team: Team, halo: Halo) -> Self {
        Self {
            team,
            halo,
            steps_of_window: MOST_STEPS,
            length: 0.0,
            undone: 0.0,
            short: 0,
            #[cfg(any(test, debug_assertions))]
            checked: cfg!(debug_assertions).then_some(0),
            cut: None,
            work: DomainWork::default(),
        }
    }

    /// Continues a run with exactly the same results as [`Engine::advance_for`]. Between calls, the single engine is
    /// out of date until [`Self::settle`] is called.
    pub fn advance_for(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        if observe.is_some() {
            return self.advance_in_windows(whole, steps, until, observe);
        }
        // The loop runs on a worker thread, because a worker starts the other workers faster than this thread could.
        let team = self.team.clone();
        team.within(|| self.advance_in_windows(whole, steps, until, &mut None))
    }

    fn advance_in_windows(
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
            let next = if whole.obstacle().is_none() {
                let done = whole.counts.totals.transition + whole.counts.executed;
                #[cfg(any(test, debug_assertions))]
                let other = self.copy_to_check(whole);
                let next = self.window(whole, until, observe)?;
                #[cfg(any(test, debug_assertions))]
                self.check_window(whole, until, other);
                let done = whole.counts.totals.transition + whole.counts.executed - done;
                left = left.saturating_sub(done.max(1));
                self.short = if done < FEWEST_STEPS { self.short + 1 } else { 0 };
                if self.short > MOST_SHORT && matches!(next, Next::Done) {
                    self.short = 0;
                    Next::Serial(SERIAL_STEPS)
                } else {
                    next
                }
            } else {
                Next::Serial(SERIAL_STEPS)
            };
            match next {
                Next::Done => {}
                Next::Return(reason) => return Ok(Some(reason)),
                Next::Serial(steps) => {
                    self.work.serial += 1;
                    self.join(whole);
                    // A new cut of the system costs much more than some extra steps of the single engine.
                    if let Some(reason) = whole.advance_for(steps.min(left.max(LEAST_SERIAL)), until, observe)? {
                        return Ok(Some(reason));
                    }
                    left = left.saturating_sub(steps);
                }
            }
        }
    }

    /// Runs a window in the domains, at most to the end of the run or of the epoch.
    fn window(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Next, EngineError> {
        if whole.counts.executed >= until.last_event() {
            return Ok(Next::Serial(SERIAL_STEPS));
        }
        let end = whole.since_epoch(until.last_time());
        let mut cut = match self.cut.take() {
            Some(cut) => cut,
            None => self.cut_up(whole),
        };
        if cut.now >= whole.schedule.queue.span() {
            self.cut = Some(cut);
            return Ok(self.move_epoch(whole, until));
        }
        let tick = whole.schedule.queue.next_tick(cut.now);
        let mut stop = (cut.now + self.length).min(tick.next_down()).min(end);
        // After a rollback, the window is repeated once, up to the time of the failure.
        for _ in 0..2 {
            cut.draw_collisions(whole, stop);
            match cut.run(&self.team, stop, observe.is_some(), &mut self.work) {
                End::Agreed => {
                    return self.finish(whole, cut, (stop, end, tick), until, observe);
                }
                End::Difference(time) => {
                    self.work.differences += 1;
                    self.steps_of_window *= 0.7;
                    stop = time.next_down();
                }
                End::Uncovered(time) => {
                    self.work.uncovered += 1;
                    stop = time.next_down();
                }
            }
            cut.undo(whole, &self.team);
            self.undone += 1.0;
            if stop <= cut.now {
                break;
            }
        }
        // The domains cannot continue. A new cut helps only if a window was accepted since the last cut. Otherwise, the
        // new domains would be the same, and the single engine runs for a while instead.
        let is_fresh = cut.is_fresh;
        self.cut = Some(cut);
        self.join(whole);
        Ok(if is_fresh { Next::Serial(SERIAL_STEPS) } else { Next::Done })
    }

    fn finish(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        mut cut: Cut<FALLING, TABLE>,
        (stop, end, tick): (f64, f64, f64),
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Next, EngineError> {
        let executed = cut.outcomes.iter().map(|outcome| outcome.counts.executed).sum::<u64>();
        let events = progress::merged(cut.outcomes.iter().map(|outcome| &*outcome.tally.events));
        let times: Vec<&Times> = cut.outcomes.iter().map(|outcome| &outcome.tally.times).collect();
        let standstill = progress::standstill(&times, &whole.clock.standstill, whole.schedule.queue.span());
        let (Some(events), Some(standstill)) = (events, standstill) else {
            self.give_up(whole, cut);
            return Ok(Next::Serial(SERIAL_STEPS));
        };
        if whole.counts.executed + executed >= until.last_event() {
            // The run ends in this window, at an event that only the single engine can find.
            self.give_up(whole, cut);
            return Ok(Next::Serial(u64::MAX));
        }
        if let Some(observe) = observe {
            for (shown, event) in (1_u64..).zip(&events) {
                if observe(event).is_break() {
                    self.give_up(whole, cut);
                    self.join(whole);
                    return Ok(Next::Return(whole.advance_to_event(shown, until)?));
                }
            }
        }
        let length = stop - cut.now;
        let share = self.accept(whole, &mut cut, stop);
        (whole.clock.standstill.since, whole.clock.standstill.events) = standstill;
        let is_tick = stop == tick.next_down();
        if stop < end && !is_tick {
            self.length = length * (self.steps_of_window / share.max(1.0)).clamp(0.5, 2.0);
        }
        let ends_epoch = is_tick && whole.schedule.queue.ends_at(tick, cut.steps);
        if is_tick && !ends_epoch {
            cut.now = tick;
        }
        if stop == end {
            cut.latest = stop;
        }
        self.cut = Some(cut);
        if stop == end {
            self.settle(whole);
            return Ok(Next::Return(Reason::Time));
        }
        if ends_epoch {
            return Ok(self.move_epoch(whole, until));
        }
        let is_thin = self.undone > MOST_UNDONE;
        if is_thin {
            self.undone = 0.0;
            self.halo.slack += WIDER.slack;
            self.halo.margin += WIDER.margin;
        }
        if is_thin || self.cut.iter().flat_map(|cut| &cut.outcomes).any(|outcome| outcome.has_grown) {
            self.join(whole);
        }
        Ok(Next::Done)
    }

    /// Returns the mean number of steps per domain.
    fn accept(&mut self, whole: &mut Engine<FALLING, TABLE>, cut: &mut Cut<FALLING, TABLE>, stop: f64) -> f64 {
        let times: Vec<&Times> = cut.outcomes.iter().map(|outcome| &outcome.tally.times).collect();
        let (last, quiet) = progress::quiet(&times);
        let mut done = 0;
        for outcome in &cut.outcomes {
            done += outcome.tally.done;
            cut.latest = cut.latest.max(outcome.tally.latest);
            self.work.steps[1] += outcome.tally.done_in_all;
            whole.counts.merge(&outcome.counts);
        }
        for domain in &mut cut.domains {
            domain.engine.counts.accepted_overlap = whole.counts.accepted_overlap;
        }
        if last.is_some() {
            whole.counts.transitions_at_event = whole.counts.totals.transition.wrapping_sub(quiet);
        }
        self.work.windows += 1;
        self.work.steps[0] += done;
        self.undone *= 0.95;
        self.steps_of_window = (self.steps_of_window * 1.01).min(MOST_STEPS);
        let begin = Instant::now();
        cut.exchange(&self.team);
        self.work.exchanging += begin.elapsed();
        self.work.sent = self.team.sent();
        cut.steps += done;
        (cut.now, cut.is_fresh) = (stop, false);
        (cut.is_settled, cut.is_complete) = (false, false);
        whole.clock.now = stop;
        done as f64 / self.team.domains() as f64
    }

    /// Rolls back a window and leaves it to the single engine.
    fn give_up(&mut self, whole: &mut Engine<FALLING, TABLE>, mut cut: Cut<FALLING, TABLE>) {
        cut.undo(whole, &self.team);
        self.cut = Some(cut);
    }

    /// Cuts the system. The single engine frees memory that it does not need meanwhile.
    fn cut_up(&mut self, whole: &mut Engine<FALLING, TABLE>) -> Cut<FALLING, TABLE> {
        self.work.cuts += 1;
        let begin = Instant::now();
        let regions = Regions::of(whole, self.team.domains(), self.halo);
        let numbers: Vec<u8> = self.team.numbers().filter_map(|number| u8::try_from(number).ok()).collect();
        let queue = &whole.schedule.queue;
        let share = self.steps_of_window * self.team.domains() as f64 / queue.target() as f64;
        if self.length == 0.0 {
            self.length = queue.span() * share.min(1.0);
        }
        let steps = queue.steps();
        let domains = {
            let whole = &*whole;
            self.team.each(numbers, |number| Domain::of(whole, &regions, number))
        };
        whole.schedule.queue.clear();
        if let Some(lists) = whole.neighbours.lists_mut() {
            lists.let_go();
        }
        self.work.cutting += begin.elapsed();
        Cut {
            domains,
            regions,
            // No event is due before the epoch, so the domains can start there.
            now: whole.clock.now.max(0.0),
            latest: whole.clock.now,
            steps,
            is_settled: false,
            is_complete: false,
            is_fresh: true,
            compared: Vec::new(),
            outcomes: Vec::new(),
            bath: None,
        }
    }
}

#[cfg(test)]
pub(in crate::engine) mod tests;
