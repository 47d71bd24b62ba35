//! The end of a run.

use super::Driver;
use crate::analysis::instruments::Sample;
use crate::run::progress::Stage;
use crate::run::{Ending, Finished, Recorder, Stretch};

impl<R: Recorder> Driver<'_, R> {
    /// The last row and frame, and the audit.
    pub(super) fn finish(mut self, ending: Ending) -> Result<Finished, R::Error> {
        let is_measured = self.course.stage.stage == Stage::Measurement;
        let wall_seconds =
            self.course.earlier_seconds + self.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        if !is_measured {
            self.course.before = *self.simulation.tally();
            self.course.counts_before = self.simulation.event_counts();
            self.keep()?;
        }
        self.record(true, true)?;
        if let Some(measurement) = self.course.measurement.as_mut().filter(|_| is_measured) {
            let snapshot = self.simulation.snapshot();
            measurement.instruments.end(&Sample::of(&snapshot), &self.subject);
        }
        let now = self.simulation.time();
        let start = if is_measured { self.course.stage.time } else { now };
        Ok(Finished {
            stretch: Stretch {
                start,
                duration: now - start,
                tally: self.simulation.tally().since(&self.course.before),
                wall_seconds,
            },
            event_counts: self.simulation.event_counts().since(&self.course.counts_before),
            ending,
            stage: self.course.stage.stage,
            observables: if is_measured { self.course.observer.estimates() } else { Vec::new() },
            stationarity: if is_measured { self.course.observer.stationarity() } else { Vec::new() },
            measured: self.course.measured(&self.subject),
            audit: self.course.ledger.close(&self.simulation),
            simulation: self.simulation,
        })
    }
}
