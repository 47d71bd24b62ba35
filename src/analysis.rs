//! What is measured, how well it is known, and what theory and other simulations say.

pub mod instruments;
pub mod observables;
pub mod published;
pub(crate) mod sampling_times;
pub mod statistics;

pub use sampling_times::SamplingTimes;
