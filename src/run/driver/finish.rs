//! The end of a run.

use super::Driver;
use crate::analysis::instruments::Sample;
use crate::run::progress::Stage;
use crate::run::{Ending, Finished, MeasurementPeriod, Recorder};

impl<R: Recorder> Driver<'_, R> {
    /// The last row and frame, and the audit.
    pub(super) fn finish(mut self, ending: Ending) -> Result<Finished, R::Error> {
        let is_measured = self.state.stage.stage == Stage::Measurement;
        let wall_seconds =
            self.state.earlier_seconds + self.started.map_or(0.0, |started| started.elapsed().as_secs_f64());
        if !is_measured {
            self.state.before = *self.simulation.event_counts();
            self.state.counts_before = self.simulation.event_counts_by_species();
            self.keep()?;
        }
        self.record(true, true)?;
        let measurement = self.state.measurement.as_mut().filter(|_| is_measured);
        if let Some((measurement, system)) = measurement.zip(self.system.as_ref()) {
            let snapshot = self.simulation.snapshot();
            measurement.instruments.end(&Sample::of(&snapshot), system);
        }
        let now = self.simulation.time();
        let start = if is_measured { self.state.stage.time } else { now };
        Ok(Finished {
            measurement: MeasurementPeriod {
                start,
                duration: now - start,
                event_counts: self.simulation.event_counts().since(&self.state.before),
                wall_seconds,
            },
            event_counts_by_species: self.simulation.event_counts_by_species().since(&self.state.counts_before),
            ending,
            stage: self.state.stage.stage,
            observables: if is_measured { self.state.observer.estimates() } else { Vec::new() },
            stationarity: if is_measured { self.state.observer.stationarity() } else { Vec::new() },
            measured: self.state.measured(self.system.as_ref()),
            audit: self.state.ledger.close(&self.simulation),
            simulation: self.simulation,
        })
    }
}
