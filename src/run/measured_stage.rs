//! Results of a measured stage of a scene.

use serde::{Deserialize, Serialize};

use super::MeasurementPeriod;
use crate::analysis::instruments::Measured;
use crate::analysis::observables::Equilibrium;
use crate::analysis::statistics::{Estimate, Stationarity};
use crate::engine::event::EventCountsBySpecies;
use crate::model::VolumeMoves;

/// Results of a measured stage of a scene. [`Finished`](super::Finished) contains the results of the last measurement.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MeasuredStage {
    /// Name of the stage in the scene.
    pub name: String,
    /// The measurement.
    pub measurement: MeasurementPeriod,
    /// Event counts of the measurement, by kind and species.
    pub event_counts_by_species: EventCountsBySpecies,
    /// Mean and standard error of each observable that applies to the scene, by name.
    #[serde(with = "by_place")]
    pub observables: Vec<(&'static str, Estimate)>,
    /// Whether each observable drifted or was stationary, by name.
    #[serde(with = "verdicts")]
    pub stationarity: Vec<(&'static str, Stationarity)>,
    /// Whether the system was in equilibrium or in a steady state, and the reasons for any doubt.
    pub equilibrium: Equilibrium,
    /// Results of the instruments in this stage.
    pub measured: Measured,
    /// Factor by which the diameters grew between the start of the simulation and the end of this stage.
    pub diameter_factor: f64,
    /// Volume moves of the barostat; `None` without a barostat.
    pub volume_moves: Option<VolumeMoves>,
}

/// Serializes the index of an observable in `OBSERVABLES` instead of its name.
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

/// Serializes [`Stationarity`](crate::analysis::statistics::Stationarity) without the tag that result files have.
mod verdicts {
    use serde::de::Deserializer;
    use serde::ser::Serializer;
    use serde::{Deserialize, Serialize};

    use super::by_place;
    use crate::analysis::statistics::Stationarity;

    #[derive(Serialize, Deserialize)]
    struct Stored(#[serde(with = "Verdict")] Stationarity);

    #[derive(Serialize, Deserialize)]
    #[serde(remote = "Stationarity")]
    enum Verdict {
        Stationary,
        Constant,
        Drifting(f64),
        Unknown,
    }

    pub fn serialize<S: Serializer>(values: &[(&'static str, Stationarity)], serializer: S) -> Result<S::Ok, S::Error> {
        let stored: Vec<_> = values.iter().map(|(name, value)| (*name, Stored(*value))).collect();
        by_place::serialize(&stored, serializer)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<Vec<(&'static str, Stationarity)>, D::Error> {
        let stored: Vec<(&'static str, Stored)> = by_place::deserialize(deserializer)?;
        Ok(stored.into_iter().map(|(name, Stored(value))| (name, value)).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::observables::Answer;
    use crate::engine::event::EventCounts;

    #[test]
    fn a_checkpoint_keeps_the_results_of_a_stage() {
        let of = |value| vec![("temperature", value), ("collision_rate", value)];
        let estimate = Estimate { mean: 1.5, standard_error: Some(0.1) };
        let stage = |stationarity| MeasuredStage {
            name: "warm".to_owned(),
            measurement: MeasurementPeriod {
                start: 1.0,
                duration: 2.0,
                events_before: 3,
                event_counts: EventCounts::default(),
                wall_seconds: 4.0,
            },
            event_counts_by_species: EventCountsBySpecies::default(),
            observables: vec![("temperature", estimate), ("collision_rate", estimate)],
            stationarity: of(stationarity),
            equilibrium: Equilibrium { verdict: Answer::No, reasons: vec!["it cools".to_owned()] },
            measured: Measured::default(),
            diameter_factor: 1.25,
            volume_moves: None,
        };
        use Stationarity::{Constant, Drifting, Stationary, Unknown};
        for stationarity in [Stationary, Constant, Drifting(-0.25), Unknown] {
            let bytes = postcard::to_stdvec(&stage(stationarity)).unwrap();
            let read: MeasuredStage = postcard::from_bytes(&bytes).unwrap();
            assert_eq!(read.equilibrium.to_string(), "no (it cools)");
            assert_eq!((read.stationarity, read.diameter_factor), (of(stationarity), 1.25));
            assert_eq!(read.observables, [("temperature", estimate), ("collision_rate", estimate)]);
        }
    }
}
