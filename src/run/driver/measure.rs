//! Records rows in every stage, and frames and instrument samples in a measurement.

use super::pace::Pace;
use super::{Driver, Failed};
use crate::analysis::instruments::{Instruments, Sample, Setup, number_of_scalars, scalars};
use crate::analysis::sampling_times::SamplingTimes;
use crate::base::clock::Instant;
use crate::model::Until;
use crate::run::Ending;
use crate::run::stage::Stage;
use crate::run::state::{Measurement, NEAR};

/// Maximum number of rows or frames since the last event, in a stage without a time limit. It saves disk space.
const MOST_QUIET_ROWS: u64 = if cfg!(test) { 1_000 } else { 1_000_000 };

impl Driver<'_> {
    pub(super) fn measure(&mut self) -> Result<Ending, Failed> {
        if self.state.measurement.is_none() && self.state.pilot.is_none() {
            self.record(true, self.state.frames.has_first())?;
            self.state.before = *self.simulation.event_counts();
            self.state.counts_before = self.simulation.event_counts_by_species();
        }
        self.started = Some(Instant::now());
        if self.state.stage.limit == Until::default() {
            self.keep()?;
            return Ok(Ending::Events);
        }
        let mut ended = None;
        if self.state.measurement.is_none() {
            match self.pace()? {
                Some(pace) => {
                    ended = pace.ending.clone();
                    self.set_up(pace);
                }
                None => {
                    if !self.is_halted {
                        self.keep()?;
                    }
                    return Ok(Ending::Interrupted);
                }
            }
        }
        let ending = match ended {
            Some(ending) => ending,
            None => self.sample_until_end()?,
        };
        // The checkpoint precedes the last row and frame, so a continued run has the output of an uninterrupted run.
        if (self.is_last() || ending.is_early()) && !self.is_halted {
            self.keep()?;
        }
        if ending == Ending::Time
            && let Some(ending) = self.advance(self.state.stage.end().0, u64::MAX)?
        {
            return Ok(ending);
        }
        Ok(ending)
    }

    pub(super) fn is_last(&self) -> bool {
        self.state.stage.stage == Stage::Measurement
    }

    /// Starts or continues a stage without measurement. Returns an ending if the whole run ends in this stage.
    pub(super) fn prepare(&mut self) -> Result<Option<Ending>, Failed> {
        if self.state.rows.is_none() {
            if self.state.pilot.is_none() {
                self.record(true, false)?;
            }
            let Some((rows, ended)) = self.pace_of_rows()? else { return Ok(Some(Ending::Interrupted)) };
            (self.state.rows, self.state.pilot) = (Some(rows), None);
            if ended.is_some() || self.is_over {
                return Ok(ended.filter(Ending::is_early));
            }
        }
        let (end_time, end_events) = self.state.stage.end();
        loop {
            let due = self.state.rows.as_ref().map_or(f64::INFINITY, SamplingTimes::next);
            match self.advance(due.min(end_time), end_events)? {
                Some(over) if over.is_early() => return Ok(Some(over)),
                Some(_) => return Ok(None),
                None if self.is_over => return Ok(None),
                None if due >= end_time - NEAR * (end_time - self.state.stage.time) => {
                    // Because of rounding, the last sampling time may be slightly before the end of the stage.
                    let ending = self.advance(end_time, end_events)?;
                    return Ok(ending.filter(Ending::is_early));
                }
                None => {}
            }
            self.record(true, false)?;
            if self.is_too_quiet() {
                return Ok(Some(Ending::GaveUp));
            }
            let now = self.simulation.time().max(due);
            if let Some(rows) = &mut self.state.rows {
                rows.pass(now);
            }
        }
    }

    fn set_up(&mut self, Pace { rows, frames, duration, .. }: Pace) {
        self.state.pilot = None;
        let mut instruments = Instruments::default();
        if let Some(system) = &self.system {
            let snapshot = self.simulation.snapshot();
            // Without events, the duration cannot be estimated.
            let is_known = duration.is_finite() && duration > 0.0;
            let duration = if is_known { duration } else { self.without_rate(self.state.planned().time) };
            let setup = Setup { system, sample: Sample::of(&snapshot), duration };
            instruments = Instruments::new(&self.simulation.scene().measure, &setup);
            if self.is_last() {
                instruments.begin(&mut self.registry, &setup);
            }
        }
        self.state.measurement = Some(Measurement { rows, frames, instruments });
    }

    fn sample_until_end(&mut self) -> Result<Ending, Failed> {
        let (end_time, end_events) = self.state.stage.end();
        loop {
            let Some(measurement) = &self.state.measurement else { return Ok(Ending::Time) };
            if measurement.instruments.is_done() {
                return Ok(Ending::Condition);
            }
            let (row, frame) = (measurement.rows.next(), measurement.frames.next());
            let sample = measurement.instruments.next_sample();
            let due = row.min(frame).min(sample);
            if let Some(ending) = self.advance(due.min(end_time), end_events)? {
                return Ok(ending);
            }
            if due >= end_time - NEAR * (end_time - self.state.stage.time) {
                return Ok(Ending::Time);
            }
            // Because of rounding, the simulation may have stopped slightly before the sampling time.
            let now = self.simulation.time().max(due);
            // Instruments come first, because frames contain per-particle values from them.
            if let Some((measurement, system)) =
                self.state.measurement.as_mut().zip(self.system.as_ref()).filter(|_| sample <= due)
            {
                let snapshot = self.simulation.snapshot();
                measurement.instruments.sample(&Sample { time: now, ..Sample::of(&snapshot) }, system);
            }
            self.record(row <= due, frame <= due)?;
            if self.is_too_quiet() {
                return Ok(Ending::GaveUp);
            }
            let Some(measurement) = &mut self.state.measurement else { return Ok(Ending::Time) };
            if row <= due {
                measurement.rows.pass(now);
            }
            if frame <= due {
                measurement.frames.pass(now);
            }
        }
    }

    fn is_too_quiet(&mut self) -> bool {
        self.state.quiet_rows += 1;
        self.state.quiet_rows > MOST_QUIET_ROWS && self.state.stage.limit.time.is_none()
    }

    pub(super) fn record(&mut self, has_row: bool, has_frame: bool) -> Result<(), Failed> {
        let now = Some(self.simulation.time());
        if has_row && self.state.last_row != now {
            self.state.last_row = now;
            let row = self.state.observer.row(&self.simulation);
            self.state.ledger.see(&row);
            self.recorder.row(self.state.stage.stage, &row)?;
        }
        if has_frame && self.state.last_frame != now {
            self.state.last_frame = now;
            let plan = &self.simulation.scene().measure;
            if let Some(system) =
                self.system.as_ref().filter(|system| number_of_scalars(plan, system.space.dimensions()) > 0)
            {
                let snapshot = self.simulation.snapshot();
                let instruments = self.state.measurement.as_ref().map(|measurement| &measurement.instruments);
                let scalars = scalars(plan, instruments, &Sample::of(&snapshot), system);
                self.recorder.frame(&snapshot, scalars)?;
            } else {
                self.recorder.frame_of(&self.simulation)?;
            }
        }
        Ok(())
    }
}
