//! Tables of particles: single ones, files, chains, fills, static-sphere surfaces and bonds.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::base::whole;
use crate::prepare::surface::BoxSide;
use crate::scene::names::WORDS;
use crate::scene::parse::particles::{ARRANGEMENTS, REGIONS, SURFACES};
use crate::scene::schema::{keys_by_kind, words};

/// `[[particle]]`: one particle.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ParticleFile {
    /// Name of its species.
    pub species: String,
    /// Position of its centre `[length]`.
    pub position: [f64; 3],
    /// Velocity `[length / time]`.
    #[serde(default)]
    pub velocity: [f64; 3],
}

/// `[[file]]`: particles from an extended XYZ file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CoordinatesFile {
    /// The file; a relative path starts at the folder of the scene.
    pub path: String,
    /// Which frame of the file, from 0; from -1, the last one, backwards.
    #[serde(default, deserialize_with = "whole::number")]
    pub frame: i64,
    /// Name of the interaction that holds the bonds of the file; if not given, each is held by the one whose name the file has.
    pub bond: Option<String>,
    /// Checksum that the file must have: `crc32:` and eight hexadecimal digits. Runs keep it with their scene.
    #[schemars(regex(pattern = "^crc32:[0-9a-f]{8}$"))]
    pub checksum: Option<String>,
}

/// `[[chain]]`: chains of bonded particles, grown at random, or a straight one from `start` along `direction`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChainFile {
    /// Name of the species of its particles.
    pub species: String,
    /// Particles per chain.
    #[schemars(range(min = 1))]
    #[serde(deserialize_with = "whole::number")]
    pub length: u64,
    /// Number of chains.
    #[schemars(range(min = 1), extend("default" = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub count: Option<u64>,
    /// Name of the interaction that bonds each particle to the next.
    pub bond: String,
    /// Distance of neighbours at the start `[length]`; the middle of what the bond allows if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f64>,
    /// First particle of a straight chain `[length]`.
    pub start: Option<[f64; 3]>,
    /// Direction of a straight chain, of any length.
    pub direction: Option<[f64; 3]>,
    /// Temperature of Maxwell velocities `[energy]`; at rest if neither it nor `speed` is given.
    #[schemars(range(min = 0))]
    pub temperature: Option<f64>,
    /// Equal speed of all, in random directions, in place of a temperature `[length / time]`.
    #[schemars(range(min = 0))]
    pub speed: Option<f64>,
}

/// `[[fill]]`: many particles, by two of a count, a density and a volume.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FillFile {
    /// Name of the species; `composition` for several.
    pub species: Option<String>,
    /// Species and their shares, which need not add up to 1.
    #[schemars(extend("additionalProperties" = json!({ "type": "number", "exclusiveMinimum": 0 })))]
    pub composition: Option<BTreeMap<String, f64>>,
    /// On a lattice that is stretched to fit, or at random where nothing overlaps.
    #[schemars(extend("enum" = words(&ARRANGEMENTS)))]
    pub arrangement: String,
    /// Number of particles.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub count: Option<u64>,
    /// Particles per volume `[1 / length^D]`, `D` the number of axes that are not flat.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub number_density: Option<f64>,
    /// Fraction of the volume that the particles fill.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0))]
    pub packing_fraction: Option<f64>,
    /// Whether fewer will do: as many as find a place one by one, at most those of the count or the density, if one is given. At random only.
    #[serde(default)]
    pub as_many_as_fit: bool,
    /// The part of the box to fill; all of it if not given.
    pub region: Option<RegionFile>,
    /// Temperature of Maxwell velocities `[energy]`; at rest if neither it nor `speed` is given.
    #[schemars(range(min = 0))]
    pub temperature: Option<f64>,
    /// Equal speed of all, in random directions, in place of a temperature `[length / time]`.
    #[schemars(range(min = 0))]
    pub speed: Option<f64>,
    /// Velocity that is added to all `[length / time]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub velocity: Option<[f64; 3]>,
}

/// The inside of a box that is aligned with the axes, of a cylinder, a cone or a sphere.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("shape", &REGIONS)))]
pub(crate) struct RegionFile {
    /// The shape; it decides which of the other keys there are.
    #[schemars(extend("enum" = words(&REGIONS), "default" = "box"))]
    pub shape: Option<String>,
    /// Lower corner of a box `[length]`.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of a box `[length]`.
    pub upper: Option<[f64; 3]>,
    /// Centre of the first end of a cylinder or cone `[length]`.
    pub base: Option<[f64; 3]>,
    /// Direction from the first end to the second, of any length.
    pub axis: Option<[f64; 3]>,
    /// Distance of the ends `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length: Option<f64>,
    /// Radii of the two ends of a cone `[length]`.
    #[schemars(inner(range(min = 0)))]
    pub radii: Option<[f64; 2]>,
    /// Radius of a cylinder or sphere `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<f64>,
    /// Centre of a sphere `[length]`.
    pub centre: Option<[f64; 3]>,
}

/// `[[mesh]]`: a surface made of static particles.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("surface", &SURFACES)))]
pub(crate) struct MeshFile {
    /// Name in messages: up to 100 letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: Option<String>,
    /// Name of a static species.
    pub species: String,
    /// The shape; it decides which of the other keys there are.
    #[schemars(extend("enum" = words(&SURFACES)))]
    pub surface: String,
    /// Largest distance of neighbouring particles `[length]`; chosen so that nothing leaks if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f64>,
    /// Corner of a plane `[length]`.
    pub corner: Option<[f64; 3]>,
    /// First edge of a plane, from its corner `[length]`.
    pub edge_1: Option<[f64; 3]>,
    /// Second edge of a plane, from its corner `[length]`.
    pub edge_2: Option<[f64; 3]>,
    /// Lower corner of a box or rectangle `[length]`.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of a box or rectangle `[length]`.
    pub upper: Option<[f64; 3]>,
    /// Sides of a box or rectangle that are left out; x leads to the right, y to the back, z to the top.
    #[schemars(extend("items" = json!({ "type": "string", "enum": words(&BoxSide::NAMES) }), "default" = json!([])))]
    pub open: Option<Vec<String>>,
    /// Centre of the first end of a cylinder or cone `[length]`.
    pub base: Option<[f64; 3]>,
    /// Direction from the first end to the second, of any length.
    pub axis: Option<[f64; 3]>,
    /// Distance of the ends `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub length: Option<f64>,
    /// Radii of the two ends of a cone `[length]`.
    #[schemars(inner(range(min = 0)))]
    pub radii: Option<[f64; 2]>,
    /// Radius of a cylinder, sphere or ring `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<f64>,
    /// Centre of a sphere or ring `[length]`.
    pub centre: Option<[f64; 3]>,
    /// First end of a line `[length]`.
    pub start: Option<[f64; 3]>,
    /// Second end of a line `[length]`.
    pub end: Option<[f64; 3]>,
    /// Positions of single static particles `[length]`.
    #[schemars(length(min = 1))]
    pub points: Option<Vec<[f64; 3]>>,
}

/// `[[bond]]`: a bond between two particles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct BondFile {
    /// Their ids. Ids count from 0: first particles, then files, chains, fills and meshes.
    #[schemars(inner(range(min = 0, max = u32::MAX)))]
    #[serde(deserialize_with = "whole::several")]
    pub particles: [u32; 2],
    /// Name of the interaction that holds them.
    pub interaction: String,
}
