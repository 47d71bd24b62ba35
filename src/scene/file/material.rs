//! `[[material]]`: the contact law of two materials.

use schemars::JsonSchema;
use serde::Deserialize;

use super::restitution::RestitutionFile;

/// `[[material]]`: how two materials rebound from each other. Species, walls and surfaces name their `material`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct MaterialFile {
    /// Names of the two materials, which may be the same.
    pub between: [String; 2],
    /// Ratio of the normal speeds after and before a contact.
    #[schemars(extend("default" = 1.0))]
    pub restitution: Option<RestitutionFile>,
    /// Tangential restitution of rough contacts: a contact without sliding multiplies the tangential velocity of the
    /// surfaces by minus this number. If not given, it is 0 with `friction`; without both keys, contacts are smooth.
    #[schemars(range(min = -1, max = 1))]
    pub tangential_restitution: Option<f64>,
    /// Friction coefficient: the largest ratio of the tangential to the normal impulse. If not given, contacts with a
    /// tangential restitution never slide.
    #[schemars(range(min = 0))]
    pub friction: Option<f64>,
}
