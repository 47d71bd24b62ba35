use schemars::JsonSchema;
use serde::{Deserialize, Deserializer};

use super::either::Either;
use super::restitution::RestitutionFile;
use crate::scene::parse::space::{BOUNDARIES, SIDES};
use crate::scene::schema::words;

/// `[space]`: the box and its sides.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpaceFile {
    /// Edges of the box `[length]`; 0 along flat axes. If not given, they follow from a single fill with a count and a
    /// density, or from the box of a file if there is no fill.
    #[schemars(inner(range(min = 0)))]
    pub size: Option<[f64; 3]>,
    /// Lower corner of the box `[length]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub lower: Option<[f64; 3]>,
    /// Shear rate `dv_x / dy` of Lees-Edwards boundaries `[1 / time]`, not 0. If not given, the boundaries are at rest.
    pub shear_rate: Option<f64>,
    /// Boundary conditions along x.
    #[schemars(extend("default" = "periodic"))]
    pub x: Option<AxisFile>,
    /// Boundary conditions along y.
    #[schemars(extend("default" = "periodic"))]
    pub y: Option<AxisFile>,
    /// Boundary conditions along z.
    #[schemars(extend("default" = "periodic"))]
    pub z: Option<AxisFile>,
}

/// Sides of the box along an axis: a word such as `"periodic"`, or a table such as
/// `{ lower = "wall", upper = "open", restitution = 0.5 }`. Each wall may be a table as well.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum AxisFile {
    Word(#[schemars(extend("enum" = words(&BOUNDARIES)))] String),
    Sides(Box<SidesFile>),
}

/// The lower and the upper side of the box along an axis.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SidesFile {
    /// Side at the lower corner: a word, or a table for a wall with its own values.
    pub lower: SideFile,
    /// Side at the upper corner: a word, or a table for a wall with its own values.
    pub upper: SideFile,
    /// Ratio of the normal speeds after and before a contact with a side that is `"wall"`.
    #[schemars(extend("default" = 1.0))]
    pub restitution: Option<RestitutionFile>,
    /// Tangential restitution of sides that are `"wall"`: a contact without sliding multiplies the tangential velocity of
    /// the surfaces by minus this number. If not given, it is 0 with `friction`; without both keys, contacts are smooth.
    #[schemars(range(min = -1, max = 1))]
    pub tangential_restitution: Option<f64>,
    /// Friction coefficient of sides that are `"wall"`: the largest ratio of the tangential to the normal impulse. If not
    /// given, contacts with a tangential restitution never slide.
    #[schemars(range(min = 0))]
    pub friction: Option<f64>,
    /// Material of the sides that are `"wall"`, which determines the contact law with all species.
    pub material: Option<String>,
    /// Temperature of the sides that are `"wall"` `[energy]`, instead of a restitution. Particles leave such a wall
    /// with new velocities at this temperature.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: Option<f64>,
}

/// One side of the box: a word such as `"wall"`, or the table of a wall such as `{ temperature = 2.0 }`.
#[derive(Debug, JsonSchema)]
#[schemars(untagged)]
pub(crate) enum SideFile {
    Word(#[schemars(extend("enum" = words(&SIDES)))] String),
    Wall(WallFile),
}

/// A wall with its own restitution or temperature.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct WallFile {
    /// Ratio of the normal speeds after and before a contact with this wall.
    #[schemars(extend("default" = 1.0))]
    pub restitution: Option<RestitutionFile>,
    /// Tangential restitution of this wall: a contact without sliding multiplies the tangential velocity of
    /// the surfaces by minus this number. If not given, it is 0 with `friction`; without both keys, contacts are smooth.
    #[schemars(range(min = -1, max = 1))]
    pub tangential_restitution: Option<f64>,
    /// Friction coefficient of this wall: the largest ratio of the tangential to the normal impulse. If not
    /// given, contacts with a tangential restitution never slide.
    #[schemars(range(min = 0))]
    pub friction: Option<f64>,
    /// Material of this wall, which determines the contact law with all species.
    pub material: Option<String>,
    /// Temperature of this wall `[energy]`, instead of a restitution. Particles leave the wall with new velocities.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub temperature: Option<f64>,
}

impl<'de> Deserialize<'de> for AxisFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = "\"periodic\", \"open\", \"walls\", \"flat\" or { lower = ..., upper = ... }";
        Either { of_word: Some(Self::Word), ..Either::new(expected, |sides| Self::Sides(Box::new(sides))) }
            .deserialize(deserializer)
    }
}

impl<'de> Deserialize<'de> for SideFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let expected = "\"open\", \"wall\" or the table of a wall, { temperature = ... } or { restitution = ... }";
        Either { of_word: Some(Self::Word), ..Either::new(expected, Self::Wall) }.deserialize(deserializer)
    }
}
