//! Weights of the potential energy, as a force: what a step of the energy costs in a multicanonical ensemble.

use crate::engine::contact::apply::Change;
use crate::engine::pairs::rules::Discontinuity;
use crate::engine::parts::Engine;
use crate::engine::{Chosen, Simulation};
use crate::model::EnergyWeights;
use serde::{Deserialize, Serialize};

/// A function `F(U) = T w(U)` of the potential energy in its place: in a heat bath of the temperature `T`, configurations have the weights `exp(-w(U))`.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Bias {
    weights: EnergyWeights,
    /// `T` `[energy]`.
    temperature: f64,
    /// `U`, of all pairs `[energy]`.
    energy: f64,
}

impl Bias {
    /// `F(U + step) - F(U)`.
    fn cost(&self, step: f64) -> f64 {
        self.temperature * (self.weights.at(self.energy + step) - self.weights.at(self.energy))
    }
}

impl Simulation {
    /// Replaces the potential energy `U` of all pairs by `T w(U)`, or ends that with `None`. In a heat bath of the temperature `T` `[energy]`, configurations have the weights `exp(-w(U))` then. Contacts
    /// are where they were: a step of the energy costs another amount. Energies are reported as before, and what the replacement gives to particles is counted as supplied.
    ///
    /// Of a scene without weight, in which energies only change in steps.
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
    /// A discontinuity with the step that it costs under weights of the energy.
    #[inline(always)]
    pub(in crate::engine) fn weighted(&self, seen: &Discontinuity) -> Discontinuity {
        match &self.pairs.bias {
            Some(bias) if TABLE && seen.energy_step.is_finite() => {
                Discontinuity { energy_step: bias.cost(seen.energy_step), ..*seen }
            }
            _ => *seen,
        }
    }

    /// Gives an event its step of the potential energy, `step`, where it was one of the weights. The difference comes from outside.
    #[inline(always)]
    pub(in crate::engine) fn note_weighted(&mut self, change: &mut Change, step: f64, is_crossed: bool) {
        if TABLE
            && is_crossed
            && let Some(bias) = &mut self.pairs.bias
        {
            bias.energy += step;
            change.supplied += step - change.energy_step;
            change.energy_step = step;
        }
    }
}
