//! Stages, thermostats and replica exchange in the file of a scene.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::json;

use super::either::Either;
use crate::base::whole;
use crate::model::Threads;
use crate::model::barostat::LARGEST_AMPLITUDE;
use crate::model::exchange_plan::MOST_TEMPERATURES;
use crate::model::space::AXES;
use crate::model::umbrella_plan::{MOST_BINS, MOST_MEMBERS, USUAL_BINS};
use crate::scene::names::WORDS;
use crate::scene::parse::plan::{AUTOMATIC, ENSEMBLES, THERMOSTATS};
use crate::scene::schema::{keys_by_kind, words};

/// `[[stage]]`: a stretch before the run, until a time, a number of events or the end of growth.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StageFile {
    /// Name of the stage in reports and in the column `stage` of `thermo.csv`; neither `equilibration` nor `measurement`. Up to 100
    /// letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: String,
    /// Whether the stage is measured: its means, its curves and its frames are kept as those of the run are.
    #[serde(default)]
    pub measure: bool,
    /// `auto` ends the equilibration of a measured stage when no observable drifts.
    #[schemars(extend("enum" = AUTOMATIC))]
    pub equilibration: Option<String>,
    /// Duration simulated before a measured stage is measured `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub equilibration_time: Option<f64>,
    /// Number of events simulated before a measured stage is measured.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub equilibration_events: Option<u64>,
    /// Longest duration of the stage, of a measured one that of its measurement `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub until_time: Option<f64>,
    /// Largest number of events of the stage, of a measured one that of its measurement.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub until_events: Option<u64>,
    /// Gravity during the stage `[length / time^2]`; that of `[dynamics]` if not given.
    pub gravity: Option<[f64; 3]>,
    /// Thermostat during the stage; none if not given.
    pub thermostat: Option<ThermostatFile>,
    /// Barostat during the stage, beside a thermostat of the kind `andersen`; none if not given.
    pub barostat: Option<BarostatFile>,
    /// Hard spheres that grow during the stage.
    pub grow: Option<GrowthFile>,
}

/// `{ kind = "andersen", temperature = 1.0, rate = 0.5 }` or `{ kind = "rescaling", temperature = 1.0, interval = 1.0 }`
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("kind", &THERMOSTATS)))]
pub(crate) struct ThermostatFile {
    /// How the temperature is held: by new velocities of single particles, or by scaling all velocities.
    #[schemars(extend("enum" = words(&THERMOSTATS)))]
    pub kind: String,
    /// Temperature `[energy]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: f64,
    /// How often a particle gets a new velocity `[1 / time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: Option<f64>,
    /// Axes along which velocities are drawn anew; all if not given. Flat ones are left out.
    #[schemars(length(min = 1), extend("items" = json!({ "type": "string", "enum": AXES }), "default" = AXES))]
    pub axes: Option<Vec<String>>,
    /// Time between two scalings `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: Option<f64>,
}

/// `{ pressure = 1.0, interval = 0.5, amplitude = 0.1 }`
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BarostatFile {
    /// Pressure `[energy / length^D]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub pressure: f64,
    /// Time between two moves of the volume `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: f64,
    /// Largest change of the logarithm of the volume in a move; found in the equilibration if not given.
    #[schemars(range(max = LARGEST_AMPLITUDE), extend("exclusiveMinimum" = 0))]
    pub amplitude: Option<f64>,
}

/// A number, or `auto`.
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

/// `{ rate = 0.01, packing_fraction = 0.62 }`, or up to a `compressibility_factor`
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct GrowthFile {
    /// Rate of growth `[1 / time]`: diameters grow by this fraction of those at the start of the stage.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// Packing fraction at which growth ends.
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 1))]
    pub packing_fraction: Option<f64>,
    /// Compressibility factor at which growth ends.
    #[schemars(range(max = 1e12), extend("exclusiveMinimum" = 1))]
    pub compressibility_factor: Option<f64>,
}

/// `[exchange]`: replica exchange, in which a replica at each temperature, or in each window of a distance, is swapped with its neighbours now and then.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ExchangeFile {
    /// Temperatures, ascending or descending, all different; of windows one `[energy]`.
    #[schemars(length(min = 1, max = MOST_TEMPERATURES), extend("items" = json!({ "type": "number", "exclusiveMinimum": 0 })))]
    pub temperatures: Vec<f64>,
    /// Between two attempts to swap `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: f64,
    /// How often a particle gets a new velocity from the heat bath of its replica `[1 / time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: f64,
    /// Ensemble that is measured: `canonical` at each temperature, with swaps, one `multicanonical` ensemble of all replicas, which visits all energies between those of the temperatures equally often, or
    /// `umbrella`: a canonical ensemble in each window of a distance, at one temperature, with swaps.
    #[schemars(extend("enum" = words(&ENSEMBLES), "default" = "canonical"))]
    pub ensemble: Option<String>,
    /// The distance, and its windows, of the ensemble `umbrella`.
    pub umbrella: Option<UmbrellaFile>,
}

/// `{ between = [[0], [19]], windows = [[0.9, 2.0], [1.6, 3.0]] }`
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct UmbrellaFile {
    /// The ids of the particles of two groups: the distance is that of two particles, or of the centres of mass of groups of several, which are bonded together in a periodic box. Ids count from 0.
    #[schemars(inner(length(min = 1, max = MOST_MEMBERS), inner(range(min = 0, max = u32::MAX))))]
    #[serde(deserialize_with = "whole::lists")]
    pub between: [Vec<u32>; 2],
    /// Lower and upper end of each window, both ascending; each window overlaps with the next one `[length]`.
    #[schemars(length(min = 2, max = MOST_TEMPERATURES), inner(inner(range(min = 0))))]
    pub windows: Vec<[f64; 2]>,
    /// Bins of the potential of mean force over all windows together, about: ends of windows are edges of bins.
    #[schemars(range(min = 1, max = MOST_BINS), extend("default" = USUAL_BINS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub bins: Option<usize>,
}
