//! Measurements, their errors, and results of theory and of other simulations.

pub mod instruments;
pub mod observables;
pub mod published;
pub mod reweighting;
pub(crate) mod sampling_times;
pub mod statistics;

pub use sampling_times::SamplingTimes;
