//! Instruments: measurements of structure, motion, transport and profiles during a run.
//!
//! A [`MeasurementPlan`] lists the measurements, [`Instruments`] carries them out, and [`Measured`] contains the
//! results. Instruments do not change the trajectory. Their memory is bounded, and checkpoints contain their state.
//!
//! To write your own instrument, implement the trait [`Instrument`].

pub mod bond_order;
pub mod chains;
pub mod profiles;
pub mod quantity;
pub mod radial_distribution;
mod registry;
pub mod system;

mod bins;
mod block_times;
mod budgeted_times;
mod centre_of_mass;
mod contacts;
mod diffusion;
mod finite_size;
mod flow;
mod followed;
mod free_paths;
mod free_time;
mod grid;
mod histogram;
mod instrument;
mod logarithmic;
mod mixing;
mod momentum_flow;
mod near_pairs;
mod particle_stress;
mod pressure_tensor;
mod relaxation;
mod residence_times;
mod rows_over_time;
mod slope;
mod speeds;
mod stress;
mod structure_factor;
mod surface_forces;
#[cfg(test)]
mod test_system;
mod transport;

use serde::{Deserialize, Serialize};

use crate::engine::event::Event;
use crate::model::MeasurementPlan;
use registry::Registered;

pub use chains::CHAIN_SIZES;
pub use instrument::{Instrument, Setup};
pub use near_pairs::{NearPair, NearPairsError};
pub(crate) use particle_stress::{CONTACT_PRESSURE, CONTACT_STRESS};
pub use quantity::{Curve, Divisor, Measured, Normalisation, Number, Published, Scalar, Series, Variable};
pub use registry::InstrumentError;
pub(crate) use registry::{OwnInstruments, Registry, compare as compare_instruments};
pub use system::{Sample, SystemDescription};

/// Declares the instruments of scene files. Reports and checkpoints use the same order.
macro_rules! instruments {
    ($($module:ident::$kind:ident: $entry:ident),* $(,)?) => {
        #[derive(Debug, Clone, Serialize, Deserialize)]
        enum Kind { $($kind($module::$kind),)* }

        impl Kind {
            fn planned(plan: &MeasurementPlan, setup: &Setup<'_>) -> Vec<Self> {
                let mut kinds = Vec::new();
                $(kinds.extend(plan.$entry.iter().map(|plan| Self::$kind($module::$kind::new(plan, setup))));)*
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
    pressure_tensor::PressureTensor: pressure_tensor,
    diffusion::Diffusion: diffusion,
    transport::Transport: transport,
    free_paths::FreePaths: free_paths,
    flow::Flow: flows,
    radial_distribution::RadialDistribution: radial_distribution,
    structure_factor::StructureFactor: structure_factor,
    chains::Chains: chains,
    bond_order::BondOrder: bond_order,
    speeds::Speeds: speeds,
    profiles::Profile: profiles,
    stress::Stress: stresses,
    mixing::Mixing: mixings,
    surface_forces::SurfaceForces: surface_forces,
    contacts::Contacts: contacts,
    centre_of_mass::CentreOfMass: centre_of_mass,
    residence_times::ResidenceTimes: residence_times,
    relaxation::Relaxation: relaxation,
    particle_stress::ParticleStress: particle_stress,
}

/// All instruments of a run. They come from the scene, or are registered by the program.
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
        finite_size::complete_diffusion(&mut measured, system);
        for instrument in self.registered.iter().filter_map(Registered::get) {
            let mut own = Measured::default();
            instrument.report(system, &mut own);
            measured.join(own);
        }
        measured.for_each_unit(|unit| *unit = system.units.of(unit, system.space.dimensions()));
        measured
    }
}

/// Returns a message for each cutoff that is shortened because the box is too small.
pub(crate) fn shortened_cutoffs(plan: &MeasurementPlan, system: &SystemDescription) -> Vec<String> {
    let of_pairs = plan.radial_distribution.as_ref().and_then(|it| radial_distribution::shortened_cutoff(it, system));
    let of_order = plan.bond_order.as_ref().and_then(|it| bond_order::shortened_cutoff(it, system));
    let named = |(name, why): (&str, Option<String>)| why.map(|why| format!("measure.{name}: {why}"));
    [("radial_distribution", of_pairs), ("bond_order", of_order)].into_iter().filter_map(named).collect()
}

/// Per-particle values for a frame. `instruments` is `None` before the measurement.
pub(crate) fn scalars(
    plan: &MeasurementPlan,
    instruments: Option<&Instruments>,
    sample: &Sample<'_>,
    system: &SystemDescription,
) -> Vec<Scalar> {
    let mut scalars = plan.bond_order.as_ref().map_or(Vec::new(), |plan| bond_order::scalars(plan, system, sample));
    if plan.particle_stress.is_some() {
        let stress = instruments.and_then(|instruments| {
            instruments.kinds.iter().find_map(|kind| match kind {
                Kind::ParticleStress(stress) => Some(stress),
                _ => None,
            })
        });
        scalars.extend(particle_stress::scalars(stress, sample, system));
    }
    scalars
}

/// Number of values of each particle that the plan requests in the frames of a trajectory.
pub(crate) fn number_of_scalars(plan: &MeasurementPlan, dimensions: usize) -> usize {
    let of_order = if plan.bond_order.is_some() { 2 } else { 0 };
    let of_stress = if plan.particle_stress.is_some() { 1 + dimensions * (dimensions + 1) / 2 } else { 0 };
    of_order + of_stress
}
