//! Instruments at each temperature of an exchange, whichever replica is there.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use crate::analysis::instruments::{Instruments, Measured, Sample, Setup, SystemDescription};
use crate::analysis::observables::ApplicableObservables;
use crate::engine::Simulation;
use crate::model::{ExchangePlan, MeasurementPlan};

/// Instruments at all temperatures; empty before averages begin, and if the scene requests none.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub(super) struct InstrumentsAtTemperatures {
    each: Vec<Instruments>,
    /// Follows from the scene.
    #[serde(skip)]
    system: OnceLock<SystemDescription>,
}

impl InstrumentsAtTemperatures {
    /// Begins to measure. The simulations are in the order of the temperatures.
    pub fn begin<'s>(
        &mut self,
        plan: &ExchangePlan,
        simulations: impl Iterator<Item = &'s Simulation>,
        applicable: &ApplicableObservables,
    ) {
        for simulation in simulations {
            let measure = at_attempts(&simulation.scene().measure, plan.interval);
            if measure.is_empty() {
                return;
            }
            let snapshot = simulation.snapshot();
            let system = description(&self.system, simulation, applicable);
            // Independent of the duration, because an exchange may be extended.
            let setup = Setup { system, sample: Sample::of(&snapshot), duration: plan.interval };
            self.each.push(Instruments::new(&measure, &setup));
        }
    }

    /// Passes each instrument the simulation at its temperature after an attempt.
    pub fn sample<'s>(
        &mut self,
        simulations: impl Iterator<Item = &'s Simulation>,
        applicable: &ApplicableObservables,
    ) {
        for (instruments, simulation) in self.each.iter_mut().zip(simulations) {
            let system = description(&self.system, simulation, applicable);
            // The sample counts as the end of a run, where equal times may differ by rounding.
            instruments.end(&Sample::of(&simulation.snapshot()), system);
        }
    }

    /// Results at each temperature so far; empty if nothing is measured.
    pub fn report(&self, example: &Simulation, applicable: &ApplicableObservables) -> Vec<Measured> {
        let report = |it: &Instruments| it.report(description(&self.system, example, applicable));
        self.each.iter().map(report).collect()
    }
}

/// The description that all simulations share, created once.
fn description<'c>(
    known: &'c OnceLock<SystemDescription>,
    simulation: &Simulation,
    applicable: &ApplicableObservables,
) -> &'c SystemDescription {
    known.get_or_init(|| SystemDescription::of_simulation(simulation, applicable))
}

/// A plan that samples at each attempt unless it specifies an interval.
fn at_attempts(plan: &MeasurementPlan, interval: f64) -> MeasurementPlan {
    let mut plan = plan.clone();
    let of_scene = [
        plan.radial_distribution.as_mut().map(|it| &mut it.interval),
        plan.structure_factor.as_mut().map(|it| &mut it.interval),
        plan.chains.as_mut().map(|it| &mut it.interval),
        plan.bond_order.as_mut().map(|it| &mut it.interval),
    ];
    let of_profiles = plan.profiles.iter_mut().map(|it| &mut it.interval);
    of_scene.into_iter().flatten().chain(of_profiles).for_each(|given| *given = given.or(Some(interval)));
    plan
}
