//! Errors of potentials.

use thiserror::Error;

/// Reason why the radii and energies of a potential are invalid.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum PotentialError {
    /// The list of radii is empty.
    #[error("a potential needs at least one radius")]
    NoRadius,
    /// The number of energies is not one more than the number of radii.
    #[error("{radii} radii need {} energies (one more than radii), but there are {energies}", radii + 1)]
    Count {
        /// Number of radii.
        radii: usize,
        /// Number of energies.
        energies: usize,
    },
    /// A radius is not a positive finite length.
    #[error("radius number {} is {radius}, expected a positive finite length", index + 1)]
    Radius {
        /// Index of the radius, from 0.
        index: usize,
        /// The value.
        radius: f64,
    },
    /// The radii are not in descending order.
    #[error("radius number {} is {radius}, expected less than the one outside of it, {outer}", index + 1)]
    Order {
        /// Index of the radius, from 0.
        index: usize,
        /// The value.
        radius: f64,
        /// The previous radius in the list.
        outer: f64,
    },
    /// An energy is NaN or negative infinity, or an energy in the middle of the list is infinite.
    #[error("energy number {} is {energy}, expected a finite value (+inf only outermost or innermost)", index + 1)]
    Energy {
        /// Index of the energy, from 0.
        index: usize,
        /// The value.
        energy: f64,
    },
    /// Every energy is infinite.
    #[error("every energy is infinite, so the pair could be nowhere")]
    Inaccessible,
    /// The energy beyond the largest radius is neither 0 nor positive infinity.
    #[error("the outermost energy is {energy}, expected 0 (pairs far apart do not interact) or +inf (a bond)")]
    Outside {
        /// The value.
        energy: f64,
    },
    /// A parameter of a model potential is not positive and finite.
    #[error("{name} is {value}, expected a positive finite value")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// The value.
        value: f64,
    },
}
