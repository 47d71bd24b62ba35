//! The event loop: takes events from the queue, executes them, and predicts their particles again.

use super::observe::Observe;
use super::parts::Engine;
use super::prediction::Prediction;
use super::schedule::{Pending, QueueEntry};
use super::{EngineError, InvariantBroken, Reason, Until};
use std::ops::ControlFlow;

pub(super) enum Next {
    Particle(QueueEntry),
    /// An outdated entry of the queue, which is discarded.
    Void,
    GlobalEvent,
    /// The epoch ends before any other action.
    Epoch,
    /// Nothing more is due before the time at which the loop stops.
    Stop,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline]
    pub(super) fn enqueue(&mut self, particle: u32) {
        let (queue, due) = self.schedule.split(&self.state.bodies);
        queue.enter(particle, &due);
    }

    pub fn advance(&mut self, until: Until, observe: &mut Observe<'_>) -> Result<Reason, EngineError> {
        loop {
            if let Some(reason) = self.advance_for(u64::MAX, until, observe)? {
                return Ok(reason);
            }
        }
    }

    /// Runs like [`Self::advance`], but pauses after a number of steps and then returns `None`. Steps are events, cell
    /// transitions, new predictions, and work of similar cost. Pauses do not change any result.
    ///
    /// The observer is not generic, so that the loop is compiled once per engine and not once per closure.
    pub fn advance_for(
        &mut self,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        let reason = self.advance_with_gaps(steps, until, observe);
        self.close_gaps();
        reason
    }

    /// Runs the event loop. Afterwards, there may be gaps in memory where particles have left the system.
    fn advance_with_gaps(
        &mut self,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        if let Some(broken) = self.broken {
            return Err(broken.into());
        }
        let mut stop = self.since_epoch(until.last_time());
        let mut left = steps;
        loop {
            let Some(rest) = left.checked_sub(1) else { return Ok(None) };
            left = rest;
            let entry = match self.next_due_without_gaps(stop) {
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
                Next::Epoch if until.last_time() == f64::INFINITY && self.is_shown_to_be_over() => {
                    return Ok(Some(Reason::Idle));
                }
                Next::Epoch if self.move_epoch().is_some() => {
                    left = left.saturating_sub(self.steps_of_all());
                    stop = self.since_epoch(until.last_time());
                    continue;
                }
                Next::Epoch if until.last_time() == f64::INFINITY => return Ok(Some(Reason::Idle)),
                Next::Epoch | Next::Stop => {
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
            if self.counts.executed >= until.last_event() {
                return Ok(Some(Reason::Events));
            }
            self.schedule.queue.pop();
            self.clock.now = entry.time;
            if let Some(flow) = self.execute_contact(particle, &prediction, observe)? {
                self.check_progress(particle, &prediction)?;
                if flow.is_break() {
                    return Ok(Some(Reason::Observer));
                }
            }
            // Without this check, cell transitions after the last event would advance the time.
            if self.counts.executed >= until.last_event() {
                return Ok(Some(Reason::Events));
            }
        }
    }

    /// Executes a predicted contact, and predicts both particles again. If the contact is outdated, the particle is
    /// predicted again, and the result is `None`.
    #[inline(always)]
    pub(super) fn execute_contact(
        &mut self,
        particle: u32,
        prediction: &Prediction,
        observe: &mut Observe<'_>,
    ) -> Result<Option<ControlFlow<()>>, InvariantBroken> {
        let now = self.clock.now;
        let flow = self.execute(particle, prediction, now, observe)?;
        // A particle that has just left at an outlet is not predicted.
        if self.state.vacant.last() != Some(&particle) {
            self.repredict(particle, now);
        }
        if flow.is_some() {
            if let Some(partner) = prediction.partner_in_contact()
                && !self.is_static(partner)
            {
                self.repredict(partner, now);
            }
            self.counts.executed += 1;
        }
        Ok(flow)
    }

    /// Returns an error if events continue but time stands still.
    #[inline]
    fn check_progress(&mut self, particle: u32, prediction: &Prediction) -> Result<(), EngineError> {
        self.counts.transitions_at_event = self.counts.totals.transition;
        self.count_standstill();
        Ok(self.check_standstill(particle, prediction)?)
    }

    /// Returns the next action, as [`Self::next_due`] does. At the end of an epoch, closes gaps in memory, because a
    /// new epoch visits all particles.
    #[inline(always)]
    fn next_due_without_gaps(&mut self, stop: f64) -> Next {
        let next = self.next_due(stop);
        if matches!(next, Next::Epoch) && !self.state.vacant.is_empty() {
            self.close_gaps();
        }
        next
    }

    /// Returns the next action up to the time `stop`, counted from the epoch.
    #[inline(always)]
    pub(super) fn next_due(&mut self, stop: f64) -> Next {
        let next_global = self.sources.next_global;
        let (queue, due) = self.schedule.split(&self.state.bodies);
        let limit = stop.min(next_global);
        let Some(entry) = queue.peek(limit, &due) else {
            // An epoch ends before any action that is due at its end time or later.
            return match () {
                () if limit >= queue.reached() => Next::Epoch,
                () if next_global <= stop => Next::GlobalEvent,
                () => Next::Stop,
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
            Next::Stop
        }
    }

    /// Predicts a particle again, but leaves the queue unchanged.
    #[inline]
    pub(super) fn predict_anew(&mut self, particle: u32, time: f64) {
        let mut scratch = self.take_scratch();
        self.schedule.predictions[particle as usize] = self.predict(particle, time, &mut scratch);
        self.scratch = Some(scratch);
    }

    #[inline]
    pub(super) fn repredict(&mut self, particle: u32, time: f64) {
        self.predict_anew(particle, time);
        self.enqueue(particle);
    }

    pub(super) fn since_epoch(&self, time: f64) -> f64 {
        (time - self.clock.start) - self.clock.epoch
    }
}
