//! What acts on each stage of a run.

use super::Driver;
use crate::analysis::instruments::Subject;
use crate::model::{Limit, Thermostat};
use crate::run::Recorder;
use crate::run::course::Start;
use crate::run::progress::Stage;

/// The temperature is looked at so often between two scalings, because it does not go on a straight line there.
const GLANCES: f64 = 4.0;

impl<R: Recorder> Driver<'_, R> {
    /// Sets the present stage up.
    pub(super) fn enter(&mut self) {
        let plan = &self.simulation.scene().run;
        let stage = self.course.stage.stage;
        let (mut limit, thermostat, growth, number) = match stage {
            Stage::Preparation(number) => {
                let stage = &plan.stages[number as usize];
                (stage.limit, stage.thermostat, stage.growth, number as usize)
            }
            Stage::Equilibration => (plan.equilibration, plan.thermostat, None, plan.stages.len()),
            Stage::Measurement => (plan.limit, plan.thermostat, None, plan.stages.len() + 1),
        };
        self.simulation.set_thermostat(thermostat.as_ref(), number);
        self.course.next_glance = f64::INFINITY;
        self.course.next_scaling = match thermostat {
            Some(Thermostat::Rescaling { .. }) => self.simulation.time(),
            _ => f64::INFINITY,
        };
        if let Some(growth) = growth {
            self.begin_growth(&growth, &mut limit);
        }
        self.course.stage = Start::of(&self.simulation, stage, limit);
        self.course.has_begun = true;
        (self.course.quiet_steps, self.course.quiet_rows) = (0, 0);
        self.begin_monitor();
        self.course.observer.begin();
        (self.course.rows, self.course.last_row) = (None, None);
        self.subject = Subject::of(self.simulation.scene());
    }

    /// Ends the present stage.
    pub(super) fn leave(&mut self, next: Stage) {
        self.course.ledger.note(&self.simulation.energy());
        if self.growth().is_some() {
            // What growth has heated since the last scaling.
            self.rescale(self.simulation.time());
            self.simulation.end_growth();
            self.course.pressure_look = None;
        }
        self.course.stage = Start::of(&self.simulation, next, Limit::default());
        self.course.has_begun = false;
        (self.is_over, self.course.monitor) = (false, None);
    }

    /// Scales velocities to the temperature of the thermostat, at a time that the simulation has come to, but for rounding.
    pub(super) fn rescale(&mut self, time: f64) {
        let plan = &self.simulation.scene().run;
        let thermostat = match self.course.stage.stage {
            Stage::Preparation(number) => plan.stages[number as usize].thermostat,
            _ => plan.thermostat,
        };
        let Some(Thermostat::Rescaling { temperature, interval }) = thermostat else { return };
        self.end_piece();
        let energy = self.simulation.energy();
        self.course.observer.look(&self.simulation, &energy);
        let meaning = self.course.observer.meaning();
        if let Some(now) = meaning.temperature(energy.thermal, &energy.peculiar_momentum)
            && now > 0.0
        {
            let drift = meaning.drift(&energy.peculiar_momentum);
            self.course.ledger.note(&energy);
            self.simulation.scale_velocities((temperature / now).sqrt(), &drift);
            self.begin_piece();
            let scaled = self.simulation.energy();
            self.course.observer.look(&self.simulation, &scaled);
        }
        // Counted from the start of the stage, so that rounding does not add up.
        let start = self.course.stage.time;
        let passed = ((time - start) / interval).floor();
        self.course.next_scaling = (start + (passed + 1.0) * interval).max(time.next_up());
        let is_measured = self.course.stage.stage == Stage::Measurement;
        self.course.next_glance = if is_measured { time + interval / GLANCES } else { f64::INFINITY };
    }

    /// Looks at the temperature between two scalings.
    pub(super) fn glance(&mut self) {
        let energy = self.simulation.energy();
        self.course.observer.look(&self.simulation, &energy);
        let Some(Thermostat::Rescaling { interval, .. }) = self.simulation.scene().run.thermostat else { return };
        let step = interval / GLANCES;
        let next = (self.course.next_glance + step).max(self.simulation.time().next_up());
        self.course.next_glance = if next < self.course.next_scaling - 0.5 * step { next } else { f64::INFINITY };
    }
}
