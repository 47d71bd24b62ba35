//! The numbers of an exchange, `summary.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::curves::{HeatCapacityPeak, ThermalCurves, ThermalPoint};
use super::equilibrium;
use super::replicas::Exchange;
use super::results::ExchangeResults;
use crate::model::InputFile;

/// Summary of an exchange: the content of its `summary.json`, with the populations of `energies.csv` and the curves of `curves.csv`. No number is one of the clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ExchangeSummary {
    /// The version of Carom.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Its seed.
    pub seed: u64,
    /// The files that the scene read, with their checksums.
    pub inputs: Vec<InputFile>,
    /// Checksums of its tables, by name; none of an exchange that is not complete.
    #[serde(default)]
    pub tables: BTreeMap<String, String>,
    /// The engine of the replicas, in words.
    pub engine: String,
    /// Number of particles of each replica, static ones included.
    pub particles: usize,
    /// Number of axes along which particles move.
    pub dimensions: usize,
    /// Between two attempts to swap `[time]`.
    pub interval: f64,
    /// Of the heat baths, for each particle `[1 / time]`.
    pub rate: f64,
    /// The results.
    #[serde(flatten)]
    pub results: ExchangeResults,
    /// The highest maximum of the heat capacity between the temperatures; `None` without one, or before the exchange is complete.
    #[serde(default)]
    pub heat_capacity_peak: Option<HeatCapacityPeak>,
    /// Why the exchange may not be in equilibrium, in words; empty where nothing speaks against it.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Curves between the temperatures; in `curves.csv`, not in `summary.json`. There are none before the exchange is complete.
    #[serde(skip)]
    pub curves: Vec<ThermalPoint>,
}

impl ExchangeSummary {
    /// Of an exchange as far as it has come.
    #[must_use]
    pub fn of(exchange: &Exchange) -> Self {
        let (scene, simulation, results) = (exchange.scene(), exchange.example(), exchange.results());
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.name().to_owned(),
            seed: scene.seed(),
            inputs: scene.inputs().to_vec(),
            tables: BTreeMap::new(),
            engine: simulation.engine().to_string(),
            particles: simulation.population().iter().sum(),
            dimensions: simulation.dimensions(),
            interval: exchange.plan().interval,
            rate: exchange.plan().rate,
            heat_capacity_peak: None,
            warnings: results.warnings(),
            curves: Vec::new(),
            results,
        }
    }

    /// With the curves of the exchange.
    #[must_use]
    pub(super) fn with_curves(mut self, curves: ThermalCurves) -> Self {
        self.warnings.extend(curves.is_torn.then(|| equilibrium::TORN.to_owned()));
        Self { heat_capacity_peak: curves.peak, curves: curves.points, ..self }
    }

    /// As it is written.
    pub(super) fn text(&self) -> String {
        // Numbers and words, all of which JSON has.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
