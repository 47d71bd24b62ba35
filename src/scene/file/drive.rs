//! What was typed about stages and thermostats.

use serde::Deserialize;

/// `[[stage]]`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageFile {
    pub name: String,
    pub until_time: Option<f64>,
    pub until_events: Option<u64>,
    pub thermostat: Option<ThermostatFile>,
    pub grow: Option<GrowthFile>,
}

/// `{ kind = "andersen", temperature = 1.0, rate = 0.5 }` or `{ kind = "rescaling", temperature = 1.0, interval = 1.0 }`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ThermostatFile {
    pub kind: String,
    pub temperature: f64,
    pub rate: Option<f64>,
    pub axes: Option<Vec<String>>,
    pub interval: Option<f64>,
}

/// `{ rate = 0.01, packing_fraction = 0.62 }`, or up to a `compressibility_factor`
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct GrowthFile {
    pub rate: f64,
    pub packing_fraction: Option<f64>,
    pub compressibility_factor: Option<f64>,
}
