//! `[space]`: the box and its sides.

use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};

use crate::scene::parse::space::{BOUNDARIES, SIDES};
use crate::scene::schema::words;

/// `[space]`: the box and its sides.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpaceFile {
    /// Edges of the box `[length]`; 0 along flat axes. If not given, they follow from the one fill with a count and a
    /// density, or without a fill from the box of a file.
    #[schemars(inner(range(min = 0)))]
    pub size: Option<[f64; 3]>,
    /// Lower corner of the box `[length]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub lower: Option<[f64; 3]>,
    /// Shear rate `dv_x / dy` of Lees-Edwards boundaries `[1 / time]`, not 0; at rest if not given.
    pub shear_rate: Option<f64>,
    /// What happens at the sides along x.
    #[schemars(extend("default" = "periodic"))]
    pub x: Option<AxisFile>,
    /// What happens at the sides along y.
    #[schemars(extend("default" = "periodic"))]
    pub y: Option<AxisFile>,
    /// What happens at the sides along z.
    #[schemars(extend("default" = "periodic"))]
    pub z: Option<AxisFile>,
}

/// `"periodic"`, or `{ lower = "wall", upper = "open", restitution = 0.5 }`
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum AxisFile {
    Word(#[schemars(extend("enum" = words(&BOUNDARIES)))] String),
    Sides(SidesFile),
}

/// The two sides of an axis.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SidesFile {
    /// The side at the lower corner.
    #[schemars(extend("enum" = words(&SIDES)))]
    pub lower: String,
    /// The side at the upper corner.
    #[schemars(extend("enum" = words(&SIDES)))]
    pub upper: String,
    /// Ratio of the normal speeds after and before a contact with a wall.
    #[schemars(range(min = 0, max = 1), extend("default" = 1.0))]
    pub restitution: Option<f64>,
    /// Temperature of the walls `[energy]`, instead of a restitution: a particle leaves them with a velocity of this temperature.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: Option<f64>,
}

impl<'de> Deserialize<'de> for AxisFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct WordOrSides;
        impl<'de> Visitor<'de> for WordOrSides {
            type Value = AxisFile;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("\"periodic\", \"open\", \"walls\", \"flat\" or { lower = ..., upper = ... }")
            }

            fn visit_str<E: Error>(self, word: &str) -> Result<AxisFile, E> {
                Ok(AxisFile::Word(word.to_owned()))
            }

            fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<AxisFile, A::Error> {
                SidesFile::deserialize(MapAccessDeserializer::new(map)).map(AxisFile::Sides)
            }
        }
        deserializer.deserialize_any(WordOrSides)
    }
}
