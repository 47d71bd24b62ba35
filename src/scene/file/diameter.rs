//! `diameter` of a species: a number or a distribution.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::either::Either;
use crate::base::whole;
use crate::scene::parse::diameter::DISTRIBUTIONS;
use crate::scene::schema::{keys_by_kind, words};

/// `1.0`, or `{ distribution = "lognormal", mean = 1.0, deviation = 0.1 }`
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum DiameterFile {
    Number(#[schemars(extend("exclusiveMinimum" = 0))] f64),
    Distribution(DistributionFile),
}

/// A distribution of diameters; the keys depend on its kind.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("distribution", &DISTRIBUTIONS)))]
pub(crate) struct DistributionFile {
    /// Kind of distribution.
    #[schemars(extend("enum" = words(&DISTRIBUTIONS)))]
    pub distribution: String,
    /// The smallest diameter, of a uniform distribution `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub lower: Option<f64>,
    /// The largest diameter `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub upper: Option<f64>,
    /// Mean diameter `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mean: Option<f64>,
    /// Standard deviation of the diameters `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub deviation: Option<f64>,
    /// The diameters of a list `[length]`.
    pub diameters: Option<Vec<f64>>,
    /// Number shares of the listed diameters, which need not add up to one. Equal shares if not given.
    pub shares: Option<Vec<f64>>,
    /// Number of species that approximate the distribution; 16 if not given.
    #[serde(default, deserialize_with = "whole::given")]
    pub classes: Option<u64>,
}

impl<'de> Deserialize<'de> for DiameterFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let either = Either::new("a number or { distribution = ..., ... }", Self::Distribution);
        Either { of_number: Some(Self::Number), ..either }.deserialize(deserializer)
    }
}
