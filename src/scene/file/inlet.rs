//! `[[inlet]]`: a region in which particles enter.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::json;

use super::RegionFile;
use crate::base::whole;
use crate::scene::names::WORDS;

/// `[[inlet]]`: a region where particles enter during the run, one after the other. They are new, or they return from an
/// outlet. A particle appears at a random place where it interacts with no other particle and touches no surface. If no
/// place is free, it waits.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct InletFile {
    /// Unique name: up to 100 letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit. If
    /// not given, it is `inlet 1` for the first inlet, and so on.
    #[schemars(regex(pattern = WORDS))]
    pub name: Option<String>,
    /// Name of the species of the new particles. For several species, use `composition`.
    pub species: Option<String>,
    /// Species of the new particles and their relative numbers. The sum of the numbers need not be 1.
    #[schemars(extend("additionalProperties" = json!({ "type": "number", "exclusiveMinimum": 0 })))]
    pub composition: Option<BTreeMap<String, f64>>,
    /// Where whole particles appear.
    pub region: RegionFile,
    /// Number of new particles per unit of time `[1 / time]`. The first is due at `from`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub rate: Option<f64>,
    /// Mean mass of the new particles per time, instead of a number of particles `[mass / time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass_rate: Option<f64>,
    /// Mean velocity of the particles that enter `[length / time]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub velocity: Option<[f64; 3]>,
    /// Temperature of Maxwell velocities that are added to `velocity` `[energy]`.
    #[schemars(range(min = 0), extend("default" = 0.0))]
    pub temperature: Option<f64>,
    /// Stage from whose beginning `from` and `until` count. If not given, they are simulated times.
    pub stage: Option<String>,
    /// Time at which the first new particle is due `[time]`; the start of the scene or of the stage if not given.
    pub from: Option<f64>,
    /// Time after which no new particle is due `[time]`. If not given, there is no limit.
    pub until: Option<f64>,
    /// Number of new particles that enter in all. If not given, there is no limit.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub count: Option<u64>,
    /// Particles enter only while there are fewer moving particles than this in the system.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub keep: Option<u64>,
    /// Names of the outlets whose particles return here. A particle that leaves at one of them enters again as soon as a
    /// place is free, with the same species, a new id and the velocity of the inlet.
    #[schemars(length(min = 1))]
    pub recirculate: Option<Vec<String>>,
}
