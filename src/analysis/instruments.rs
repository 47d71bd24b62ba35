//! Instruments: the measurements of a running scene, such as structure, motion, transport and profiles.
//!
//! A [`MeasurementPlan`] lists the measurements. Each entry becomes one of the [`Instruments`]. An instrument
//! chooses the times at which it sees the particles, and may ask to see events. Instruments only read: the
//! trajectory of a run is the same, bit for bit, whatever is measured. Their memory is bounded, and their
//! state is part of a checkpoint. The results are [`Measured`].
//!
//! To write your own instrument, implement the trait [`Instrument`]; its documentation explains how, and how
//! to measure with it.

pub mod bond_order;
pub mod chains;
pub mod profiles;
pub mod quantity;
pub mod radial_distribution;
mod registry;
pub mod system;

mod block_times;
mod budgeted_times;
mod diffusion;
mod finite_size;
mod flow;
mod free_paths;
mod free_time;
mod instrument;
mod momentum_flow;
mod near_pairs;
mod pressure_tensor;
mod slope;
mod speeds;
mod structure_factor;
mod surface_forces;
#[cfg(test)]
mod test_system;
mod transport;

use crate::model::MeasurementPlan;

pub use chains::CHAIN_SIZES;
pub use instrument::{Instrument, Instruments, Setup};
pub use near_pairs::{NearPair, NearPairsError};
pub use quantity::{Curve, Divisor, Measured, Normalisation, Number, Published, Scalar, Series, Variable};
pub use registry::InstrumentError;
pub(crate) use registry::{OwnInstruments, Registry, compare as compare_instruments};
pub use system::{Sample, SystemDescription};

/// Lists the cutoffs that the box makes shorter than the plan requests, each with the reason.
pub(crate) fn shortened_cutoffs(plan: &MeasurementPlan, system: &SystemDescription) -> Vec<String> {
    let of_pairs = plan.radial_distribution.as_ref().and_then(|it| radial_distribution::shortened_cutoff(it, system));
    let of_order = plan.bond_order.as_ref().and_then(|it| bond_order::shortened_cutoff(it, system));
    let named = |(name, why): (&str, Option<String>)| why.map(|why| format!("measure.{name}: {why}"));
    [("radial_distribution", of_pairs), ("bond_order", of_order)].into_iter().filter_map(named).collect()
}

/// Whether the plan asks for values of each particle in the frames of a trajectory.
pub(crate) fn has_scalars(plan: &MeasurementPlan) -> bool {
    plan.bond_order.is_some()
}

pub(crate) fn scalars(plan: &MeasurementPlan, sample: &Sample<'_>, system: &SystemDescription) -> Vec<Scalar> {
    plan.bond_order.as_ref().map_or(Vec::new(), |plan| bond_order::scalars(plan, system, sample))
}
