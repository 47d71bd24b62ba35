//! Instruments at each temperature of an exchange. An instrument stays at its temperature when replicas are swapped.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::analysis::instruments::{Instruments, Measured, Sample, Setup, SystemDescription};
use crate::analysis::observables::ApplicableObservables;
use crate::engine::Simulation;
use crate::model::ExchangePlan;

/// Instruments at all temperatures. Empty before averages begin.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct InstrumentsAtTemperatures {
    each: Vec<Instruments>,
    /// Not saved, because it follows from the scene.
    #[serde(skip)]
    system: OnceLock<SystemDescription>,
}

impl InstrumentsAtTemperatures {
    /// Creates the instruments. `simulations` are in the order of the temperatures.
    pub fn begin<'s>(
        &mut self,
        plan: &ExchangePlan,
        simulations: impl Iterator<Item = &'s Simulation>,
        applicable: &ApplicableObservables,
    ) {
        for simulation in simulations {
            let measure = simulation.scene().measure.clone().with_interval(plan.interval);
            if measure.is_empty() {
                return;
            }
            let snapshot = simulation.snapshot();
            let system = description(&self.system, simulation, applicable);
            // The exchange may be extended, so its duration is unknown. The interval between attempts is used.
            let setup = Setup { system, sample: Sample::of(&snapshot), duration: plan.interval };
            self.each.push(Instruments::new(&measure, &setup));
        }
    }

    pub fn sample<'s>(
        &mut self,
        simulations: impl Iterator<Item = &'s Simulation>,
        applicable: &ApplicableObservables,
    ) {
        for (instruments, simulation) in self.each.iter_mut().zip(simulations) {
            let system = description(&self.system, simulation, applicable);
            // Because of round-off, a sample may come slightly before it is due. `end` takes it anyway.
            instruments.end(&Sample::of(&simulation.snapshot()), system);
        }
    }

    pub fn report(&self, example: &Simulation, applicable: &ApplicableObservables) -> Vec<Measured> {
        let report = |it: &Instruments| it.report(description(&self.system, example, applicable));
        self.each.iter().map(report).collect()
    }
}

fn description<'c>(
    known: &'c OnceLock<SystemDescription>,
    simulation: &Simulation,
    applicable: &ApplicableObservables,
) -> &'c SystemDescription {
    known.get_or_init(|| SystemDescription::of_simulation(simulation, applicable))
}
