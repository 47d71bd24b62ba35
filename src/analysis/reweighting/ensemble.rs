//! Ensembles that samples of the potential energy are from.

use crate::model::EnergyWeights;

/// Ensemble in which a configuration of the potential energy `U` has the probability density `exp(-u(U))`.
#[derive(Debug, Clone, PartialEq)]
pub enum Ensemble {
    /// At a temperature: `u(U) = U / T`.
    Canonical {
        /// The temperature `T` `[energy]`.
        temperature: f64,
    },
    /// With weights of the energy: `u(U) = w(U)`.
    Multicanonical(EnergyWeights),
}

impl Ensemble {
    /// Canonical ensembles at some temperatures `[energy]`.
    #[must_use]
    pub fn canonical(temperatures: &[f64]) -> Vec<Self> {
        temperatures.iter().map(|temperature| Self::Canonical { temperature: *temperature }).collect()
    }

    /// `u` at an energy `[energy]`.
    #[must_use]
    pub fn reduced_energy(&self, energy: f64) -> f64 {
        match self {
            Self::Canonical { temperature } => energy / temperature,
            Self::Multicanonical(weights) => weights.at(energy),
        }
    }
}
