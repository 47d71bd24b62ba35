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
    /// The energy of a level, or the middle of a bin `[energy]`.
    pub energy: f64,
    /// Width of a bin `[energy]`. Zero for an exact level.
    pub width: f64,
    /// Fraction of all samples in this level or bin.
    pub population: Estimate,
}

/// Results at a temperature or in a window, from all replicas that visited it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct TemperatureResult {
    /// The temperature `[energy]`.
    pub temperature: f64,
    /// Lower and upper end of the window of the distance `[length]`, for an exchange between windows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<[f64; 2]>,
    /// Means by name: the [`OBSERVABLES`](crate::analysis::observables::OBSERVABLES) of the scene, the quantities of
    /// [`Exchange::measured_names`](super::Exchange::measured_names), and `heat_capacity_per_particle`. The last name
    /// is the heat capacity at constant volume in units of k_B, `D / 2 + <(U - <U>)^2> / (N T^2)`, with `D` dimensions,
    /// `N` moving particles and the potential energy `U`.
    pub observables: BTreeMap<String, Estimate>,
    /// Populations of the levels of the potential energy, ascending. They are in `energies.csv`.
    #[serde(skip)]
    pub populations: Vec<Population>,
    /// Numbers and curves of the scene's instruments. They are in `measurements.json`.
    #[serde(skip)]
    pub measured: Measured,
}

impl TemperatureResult {
    /// Returns the temperature as text or, for a window, its lower and upper end.
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
    /// Temperatures of the two neighbours `[energy]`.
    pub temperatures: [f64; 2],
    /// Number of attempts during the measurement.
    pub attempts: u64,
    /// Number of accepted attempts.
    pub accepted: u64,
    /// Fraction of accepted attempts, with its standard error.
    pub acceptance: Option<Estimate>,
}

/// Results of an exchange.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ExchangeResults {
    /// Ensemble of the replicas. Results of a multicanonical ensemble are reweighted to the temperatures.
    #[serde(default)]
    pub ensemble: ExchangeEnsemble,
    /// Simulated time at which the averages begin `[time]`.
    pub start: f64,
    /// Simulated time of the averages `[time]`.
    pub duration: f64,
    /// Number of attempts that are averaged. Each attempt samples all temperatures.
    pub attempts: u64,
    /// Results at each temperature or in each window, in the order of the scene.
    pub temperatures: Vec<TemperatureResult>,
    /// Swaps of each temperature or window with the next. Empty for a multicanonical exchange.
    pub neighbours: Vec<NeighbouringTemperatures>,
    /// Number of round trips of each replica between the highest and the lowest temperature, or between the last and
    /// the first window. In a multicanonical exchange, the ends of a trip are the mean potential energies at the
    /// highest and the lowest temperature.
    pub round_trips: Vec<u64>,
    /// Faults found by the audits of the replicas, in words.
    pub faults: Vec<String>,
}
