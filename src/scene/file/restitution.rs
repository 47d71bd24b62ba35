//! `restitution` of an interaction, a wall or a surface: a number, or a function of the speed of impact.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value, json};

use super::either::Either;

/// A coefficient of restitution such as `0.9`, a table such as `{ speeds = [0.1, 2.0], values = [0.95, 0.7] }`, or
/// viscoelastic spheres such as `{ viscous_time = 1e-6, stiffness = 3e8 }`.
#[derive(Debug, Clone, Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum RestitutionFile {
    Number(#[schemars(range(min = 0, max = 1))] f64),
    Varying(VaryingFile),
}

/// Ratio of the normal speeds after and before a contact, which depends on the speed before.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("minProperties" = 1, "allOf" = [
    pair("speeds", "values"), pair("values", "speeds"), pair("viscous_time", "stiffness"), pair("stiffness", "viscous_time"),
]))]
pub(crate) struct VaryingFile {
    /// Normal speeds of impact `[length / time]`, in increasing order.
    #[schemars(length(min = 1), extend("items" = json!({ "type": "number", "minimum": 0 })))]
    pub speeds: Option<Vec<f64>>,
    /// Coefficients of restitution at these speeds. The coefficient is linear between them, and constant beyond the first
    /// and the last.
    #[schemars(
        length(min = 1),
        extend("items" = json!({ "type": "number", "minimum": 0, "maximum": 1 }))
    )]
    pub values: Option<Vec<f64>>,
    /// `A` of viscoelastic spheres `[time]`. Their force at the compression xi is rho (xi^1.5 + 1.5 A sqrt(xi) dxi/dt).
    #[schemars(range(min = 0))]
    pub viscous_time: Option<f64>,
    /// `rho` of viscoelastic spheres `[mass / (length^0.5 time^2)]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub stiffness: Option<f64>,
}

/// A rule of the schema: with `key`, the table needs `other` and has no further keys.
fn pair(key: &str, other: &str) -> Value {
    let all = ["speeds", "values", "viscous_time", "stiffness"];
    let misplaced = all.into_iter().filter(|name| *name != key && *name != other);
    let misplaced: Map<String, Value> = misplaced.map(|name| (name.to_owned(), Value::Bool(false))).collect();
    json!({ "if": { "required": [key] }, "then": { "required": [other], "properties": misplaced } })
}

impl<'de> Deserialize<'de> for RestitutionFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected =
            "a number from 0 to 1, { speeds = ..., values = ... } or { viscous_time = ..., stiffness = ... }";
        Either { of_number: Some(Self::Number), ..Either::new(expected, Self::Varying) }.deserialize(deserializer)
    }
}
