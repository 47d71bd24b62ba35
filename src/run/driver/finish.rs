//! Ends a measured stage or the run.

use super::{Driver, Failed};
use crate::analysis::instruments::Sample;
use crate::analysis::observables::Equilibrium;
use crate::run::stage::Stage;
use crate::run::{Ending, Finished, MeasuredStage, MeasurementPeriod};

impl Driver<'_> {
    pub(super) fn end_measured_stage(&mut self) -> Result<(), Failed> {
        let results = self.results()?;
        self.state.measured_stages.push(results);
        Ok(())
    }

    pub(super) fn finish(mut self, ending: Ending) -> Result<Finished, Failed> {
        self.simulation.complete();
        let stage = self.state.stage.stage;
        if let Stage::MeasurementOf(_) = stage {
            self.end_measured_stage()?;
        }
        if stage != Stage::Measurement {
            self.state.before = *self.simulation.event_counts();
            self.state.counts_before = self.simulation.event_counts_by_species();
        }
        if !stage.is_measured() {
            self.keep()?;
        }
        let last = if self.is_last() {
            self.results()?
        } else {
            self.record(true, true)?;
            self.nothing()
        };
        self.note_swaps();
        let instruments = self.state.measurement.take().map(|measurement| measurement.instruments.into_own());
        Ok(Finished {
            ending,
            stage,
            measurement: last.measurement,
            event_counts_by_species: last.event_counts_by_species,
            observables: last.observables,
            stationarity: last.stationarity,
            equilibrium: last.equilibrium,
            measured: last.measured,
            volume_moves: last.volume_moves,
            swaps: self.state.stage_swaps,
            stages: self.state.measured_stages,
            audit: self.state.ledger.close(&self.simulation),
            frames_limit: self.state.frames.reason(),
            instruments: instruments.unwrap_or_default(),
            simulation: self.simulation,
        })
    }

    /// Records the last row and frame of a measurement, and returns the results.
    fn results(&mut self) -> Result<MeasuredStage, Failed> {
        if let Some((measurement, system)) = self.state.measurement.as_mut().zip(self.system.as_ref()) {
            let snapshot = self.simulation.snapshot();
            measurement.instruments.end(&Sample::of(&snapshot), system);
        }
        self.record(true, self.state.frames.has_last(self.state.stage.stage))?;
        let start = self.state.stage.time;
        let nothing = self.nothing();
        let stationarity = self.state.observer.stationarity();
        Ok(MeasuredStage {
            measurement: MeasurementPeriod {
                start,
                duration: self.simulation.time() - start,
                wall_seconds: self.state.earlier_seconds
                    + self.started.map_or(0.0, |started| started.elapsed().as_secs_f64()),
                ..nothing.measurement
            },
            observables: self.state.observer.estimates(),
            equilibrium: self.state.observer.equilibrium(
                &stationarity,
                &nothing.measurement.event_counts,
                self.simulation.scene().units(),
            ),
            stationarity,
            measured: self.state.measured(self.system.as_ref()),
            ..nothing
        })
    }

    /// Returns the results of a measurement of zero duration.
    fn nothing(&self) -> MeasuredStage {
        MeasuredStage {
            name: self.state.stage.stage.name(&self.simulation.scene().run).into_owned(),
            measurement: MeasurementPeriod {
                start: self.simulation.time(),
                duration: 0.0,
                events_before: self.state.before.physical(),
                event_counts: self.simulation.event_counts().since(&self.state.before),
                wall_seconds: 0.0,
            },
            event_counts_by_species: self.simulation.event_counts_by_species().since(&self.state.counts_before),
            observables: Vec::new(),
            stationarity: Vec::new(),
            equilibrium: Equilibrium::default(),
            measured: crate::analysis::instruments::Measured::default(),
            diameter_factor: self.simulation.scale(),
            volume_moves: self.state.moves.as_ref().map(|moves| moves.done),
        }
    }
}
