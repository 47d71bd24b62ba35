//! `diameter` of a species: a number or a distribution.

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};

use super::either::Either;
use crate::base::whole;
use crate::scene::parse::diameter::DISTRIBUTIONS;
use crate::scene::schema::{keys_by_kind, words};

/// A diameter such as `1.0`, or a distribution such as `{ distribution = "lognormal", mean = 1.0, deviation = 0.1 }`.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum DiameterFile {
    Number(#[schemars(extend("exclusiveMinimum" = 0))] f64),
    Distribution(DistributionFile),
}

/// A distribution of diameters. Its kind determines which keys are allowed.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("distribution", &DISTRIBUTIONS)))]
pub(crate) struct DistributionFile {
    /// Kind of distribution.
    #[schemars(extend("enum" = words(&DISTRIBUTIONS)))]
    pub distribution: String,
    /// Exponent `a` of a power law: the probability density is proportional to `diameter^-a`.
    #[schemars(range(min = -100, max = 100))]
    pub exponent: Option<f64>,
    /// Smallest diameter of a uniform distribution or of a power law `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub lower: Option<f64>,
    /// Largest diameter of a uniform distribution or of a power law `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub upper: Option<f64>,
    /// Mean diameter `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mean: Option<f64>,
    /// Standard deviation of the diameters `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub deviation: Option<f64>,
    /// Diameters of the distribution `list` `[length]`.
    pub diameters: Option<Vec<f64>>,
    /// Relative numbers of particles of the listed diameters; equal if not given. The sum need not be 1.
    pub shares: Option<Vec<f64>>,
    /// Number of classes that approximate the distribution; 16 if not given. Each class is a species.
    #[serde(default, deserialize_with = "whole::given")]
    pub classes: Option<u64>,
}

impl<'de> Deserialize<'de> for DiameterFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let either = Either::new("a number or { distribution = ..., ... }", Self::Distribution);
        Either { of_number: Some(Self::Number), ..either }.deserialize(deserializer)
    }
}
