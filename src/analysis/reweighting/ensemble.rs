//! The ensembles from which samples of the potential energy are drawn.

use crate::model::EnergyWeights;

/// An ensemble in which a configuration of potential energy `U` has the probability density `exp(-u(U))`.
#[derive(Debug, Clone, PartialEq)]
pub enum Ensemble {
    /// The canonical ensemble at a temperature `T`, with `u(U) = U / T`.
    Canonical {
        /// The temperature `T` `[energy]`.
        temperature: f64,
    },
    /// A multicanonical ensemble with weights `w` that depend on the energy, `u(U) = w(U)`.
    Multicanonical(EnergyWeights),
    /// An umbrella window of a coordinate `U`, at one temperature: `u` is zero inside the window and infinite outside.
    Window {
        /// Lower and upper end of the window.
        ends: [f64; 2],
    },
}

impl Ensemble {
    /// Canonical ensembles at the given temperatures `[energy]`.
    #[must_use]
    pub fn canonical(temperatures: &[f64]) -> Vec<Self> {
        temperatures.iter().map(|temperature| Self::Canonical { temperature: *temperature }).collect()
    }

    /// Returns the exponent `u(U)` of the probability density at a potential energy `U` `[energy]`.
    #[must_use]
    pub fn reduced_energy(&self, energy: f64) -> f64 {
        match self {
            Self::Canonical { temperature } => energy / temperature,
            Self::Multicanonical(weights) => weights.at(energy),
            Self::Window { ends: [lower, upper] } if (*lower..*upper).contains(&energy) => 0.0,
            Self::Window { .. } => f64::INFINITY,
        }
    }
}
