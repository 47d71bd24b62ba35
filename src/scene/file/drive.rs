//! Stages, thermostats and replica exchange in a scene file.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::json;

use super::either::Either;
use crate::base::whole;
use crate::model::Threads;
use crate::model::barostat::LARGEST_AMPLITUDE;
use crate::model::exchange_plan::MOST_TEMPERATURES;
use crate::model::space::AXES;
use crate::model::swap::MOST_ATTEMPTS;
use crate::model::umbrella_plan::{MOST_BINS, MOST_MEMBERS, USUAL_BINS};
use crate::scene::names::WORDS;
use crate::scene::parse::plan::{AUTOMATIC, ENSEMBLES, THERMOSTATS};
use crate::scene::schema::{keys_by_kind, words};

/// `[[stage]]`: a part of the run before the final part. It ends at a limit of time or events, or after its growth.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageFile {
    /// Name of the stage in reports and in `thermo.csv`, other than `equilibration` and `measurement`: up to 100
    /// letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: String,
    /// Whether the stage is measured. It then has its own means, curves and frames, like the measurement of the run.
    #[serde(default)]
    pub measure: bool,
    /// With `auto`, the equilibration of a measured stage ends when no observable drifts any more.
    #[schemars(extend("enum" = AUTOMATIC))]
    pub equilibration: Option<String>,
    /// Duration of the equilibration of a measured stage `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub equilibration_time: Option<f64>,
    /// Number of events in the equilibration of a measured stage.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub equilibration_events: Option<u64>,
    /// Longest duration of the stage, or of the measurement of a measured stage `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub until_time: Option<f64>,
    /// Largest number of physical events in the stage, or in the measurement of a measured stage.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub until_events: Option<u64>,
    /// Gravity during the stage `[length / time^2]`; the gravity of `[dynamics]` if not given.
    pub gravity: Option<[f64; 3]>,
    /// Thermostat during the stage; none if not given.
    pub thermostat: Option<ThermostatFile>,
    /// Barostat during the stage; none if not given. It needs a thermostat of the kind `andersen`.
    pub barostat: Option<BarostatFile>,
    /// Swap moves of a mixture of hard spheres during the stage; none if not given.
    pub swap: Option<SwapFile>,
    /// Growth of the diameters of hard spheres during the stage.
    pub grow: Option<GrowthFile>,
}

/// A thermostat, such as `{ kind = "andersen", temperature = 1.0, rate = 0.5 }` or
/// `{ kind = "rescaling", temperature = 1.0, interval = 1.0 }`.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("kind", &THERMOSTATS)))]
pub(crate) struct ThermostatFile {
    /// Kind of thermostat: `andersen` gives single particles new velocities, and `rescaling` scales all velocities.
    #[schemars(extend("enum" = words(&THERMOSTATS)))]
    pub kind: String,
    /// Temperature `[energy]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: f64,
    /// Rate at which each particle gets new velocities `[1 / time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: Option<f64>,
    /// Axes along which the thermostat draws new velocities; all axes if not given. Flat axes are skipped.
    #[schemars(length(min = 1), extend("items" = json!({ "type": "string", "enum": AXES }), "default" = AXES))]
    pub axes: Option<Vec<String>>,
    /// Time between two scalings of the velocities `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// A barostat, such as `{ pressure = 1.0, interval = 0.5, amplitude = 0.1 }`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BarostatFile {
    /// Pressure `[energy / length^D]`, where `D` is the number of axes that are not flat.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pressure: f64,
    /// Time between two volume moves `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: f64,
    /// Largest change of the logarithm of the volume in one move; if not given, adjusted while nothing is measured.
    #[schemars(range(max = LARGEST_AMPLITUDE), extend("exclusiveMinimum" = 0))]
    pub amplitude: Option<f64>,
}

/// Swap moves, such as `{ interval = 0.5, attempts = 1000, largest_ratio = 1.3 }`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SwapFile {
    /// Time between two sets of swap moves `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: f64,
    /// Number of moves in a set; the number of moving particles if not given.
    #[schemars(range(min = 1, max = MOST_ATTEMPTS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub attempts: Option<u64>,
    /// Largest ratio of two diameters that are exchanged; no limit if not given.
    #[schemars(range(min = 1))]
    pub largest_ratio: Option<f64>,
}

/// Number of threads, or `auto`.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum ThreadsFile {
    Number(#[schemars(with = "usize", range(min = 1, max = Threads::MOST))] f64),
    Word(#[schemars(extend("enum" = AUTOMATIC))] String),
}

impl<'de> Deserialize<'de> for ThreadsFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let either = Either::<(), _>::plain("a number or \"auto\"");
        Either { of_number: Some(Self::Number), of_word: Some(Self::Word), ..either }.deserialize(deserializer)
    }
}

/// Growth of the diameters up to a target, such as `{ rate = 0.01, packing_fraction = 0.62 }`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GrowthFile {
    /// Growth of a diameter per unit of time, relative to the diameter at the start of the stage `[1 / time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// Packing fraction at which growth ends.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub packing_fraction: Option<f64>,
    /// Compressibility factor at which growth ends.
    #[schemars(range(max = 1e12), extend("exclusiveMinimum" = 1))]
    pub compressibility_factor: Option<f64>,
}

/// `[exchange]`: replica exchange, with one replica at each temperature, or in each window of a distance. At intervals,
/// neighbouring replicas may be swapped, except in the ensemble `multicanonical`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExchangeFile {
    /// Temperatures in ascending or descending order `[energy]`. The ensemble `umbrella` has a single temperature.
    #[schemars(length(min = 1, max = MOST_TEMPERATURES), extend("items" = json!({ "type": "number", "exclusiveMinimum": 0 })))]
    pub temperatures: Vec<f64>,
    /// Time between two attempts to swap replicas `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: f64,
    /// Rate at which each particle gets new velocities from the heat bath of its replica `[1 / time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// Ensemble that is measured. `canonical` is a canonical ensemble at each temperature. `multicanonical` visits all
    /// energies between the mean energies at the lowest and the highest temperature equally often. `umbrella` is a
    /// canonical ensemble in each window of a distance, at a single temperature.
    #[schemars(extend("enum" = words(&ENSEMBLES), "default" = "canonical"))]
    pub ensemble: Option<String>,
    /// Distance and windows for the ensemble `umbrella`.
    pub umbrella: Option<UmbrellaFile>,
}

/// Umbrella sampling, such as `{ between = [[0], [19]], windows = [[0.9, 2.0], [1.6, 3.0]] }`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct UmbrellaFile {
    /// Ids of the particles of two groups, counted from 0. The distance is between the centres of mass of the groups.
    /// In a periodic box, the particles of a group must be bonded together.
    #[schemars(inner(length(min = 1, max = MOST_MEMBERS), inner(range(min = 0, max = u32::MAX))))]
    #[serde(deserialize_with = "whole::lists")]
    pub between: [Vec<u32>; 2],
    /// Lower and upper ends of the windows `[length]`, in ascending order. Neighbouring windows overlap.
    #[schemars(length(min = 2, max = MOST_TEMPERATURES), inner(inner(range(min = 0))))]
    pub windows: Vec<[f64; 2]>,
    /// Approximate number of bins of the potential of mean force in all windows. Ends of windows are edges of bins.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = USUAL_BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<usize>,
}
