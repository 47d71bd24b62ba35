//! The numerical results of an exchange, `summary.json`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::curves::{HeatCapacityPeak, ThermalCurves, ThermalPoint};
use super::equilibrium;
use super::levels::LevelDensity;
use super::mean_force::{MeanForce, MeanForcePoint};
use super::replicas::Exchange;
use super::results::ExchangeResults;
use crate::analysis::reweighting::DensityOfStates;
use crate::model::exchange_plan::ends;
use crate::model::{InputFile, UmbrellaPlan, Units};

/// Summary of an exchange, `summary.json`, with the contents of the tables. It contains no wall times.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct ExchangeSummary {
    /// The version of Carom.
    pub version: String,
    /// Name of the scene.
    pub scene: String,
    /// Seed of the scene.
    pub seed: u64,
    /// Names of the units of length, mass and time; absent if the scene has no names.
    #[serde(default, skip_serializing_if = "Units::are_unnamed")]
    pub units: Units,
    /// The files that the scene read, with their checksums.
    pub inputs: Vec<InputFile>,
    /// Checksums of the tables, by name. Empty for an incomplete exchange.
    #[serde(default)]
    pub tables: BTreeMap<String, String>,
    /// Description of the engine that runs the replicas.
    pub engine: String,
    /// Number of particles of each replica, including static particles.
    pub particles: usize,
    /// Number of axes along which particles move.
    pub dimensions: usize,
    /// Interval between two attempts to swap `[time]`.
    pub interval: f64,
    /// Collision rate of the heat baths with each particle `[1 / time]`.
    pub rate: f64,
    /// The windows of the distance, for an exchange between windows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub umbrella: Option<UmbrellaPlan>,
    /// The results.
    #[serde(flatten)]
    pub results: ExchangeResults,
    /// The highest maximum of the heat capacity that is not at an end of the curve.
    #[serde(default)]
    pub heat_capacity_peak: Option<HeatCapacityPeak>,
    /// Reasons why the exchange may not be in equilibrium, in words.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// Points of the thermal curves, from `curves.csv`. Empty before the exchange is complete.
    #[serde(skip)]
    pub curves: Vec<ThermalPoint>,
    /// The density of states, from `density_of_states.csv`. Empty before the exchange is complete.
    #[serde(skip)]
    pub density_of_states: Vec<LevelDensity>,
    /// The potential of mean force, from `potential_of_mean_force.csv`. Empty before the exchange is complete.
    #[serde(skip)]
    pub potential_of_mean_force: Vec<MeanForcePoint>,
}

impl ExchangeSummary {
    /// Returns the unit of a quantity with the names of the scene.
    pub(crate) fn unit_of(&self, unit: &str) -> String {
        self.units.of(unit, self.dimensions)
    }

    /// Returns the summary of the current state of an exchange.
    #[must_use]
    pub fn of(exchange: &Exchange) -> Self {
        let (scene, simulation, results) = (exchange.scene(), exchange.example(), exchange.results());
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.name().to_owned(),
            seed: scene.seed(),
            units: scene.units().clone(),
            inputs: scene.inputs().to_vec(),
            tables: BTreeMap::new(),
            engine: simulation.engine().to_string(),
            particles: simulation.population().iter().sum(),
            dimensions: simulation.dimensions(),
            interval: exchange.plan().interval,
            rate: exchange.plan().rate,
            umbrella: exchange.plan().umbrella.clone(),
            heat_capacity_peak: None,
            warnings: results.warnings(),
            curves: Vec::new(),
            density_of_states: Vec::new(),
            potential_of_mean_force: Vec::new(),
            results,
        }
    }

    #[must_use]
    pub(super) fn with_curves(mut self, mut curves: ThermalCurves) -> Self {
        self.warnings.extend(curves.is_torn.then(|| equilibrium::TORN.to_owned()));
        for (at, populations) in self.results.temperatures.iter_mut().zip(std::mem::take(&mut curves.populations)) {
            at.populations = populations;
            let point = curves.points.iter().find(|point| point.temperature == at.temperature);
            at.observables = point.map(ThermalPoint::means).unwrap_or_default();
        }
        let ThermalCurves { points, peak, density_of_states, .. } = curves;
        Self { heat_capacity_peak: peak, curves: points, density_of_states, ..self }
    }

    #[must_use]
    pub(super) fn with_mean_force(mut self, found: MeanForce) -> Self {
        self.warnings.extend(found.is_torn.then(|| equilibrium::TORN_WINDOWS.to_owned()));
        Self { potential_of_mean_force: found.points, ..self }
    }

    /// Returns the shortest list of ascending temperatures, from the lowest to the highest of the exchange, at which
    /// all neighbours swap equally often. A swap is accepted with a predicted probability of at least `acceptance`.
    /// `None` if the density of states is unknown, for an `acceptance` outside 0 to 1, or for more than a thousand
    /// temperatures.
    #[must_use]
    pub fn temperatures_for(&self, acceptance: f64) -> Option<Vec<f64>> {
        let levels = self.density_of_states.iter().map(|level| (level.energy, level.log_density_of_states.mean));
        let temperatures: Vec<f64> = self.results.temperatures.iter().map(|at| at.temperature).collect();
        if self.density_of_states.is_empty() {
            return None;
        }
        DensityOfStates::of_levels(levels).temperatures_for(ends(&temperatures), acceptance)
    }

    pub(super) fn text(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }
}
