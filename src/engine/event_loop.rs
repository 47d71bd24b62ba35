//! The event loop: pop, stream, execute, repredict.

use super::observe::Observe;
use super::parts::Engine;
use super::prediction::{Due, Prediction};
use super::schedule::{Pending, QueueEntry};
use super::{EngineError, Reason, Until};
use std::ops::ControlFlow;

/// Kind of the next entry of the queue, or of what comes before it.
enum Next {
    /// The prediction of a particle.
    Particle(QueueEntry),
    /// An entry of the queue that is no longer a particle's prediction.
    Void,
    /// A global event.
    GlobalEvent,
    /// The end of the epoch.
    Epoch,
    /// The end of the run.
    Limit,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Puts a particle's pending prediction into the queue.
    #[inline]
    pub(super) fn enqueue(&mut self, particle: u32) {
        let due = Due { predictions: &self.schedule.predictions, bodies: &self.state.bodies };
        let entry = due.entry(particle);
        if entry.time < f64::INFINITY {
            self.schedule.queue.push(entry, &due);
        }
    }

    /// Runs until a time or a number of physical events, calls `observe` for each event and ends where that breaks.
    pub fn advance(&mut self, until: Until, observe: &mut Observe<'_>) -> Result<Reason, EngineError> {
        loop {
            if let Some(reason) = self.advance_for(u64::MAX, until, observe)? {
                return Ok(reason);
            }
        }
    }

    /// Runs as [`Self::advance`] does, but pauses with `None` after a number of steps, be they events, cell transitions, new predictions or whatever
    /// else takes as long. Where it pauses changes nothing.
    ///
    /// The observer is no type parameter: the loop is compiled once for each engine, in the library, and not for each closure of each caller.
    pub fn advance_for(
        &mut self,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        if let Some(broken) = self.broken {
            return Err(broken.into());
        }
        let mut stop = self.since_epoch(until.time);
        let mut left = steps;
        loop {
            let Some(rest) = left.checked_sub(1) else { return Ok(None) };
            left = rest;
            let entry = match self.next_due(stop) {
                Next::Particle(entry) => entry,
                Next::Void => {
                    self.schedule.queue.discard();
                    continue;
                }
                Next::GlobalEvent => {
                    let (taken, flow) = self.execute_global(observe)?;
                    if flow.is_break() {
                        return Ok(Some(Reason::Observer));
                    }
                    left = left.saturating_sub(taken);
                    continue;
                }
                Next::Epoch if until.time == f64::INFINITY && self.is_shown_to_be_over() => {
                    return Ok(Some(Reason::Idle));
                }
                Next::Epoch if self.move_epoch().is_some() => {
                    left = left.saturating_sub(self.steps_of_all());
                    stop = self.since_epoch(until.time);
                    continue;
                }
                Next::Epoch if until.time == f64::INFINITY => return Ok(Some(Reason::Idle)),
                Next::Epoch | Next::Limit => {
                    self.clock.now = stop;
                    return Ok(Some(Reason::Time));
                }
            };
            let particle = entry.particle;
            let prediction = self.schedule.predictions[particle as usize];
            if prediction.is_transition() {
                self.schedule.queue.pop();
                self.clock.now = entry.time;
                self.execute_transition(particle, entry.time)?;
                continue;
            }
            if self.counts.executed >= until.events {
                return Ok(Some(Reason::Events));
            }
            self.schedule.queue.pop();
            self.clock.now = entry.time;
            if self.execute_contact(particle, &prediction, observe)?.is_break() {
                return Ok(Some(Reason::Observer));
            }
            // At the time of the last event, whatever else goes on until the next one.
            if self.counts.executed >= until.events {
                return Ok(Some(Reason::Events));
            }
        }
    }

    /// Executes the contact of a particle that is due now, shows it, and predicts again what it has changed.
    #[inline]
    fn execute_contact(
        &mut self,
        particle: u32,
        prediction: &Prediction,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, EngineError> {
        let now = self.clock.now;
        let Some(flow) = self.execute(particle, prediction, now, observe)? else {
            self.repredict(particle, now);
            return Ok(ControlFlow::Continue(()));
        };
        self.repredict(particle, now);
        if let Some(partner) = prediction.partner_in_contact()
            && !self.is_static(partner)
        {
            self.repredict(partner, now);
        }
        self.counts.executed += 1;
        self.counts.transitions_at_event = self.counts.totals.transition;
        self.count_standstill();
        self.check_standstill(particle, prediction)?;
        Ok(flow)
    }

    /// Kind of the next entry, up to a time since the epoch.
    #[inline]
    fn next_due(&mut self, stop: f64) -> Next {
        let next_global = self.sources.next_global;
        let due = Due { predictions: &self.schedule.predictions, bodies: &self.state.bodies };
        let limit = stop.min(next_global);
        let Some(entry) = self.schedule.queue.peek(limit, &due) else {
            // The epoch ends before whatever happens at its end or later.
            return match () {
                () if limit >= self.schedule.queue.reached() => Next::Epoch,
                () if next_global <= stop => Next::GlobalEvent,
                () => Next::Limit,
            };
        };
        if due.entry(entry.particle) != entry {
            return Next::Void;
        }
        if self.hardware.looks_ahead {
            self.prefetch_coming();
        }
        if entry.time <= limit {
            Next::Particle(entry)
        } else if next_global <= stop {
            Next::GlobalEvent
        } else {
            Next::Limit
        }
    }

    /// Predicts a particle again.
    #[inline]
    pub(super) fn predict_anew(&mut self, particle: u32, time: f64) {
        let mut scratch = self.take_scratch();
        self.schedule.predictions[particle as usize] = self.predict(particle, time, &mut scratch);
        self.scratch = Some(scratch);
    }

    /// Predicts a particle again, and puts its prediction into the queue.
    #[inline]
    pub(super) fn repredict(&mut self, particle: u32, time: f64) {
        self.predict_anew(particle, time);
        self.enqueue(particle);
    }

    pub(super) fn since_epoch(&self, time: f64) -> f64 {
        (time - self.clock.start) - self.clock.epoch
    }
}
