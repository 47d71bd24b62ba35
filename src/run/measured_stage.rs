//! What a measured stage of a scene leaves.

use serde::{Deserialize, Serialize};

use super::MeasurementPeriod;
use crate::analysis::instruments::Measured;
use crate::analysis::statistics::{Estimate, Stationarity};
use crate::engine::event::EventCountsBySpecies;

/// Results of a measured stage of a scene: the same as of the last measurement of a run.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MeasuredStage {
    /// Its name in the scene.
    pub name: String,
    /// Its measurement.
    pub measurement: MeasurementPeriod,
    /// What happened in it, by kind and species.
    pub event_counts_by_species: EventCountsBySpecies,
    /// Means and standard errors, by name; only those that mean something for the scene.
    #[serde(with = "by_place")]
    pub observables: Vec<(&'static str, Estimate)>,
    /// Whether each of them was stationary, by name.
    #[serde(with = "by_place")]
    pub stationarity: Vec<(&'static str, Stationarity)>,
    /// What the instruments of the scene have measured in it.
    pub measured: Measured,
    /// Factor by which diameters had grown since the start of the scene.
    pub diameter_factor: f64,
}

/// Values by the name of an observable, of which a checkpoint has the place among [`OBSERVABLES`].
mod by_place {
    use serde::de::{Deserialize, Deserializer, Error};
    use serde::ser::{Serialize, Serializer};

    use crate::analysis::observables::OBSERVABLES;

    pub fn serialize<S: Serializer, T: Serialize>(
        values: &[(&'static str, T)],
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        let place = |name: &str| OBSERVABLES.iter().position(|(known, _)| *known == name).unwrap_or(OBSERVABLES.len());
        let placed: Vec<(usize, &T)> = values.iter().map(|(name, value)| (place(name), value)).collect();
        placed.serialize(serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>, T: Deserialize<'de>>(
        deserializer: D,
    ) -> Result<Vec<(&'static str, T)>, D::Error> {
        let placed: Vec<(usize, T)> = Vec::deserialize(deserializer)?;
        let named = |(place, value)| {
            let name = OBSERVABLES.get(place).map(|(name, _)| *name);
            name.map(|name| (name, value)).ok_or_else(|| D::Error::custom("there is no such observable"))
        };
        placed.into_iter().map(named).collect()
    }
}
