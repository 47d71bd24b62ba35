//! Instruments: what each has in common, and all of a run together.

use serde::{Deserialize, Serialize};

use super::bond_order::BondOrder;
use super::chains::Chains;
use super::diffusion::Diffusion;
use super::flow::Flow;
use super::free_paths::FreePaths;
use super::pressure_tensor::PressureTensor;
use super::profiles::Profile;
use super::quantity::Measured;
use super::radial_distribution::RadialDistribution;
use super::structure_factor::StructureFactor;
use super::system::{Sample, SystemDescription};
use super::transport::Transport;
use crate::engine::event::Event;
use crate::model::measurement_plan::MeasurementPlan;

/// What an instrument starts with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup<'a> {
    /// The description of the system.
    pub system: &'a SystemDescription,
    /// The particles at the start of the measurement.
    pub sample: Sample<'a>,
    /// How long the measurement will last, as far as is known; positive and finite `[time]`.
    pub duration: f64,
}

/// Measures one kind of quantity.
pub(crate) trait Instrument {
    /// Simulated time of the next sample that it wants, later than the last one; infinite for none.
    fn next_sample(&self) -> f64;

    /// Shows it the particles, at the time that it asked for or, at the end of the run, earlier.
    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription);

    /// Shows it the particles at the end of the measurement, if that is the time that it has asked for.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let due = self.next_sample();
        if is_now(due, sample.time) {
            self.sample(&Sample { time: due, ..*sample }, system);
        }
    }

    /// Whether it wants to see events.
    fn has_events(&self) -> bool {
        false
    }

    /// Shows it an event.
    fn event(&mut self, _event: &Event, _subject: &SystemDescription) {}

    /// Adds what it has measured so far.
    fn report(&self, system: &SystemDescription, measured: &mut Measured);
}

/// Whether two times are the same but for rounding.
fn is_now(due: f64, now: f64) -> bool {
    due <= now || due - now <= 16.0 * f64::EPSILON * now.abs()
}

/// Declares the kinds of instruments.
macro_rules! instruments {
    ($($kind:ident($type:ty)),* $(,)?) => {
        /// One instrument of any kind.
        #[derive(Debug, Clone, Serialize, Deserialize)]
        enum Kind { $($kind($type),)* }

        impl Kind {
            fn get(&self) -> &dyn Instrument {
                match *self { $(Self::$kind(ref instrument) => instrument,)* }
            }

            fn get_mut(&mut self) -> &mut dyn Instrument {
                match *self { $(Self::$kind(ref mut instrument) => instrument,)* }
            }
        }
    };
}

instruments! {
    PressureTensor(PressureTensor),
    Diffusion(Diffusion),
    Transport(Transport),
    FreePaths(FreePaths),
    Flow(Flow),
    RadialDistribution(RadialDistribution),
    StructureFactor(StructureFactor),
    Chains(Chains),
    BondOrder(BondOrder),
    Profile(Profile),
}

/// All instruments of a run.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Instruments {
    kinds: Vec<Kind>,
}

impl Instruments {
    /// Instruments for what is planned, at the start of the measurement.
    pub(crate) fn new(plan: &MeasurementPlan, setup: &Setup<'_>) -> Self {
        let mut kinds = Vec::new();
        kinds.extend(plan.pressure_tensor.as_ref().map(|plan| Kind::PressureTensor(PressureTensor::new(plan, setup))));
        kinds.extend(plan.diffusion.as_ref().map(|plan| Kind::Diffusion(Diffusion::new(plan, setup))));
        kinds.extend(plan.transport.as_ref().map(|plan| Kind::Transport(Transport::new(plan, setup))));
        kinds.extend(plan.free_paths.as_ref().map(|plan| Kind::FreePaths(FreePaths::new(plan, setup))));
        kinds.extend(plan.flows.iter().map(|plan| Kind::Flow(Flow::new(plan, setup))));
        let radial = plan.radial_distribution.as_ref();
        kinds.extend(radial.map(|plan| Kind::RadialDistribution(RadialDistribution::new(plan, setup))));
        let factor = plan.structure_factor.as_ref();
        kinds.extend(factor.map(|plan| Kind::StructureFactor(StructureFactor::new(plan, setup))));
        kinds.extend(plan.chains.as_ref().map(|plan| Kind::Chains(Chains::new(plan, setup))));
        kinds.extend(plan.bond_order.as_ref().map(|plan| Kind::BondOrder(BondOrder::new(plan, setup))));
        kinds.extend(plan.profiles.iter().map(|plan| Kind::Profile(Profile::new(plan, setup))));
        Self { kinds }
    }

    /// Simulated time of the next sample that any of them wants; infinite for none.
    pub(crate) fn next_sample(&self) -> f64 {
        self.kinds.iter().map(|kind| kind.get().next_sample()).fold(f64::INFINITY, f64::min)
    }

    /// Shows the particles to those that have waited for this time.
    pub(crate) fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        for kind in &mut self.kinds {
            if kind.get().next_sample() <= sample.time {
                kind.get_mut().sample(sample, system);
            }
        }
    }

    /// Shows the particles at the end of the measurement.
    pub(crate) fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.kinds.iter_mut().for_each(|kind| kind.get_mut().end(sample, system));
    }

    /// Whether any wants to see events.
    pub(crate) fn has_events(&self) -> bool {
        self.kinds.iter().any(|kind| kind.get().has_events())
    }

    /// Shows an event to those that want to see it.
    pub(crate) fn event(&mut self, event: &Event, system: &SystemDescription) {
        for kind in &mut self.kinds {
            if kind.get().has_events() {
                kind.get_mut().event(event, system);
            }
        }
    }

    /// What was measured so far.
    #[must_use]
    pub fn report(&self, system: &SystemDescription) -> Measured {
        let mut measured = Measured::default();
        self.kinds.iter().for_each(|kind| kind.get().report(system, &mut measured));
        let series = measured.curves.iter_mut().flat_map(|curve| &mut curve.series).map(|series| &mut series.unit);
        for unit in measured.numbers.iter_mut().map(|number| &mut number.unit).chain(series) {
            *unit = crate::base::text::unit(unit, system.space.dimensions());
        }
        measured
    }
}
