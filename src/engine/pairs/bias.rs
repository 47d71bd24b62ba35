//! Weights of the potential energy in a multicanonical ensemble, which change the cost of energy steps.

use crate::engine::pairs::rules::Discontinuity;
use crate::engine::parts::Engine;
use crate::engine::{Chosen, Simulation};
use crate::model::EnergyWeights;
use serde::{Deserialize, Serialize};

/// A function `F(U) = T w(U)` that replaces the potential energy `U`. In a heat bath of temperature `T`,
/// configurations then have the weights `exp(-w(U))`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Bias {
    weights: EnergyWeights,
    /// Temperature `T` of the heat bath `[energy]`.
    temperature: f64,
    /// Potential energy `U` of all pairs `[energy]`.
    energy: f64,
}

impl Bias {
    /// Returns the cost of an energy step: `F(U + step) - F(U)`.
    fn cost(&self, step: f64) -> f64 {
        self.temperature * (self.weights.at(self.energy + step) - self.weights.at(self.energy))
    }
}

impl Simulation {
    /// Replaces the potential energy `U` of all pairs by `T w(U)`; `None` restores `U`. In a heat bath of temperature
    /// `T` `[energy]`, configurations then have the weights `exp(-w(U))`. Energy steps have a different cost. Reported
    /// energies refer to `U`, and the difference counts as supplied energy.
    ///
    /// The scene must have no gravity, so that energies change only in steps.
    pub(crate) fn set_energy_weights(&mut self, weights: Option<(&EnergyWeights, f64)>) {
        let energy = self.energy().potential;
        let bias = weights.map(|(weights, temperature)| Bias { weights: weights.clone(), temperature, energy });
        with_engine!(&mut self.engine, engine => {
            engine.join();
            engine.pairs.bias = bias.map(Box::new);
        });
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns a discontinuity with the cost of its energy step. Without weights, the cost is the energy step.
    #[inline(always)]
    pub(in crate::engine) fn weighted(&self, seen: &Discontinuity) -> Discontinuity {
        match &self.pairs.bias {
            Some(bias) if TABLE && seen.energy_step.is_finite() => {
                Discontinuity { energy_step: bias.cost(seen.energy_step), ..*seen }
            }
            _ => *seen,
        }
    }

    /// Records that a pair has crossed a step of its potential. `step` is the change of the potential energy, and
    /// `felt` is the cost of the step. Returns `step - felt`, which counts as supplied energy, or 0 without weights.
    #[inline(always)]
    pub(in crate::engine) fn pay(&mut self, step: f64, felt: f64) -> f64 {
        match &mut self.pairs.bias {
            Some(bias) if TABLE => {
                bias.energy += step;
                step - felt
            }
            _ => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::engine::Until;
    use crate::model::{Potential, Space};
    use crate::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

    #[test]
    fn reported_step_is_physical_while_weights_decide_its_cost() {
        let scene = SceneBuilder::new("pair")
            .space(Space::periodic_cube(9.0))
            .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
            .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 0.9).unwrap()).between("A", "A"))
            .particle("A", Vector::new(1.0, 4.0, 4.0), Vector::new(0.8, 0.0, 0.0))
            .particle("A", Vector::new(4.0, 4.0, 4.0), Vector::zeros())
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene);
        let weights = EnergyWeights::new(vec![(-0.9, 0.3), (0.0, 1.1)], [1.0, 1.0]);
        simulation.set_energy_weights(Some((&weights, 2.0)));
        let start = simulation.energy().kinetic;
        let mut found = Vec::new();
        for count in 1..=3 {
            let next = simulation.events(Until::events(count)).next().unwrap().unwrap();
            let supplied = simulation.event_counts().supplied.total();
            found.push([next.energy_step, simulation.energy().kinetic - start, supplied]);
        }
        // The particle enters the well, hits the core, and leaves the well. The first step costs 2 (0.3 - 1.1).
        for (found, expected) in found.iter().zip([[-0.9, 1.6, 0.7], [0.0, 1.6, 0.7], [0.9, 0.0, 0.0]]) {
            assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}, expected {expected:?}");
        }
        simulation.set_energy_weights(None);
        assert!(simulation.energy().potential == 0.0);
    }
}
