//! Begins and ends the stages of a run.

use super::Driver;
use crate::analysis::instruments::Sample;
use crate::model::{Thermostat, Until};
use crate::run::Blocked;
use crate::run::stage::{Settings, Stage};
use crate::run::state::Start;

/// Number of temperature samples between two scalings, because the temperature is not linear in time.
const TEMPERATURES: f64 = 4.0;

impl Driver<'_> {
    pub(super) fn settings(&self) -> Settings {
        self.state.stage.stage.settings(&self.simulation.scene().run)
    }

    pub(super) fn enter(&mut self) {
        let stage = self.state.stage.stage;
        let Settings { mut limit, thermostat, barostat, swap, growth, gravity, stream, .. } = self.settings();
        let scene = self.simulation.scene();
        // A stage without measurement uses the velocity components of the last measurement for the temperature.
        let counted = if matches!(stage, Stage::Preparation(_)) { scene.run.thermostat } else { thermostat };
        self.state.observer.set_thermostat(scene, counted.as_ref());
        self.state.observer.set_swaps(swap.is_some());
        let grown = self.simulation.grown();
        self.state.observer.set_barostat(scene, barostat.as_ref().zip(thermostat.as_ref()), grown);
        let stream = scene.first_stream() + stream;
        let listed = stage.listed_name(&self.simulation.scene().run).to_owned();
        let has_changed = self.simulation.set_stage_of_surfaces(&listed);
        self.blocked = if has_changed { self.blocked_by_surface(&listed) } else { None };
        if let Some(gravity) = gravity {
            self.simulation.set_gravity(&gravity);
        }
        let seed = self.simulation.stream_seed();
        self.simulation.set_planned_thermostat(thermostat.as_ref(), seed, stream);
        self.begin_moves(barostat, seed, stream);
        self.begin_swaps(swap, seed, stream);
        self.state.next_temperature = f64::INFINITY;
        self.state.next_scaling = match thermostat {
            Some(Thermostat::Rescaling { .. }) => self.simulation.time(),
            _ => f64::INFINITY,
        };
        if let Some(growth) = growth {
            self.begin_growth(&growth, &mut limit);
        }
        self.state.stage = Start::of(&self.simulation, stage, limit);
        self.state.has_begun = true;
        (self.state.quiet_steps, self.state.quiet_rows) = (0, 0);
        self.begin_monitor();
        self.state.observer.begin();
        (self.state.rows, self.state.last_row) = (None, None);
        self.describe();
    }

    fn blocked_by_surface(&mut self, stage: &str) -> Option<Blocked> {
        if self.simulation.scene().allow_invalid_start {
            return None;
        }
        self.simulation.complete();
        let (particle, surface, depth) = self.simulation.deepest_in_surface()?;
        Some(Blocked { particle, surface, stage: stage.to_owned(), depth, time: self.simulation.time() })
    }

    pub(super) fn leave(&mut self, next: Stage) {
        self.note_swaps();
        self.state.ledger.note(&self.simulation, &self.simulation.energy());
        if self.growth().is_some() {
            // Removes the heat that growth has added since the last scaling.
            self.rescale(self.simulation.time());
            self.simulation.end_growth();
            self.state.ledger.start_again(&self.simulation);
            self.state.pressure_check = None;
        }
        self.state.stage = Start::of(&self.simulation, next, Until::default());
        self.state.has_begun = false;
        (self.is_over, self.state.monitor, self.state.measurement) = (false, None, None);
        (self.started, self.state.earlier_seconds) = (None, 0.0);
    }

    /// Returns the next time after `time` at a multiple of an interval since the start of the stage. Multiples do not
    /// accumulate rounding errors.
    pub(super) fn next_multiple(&self, interval: f64, time: f64) -> f64 {
        let start = self.state.stage.time;
        let passed = ((time - start) / interval).round();
        (start + (passed + 1.0) * interval).max(time.next_up())
    }

    /// Scales the velocities. The simulation has reached `time` within round-off.
    pub(super) fn rescale(&mut self, time: f64) {
        let Some(Thermostat::Rescaling { temperature, interval }) = self.settings().thermostat else { return };
        self.end_piece();
        let energy = self.simulation.energy();
        self.state.observer.integrate(&self.simulation, &energy);
        let applicable = self.state.observer.applicable();
        if let Some((factor, drift)) = applicable.scaling(&energy, temperature) {
            self.state.ledger.note(&self.simulation, &energy);
            let is_watched = self.state.measurement.as_ref().is_some_and(|it| !it.instruments.is_empty());
            let before = is_watched.then(|| self.simulation.snapshot());
            self.simulation.scale_velocities(factor, &drift);
            if let (Some(before), Some(measurement), Some(system)) = (before, &mut self.state.measurement, &self.system)
            {
                let after = self.simulation.snapshot();
                measurement.instruments.scaled(&Sample::of(&before), &Sample::of(&after), system);
            }
            self.begin_piece();
            let scaled = self.simulation.energy();
            self.state.observer.integrate(&self.simulation, &scaled);
        }
        self.state.next_scaling = self.next_multiple(interval, time);
        self.state.next_temperature =
            if self.state.stage.stage.is_measured() { time + interval / TEMPERATURES } else { f64::INFINITY };
    }

    pub(super) fn sample_temperature(&mut self) {
        let energy = self.simulation.energy();
        self.state.observer.integrate(&self.simulation, &energy);
        let Some(Thermostat::Rescaling { interval, .. }) = self.settings().thermostat else { return };
        let step = interval / TEMPERATURES;
        let next = (self.state.next_temperature + step).max(self.simulation.time().next_up());
        self.state.next_temperature = if next < self.state.next_scaling - 0.5 * step { next } else { f64::INFINITY };
    }
}
