//! `[[interaction]]`: a potential of two species or of bonds.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::restitution::RestitutionFile;
use crate::base::whole;
use crate::scene::interactions::MOST_STEPS;
use crate::scene::names::WORD;
use crate::scene::parse::interaction::POTENTIALS;
use crate::scene::schema::{keys_by_kind, words};

/// `[[interaction]]`: the potential between two particles. It has `species`, or a `name` for bonds, or both.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("potential", &POTENTIALS)))]
pub(crate) struct InteractionFile {
    /// Name for bonds and chains, unique among interactions, with the characters allowed in the name of a species.
    #[schemars(regex(pattern = WORD))]
    pub name: Option<String>,
    /// Names of the two species that have this interaction.
    pub species: Option<[String; 2]>,
    /// Kind of potential. It determines which other keys are allowed.
    #[schemars(extend("enum" = words(&POTENTIALS)))]
    pub potential: String,
    /// Contact distance `[length]`; the mean diameter of the two species if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub diameter: Option<f64>,
    /// Outer end of a well, shoulder or bond, divided by the contact distance.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub lambda: Option<f64>,
    /// Depth of the well `[energy]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub well_depth: Option<f64>,
    /// Height of a shoulder or of a penetrable core `[energy]`. A shoulder needs a positive height.
    pub height: Option<f64>,
    /// Shortest length of a bond `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub shortest: Option<f64>,
    /// Longest length of a bond `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub longest: Option<f64>,
    /// Radii of the steps `[length]`, outermost first.
    #[schemars(length(min = 1), extend("items" = json!({ "type": "number", "exclusiveMinimum": 0 })))]
    pub radii: Option<Vec<f64>>,
    /// Energies `[energy]`: first the energy outside all radii, then the energy inside each radius. `inf` as the first
    /// or last energy is a barrier.
    #[schemars(length(min = 2), with = "Option<Vec<Option<f64>>>")]
    // JSON has no infinity, and programs that convert TOML to JSON turn `inf` into null.
    pub energies: Option<Vec<f64>>,
    /// Distance at which a Lennard-Jones potential is cut off `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cutoff: Option<f64>,
    /// Number of steps of a Lennard-Jones potential.
    #[schemars(range(min = 1, max = MOST_STEPS))]
    #[serde(default, deserialize_with = "whole::given")]
    pub steps: Option<u64>,
    /// Energy at which the hard core of a Lennard-Jones potential begins `[energy]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub core_energy: Option<f64>,
    /// Ratio of the normal speeds after and before a contact with an infinite barrier.
    #[schemars(extend("default" = 1.0))]
    pub restitution: Option<RestitutionFile>,
    /// Tangential restitution of rough cores: a contact without sliding multiplies the tangential velocity of
    /// the surfaces by minus this number. If not given, it is 0 with `friction`; without both keys, contacts are smooth.
    #[schemars(range(min = -1, max = 1))]
    pub tangential_restitution: Option<f64>,
    /// Friction coefficient of rough cores: the largest ratio of the tangential to the normal impulse. If not
    /// given, contacts with a tangential restitution never slide.
    #[schemars(range(min = 0))]
    pub friction: Option<f64>,
}
