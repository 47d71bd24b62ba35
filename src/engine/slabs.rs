//! One system on several threads, with the results of one thread, bit for bit.
//!
//! The box is cut into *slabs*, one for each thread. All threads share one engine. They run a short *window* of
//! simulated time in three phases:
//!
//! 1. Each thread executes the steps in its slab in the order of time. Steps near the faces of the slab are held back:
//!    they could read particles that another thread changes. Steps near a step that is held back are held back, too,
//!    because the outcome of that step is not known yet.
//! 2. Each thread executes the steps that were held back in its *strip*, which reaches from the middle of one slab to the
//!    middle of the next. Steps near the faces of the strip, of which there are hardly any, are held back again.
//! 3. One thread executes the rest.
//!
//! A step of a later phase may come too late: it follows from a step that was held back, but in the meantime another
//! step nearby with a later time was executed. Such steps *conflict*. The places of all steps that may conflict are
//! recorded. After a conflict, all steps of the window are undone, and one thread executes the window.
//!
//! *Proof.* A step reads and changes only particles whose places are within reach of the places of its own particles.
//! Two steps whose places are farther apart give the same results in any order. All other pairs of steps are executed
//! in the order of their times: within a phase, because they are in the same region, and from phase to phase, because
//! otherwise they conflict. So the results are those of a single thread, which executes all steps in the order of their
//! times.
//!
//! *Threads* never access the same data at the same time. A step that is not held back reads and changes only data of
//! its own region, because the layers in which steps are held back are at least as wide as the reach of a step.

mod alias;
mod barrier;
mod geometry;
mod part;
mod places;
mod rooms;
mod stretch;
mod work;

pub use rooms::Rooms;
pub use work::ThreadWork;

use super::domains::Domains;
use super::observe::Observe;
use super::pairs::rules::Steps;
use super::parts::Engine;
use super::schedule::Pending;
use super::{EngineError, Reason, Until};
use geometry::Geometry;
use part::{Part, Phase};
use std::sync::{PoisonError, RwLock};
use stretch::{End, PHASES, Progress, Request, SHORTEST};

/// Desired number of steps of a window: per particle, with lists and with cells, and at most per thread. In longer windows,
/// more steps are held back, and conflicts are more frequent. With cells, a step reads more particles.
const WITH_LISTS: f64 = 0.015;
const WITH_CELLS: f64 = 0.005;
const STEPS_PER_THREAD: f64 = 1_500.0;

/// Number of steps of the first window, before its duration is adapted.
const FIRST: f64 = 100.0;

/// Factors of the desired number of steps after a conflict, and after a window without a conflict.
const FEWER: f64 = 0.8;
const MORE: f64 = 1.005;

/// Smallest width of a slab, in units of the width of the layer at its faces in which steps are held back.
const NARROWEST: f64 = 4.0;

/// Number of steps that the engine executes alone when the threads cannot continue.
const ALONE: u64 = 2_000;

/// Number of steps that the engine executes alone at the end of a run that ends at a number of events.
const LAST: u64 = 50_000;

/// A system on several threads.
#[derive(Debug, Clone)]
pub struct Slabs {
    threads: usize,
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
    pub work: ThreadWork,
}

/// A system that is cut into slabs.
#[derive(Debug)]
pub struct Cut {
    geometry: Geometry,
    parts: Vec<Part>,
    phases: Vec<[RwLock<Phase>; PHASES]>,
    /// Time since the epoch that has been reached.
    now: f64,
    /// Time of the last step, or the time limit if the run has reached it.
    latest: f64,
    /// Number of steps of this epoch.
    steps: u64,
    length: f64,
    /// Whether one thread executes the next window.
    is_alone: bool,
    /// Whether the queue of the engine has all entries, too.
    is_complete: bool,
}

impl Clone for Cut {
    fn clone(&self) -> Self {
        Self {
            geometry: self.geometry.clone(),
            parts: self.parts.clone(),
            phases: self.parts.iter().map(|_| new_phases()).collect(),
            ..*self
        }
    }
}

fn new_phases() -> [RwLock<Phase>; PHASES] {
    std::array::from_fn(|_| RwLock::new(Phase::new()))
}

enum Next {
    Continue,
    Return(Reason),
    /// The engine executes this number of steps alone.
    Alone(u64),
}

impl Slabs {
    pub fn new(threads: usize) -> Self {
        Self {
            threads,
            length: 0.0,
            narrowest: NARROWEST,
            per_window: 0.0,
            is_queue_empty: false,
            refused: None,
            cut: None,
            work: ThreadWork::default(),
        }
    }

    /// Whether the threads can probably run the system.
    pub fn suit<const FALLING: bool, const TABLE: bool>(&self, engine: &Engine<FALLING, TABLE>) -> bool {
        // A contact changes the time of a static particle's state, so particles that do not meet would affect each other.
        let has_static = engine.state.moving < engine.particles().len();
        Domains::obstacle(engine).is_none()
            && engine.sources.next_global == f64::INFINITY
            && !has_static
            && self.refused != Some(engine.clock.epochs)
    }

    /// Continues a run with exactly the same results as [`Engine::advance_for`]. Returns `None` if the system cannot be
    /// cut. Between calls, the queue of the engine is empty until [`Self::complete`] or [`Self::join`] is called.
    pub fn advance_for<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Option<Result<Option<Reason>, EngineError>> {
        if observe.is_some() || !self.suit(whole) || (self.cut.is_none() && !self.cut_up(whole)) {
            self.join(whole);
            return None;
        }
        Some(self.advance_in_windows(whole, steps, until))
    }

    fn advance_in_windows<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
    ) -> Result<Option<Reason>, EngineError> {
        let mut left = steps;
        while left > 0 {
            if let Some(broken) = whole.broken {
                return Err(broken.into());
            }
            if self.cut.is_none() && !self.cut_up(whole) {
                self.complete(whole);
                return whole.advance_for(left, until, &mut None);
            }
            let next = if whole.counts.executed >= until.last_event() {
                Next::Alone(LAST)
            } else {
                let (done, next) = self.stretch(whole, left, until);
                left = left.saturating_sub(done.max(1));
                next
            };
            match next {
                Next::Continue => {}
                Next::Return(reason) => return Ok(Some(reason)),
                Next::Alone(steps) => {
                    self.work.alone += 1;
                    self.join(whole);
                    if let Some(reason) = whole.advance_for(steps, until, &mut None)? {
                        return Ok(Some(reason));
                    }
                    left = left.saturating_sub(steps);
                }
            }
        }
        Ok(None)
    }

    /// Runs windows until something else has to be done. Returns the number of steps, and how to continue.
    fn stretch<const FALLING: bool, const TABLE: bool>(
        &mut self,
        whole: &mut Engine<FALLING, TABLE>,
        steps: u64,
        until: Until,
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
        let most = (per_particle * whole.state.moving as f64).min(STEPS_PER_THREAD * cut.parts.len() as f64);
        self.per_window = if self.per_window == 0.0 { most } else { self.per_window.min(most) };
        let request = Request {
            end,
            steps,
            last_event: until.last_event(),
            per_window: self.per_window.max(1.0),
            is_alone: std::mem::take(&mut cut.is_alone),
        };
        let (reason, progress) = whole.run_stretch(&mut cut, request);
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
                cut.length *= FEWER;
                cut.is_alone = true;
                Next::Continue
            }
            End::TooLong => {
                cut.length *= 0.25;
                // Very many steps may be due at the same time.
                if cut.length > SHORTEST * whole.schedule.queue.span() { Next::Continue } else { Next::Alone(LAST) }
            }
            End::Alone => Next::Alone(ALONE),
            End::LastEvent => Next::Alone(LAST),
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
        cut.parts.iter_mut().for_each(|part| whole.neighbours.take_room(&mut part.rooms));
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
        let (count, threads) = (whole.particles().len(), geometry.slabs.len());
        // No event is due before the epoch, so the threads can start there.
        let now = whole.clock.now.max(0.0);
        let queue = &whole.schedule.queue;
        let part =
            || Part::new(queue.of_part(now, count / threads, count), queue.of_part(now, 1, count), whole.no_counts());
        let parts: Vec<Part> = (0..threads).map(|_| part()).collect();
        if self.length == 0.0 {
            self.length = queue.span() * (FIRST / queue.target() as f64).min(1.0);
        }
        self.cut = Some(Cut {
            phases: parts.iter().map(|_| new_phases()).collect(),
            geometry,
            parts,
            now,
            latest: whole.clock.now,
            steps: queue.steps(),
            length: self.length,
            is_alone: false,
            is_complete: false,
        });
        whole.schedule.queue.clear();
        if TABLE && whole.pairs.rules.steps.iter().any(Steps::can_capture) {
            whole.pairs.states.make_room();
        }
        if let Some(cut) = &mut self.cut {
            let share = count / cut.parts.len();
            cut.parts.iter_mut().for_each(|part| whole.neighbours.make_room(&mut part.rooms, share));
        }
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
        cut.parts.iter_mut().for_each(|part| whole.neighbours.take_room(&mut part.rooms));
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Adds the counts and the progress of a stretch.
    fn take_progress(&mut self, cut: &mut Cut, progress: &Progress) {
        for part in &mut cut.parts {
            self.counts.merge(&part.total);
        }
        let none = self.no_counts();
        for part in &mut cut.parts {
            for counts in [&mut part.total, &mut part.counts, &mut part.none] {
                (**counts).clone_from(&none);
            }
        }
        (self.clock.standstill.since, self.clock.standstill.events) = progress.standstill;
        if let Some(quiet) = progress.quiet {
            self.counts.transitions_at_event = self.counts.totals.transition.wrapping_sub(quiet);
        }
        (cut.now, cut.latest, cut.length) = (progress.now, progress.latest, progress.length);
        cut.steps += progress.steps;
        self.clock.now = cut.now;
    }

    /// Undoes all steps of the last window.
    fn undo_window(&mut self, cut: &mut Cut) {
        let mut changed = Vec::new();
        for number in (0..PHASES).rev() {
            for phases in &mut cut.phases {
                let phase = phases[number].get_mut().unwrap_or_else(PoisonError::into_inner);
                let undone = phase.log.undone(&self.state.bodies);
                changed.extend(self.restore(&undone));
                changed.extend(phase.held_back.iter().map(|(entry, _)| entry.particle));
                phase.clear();
            }
        }
        let due = self.schedule.due(&self.state.bodies);
        for part in &mut cut.parts {
            part.queue.rewind(cut.now, &due);
        }
        changed.sort_unstable();
        changed.dedup();
        for particle in changed {
            let along = cut.geometry.along(self, particle);
            let slab = cut.geometry.slab_of(along);
            for (number, part) in cut.parts.iter_mut().enumerate() {
                let is_here = number == slab;
                part.held.put(particle, is_here);
                if is_here {
                    let entry = due.entry(particle);
                    if entry.time < f64::INFINITY {
                        part.queue.push(entry, &due);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
