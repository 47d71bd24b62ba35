//! Results of replica exchange.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::analysis::instruments::Measured;
use crate::analysis::statistics::Estimate;
use crate::base::text::digits;
use crate::model::ExchangeEnsemble;

/// Population of a level of the potential energy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Population {
    /// The energy of the level, or the middle of a bin `[energy]`.
    pub energy: f64,
    /// Width of the bin; 0 for an exact level `[energy]`.
    pub width: f64,
    /// The fraction of all samples in it.
    pub population: Estimate,
}

/// Results at a temperature, or in a window of a distance, over all replicas that visited it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TemperatureResult {
    /// The temperature `[energy]`.
    pub temperature: f64,
    /// Ends of the window of the held distance, for an exchange between windows `[length]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<[f64; 2]>,
    /// Means by name. The names are the [`OBSERVABLES`](crate::analysis::observables::OBSERVABLES) that
    /// apply to the scene, `heat_capacity_per_particle` (at constant volume, in units of k_B), `D / 2 +
    /// <(U - <U>)^2> / (N T^2)`, and the names of
    /// [`Exchange::measured_names`](super::Exchange::measured_names).
    pub observables: BTreeMap<String, Estimate>,
    /// Populations of the levels of the potential energy, in ascending order. They are in `energies.csv`, not
    /// in `summary.json`.
    #[serde(skip)]
    pub populations: Vec<Population>,
    /// Numbers and curves of the scene's instruments. They are in `measurements.json`, not in `summary.json`.
    #[serde(skip)]
    pub measured: Measured,
}

impl TemperatureResult {
    /// The temperature, or the window, in words.
    #[must_use]
    pub fn place(&self) -> String {
        self.window.map_or_else(
            || digits(self.temperature),
            |[lower, upper]| format!("{} to {}", digits(lower), digits(upper)),
        )
    }
}

/// Swaps between two neighbouring temperatures or windows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct NeighbouringTemperatures {
    /// The two temperatures `[energy]`.
    pub temperatures: [f64; 2],
    /// Number of attempts during the measurement.
    pub attempts: u64,
    /// Number of accepted attempts.
    pub accepted: u64,
    /// Ratio of accepted attempts with its standard error; `None` without attempts.
    pub acceptance: Option<Estimate>,
}

/// Results of an exchange.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ExchangeResults {
    /// Ensemble in which replicas were sampled. In a multicanonical ensemble, means and populations at the
    /// temperatures follow by reweighting.
    #[serde(default)]
    pub ensemble: ExchangeEnsemble,
    /// Simulated time at which the averages begin `[time]`.
    pub start: f64,
    /// Duration of the averages `[time]`.
    pub duration: f64,
    /// Attempts in that time, each with a sample of all temperatures.
    pub attempts: u64,
    /// By temperature, or by window, in the order of the scene.
    pub temperatures: Vec<TemperatureResult>,
    /// Each temperature or window with the next one; empty for a multicanonical exchange, which has no swaps.
    pub neighbours: Vec<NeighbouringTemperatures>,
    /// Round trips of each replica from the highest temperature to the lowest and back. In a
    /// multicanonical exchange, a round trip leads between the mean potential energies of these
    /// temperatures. Between windows, it leads from the last window to the first and back.
    pub round_trips: Vec<u64>,
    /// Faults found by the audits of the replicas, in words; empty for a sound exchange.
    pub faults: Vec<String>,
}
