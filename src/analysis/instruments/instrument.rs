//! Instruments: their common interface, and all instruments of a run together.

use serde::{Deserialize, Serialize};

use super::bond_order::BondOrder;
use super::chains::Chains;
use super::diffusion::Diffusion;
use super::finite_size::complete_diffusion;
use super::flow::Flow;
use super::free_paths::FreePaths;
use super::pressure_tensor::PressureTensor;
use super::profiles::Profile;
use super::quantity::Measured;
use super::radial_distribution::RadialDistribution;
use super::registry::{InstrumentError, OwnInstruments, Registered, Registry};
use super::speeds::Speeds;
use super::structure_factor::StructureFactor;
use super::surface_forces::SurfaceForces;
use super::system::{Sample, SystemDescription};
use super::transport::Transport;
use crate::engine::event::Event;
use crate::model::measurement_plan::MeasurementPlan;

/// Initial conditions of an instrument: the system and its state at the start of the measurement.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct Setup<'a> {
    /// The particles, species and box of the simulation.
    pub system: &'a SystemDescription,
    /// The particles at the start of the measurement. They are not passed to [`Instrument::sample`], so an
    /// instrument that needs them has to read them here.
    pub sample: Sample<'a>,
    /// Expected duration of the measurement, positive and finite `[time]`.
    pub duration: f64,
}

/// An instrument measures one kind of quantity during a run, like a *compute* in other programs.
///
/// An instrument sees the particles at times that it chooses, and all events if it asks for them. It only
/// reads: the trajectory of a run is the same, bit for bit, whatever is measured. Its report is written with
/// the other measurements of the run (`measurements.json`, and a table for each curve) and drawn on the page
/// of the run.
///
/// To add your own instrument, implement this trait and register the type with
/// [`Run::instrument`](crate::run::Run::instrument). Its state is part of every checkpoint through
/// `serde::Serialize` and `serde::Deserialize`. Derive both and `Clone`, and keep everything that later
/// samples depend on in its fields. Checkpoints are written with `postcard`, which stores no field names, so
/// `serde`'s attributes `flatten`, `untagged` and `skip_serializing_if` cannot be used.
///
/// [The guide of the crate](crate#an-instrument-of-ones-own) and `examples/own_instrument.rs` have complete
/// examples.
#[doc(alias = "compute")]
#[doc(alias = "fix")]
#[doc(alias = "observable")]
pub trait Instrument {
    /// Simulated time of the next sample, which must be later than the previous sample; infinite if there is
    /// none.
    fn next_sample(&self) -> f64;

    /// Takes a sample of the particles at the requested time.
    fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription);

    /// Called with the particles at the end of the measurement, even if it was interrupted.
    ///
    /// By default, it takes a sample if the requested time has been reached; your own method must do the same. A
    /// checkpoint is written before this call, so an instrument restored from the checkpoint has not seen the call.
    fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        let due = self.next_sample();
        if is_now(due, sample.time) {
            self.sample(&Sample { time: due, ..*sample }, system);
        }
    }

    /// Whether the instrument needs to see events.
    fn has_events(&self) -> bool {
        false
    }

    /// Takes an event.
    fn event(&mut self, _event: &Event, _system: &SystemDescription) {}

    /// Called after a thermostat has scaled all velocities, with the particles just before and just after the scaling.
    /// A scaling is not reported as an event.
    fn scaled(&mut self, _before: &Sample<'_>, _after: &Sample<'_>, _system: &SystemDescription) {}

    /// Whether the run should end now. The run asks after every sample and event.
    fn is_done(&self) -> bool {
        false
    }

    /// Adds the results so far. May be called several times and at any time during the measurement.
    fn report(&self, system: &SystemDescription, measured: &mut Measured);
}

fn is_now(due: f64, now: f64) -> bool {
    due <= now || due - now <= 16.0 * f64::EPSILON * now.abs()
}

/// Declares the kinds of instruments in the order in which they report. Each has a field in the measurement
/// plan.
macro_rules! instruments {
    ($($kind:ident: $entry:ident),* $(,)?) => {
        #[derive(Debug, Clone, Serialize, Deserialize)]
        enum Kind { $($kind($kind),)* }

        impl Kind {
            fn planned(plan: &MeasurementPlan, setup: &Setup<'_>) -> Vec<Self> {
                let mut kinds = Vec::new();
                $(kinds.extend(plan.$entry.iter().map(|plan| Self::$kind($kind::new(plan, setup))));)*
                kinds
            }

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
    PressureTensor: pressure_tensor,
    Diffusion: diffusion,
    Transport: transport,
    FreePaths: free_paths,
    Flow: flows,
    RadialDistribution: radial_distribution,
    StructureFactor: structure_factor,
    Chains: chains,
    BondOrder: bond_order,
    Speeds: speeds,
    Profile: profiles,
    SurfaceForces: surface_forces,
}

/// All instruments of a run: instruments of the scene and registered instruments.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Instruments {
    kinds: Vec<Kind>,
    registered: Vec<Registered>,
}

impl Instruments {
    pub(crate) fn is_empty(&self) -> bool {
        self.kinds.is_empty() && self.registered.is_empty()
    }

    pub(crate) fn new(plan: &MeasurementPlan, setup: &Setup<'_>) -> Self {
        Self { kinds: Kind::planned(plan, setup), registered: Vec::new() }
    }

    pub(crate) fn begin(&mut self, registry: &mut Registry, setup: &Setup<'_>) {
        self.registered = registry.begin(setup);
    }

    pub(crate) fn restore(&mut self, registry: &Registry) -> Result<(), InstrumentError> {
        registry.restore(&mut self.registered)
    }

    pub(crate) fn into_own(self) -> OwnInstruments {
        OwnInstruments::new(self.registered)
    }

    fn all(&self) -> impl Iterator<Item = &dyn Instrument> {
        self.kinds.iter().map(Kind::get).chain(self.registered.iter().filter_map(Registered::get))
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut dyn Instrument> {
        self.kinds.iter_mut().map(Kind::get_mut).chain(self.registered.iter_mut().filter_map(Registered::get_mut))
    }

    pub(crate) fn is_done(&self) -> bool {
        self.registered.iter().filter_map(Registered::get).any(Instrument::is_done)
    }

    pub(crate) fn next_sample(&self) -> f64 {
        self.all().map(Instrument::next_sample).fold(f64::INFINITY, f64::min)
    }

    pub(crate) fn sample(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        for instrument in self.all_mut() {
            if instrument.next_sample() <= sample.time {
                instrument.sample(sample, system);
            }
        }
    }

    pub(crate) fn end(&mut self, sample: &Sample<'_>, system: &SystemDescription) {
        self.all_mut().for_each(|instrument| instrument.end(sample, system));
    }

    pub(crate) fn scaled(&mut self, before: &Sample<'_>, after: &Sample<'_>, system: &SystemDescription) {
        self.all_mut().for_each(|instrument| instrument.scaled(before, after, system));
    }

    pub(crate) fn has_events(&self) -> bool {
        self.all().any(Instrument::has_events)
    }

    pub(crate) fn event(&mut self, event: &Event, system: &SystemDescription) {
        for instrument in self.all_mut() {
            if instrument.has_events() {
                instrument.event(event, system);
            }
        }
    }

    /// Results so far.
    #[must_use]
    pub fn report(&self, system: &SystemDescription) -> Measured {
        let mut measured = Measured::default();
        self.kinds.iter().for_each(|kind| kind.get().report(system, &mut measured));
        complete_diffusion(&mut measured, system);
        for instrument in self.registered.iter().filter_map(Registered::get) {
            let mut own = Measured::default();
            instrument.report(system, &mut own);
            measured.join(own);
        }
        let series = measured.curves.iter_mut().flat_map(|curve| &mut curve.series).map(|series| &mut series.unit);
        for unit in measured.numbers.iter_mut().map(|number| &mut number.unit).chain(series) {
            *unit = crate::base::text::unit(unit, system.space.dimensions());
        }
        measured
    }
}
