//! A stretch of windows on all threads, without interruption.

use super::alias::Alias;
use super::barrier::Barrier;
use super::covered::Covered;
use super::cut::Cut;
use super::geometry::{Geometry, Slab};
use super::part::{Around, Part, Phase, Task};
use super::places::Places;
use crate::engine::clock::StandstillWatch;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::progress::{self, Times};
use crate::engine::schedule::EventQueue;
use crate::engine::sources::andersen::{Andersen, Collision};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Number of phases of a window: slabs, strips, and the rest.
pub const PHASES: usize = 3;

/// Smallest duration of a window, in units of the span of the queue. A window without duration would make no progress.
pub const SHORTEST: f64 = 1e-9;

/// Why a stretch ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// The requested number of steps is done.
    Pause,
    /// The stretch has reached its end time.
    Time,
    Epoch,
    /// A step came too late. The window must be undone and repeated by one thread.
    Conflict,
    /// The window has too many steps. It must be undone and replaced by a shorter one.
    TooLong,
    /// The engine must continue alone, after the window is undone.
    Alone,
    /// The run reaches its number of events within this window. The window must be undone.
    LastEvent,
    /// The observer ends the run after this number of events of the window. The window must be undone.
    Observer(u64),
}

/// What a stretch is asked for.
#[derive(Debug, Clone, Copy)]
pub struct Request {
    /// End time since the epoch.
    pub end: f64,
    pub steps: u64,
    pub last_event: u64,
    /// Duration of the first window.
    pub length: f64,
    /// Desired number of steps of a window.
    pub per_window: f64,
    /// Whether one thread executes all steps of the first window.
    pub is_alone: bool,
}

/// The progress of a stretch.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Time since the epoch that has been reached.
    pub now: f64,
    /// Time of the last step.
    pub latest: f64,
    pub steps: u64,
    pub windows: u64,
    /// Number of executed events, also of earlier stretches.
    pub executed: u64,
    /// Steps of each phase.
    pub of_phases: [u64; PHASES],
    /// Duration of the next window.
    pub length: f64,
    pub standstill: (f64, u64),
    /// Number of transitions since the last event; `None` if there was no event.
    pub quiet: Option<u64>,
}

/// The next window, or the end of the stretch.
#[derive(Debug, Clone, Copy)]
struct Plan {
    stop: f64,
    is_alone: bool,
    end: Option<End>,
    /// Whether the steps of the last window are valid.
    is_accepted: bool,
}

struct Shared<'a> {
    geometry: &'a Geometry,
    phases: &'a [[RwLock<Phase>; PHASES]],
    barrier: Barrier,
    plan: Mutex<Plan>,
    /// Collisions with the heat bath in the window.
    collisions: RwLock<Vec<Collision>>,
    is_observed: bool,
    is_plain: bool,
    /// Deepest accepted overlap of all threads `[length]`, as bits. Of two overlaps, the deeper one has the larger bits.
    accepted: AtomicU64,
}

fn read<T>(lock: &RwLock<T>) -> RwLockReadGuard<'_, T> {
    lock.read().unwrap_or_else(PoisonError::into_inner)
}

fn write<T>(lock: &RwLock<T>) -> RwLockWriteGuard<'_, T> {
    lock.write().unwrap_or_else(PoisonError::into_inner)
}

fn locked<T>(lock: &Mutex<T>) -> MutexGuard<'_, T> {
    lock.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Decides after each window how to continue. Only one thread has the judge.
struct Judge<'a, 'o> {
    request: Request,
    queue: &'a EventQueue,
    watch: StandstillWatch,
    /// Number of steps of the epoch before the stretch.
    before: u64,
    progress: Progress,
    observe: &'a mut Observe<'o>,
    /// The heat bath at the beginning and at the end of the window.
    baths: [Option<Andersen>; 2],
}

impl Judge<'_, '_> {
    /// Returns the end of the window that begins now.
    fn stop(&self) -> f64 {
        let Progress { now, length, .. } = self.progress;
        (now + length).min(self.queue.next_tick(now).next_down()).min(self.request.end)
    }

    /// Accepts or rejects the window that has been executed. Shows the events of an accepted window to the observer.
    fn judge(&mut self, phases: &[[RwLock<Phase>; PHASES]], window: Plan) -> Plan {
        let phases: Vec<RwLockReadGuard<'_, Phase>> = phases.iter().flatten().map(read).collect();
        let has_ended = match () {
            () if phases.iter().any(|phase| phase.has_conflict) => Err(End::Conflict),
            () if phases.iter().any(|phase| phase.is_too_long) => Err(End::TooLong),
            () if phases.iter().any(|phase| phase.is_stuck) => Err(End::Alone),
            () => self.take_steps(&phases),
        };
        match has_ended {
            Ok(steps) => self.accept(window, steps),
            Err(end) => Plan { end: Some(end), is_accepted: false, ..window },
        }
    }

    /// Adds the steps of a window. Returns their number, including collisions with the heat bath.
    fn take_steps(&mut self, phases: &[RwLockReadGuard<'_, Phase>]) -> Result<u64, End> {
        let executed: u64 = phases.iter().map(|phase| phase.times.executed).sum();
        if self.progress.executed + executed >= self.request.last_event {
            return Err(End::LastEvent);
        }
        let times: Vec<&Times> = phases.iter().map(|phase| &phase.times).collect();
        let (since, events) = self.progress.standstill;
        let watch = StandstillWatch { since, events, ..self.watch };
        let standstill = progress::standstill(&times, &watch, self.queue.span()).ok_or(End::Alone)?;
        self.show(phases)?;
        let (last, after) = progress::quiet(&times);
        let progress = &mut self.progress;
        progress.quiet = if last.is_some() { Some(after) } else { progress.quiet.map(|before| before + after) };
        let steps: u64 = phases.iter().map(|phase| phase.steps).sum();
        for (number, phase) in phases.iter().enumerate() {
            progress.of_phases[number % PHASES] += phase.steps;
            progress.latest = progress.latest.max(phase.latest);
        }
        (progress.standstill, progress.executed) = (standstill, progress.executed + executed);
        (progress.windows, progress.steps) = (progress.windows + 1, progress.steps + steps);
        Ok(steps + phases.iter().map(|phase| phase.baths).sum::<u64>())
    }

    /// Shows the events of a window to the observer.
    fn show(&mut self, phases: &[RwLockReadGuard<'_, Phase>]) -> Result<(), End> {
        let Some(observe) = self.observe else { return Ok(()) };
        let events = progress::merged(phases.iter().map(|phase| &*phase.seen)).ok_or(End::Alone)?;
        let ended = (1..).zip(&events).find(|(_, event)| observe(event).is_break());
        ended.map_or(Ok(()), |(shown, _)| Err(End::Observer(shown)))
    }

    /// Accepts a window, and returns the next one.
    fn accept(&mut self, window: Plan, steps: u64) -> Plan {
        let tick = self.queue.next_tick(self.progress.now);
        let is_tick = window.stop == tick.next_down();
        let progress = &mut self.progress;
        let is_end = window.stop == self.request.end;
        // Windows without steps become longer, too.
        let change = self.request.per_window / (steps as f64).max(0.5);
        // After a window that was cut short, the next one may be shorter, but not longer.
        if !(is_end || is_tick) || change < 1.0 {
            let length = (window.stop - progress.now) * change.clamp(0.1, 2.0);
            progress.length = length.max(self.queue.span() * SHORTEST);
        }
        let ends_epoch = is_tick && self.queue.ends_at(tick, self.before + progress.steps);
        progress.now = if is_tick && !ends_epoch { tick } else { window.stop };
        let [before, after] = &mut self.baths;
        before.clone_from(after);
        let end = match () {
            () if is_end => Some(End::Time),
            () if ends_epoch => Some(End::Epoch),
            () if progress.steps >= self.request.steps => Some(End::Pause),
            () => None,
        };
        Plan { stop: self.stop(), is_alone: false, end, is_accepted: true }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Runs windows on all threads until something ends the stretch.
    pub(super) fn run_stretch(
        &mut self,
        cut: &mut Cut,
        request: Request,
        observe: &mut Observe<'_>,
    ) -> (End, Progress) {
        let is_observed = observe.is_some();
        let mut judge = Judge {
            request,
            queue: &self.schedule.queue,
            watch: self.clock.standstill.clone(),
            before: cut.steps,
            progress: Progress {
                now: cut.now,
                latest: cut.latest,
                steps: 0,
                windows: 0,
                executed: self.counts.executed,
                of_phases: [0; PHASES],
                length: request.length,
                standstill: (self.clock.standstill.since, self.clock.standstill.events),
                quiet: None,
            },
            observe,
            baths: [self.sources.andersen.clone(), self.sources.andersen.clone()],
        };
        let plan = Plan { stop: judge.stop(), is_alone: request.is_alone, end: None, is_accepted: true };
        let shared = Shared {
            geometry: &cut.geometry,
            phases: &cut.phases,
            barrier: Barrier::new(cut.parts.len()),
            plan: Mutex::new(plan),
            collisions: RwLock::new(self.collisions_until(&mut judge.baths[1], plan.stop)),
            is_observed,
            is_plain: self.changes_motions_and_pairs_only(),
            accepted: AtomicU64::new(self.counts.accepted_overlap.to_bits()),
        };
        // SAFETY: the engine is not used before all aliases are given back. The threads access disjoint elements, see
        // the description of `slabs`.
        let aliases = cut.parts.iter_mut().map(|part| unsafe { Alias::of(self, part) });
        let mut aliases: Vec<Alias<FALLING, TABLE>> = aliases.collect();
        let mut workers = aliases.iter_mut().zip(&mut cut.parts).enumerate();
        let first = workers.next();
        std::thread::scope(|scope| {
            let shared = &shared;
            for (number, (engine, part)) in workers {
                scope.spawn(move || Worker::new(number, part, shared).run(engine, &mut None));
            }
            if let Some((number, (engine, part))) = first {
                Worker::new(number, part, shared).run(engine, &mut Some(&mut judge));
            }
        });
        let end = locked(&shared.plan).end.unwrap_or(End::Alone);
        let Judge { progress, baths: [bath, _], .. } = judge;
        for (alias, part) in aliases.into_iter().zip(&mut cut.parts) {
            alias.give_back(part);
        }
        self.put_bath(bath);
        (end, progress)
    }
}

/// Releases the other threads if a thread panics. The panic then ends the scope of the threads.
struct Guard<'a>(&'a Barrier);

impl Drop for Guard<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.break_down();
        }
    }
}

/// A thread with its share of the work.
struct Worker<'a> {
    number: usize,
    part: &'a mut Part,
    shared: &'a Shared<'a>,
    held_back: Places,
    earlier: Places,
    covered: Covered,
}

impl<'a> Worker<'a> {
    fn new(number: usize, part: &'a mut Part, shared: &'a Shared<'a>) -> Self {
        let geometry = shared.geometry;
        let held_back = Places::new(geometry, geometry.around_held);
        Self {
            number,
            part,
            shared,
            held_back,
            earlier: Places::new(geometry, geometry.reach),
            covered: Covered::default(),
        }
    }

    /// Runs windows until the stretch ends. One thread has the judge.
    fn run<const FALLING: bool, const TABLE: bool>(
        &mut self,
        engine: &mut Engine<FALLING, TABLE>,
        judge: &mut Option<&mut Judge<'_, '_>>,
    ) {
        let _guard = Guard(&self.shared.barrier);
        self.fill(engine);
        // No thread changes a particle while another thread still looks for its particles.
        if !self.shared.barrier.wait() {
            return;
        }
        let mut now = engine.clock.now;
        loop {
            let plan = *locked(&self.shared.plan);
            if plan.end.is_some() {
                break;
            }
            self.run_slab(engine, &plan);
            if !self.shared.barrier.wait() {
                break;
            }
            self.run_strip(engine, now, &plan);
            self.note_overlap(engine);
            if !self.shared.barrier.wait() {
                break;
            }
            if let Some(judge) = judge {
                self.run_rest(engine, now, &plan);
                self.note_overlap(engine);
                let next = judge.judge(self.shared.phases, plan);
                if next.end.is_none() {
                    *write(&self.shared.collisions) = engine.collisions_until(&mut judge.baths[1], next.stop);
                }
                *locked(&self.shared.plan) = next;
            }
            if !self.shared.barrier.wait() {
                break;
            }
            if locked(&self.shared.plan).is_accepted {
                self.accept(engine);
                now = plan.stop;
            }
        }
    }

    fn note_overlap<const FALLING: bool, const TABLE: bool>(&self, engine: &Engine<FALLING, TABLE>) {
        self.shared.accepted.fetch_max(engine.counts.accepted_overlap.to_bits(), Ordering::AcqRel);
    }

    fn slab(&self) -> &'a Slab {
        &self.shared.geometry.slabs[self.number]
    }

    fn strip(&self) -> &'a Slab {
        &self.shared.geometry.strips[self.number]
    }

    fn task(&self, region: &'a Slab, phase: usize, plan: &Plan) -> Task<'a> {
        let &Shared { geometry, is_observed, is_plain, .. } = self.shared;
        Task { geometry, region, stop: plan.stop, phase, is_alone: plan.is_alone, is_observed, is_plain }
    }

    /// Enters the particles of the slab into the queue.
    fn fill<const FALLING: bool, const TABLE: bool>(&mut self, engine: &mut Engine<FALLING, TABLE>) {
        if std::mem::replace(&mut self.part.is_filled, true) {
            return;
        }
        for particle in engine.particles() {
            let geometry = self.shared.geometry;
            let is_here = geometry.slab_of(geometry.along(engine, particle)) == self.number;
            if is_here {
                if let Some(part) = &mut engine.schedule.part {
                    part.put(particle, true);
                }
                engine.enqueue(particle);
            }
        }
    }

    fn run_slab<const FALLING: bool, const TABLE: bool>(&mut self, engine: &mut Engine<FALLING, TABLE>, plan: &Plan) {
        let mut phase = write(&self.shared.phases[self.number][0]);
        phase.clear();
        self.held_back.clear();
        self.earlier.clear();
        let collisions = read(&self.shared.collisions);
        let is_here = |collision: &Collision| {
            let particle = engine.state.numbers[collision.id];
            engine.schedule.part.as_ref().is_some_and(|part| part.has(particle))
        };
        let collisions: Vec<Collision> = collisions.iter().copied().filter(is_here).collect();
        let task = self.task(self.slab(), 0, plan);
        let around = Around { held_back: &mut self.held_back, earlier: &self.earlier, covered: &mut self.covered };
        engine.run_phase(&task, around, collisions, &mut phase);
    }

    fn run_strip<const FALLING: bool, const TABLE: bool>(
        &mut self,
        engine: &mut Engine<FALLING, TABLE>,
        now: f64,
        plan: &Plan,
    ) {
        let count = self.shared.phases.len();
        let mut phase = write(&self.shared.phases[self.number][1]);
        phase.clear();
        let slabs = [(self.number + count - 1) % count, self.number].map(|slab| read(&self.shared.phases[slab][0]));
        let slabs = [&*slabs[0], &*slabs[1]];
        self.run_held_back(engine, (now, plan), 1, (&slabs, &slabs), &mut phase);
    }

    /// Executes the steps that the strips have held back.
    fn run_rest<const FALLING: bool, const TABLE: bool>(
        &mut self,
        engine: &mut Engine<FALLING, TABLE>,
        now: f64,
        plan: &Plan,
    ) {
        let mut phase = write(&self.shared.phases[self.number][2]);
        phase.clear();
        let [slabs, strips] =
            [0, 1].map(|k| self.shared.phases.iter().map(|phases| read(&phases[k])).collect::<Vec<_>>());
        if strips.iter().all(|strip| strip.held_back.is_empty() && strip.collisions.is_empty()) {
            return;
        }
        let strips: Vec<&Phase> = strips.iter().map(|strip| &**strip).collect();
        let all: Vec<&Phase> = slabs.iter().map(|slab| &**slab).chain(strips.iter().copied()).collect();
        self.run_held_back(engine, (now, plan), 2, (&strips, &all), &mut phase);
    }

    /// Executes steps that an earlier phase has held back, and all steps that follow from them.
    fn run_held_back<const FALLING: bool, const TABLE: bool>(
        &mut self,
        engine: &mut Engine<FALLING, TABLE>,
        (now, plan): (f64, &Plan),
        number: usize,
        (held_back, before): (&[&Phase], &[&Phase]),
        phase: &mut Phase,
    ) {
        let geometry = self.shared.geometry;
        let region = if number == 1 { self.strip() } else { &geometry.all };
        self.held_back.clear();
        self.earlier.clear();
        self.covered.clear();
        std::mem::swap(&mut engine.schedule.queue, &mut self.part.of_strip);
        let saved = engine.schedule.part.take();
        let looks_ahead = std::mem::replace(&mut engine.hardware.looks_ahead, false);
        engine.schedule.queue.resume(now, 0);
        let (queue, due) = engine.schedule.split(&engine.state.bodies);
        let is_here = |along: f64| number == 2 || geometry.strip_of(along) == self.number;
        for held in held_back.iter().flat_map(|phase| &phase.held_back).filter(|held| is_here(held.along)) {
            queue.push(held.entry, &due);
            if held.is_covered {
                self.covered.add(held.entry.particle);
            }
        }
        for (place, time, depth) in before.iter().flat_map(|phase| &phase.places) {
            if is_here(place[geometry.axis]) {
                self.earlier.add(place, *time, *depth);
            }
        }
        let collisions = held_back.iter().flat_map(|phase| &phase.collisions);
        let mut collisions: Vec<Collision> =
            collisions.filter(|(_, along)| is_here(*along)).map(|(collision, _)| *collision).collect();
        collisions.sort_by(|one, other| one.time.total_cmp(&other.time));
        let task = self.task(region, number, plan);
        let around = Around { held_back: &mut self.held_back, earlier: &self.earlier, covered: &mut self.covered };
        engine.run_phase(&task, around, collisions, phase);
        engine.schedule.queue.clear();
        std::mem::swap(&mut engine.schedule.queue, &mut self.part.of_strip);
        engine.schedule.part = saved;
        engine.hardware.looks_ahead = looks_ahead;
    }

    /// Keeps the results of the window. Particles with steps in strips return to the queue of their slab.
    fn accept<const FALLING: bool, const TABLE: bool>(&mut self, engine: &mut Engine<FALLING, TABLE>) {
        let geometry = self.shared.geometry;
        let phases = (1..PHASES).flat_map(|number| self.shared.phases.iter().map(move |phases| &phases[number]));
        for phase in phases {
            for &(particle, along) in &read(phase).touched {
                let is_here = geometry.slab_of(along) == self.number;
                if let Some(part) = &mut engine.schedule.part {
                    part.put(particle, is_here);
                }
                if is_here {
                    engine.enqueue(particle);
                }
            }
        }
        self.part.total.merge(&engine.counts);
        self.part.none.accepted_overlap = f64::from_bits(self.shared.accepted.load(Ordering::Acquire));
        engine.counts.clone_from(&self.part.none);
    }
}
