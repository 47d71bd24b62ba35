//! What a scene asks to be measured while it runs: structure, motion, transport, profiles.
//!
//! A [`MeasurementPlan`] says what is wanted; each entry becomes one of the [`Instruments`], which are shown the particles at times of their own choosing, and
//! the events where they ask for them. Instruments only read: a run has the same trajectory, bit for bit, whatever is measured.
//! Their memory is bounded, and their state is part of a checkpoint. What came out is [`Measured`].

pub mod bond_order;
pub mod chains;
pub mod profiles;
pub mod quantity;
pub mod radial_distribution;
pub mod subject;

mod diffusion;
mod flow;
mod free_paths;
mod free_time;
mod instrument;
mod momentum_flow;
mod near;
mod pressure_tensor;
mod schedule;
mod slope;
mod stretches;
mod structure_factor;
mod transport;
#[cfg(test)]
mod trial;

use crate::model::MeasurementPlan;

pub use instrument::Instruments;
pub(crate) use instrument::Setup;
pub use quantity::{Curve, Measured, Number, Published, Scalar, Series, Variable};
pub use subject::{Sample, Subject};

/// What is asked for of each particle, for the frames of a trajectory.
pub(crate) fn scalars(plan: &MeasurementPlan, sample: &Sample<'_>, subject: &Subject) -> Vec<Scalar> {
    plan.bond_order.as_ref().map_or(Vec::new(), |plan| bond_order::scalars(plan, subject, sample))
}
