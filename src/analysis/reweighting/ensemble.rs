//! The ensembles from which samples of the potential energy are drawn.

use crate::model::EnergyWeights;

/// An ensemble in which a configuration of potential energy `U` has the probability density `exp(-u(U))`.
#[derive(Debug, Clone, PartialEq)]
pub enum Ensemble {
    /// At a temperature: `u(U) = U / T`.
    Canonical {
        /// The temperature `T` `[energy]`.
        temperature: f64,
    },
    /// With weights of the energy: `u(U) = w(U)`.
    Multicanonical(EnergyWeights),
    /// In an umbrella window of a coordinate at one temperature. The coordinate replaces the energy: `u` is
    /// zero inside the window and infinite elsewhere.
    Window {
        /// The lower and the upper end.
        ends: [f64; 2],
    },
}

impl Ensemble {
    /// Canonical ensembles at the given temperatures `[energy]`.
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
            Self::Window { ends: [lower, upper] } if (*lower..*upper).contains(&energy) => 0.0,
            Self::Window { .. } => f64::INFINITY,
        }
    }
}
