//! `diameter` of a species: a number or a distribution.

use std::fmt;

use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

/// `1.0`, or `{ distribution = "lognormal", mean = 1.0, deviation = 0.1 }`
#[derive(Debug)]
pub(crate) enum DiameterFile {
    Number(f64),
    Distribution(DistributionFile),
}

/// A distribution of diameters; the keys depend on its kind.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct DistributionFile {
    pub distribution: String,
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub mean: Option<f64>,
    pub deviation: Option<f64>,
    pub diameters: Option<Vec<f64>>,
    pub shares: Option<Vec<f64>>,
    pub classes: Option<u64>,
}

impl<'de> Deserialize<'de> for DiameterFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct NumberOrDistribution;
        impl<'de> Visitor<'de> for NumberOrDistribution {
            type Value = DiameterFile;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or { distribution = ..., ... }")
            }

            fn visit_f64<E: Error>(self, number: f64) -> Result<DiameterFile, E> {
                Ok(DiameterFile::Number(number))
            }

            fn visit_i64<E: Error>(self, number: i64) -> Result<DiameterFile, E> {
                Ok(DiameterFile::Number(number as f64))
            }

            fn visit_u64<E: Error>(self, number: u64) -> Result<DiameterFile, E> {
                Ok(DiameterFile::Number(number as f64))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<DiameterFile, A::Error> {
                DistributionFile::deserialize(MapAccessDeserializer::new(map)).map(DiameterFile::Distribution)
            }
        }
        deserializer.deserialize_any(NumberOrDistribution)
    }
}
