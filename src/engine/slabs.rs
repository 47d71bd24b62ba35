//! One system on several threads, with the results of one thread, bit for bit.
//!
//! The box is cut into *slabs*, one for each thread. All threads share one engine. They run a short *window* of
//! simulated time in three phases:
//!
//! 1. Each thread executes the steps in its slab, in the order of their times. It holds back steps near the faces of the
//!    slab, because they could read particles that another thread changes. It also holds back steps near a step that it
//!    has held back, because the outcome of that step is not known yet.
//! 2. Each thread executes the steps that were held back in its *strip*. A strip reaches from the middle of a slab to the
//!    middle of the next slab. The few steps near the faces of the strip are held back again.
//! 3. One thread executes the rest.
//!
//! A step of a later phase may come too late: another thread has already executed a step nearby that has a later time.
//! The two steps *conflict*. All steps that may conflict are recorded with their places. After a conflict, all steps of
//! the window are undone, and one thread executes them again.
//!
//! *Proof.* A step reads and changes only particles within reach of its own particles. If the particles of two steps are
//! farther apart, the order of the steps does not matter. If they are nearer, the steps are executed in the order of their
//! times:
//!
//! - In the same phase, both steps are in the same region. One thread executes both, in the order of their times.
//! - In different phases, the steps would conflict if the step of the earlier phase had the later time.
//!
//! Each step therefore finds the same particles as on one thread, and has the same result.
//!
//! *Threads* never use the same data at the same time, unless they only read them. Each step uses only data of its own
//! region, because the layers in which steps are held back are at least as wide as the reach of a step.

mod alias;
mod barrier;
mod covered;
mod cut;
mod geometry;
mod pace;
mod part;
mod places;
mod rooms;
mod stretch;
mod work;

pub use rooms::Rooms;
pub use work::ThreadWork;

use super::observe::Observe;
use super::pairs::rules::Steps;
use super::parts::Engine;
use super::{EngineError, Reason, Until};
use cut::Cut;
use geometry::Geometry;
use pace::Pace;
use std::time::Instant;
use stretch::{End, Progress, Request, SHORTEST};

/// Desired number of steps of a window, per particle. In longer windows, more steps are held back, and conflicts are more
/// frequent.
const WITH_LISTS: f64 = 0.015;
/// The same without neighbour lists. A step then reads more particles.
const WITH_CELLS: f64 = 0.005;
/// Smallest desired number of steps of a window.
const FEWEST_STEPS: f64 = 20.0;
/// Largest desired number of steps of a window, per thread.
const STEPS_PER_THREAD: f64 = 1_500.0;

/// Number of steps of the first window, before its duration is adapted.
const FIRST: f64 = 100.0;

/// A conflict multiplies the desired number of steps by this factor.
const FEWER: f64 = 0.8;
/// A window without a conflict multiplies it by this factor.
const MORE: f64 = 1.001;

/// Smallest width of a slab, in units of the width of the layer at its faces in which steps are held back.
const NARROWEST: f64 = 4.0;

/// Number of steps that the engine executes alone when the threads cannot continue.
const ALONE: u64 = 2_000;

/// One thread executes this number of steps if the run is about to end at a number of events, or if an observer has ended
/// the last run.
const LAST: u64 = 50_000;

/// A system on several threads.
#[derive(Debug, Clone)]
pub struct Slabs {
    threads: usize,
    /// Smallest desired number of steps of a window.
    fewest: f64,
    /// Duration of a window; zero if it is not known yet.
    length: f64,
    /// Desired number of steps of a window. It becomes smaller with each conflict.
    per_window: f64,
    /// Smallest width of a slab, in units of the width of the layer in which steps are held back.
    narrowest: f64,
    /// The slabs; `None` while the engine works alone.
    cut: Option<Cut>,
    /// Whether the queue of the engine is empty although there are no slabs.
    is_queue_empty: bool,
    /// Number of epochs when the system could not be cut.
    refused: Option<u64>,
    /// Whether the observer ended the last run that had one. The next run may end soon, too, so one thread begins it.
    is_interrupted: bool,
    /// `None` to use several threads even if one thread is faster.
    pace: Option<Pace>,
    pub work: ThreadWork,
}

enum Next {
    Continue,
    Return(Reason),
    /// The observer ends the run after this number of events.
    Observer(u64),
    /// The engine executes this number of steps alone.
    Alone(u64),
}

impl Slabs {
    pub fn new(threads: usize) -> Self {
        Self {
            threads,
            fewest: FEWEST_STEPS,
            length: 0.0,
            narrowest: NARROWEST,
            per_window: 0.0,
            is_queue_empty: false,
            refused: None,
            is_interrupted: false,
            pace: Some(Pace::new()),
            cut: None,
            work: ThreadWork::default(),
        }
    }

    /// Uses several threads even if one thread is faster. The slabs may be narrow.
    pub fn always(threads: usize, narrowest: f64) -> Self {
        Self { narrowest, pace: None, ..Self::new(threads) }
    }

    /// Whether one thread is faster, or is tried.
    fn is_alone(&self) -> bool {
        self.pace.as_ref().is_some_and(Pace::is_alone)
    }

    /// Whether the threads have done nothing, because the system could not be cut.
    pub fn is_refused(&self) -> bool {
        self.work.windows == 0 && self.refused.is_some()
    }

    /// Continues a run with exactly the same results as [`Engine::advance_for`]. Returns `None` if only one thread can run
    /// the system. Between calls, the queue of the engine is empty until [`Self::complete`] or [`Self::join`] is called.
    pub fn advance_for<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Option<Result<Option<Reason>, EngineError>> {
        if whole.obstacle().is_some() {
            self.join(whole);
            return None;
        }
        let mut left = steps;
        while left > 0 {
            if let Some(broken) = whole.broken {
                return Some(Err(broken.into()));
            }
            let (begin, epochs, before) = (Instant::now(), whole.clock.epochs, whole.executed_steps());
            let most = self.pace.as_ref().map_or(left, |pace| left.min(pace.steps(whole.state.moving)));
            let (done, result) = self.advance_some(whole, most, until, observe);
            left = left.saturating_sub(done.max(1));
            // The beginning of a long epoch would disturb the measurement.
            let is_disturbed =
                whole.clock.epochs != epochs && whole.schedule.queue.target() > Pace::long_epoch(whole.state.moving);
            if let Some(pace) = self.pace.as_mut().filter(|_| !is_disturbed) {
                pace.note(whole.executed_steps() - before, begin.elapsed(), whole.state.moving);
            }
            if let Some(result) = result.transpose() {
                return Some(result.map(Some));
            }
        }
        Some(Ok(None))
    }

    /// Runs some steps on several threads or on one. Returns their number.
    fn advance_some<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        most: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> (u64, Result<Option<Reason>, EngineError>) {
        let is_interrupted = observe.is_some() && std::mem::take(&mut self.is_interrupted);
        if is_interrupted || self.is_alone() {
            return self.advance_alone(whole, most.min(LAST), until, observe);
        }
        let is_refused = self.refused == Some(whole.clock.epochs);
        if self.cut.is_none() && (is_refused || !self.cut_up(whole)) {
            return self.advance_alone(whole, most, until, observe);
        }
        let (steps, next) = if whole.counts.executed >= until.last_event() {
            (0, Next::Alone(LAST))
        } else {
            self.stretch(whole, most, until, observe)
        };
        match next {
            Next::Continue => (steps, Ok(None)),
            Next::Return(reason) => (steps, Ok(Some(reason))),
            Next::Observer(shown) => {
                self.join(whole);
                self.is_interrupted = true;
                (steps, whole.advance_to_event(shown, until).map(Some))
            }
            Next::Alone(more) => {
                let (done, result) = self.advance_alone(whole, more, until, observe);
                (steps + done, result)
            }
        }
    }

    /// Runs some steps on one thread.
    fn advance_alone<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> (u64, Result<Option<Reason>, EngineError>) {
        self.join(whole);
        let before = whole.executed_steps();
        let result = whole.advance_for(steps, until, observe);
        self.work.alone += whole.executed_steps() - before;
        self.is_interrupted |= matches!(result, Ok(Some(Reason::Observer)));
        (steps, result)
    }

    /// Runs windows until something else has to be done. Returns the number of steps, and how to continue.
    fn stretch<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> (u64, Next) {
        let Some(mut cut) = self.cut.take() else { return (0, Next::Continue) };
        let end = whole.since_epoch(until.last_time());
        if cut.now >= whole.schedule.queue.span() {
            return (0, self.move_epoch(whole, cut, until));
        }
        whole.clock.now = cut.now;
        if std::mem::take(&mut cut.is_complete) {
            whole.schedule.queue.clear();
        }
        let per_particle = if whole.neighbours.verlet().is_some() { WITH_LISTS } else { WITH_CELLS };
        let most = (per_particle * whole.state.moving as f64).max(self.fewest);
        let most = most.min(STEPS_PER_THREAD * cut.parts.len() as f64);
        self.per_window = if self.per_window == 0.0 { most } else { self.per_window.min(most) };
        let request = Request {
            end,
            steps,
            last_event: until.last_event(),
            length: self.length,
            per_window: self.per_window.max(1.0),
            is_alone: std::mem::take(&mut cut.is_alone),
        };
        let (reason, progress) = whole.run_stretch(&mut cut, request, observe);
        whole.take_progress(&mut cut, &progress);
        self.note(&progress);
        self.per_window = (self.per_window * libm::pow(MORE, progress.windows as f64)).min(most);
        let next = match reason {
            End::Pause => Next::Continue,
            End::Time => {
                (cut.latest, whole.clock.now) = (end, end);
                self.cut = Some(cut);
                return (progress.steps, Next::Return(Reason::Time));
            }
            End::Epoch => return (progress.steps, self.move_epoch(whole, cut, until)),
            End::Conflict => {
                self.work.conflicts += 1;
                self.per_window *= FEWER;
                self.length *= FEWER;
                cut.is_alone = true;
                Next::Continue
            }
            End::TooLong => {
                self.length *= 0.25;
                // Very many steps may be due at the same time.
                if self.length > SHORTEST * whole.schedule.queue.span() { Next::Continue } else { Next::Alone(LAST) }
            }
            End::Alone => Next::Alone(ALONE),
            End::LastEvent => Next::Alone(LAST),
            End::Observer(shown) => Next::Observer(shown),
        };
        if reason != End::Pause {
            whole.undo_window(&mut cut);
        }
        self.cut = Some(cut);
        (progress.steps, next)
    }

    fn note(&mut self, progress: &Progress) {
        self.length = progress.length;
        self.work.windows += progress.windows;
        for (sum, steps) in self.work.steps.iter_mut().zip(progress.of_phases) {
            *sum += steps;
        }
    }

    /// Begins the next epoch, and cuts the system anew.
    fn move_epoch<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        mut cut: Cut,
        until: Until,
    ) -> Next {
        let is_endless = until.last_time() == f64::INFINITY;
        cut.give_rooms_back(&mut whole.neighbours);
        // If no event follows, the run ends at the time of the last step.
        whole.clock.now = cut.latest;
        whole.schedule.queue.resume(cut.now, cut.steps);
        if is_endless && whole.is_shown_to_be_over() {
            return Next::Return(Reason::Idle);
        }
        if whole.start_epoch().is_some() {
            self.is_queue_empty = true;
            return Next::Continue;
        }
        if is_endless {
            return Next::Return(Reason::Idle);
        }
        whole.clock.now = whole.since_epoch(until.last_time());
        Next::Return(Reason::Time)
    }

    /// Cuts the system. Returns false if it is too small.
    fn cut_up<const FALLING: bool, const TABLE: bool>(&mut self, whole: &mut Engine<FALLING, TABLE>) -> bool {
        self.refused = Some(whole.clock.epochs);
        let Some(geometry) = Geometry::of(whole, self.threads, self.narrowest) else { return false };
        if !whole.neighbours.can_make_rooms() {
            return false;
        }
        (self.refused, self.is_queue_empty) = (None, false);
        self.work.cuts += 1;
        let cut = Cut::new(whole, geometry);
        let queue = &whole.schedule.queue;
        if self.length == 0.0 {
            self.length = queue.span() * (FIRST / queue.target() as f64).min(1.0);
        }
        whole.schedule.queue.clear();
        if TABLE && whole.pairs.rules.steps.iter().any(Steps::can_capture) {
            whole.pairs.states.make_room();
        }
        let particles = whole.particles().len();
        self.cut.insert(cut).make_rooms(&mut whole.neighbours, particles);
        true
    }

    /// Sets the clock of the engine to the last step. The states of particles are always in the engine.
    pub fn settle<const FALLING: bool, const TABLE: bool>(&self, whole: &mut Engine<FALLING, TABLE>) {
        if let Some(cut) = &self.cut {
            whole.clock.now = cut.latest;
        }
    }

    /// Enters all particles into the queue of the engine, so that the simulation can be saved. The threads can continue.
    pub fn complete<const FALLING: bool, const TABLE: bool>(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        if let Some(cut) = self.cut.as_mut().filter(|cut| !cut.is_complete) {
            cut.is_complete = true;
            whole.clock.now = cut.latest;
            whole.schedule.queue.resume(cut.now, cut.steps);
        } else if !std::mem::take(&mut self.is_queue_empty) {
            return;
        }
        for particle in whole.particles() {
            whole.enqueue(particle);
        }
    }

    /// Gives everything back to the engine, so that it can continue alone.
    pub fn join<const FALLING: bool, const TABLE: bool>(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        self.complete(whole);
        let Some(mut cut) = self.cut.take() else { return };
        cut.give_rooms_back(&mut whole.neighbours);
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn executed_steps(&self) -> u64 {
        self.counts.executed + self.counts.totals.transition
    }
}

#[cfg(test)]
mod tests;
