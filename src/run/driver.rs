//! The loop of a run.

mod pace;

use std::ops::ControlFlow;
use std::time::Instant;

use super::progress::{Progress, Stage};
use super::{Ending, Finished, Recorder, Stretch};
use crate::audit::Ledger;
use crate::observe::Observer;
use crate::scene::{Limit, Scene};
use crate::simulation::{Reason, Simulation, Until};

/// Physical events between two looks at whether to go on: some hundredths of a second.
const CHUNK: u64 = 10_000;

/// Crossings of the box by a typical particle, without any event, after which it is asked whether there will be one.
const QUIET_CROSSINGS: f64 = 1000.0;

/// Runs a scene as it plans, and hands rows and frames to a recorder.
///
/// `watch` is called every few hundredths of a second; the run ends at once, but in good order, where it breaks. Neither
/// it nor the recorder changes the trajectory. A stage without a limit is left out.
///
/// # Errors
/// The recorder's. A simulation that cannot go on is no error here, but an [`Ending`].
pub fn run<R: Recorder>(
    scene: Scene,
    recorder: &mut R,
    watch: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Finished, R::Error> {
    let observer = Observer::new(&scene);
    let simulation = Simulation::new(scene);
    let mut driver = Driver {
        ledger: Ledger::open(&simulation, observer.meaning().conserves_momentum),
        crossing: crossing_time(&simulation),
        stage: Start::of(&simulation, Stage::Equilibration, Limit::default()),
        quiet_since: simulation.time(),
        quiet_transitions: 0,
        last_row: None,
        last_frame: None,
        simulation,
        observer,
        recorder,
        watch,
    };
    let plan = driver.simulation.scene().run;
    let equilibration = plan.equilibration;
    let mut ending = Ending::Events;
    if equilibration != Limit::default() {
        driver.stage = Start::of(&driver.simulation, Stage::Equilibration, equilibration);
        let (time, events) = driver.stage.end();
        ending = driver.advance(time, events)?.unwrap_or(Ending::Time);
    }
    let is_over = matches!(ending, Ending::Interrupted | Ending::Arrested(_));
    if !is_over {
        driver.stage = Start::of(&driver.simulation, Stage::Measurement, plan.limit);
    }
    let (start, started) = (driver.stage, Instant::now());
    driver.record(true, true)?;
    let tally = *driver.simulation.tally();
    if !is_over {
        ending = driver.measure()?;
    }
    let wall_seconds = started.elapsed().as_secs_f64();
    driver.record(true, true)?;
    let (now, start_time) = (driver.simulation.time(), if is_over { driver.simulation.time() } else { start.time });
    Ok(Finished {
        stretch: Stretch {
            start: start_time,
            duration: now - start_time,
            tally: driver.simulation.tally().since(&tally),
            wall_seconds,
        },
        ending,
        stage: start.stage,
        observables: driver.observer.estimates(),
        audit: driver.ledger.close(&driver.simulation),
        simulation: driver.simulation,
    })
}

/// Where a stage began.
#[derive(Debug, Clone, Copy)]
struct Start {
    stage: Stage,
    time: f64,
    events: u64,
    limit: Limit,
}

impl Start {
    fn of(simulation: &Simulation, stage: Stage, limit: Limit) -> Self {
        Self { stage, time: simulation.time(), events: simulation.tally().physical(), limit }
    }

    /// Simulated time and physical events, since the start of the simulation, at which the stage ends.
    fn end(&self) -> (f64, u64) {
        let time = self.limit.time.map_or(f64::INFINITY, |time| self.time + time);
        (time, self.limit.events.map_or(u64::MAX, |events| self.events.saturating_add(events)))
    }
}

/// Part of the crossing time after which it is first looked whether overlaps of the start are gone.
const SHORTEST_LOOK: f64 = 1e-4;

struct Driver<'a, R> {
    simulation: Simulation,
    observer: Observer,
    ledger: Ledger,
    recorder: &'a mut R,
    watch: &'a mut dyn FnMut(&Progress) -> ControlFlow<()>,
    stage: Start,
    /// Simulated time in which a typical particle crosses the box `[time]`.
    crossing: f64,
    quiet_since: f64,
    /// Cell transitions at the last physical event.
    quiet_transitions: u64,
    last_row: Option<f64>,
    last_frame: Option<f64>,
}

impl<R: Recorder> Driver<'_, R> {
    /// The measured stretch.
    fn measure(&mut self) -> Result<Ending, R::Error> {
        if self.stage.limit == Limit::default() {
            return Ok(Ending::Events);
        }
        let (end_time, end_events) = self.stage.end();
        let (mut rows, mut frames) = match self.pace()? {
            Ok(pace) => pace,
            Err(ending) => return Ok(ending),
        };
        loop {
            let (row, frame) = (rows.next(), frames.next());
            // The last tick falls on the end, but for rounding.
            let near_end = |tick: f64| tick >= end_time - 1e-9 * (end_time - self.stage.time);
            let tick = row.min(frame);
            let target = if near_end(tick) { end_time } else { tick };
            if let Some(ending) = self.advance(target, end_events)? {
                return Ok(ending);
            }
            if target == end_time {
                return Ok(Ending::Time);
            }
            self.record(row <= target, frame <= target)?;
            if row <= target {
                rows.pass(self.simulation.time());
            }
            if frame <= target {
                frames.pass(self.simulation.time());
            }
        }
    }

    /// Goes on to a time, or `None`; or to a number of events or an obstacle, and says which.
    fn advance(&mut self, time: f64, events: u64) -> Result<Option<Ending>, R::Error> {
        if self.ledger.has_overlaps()
            && let Some(ending) = self.advance_overlapped(time, events)?
        {
            return Ok(Some(ending));
        }
        let mut wait = self.crossing;
        while self.simulation.time() < time {
            let before = *self.simulation.tally();
            let done = before.physical();
            if done >= events {
                return Ok(Some(Ending::Events));
            }
            let progress = self.progress();
            if (self.watch)(&progress).is_break() {
                return Ok(Some(Ending::Interrupted));
            }
            let until =
                Until { time: time.min(self.simulation.time() + wait), events: events.min(done.saturating_add(CHUNK)) };
            match self.chunk(until)? {
                Ok(Reason::Idle) => return Ok(Some(Ending::Idle)),
                Ok(Reason::Time | Reason::Events) => {}
                Err(arrest) => return Ok(Some(Ending::Arrested(arrest))),
            }
            let now = *self.simulation.tally();
            let is_quiet = now.physical() == done;
            wait = if is_quiet && now.transition == before.transition { 2.0 * wait } else { self.crossing };
            if !is_quiet {
                (self.quiet_since, self.quiet_transitions) = (self.simulation.time(), now.transition);
            } else if self.stage.limit.time.is_none() && self.will_stay_quiet() {
                return Ok(Some(Ending::Idle));
            }
        }
        Ok((self.simulation.tally().physical() >= events).then_some(Ending::Events))
    }

    /// Goes on in small steps while overlaps of the start are left, to see when the last one goes.
    fn advance_overlapped(&mut self, time: f64, events: u64) -> Result<Option<Ending>, R::Error> {
        let moving = self.observer.meaning().moving as u64;
        let (mut step, mut duration) = (moving.div_ceil(16), self.crossing * SHORTEST_LOOK);
        while self.ledger.has_overlaps() && self.simulation.time() < time {
            let done = self.simulation.tally().physical();
            if done >= events {
                return Ok(Some(Ending::Events));
            }
            let progress = self.progress();
            if (self.watch)(&progress).is_break() {
                return Ok(Some(Ending::Interrupted));
            }
            let until = Until { time: time.min(self.simulation.time() + duration), events: events.min(done + step) };
            match self.chunk(until)? {
                Ok(Reason::Idle) => return Ok(Some(Ending::Idle)),
                Ok(Reason::Time | Reason::Events) => {}
                Err(arrest) => return Ok(Some(Ending::Arrested(arrest))),
            }
            self.ledger.see_overlaps(&self.simulation);
            // Ever longer ones, so that overlaps that stay cost little: the time is known to a tenth.
            (step, duration) = (step + step.div_ceil(10), 1.1 * duration);
        }
        Ok(None)
    }

    /// Whether a run without a time limit would never end.
    fn will_stay_quiet(&mut self) -> bool {
        // A thousand crossings of a thousand cells each, per particle: nothing is there to be met.
        let most = 10_000_000 + 10_000 * self.observer.meaning().moving as u64;
        let (time, tally) = (self.simulation.time(), *self.simulation.tally());
        if tally.transition - self.quiet_transitions > most {
            return true;
        }
        if time - self.quiet_since < QUIET_CROSSINGS * self.crossing {
            return false;
        }
        tally.transition == self.quiet_transitions && self.simulation.is_idle() == Ok(true)
    }

    fn chunk(&mut self, until: Until) -> Result<Result<Reason, crate::simulation::Arrest>, R::Error> {
        if self.stage.stage == Stage::Equilibration || !self.recorder.has_events() {
            return Ok(self.simulation.advance(until));
        }
        let mut failure = None;
        let recorder = &mut *self.recorder;
        let reason = self.simulation.advance_with(until, |event| {
            if failure.is_none() {
                failure = recorder.event(event).err();
            }
        });
        failure.map_or(Ok(reason), Err)
    }

    /// Hands out a row and a frame of now, unless that was done.
    fn record(&mut self, has_row: bool, has_frame: bool) -> Result<(), R::Error> {
        let now = Some(self.simulation.time());
        if has_row && self.last_row != now {
            self.last_row = now;
            let row = self.observer.row(&self.simulation);
            self.ledger.see(&row);
            self.recorder.row(&row)?;
        }
        if has_frame && self.last_frame != now {
            self.last_frame = now;
            self.recorder.frame(&self.simulation.snapshot())?;
        }
        Ok(())
    }

    fn progress(&self) -> Progress {
        let (time, events) = (self.simulation.time(), self.simulation.tally().physical());
        Progress {
            stage: self.stage.stage,
            time,
            elapsed: time - self.stage.time,
            events: events - self.stage.events,
            limit: self.stage.limit,
        }
    }
}

/// The simulated time in which a typical particle crosses the box, by its speed or from rest; infinite if nothing moves.
fn crossing_time(simulation: &Simulation) -> f64 {
    let scene = simulation.scene();
    let length = scene.space.size.max().max(scene.longest_range());
    let fastest = scene.particles.iter().map(|particle| particle.velocity.norm()).fold(0.0, f64::max);
    let steepest = scene.species.iter().map(|species| species.acceleration.norm()).fold(0.0, f64::max);
    (length / fastest).min((2.0 * length / steepest).sqrt())
}
