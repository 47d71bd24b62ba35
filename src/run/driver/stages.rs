//! What acts on each stage of a run: thermostats, growing diameters.

use super::Driver;
use crate::measure::Subject;
use crate::run::Recorder;
use crate::run::course::Start;
use crate::run::progress::Stage;
use crate::scene::{Growth, GrowthTarget, Limit, Thermostat};

/// Growth may go this much too far, so that rounding does not leave it short of its target.
const BEYOND: f64 = 1.0 + 1e-12;

/// The pressure of growing spheres is averaged over this many contacts of each.
const CONTACTS: u64 = 10;

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
        self.course.next_scaling = match thermostat {
            Some(Thermostat::Rescaling { .. }) => self.simulation.time(),
            _ => f64::INFINITY,
        };
        if let Some(growth) = growth {
            self.begin_growth(&growth, &mut limit);
        }
        self.course.stage = Start::of(&self.simulation, stage, limit);
        self.course.has_begun = true;
        self.subject = Subject::of(self.simulation.scene());
    }

    /// Ends the present stage.
    pub(super) fn leave(&mut self, next: Stage) {
        self.course.ledger.note(&self.simulation.energy());
        if self.growth().is_some() {
            // What growth has heated since the last scaling.
            self.rescale(self.simulation.time());
            self.simulation.end_growth();
            self.course.growth_look = None;
        }
        self.course.stage = Start::of(&self.simulation, next, Limit::default());
        self.course.has_begun = false;
    }

    /// The growth of the present stage.
    pub(super) fn growth(&self) -> Option<Growth> {
        match self.course.stage.stage {
            Stage::Preparation(number) => self.simulation.scene().run.stages[number as usize].growth,
            _ => None,
        }
    }

    fn begin_growth(&mut self, growth: &Growth, limit: &mut Limit) {
        let scene = self.simulation.scene();
        let dimensions = scene.space.dimensions();
        let (filled, target) = match growth.until {
            GrowthTarget::PackingFraction(target) => (scene.packing_fraction(), target),
            // Nothing is denser than full.
            GrowthTarget::CompressibilityFactor(_) => (scene.packing_fraction(), 1.0),
        };
        // What is too little to begin with was refused with the scene, but for rounding.
        let largest = libm::pow(target / filled, 1.0 / dimensions as f64).max(1.0) * BEYOND;
        self.simulation.grow(growth, largest);
        if matches!(growth.until, GrowthTarget::PackingFraction(_)) {
            let duration = (largest - 1.0) / growth.rate;
            limit.time = Some(limit.time.map_or(duration, |time| time.min(duration)));
        }
    }

    /// Whether growing spheres have come to the pressure that they are to reach.
    pub(super) fn has_grown(&mut self) -> bool {
        let Some(Growth { until: GrowthTarget::CompressibilityFactor(target), .. }) = self.growth() else {
            return false;
        };
        let (time, tally) = (self.simulation.time(), self.simulation.tally());
        let (virial, contacts) = (tally.virial, tally.core);
        let meaning = self.course.observer.meaning();
        let Some((since, before, contacts_before)) = self.course.growth_look else {
            self.course.growth_look = Some((time, virial, contacts));
            return false;
        };
        if 2 * (contacts - contacts_before) < CONTACTS * meaning.moving as u64 {
            return false;
        }
        self.course.growth_look = Some((time, virial, contacts));
        let energy = self.simulation.energy();
        let temperature = meaning.temperature(energy.thermal, &energy.momentum).unwrap_or(0.0);
        let factor = 1.0 + (virial - before) / (meaning.degrees_of_freedom * temperature * (time - since));
        factor >= target
    }

    /// Scales velocities to the temperature of the thermostat, at a time that the simulation has come to, but for rounding.
    pub(super) fn rescale(&mut self, time: f64) {
        let plan = &self.simulation.scene().run;
        let thermostat = match self.course.stage.stage {
            Stage::Preparation(number) => plan.stages[number as usize].thermostat,
            _ => plan.thermostat,
        };
        let Some(Thermostat::Rescaling { temperature, interval }) = thermostat else { return };
        let energy = self.simulation.energy();
        let meaning = self.course.observer.meaning();
        if let Some(now) = meaning.temperature(energy.thermal, &energy.momentum)
            && now > 0.0
        {
            let drift = meaning.drift(&energy.momentum);
            self.course.ledger.note(&energy);
            self.simulation.scale_velocities((temperature / now).sqrt(), &drift);
        }
        // Counted from the start of the stage, so that rounding does not add up.
        let start = self.course.stage.time;
        let passed = ((time - start) / interval).floor();
        self.course.next_scaling = (start + (passed + 1.0) * interval).max(time.next_up());
    }
}
