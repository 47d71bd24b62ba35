use std::ops::ControlFlow;
use std::time::Duration;

use super::{Driver, Failed, Halt, NEVER, STEPS};
use crate::base::clock::Instant;
use crate::engine::event::Event;
use crate::engine::{EngineError, Reason, Until};
use crate::run::Ending;
use crate::run::state::Aim;

/// Number of physical events between two checks of a run.
const CHUNK: u64 = 10_000;

/// Number of physical events per particle between two checks of a run on several threads or processes.
const SPREAD: u64 = 64;

/// Longest wait for an event in a run without a time limit, in crossing times of the box. After such a wait, round-off
/// is too large to predict another event, and the run gives up.
const LONGEST_WAIT: f64 = 1e12;

/// Desired wall time between two calls of `watch`.
const PAUSE: Duration = Duration::from_millis(20);

impl Driver<'_> {
    /// Advances to a simulated time, a number of events or the next check of the run, whichever comes first. Returns an
    /// ending at the simulated time, or if the stage or the run ends. While initial overlaps remain, checks are
    /// frequent, to find the time of the last overlap.
    pub(super) fn go(&mut self, time: f64, events: u64) -> Result<Option<Ending>, Failed> {
        let (wait, check) = (self.state.wait, self.state.overlap_check);
        let has_overlaps = self.state.ledger.has_overlaps();
        let aim =
            if has_overlaps { self.aim(check.time, check.events) } else { self.aim(wait, self.events_to_check()) };
        let until = aim.until(time, events);
        let reason = match self.chunk(until)? {
            Ok(reason) => reason,
            Err(ending) => return Ok(Some(ending)),
        };
        let reached = (reason == Reason::Time && until.last_time() >= time).then_some(Ending::Time);
        let ending = self.quiet(&aim, reason);
        if has_overlaps {
            self.state.ledger.see_overlaps(&self.simulation);
            self.state.overlap_check.grow();
            return Ok(ending.or(reached));
        }
        let is_still = self.state.quiet_steps > 0 && self.simulation.event_counts().transition == aim.transitions;
        let waited = self.simulation.time() - (aim.time - wait);
        let state = &mut self.state;
        state.wait = if is_still { 2.0 * wait } else { state.crossing };
        if ending.is_some() {
            return Ok(ending);
        }
        if is_still && waited > LONGEST_WAIT * state.crossing && state.stage.limit.time.is_none() {
            return Ok(Some(Ending::GaveUp));
        }
        Ok(reached)
    }

    /// Returns the number of physical events until the next check. At a check, several threads must wait for one.
    fn events_to_check(&self) -> u64 {
        if !self.simulation.is_spread() {
            return CHUNK;
        }
        CHUNK.max(SPREAD * self.simulation.population().iter().sum::<usize>() as u64)
    }

    /// Returns the next check of the run. A continued run keeps the check that was planned before the interruption.
    fn aim(&mut self, ahead: f64, events: u64) -> Aim {
        let event_counts = *self.simulation.event_counts();
        let aim = Aim {
            time: self.simulation.time() + ahead,
            events: event_counts.physical().saturating_add(events),
            transitions: event_counts.transition,
            collisions: event_counts.thermostat,
            done: event_counts.physical(),
        };
        *self.state.aim.get_or_insert(aim)
    }

    /// Returns an ending if no further event can occur.
    fn quiet(&mut self, aim: &Aim, reason: Reason) -> Option<Ending> {
        let now = self.simulation.event_counts();
        let state = &mut self.state;
        if now.physical() != aim.done || now.thermostat != aim.collisions {
            (state.quiet_steps, state.quiet_rows) = (0, 0);
            return None;
        }
        state.quiet_steps += 1;
        // The test for further events is expensive. It is made after 1, 2, 4, ... consecutive checks without an event.
        let is_asked = state.stage.limit.time.is_none() && state.quiet_steps.is_power_of_two();
        let nothing_is_due = reason == Reason::Idle;
        if is_asked || nothing_is_due {
            self.simulation.complete();
            if self.simulation.is_over() {
                return Some(Ending::Idle);
            }
        }
        // In a growth stage, spheres may come to rest when they cannot grow further. This is a normal end.
        let nothing = if self.growth().is_some() { Ending::Idle } else { Ending::GaveUp };
        nothing_is_due.then_some(nothing)
    }

    /// Advances to a time or a number of events, and calls `watch` on the way.
    fn chunk(&mut self, until: Until) -> Result<Result<Reason, Ending>, Failed> {
        loop {
            let started = Instant::now();
            let pause = self.pause();
            let nearer = until.or(pause);
            let reached = self.steps(nearer)?;
            self.steps = self.simulation.agreed(steps_after(self.steps, started.elapsed()).min(self.most_steps));
            if self.work() > self.patience {
                return Ok(Err(Ending::Idle));
            }
            match reached {
                Ok(Some(Reason::Observer)) => return Ok(Err(Ending::Condition)),
                Ok(Some(Reason::Time)) if pause.last_time() < until.last_time() => return Ok(Err(self.paused(nearer))),
                Ok(Some(Reason::Events)) if pause.last_event() < until.last_event() => {
                    return Ok(Err(self.paused(nearer)));
                }
                Ok(Some(reason)) => {
                    self.state.aim = None;
                    return Ok(Ok(reason));
                }
                Ok(None) => {}
                Err(error) => return Ok(Err(error.into())),
            }
            if self.is_checkpoint_due() {
                self.keep()?;
            }
            if self.is_stopped() {
                self.simulation.settle();
                return Ok(Err(Ending::Interrupted));
            }
        }
    }

    fn pause(&self) -> Until {
        self.pause.or(self.halt())
    }

    fn halt(&self) -> Until {
        match self.halt {
            Halt::At(until) if !self.is_pilot => until,
            _ => NEVER,
        }
    }

    /// Records whether the run has reached `halt`.
    fn paused(&mut self, at: Until) -> Ending {
        let halt = self.halt();
        self.is_halted = !self.is_pilot && (halt.last_time() <= at.last_time() || halt.last_event() <= at.last_event());
        Ending::Interrupted
    }

    fn steps(&mut self, until: Until) -> Result<Result<Option<Reason>, EngineError>, Failed> {
        let is_measuring = self.state.stage.stage.is_measured() && !self.is_pilot;
        let has_events = is_measuring && self.agreed(self.recorder.has_events());
        // With several processes, a process must complete all steps before it returns an error.
        let is_alone = self.simulation.processes() == 1;
        let measurement = self.state.measurement.as_mut().filter(|_| is_measuring);
        let instruments = measurement.map(|it| &mut it.instruments).filter(|it| it.has_events());
        let mut instruments = instruments.zip(self.system.as_ref());
        let mut recorder = has_events.then_some(&mut *self.recorder);
        if instruments.is_none() && recorder.is_none() {
            return Ok(self.simulation.advance_unsettled(self.steps, until, None));
        }
        let mut failure = None;
        let mut show = |event: &Event| {
            if let Some((instruments, system)) = &mut instruments {
                instruments.event(event, system);
            }
            if let Some(recorder) = recorder.as_mut().filter(|_| failure.is_none()) {
                failure = recorder.event(event).err();
            }
            let is_done = instruments.as_ref().is_some_and(|(instruments, _)| instruments.is_done());
            if is_done || (is_alone && failure.is_some()) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let reason = self.simulation.advance_unsettled(self.steps, until, Some(&mut show));
        failure.map_or(Ok(reason), Err)
    }

    pub(super) fn work(&self) -> u64 {
        let event_counts = self.simulation.event_counts();
        event_counts.physical().saturating_add(event_counts.transition).saturating_add(event_counts.thermostat)
    }
}

fn steps_after(steps: u64, took: Duration) -> u64 {
    let next = if took > PAUSE { steps / 2 } else { steps * 2 };
    next.clamp(1, STEPS[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn step_count_adapts_to_duration_within_limits() {
        assert_eq!(steps_after(64, PAUSE), 128);
        assert_eq!(steps_after(64, 2 * PAUSE), 32);
        assert_eq!(steps_after(1, 1000 * PAUSE), 1);
        assert_eq!(steps_after(STEPS[1], Duration::ZERO), STEPS[1]);
    }
}
