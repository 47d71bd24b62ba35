//! Energy weights of a multicanonical exchange. They are determined in the equilibration.

use serde::{Deserialize, Serialize};

use crate::analysis::reweighting::{DensityOfStates, EnergyHistograms, EnergyLevels, Ensemble};
use crate::model::EnergyWeights;
use crate::model::exchange_plan::ends;

/// Largest number of rows of energies that are kept in a quarter of the equilibration.
const MOST_ROWS: u64 = 10_000;

/// The weights of a multicanonical exchange, and the energies that determine them.
///
/// The equilibration has four quarters. In the first and second quarter, replicas are swapped between temperatures. The
/// first weights follow from the energies of the second quarter. The third quarter is simulated with these weights. The
/// final weights follow from the energies of the second and third quarter. The last quarter equilibrates.
///
/// Y. Sugita and Y. Okamoto, Chem. Phys. Lett. 329, 261 (2000), [doi:10.1016/S0009-2614(00)00999-4](https://doi.org/10.1016/S0009-2614(00)00999-4).
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Multicanonical {
    /// Numbers of the attempts at which the first, second and third quarter end.
    ends: [u64; 3],
    /// Number of attempts from one stored row of energies to the next.
    every: u64,
    rows: [Vec<Vec<f64>>; 2],
    /// Current energy weights. `None` before the third quarter.
    weights: Option<EnergyWeights>,
}

/// Energies at different temperatures do not overlap sufficiently to determine the weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Torn;

impl Multicanonical {
    /// The equilibration is given as a number of attempts.
    pub fn new(equilibration: u64) -> Self {
        let ends = [1, 2, 3].map(|quarter| quarter * (equilibration / 4));
        Self {
            ends,
            every: (equilibration / 4).div_ceil(MOST_ROWS).max(1),
            rows: [Vec::new(), Vec::new()],
            weights: None,
        }
    }

    pub fn weights(&self) -> Option<&EnergyWeights> {
        self.weights.as_ref()
    }

    /// Records the energies of an attempt. Returns whether there are new weights.
    pub fn see(&mut self, attempt: u64, energies: &[f64], temperatures: &[f64]) -> Result<bool, Torn> {
        let [first, second, third] = self.ends;
        let quarter = match attempt {
            _ if attempt <= first || attempt > third => return Ok(false),
            _ if attempt <= second => 0,
            _ => 1,
        };
        if attempt.is_multiple_of(self.every) {
            self.rows[quarter].push(energies.to_vec());
        }
        if attempt != self.ends[quarter + 1] {
            return Ok(false);
        }
        let weights = self.learned(quarter, temperatures)?;
        self.weights = Some(weights);
        if quarter == 1 {
            self.rows = [Vec::new(), Vec::new()];
        }
        Ok(true)
    }

    fn learned(&self, quarter: usize, temperatures: &[f64]) -> Result<EnergyWeights, Torn> {
        let mut ensembles = Ensemble::canonical(temperatures);
        let [canonical, weighted] = &self.rows;
        let mut rows = canonical.clone();
        if let (1, Some(weights)) = (quarter, &self.weights) {
            ensembles.extend(temperatures.iter().map(|_| Ensemble::Multicanonical(weights.clone())));
            // If the third quarter has fewer rows than the second, the histograms skip incomplete rows.
            rows.iter_mut().zip(weighted).for_each(|(row, more)| row.extend_from_slice(more));
        }
        let mut levels = EnergyLevels::default();
        rows.iter().for_each(|row| levels.see(row));
        let mut histograms = EnergyHistograms::new(ensembles, levels, 0);
        rows.iter().for_each(|row| histograms.add(row, &[]));
        Ok(flat(&histograms.density_of_states().ok_or(Torn)?, temperatures))
    }
}

/// Returns weights for equal visits to all levels between the mean energies at the lowest and highest temperatures.
fn flat(density: &DensityOfStates, temperatures: &[f64]) -> EnergyWeights {
    let ends = ends(temperatures);
    let [lowest, highest] = ends.map(|temperature| density.at(temperature).mean);
    let levels: Vec<(f64, f64)> = density.levels().filter(|(_, logarithm)| logarithm.is_finite()).collect();
    let from = levels.partition_point(|level| level.0 <= lowest).saturating_sub(1);
    let to = (levels.partition_point(|level| level.0 < highest) + 1).clamp(from + 1, levels.len());
    EnergyWeights::new(levels[from..to].to_vec(), ends)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::random::{Purpose, Random};

    const STATES: [f64; 4] = [1.0, 9.0, 44.0, 130.0];
    const TEMPERATURES: [f64; 3] = [1.4, 0.5, 0.2];

    fn level(random: &mut Random, ensemble: &Ensemble) -> f64 {
        let energies = [-3.0, -2.0, -1.0, 0.0];
        let weights: Vec<f64> = (0..4).map(|k| STATES[k] * (-ensemble.reduced_energy(energies[k])).exp()).collect();
        let mut left = random.uniform() * weights.iter().sum::<f64>();
        let place = weights.iter().position(|weight| {
            left -= weight;
            left < 0.0
        });
        energies[place.unwrap_or(3)]
    }

    #[test]
    fn weights_are_the_density_of_states_between_the_mean_energies() {
        let mut random = Random::new(5, Purpose::Placement, 0);
        let mut learning = Multicanonical::new(4000);
        let mut changes = Vec::new();
        for attempt in 1..=4000 {
            let ensembles = match learning.weights() {
                Some(weights) => vec![Ensemble::Multicanonical(weights.clone()); 3],
                None => Ensemble::canonical(&TEMPERATURES),
            };
            let row: Vec<f64> = ensembles.iter().map(|ensemble| level(&mut random, ensemble)).collect();
            if learning.see(attempt, &row, &TEMPERATURES).unwrap() {
                changes.push(attempt);
            }
        }
        assert_eq!(changes, [2000, 3000]);
        let weights = learning.weights().unwrap();
        // The mean energy is near -3 at the lowest temperature, and between -1 and 0 at the highest temperature.
        assert_eq!(weights.nodes().iter().map(|node| node.0).collect::<Vec<_>>(), [-3.0, -2.0, -1.0, 0.0]);
        let differences: Vec<f64> = weights.nodes().iter().zip(STATES).map(|(node, n)| node.1 - n.ln()).collect();
        assert!(differences.iter().all(|it| (it - differences[0]).abs() < 0.2), "{differences:?}");
        // Outside these levels, the weights equal the canonical weights at the lowest and the highest temperature.
        assert!((weights.at(-4.0) - weights.at(-3.0) + 1.0 / 0.2).abs() < 1e-12);
        assert!((weights.at(1.0) - weights.at(0.0) - 1.0 / 1.4).abs() < 1e-12);
    }

    #[test]
    fn temperatures_without_overlap_give_no_weights() {
        let mut learning = Multicanonical::new(400);
        let rows = (1..=400).map(|attempt| {
            let row = [-50.0 + f64::from((attempt % 2) as u8), f64::from((attempt % 3) as u8)];
            learning.see(attempt, &row, &[0.1, 5.0])
        });
        let found: Vec<_> = rows.take_while(Result::is_ok).collect();
        assert_eq!(found.len(), 199);
    }
}
