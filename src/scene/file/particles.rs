//! Tables of particles: single particles, files, chains, fills, static surfaces and bonds.

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
    /// Name of the species of the particle.
    pub species: String,
    /// Position of the centre of the particle `[length]`.
    pub position: [f64; 3],
    /// Initial velocity `[length / time]`.
    #[serde(default)]
    pub velocity: [f64; 3],
    /// Initial angular velocity about the centre `[1 / time]`. In two dimensions, only the component along the flat
    /// axis may differ from 0.
    #[serde(default)]
    pub spin: [f64; 3],
    /// Diameter `[length]`, if the species has individual diameters.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub diameter: Option<f64>,
}

/// `[[file]]`: particles from an extended XYZ file.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CoordinatesFile {
    /// Path of the file, relative to the folder of the scene.
    pub path: String,
    /// Frame of the file, counted from 0. Negative numbers count from the end: -1 is the last frame.
    #[serde(default, deserialize_with = "whole::number")]
    pub frame: i64,
    /// Name of the interaction for the bonds of the file. If not given, the names in the file are used.
    pub bond: Option<String>,
    /// Checksum that the file must have: `crc32:` and eight hexadecimal digits. A run adds it to its copy of the scene.
    #[schemars(regex(pattern = "^crc32:[0-9a-f]{8}$"))]
    pub checksum: Option<String>,
}

/// `[[chain]]`: chains of bonded particles, grown at random, or one straight chain from `start` along `direction`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct ChainFile {
    /// Name of the species of the particles.
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
    /// Bond length at the start `[length]`; the middle of the allowed lengths if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub spacing: Option<f64>,
    /// Position of the first particle of a straight chain `[length]`.
    pub start: Option<[f64; 3]>,
    /// Direction of a straight chain, of any length.
    pub direction: Option<[f64; 3]>,
    /// Temperature of the initial Maxwell velocities `[energy]`. Without `temperature` and `speed`, the particles start
    /// at rest.
    #[schemars(range(min = 0))]
    pub temperature: Option<f64>,
    /// Initial speed of every particle, in a random direction, instead of a temperature `[length / time]`.
    #[schemars(range(min = 0))]
    pub speed: Option<f64>,
}

/// `[[fill]]`: many particles. Two of count, density and volume determine the third.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct FillFile {
    /// Name of the species. For several species, use `composition`.
    pub species: Option<String>,
    /// Species and their relative numbers of particles. The sum of the numbers need not be 1.
    #[schemars(extend("additionalProperties" = json!({ "type": "number", "exclusiveMinimum": 0 })))]
    pub composition: Option<BTreeMap<String, f64>>,
    /// `random` (random positions without overlaps), or the name of a lattice, which is stretched to fit.
    #[schemars(extend("enum" = words(&ARRANGEMENTS)))]
    pub arrangement: String,
    /// Number of particles.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub count: Option<u64>,
    /// Number density `[1 / length^D]`, where `D` is the number of axes that are not flat.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub number_density: Option<f64>,
    /// Packing fraction.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0))]
    pub packing_fraction: Option<f64>,
    /// Whether a fill with the arrangement `random` may have fewer particles than requested. Particles are then added
    /// one by one until the count or density is reached, or no more fit.
    #[serde(default)]
    pub as_many_as_fit: bool,
    /// Part of the box to fill; the whole box if not given.
    pub region: Option<RegionFile>,
    /// Temperature of the initial Maxwell velocities `[energy]`. Without `temperature` and `speed`, all particles start
    /// with the velocity `velocity`.
    #[schemars(range(min = 0))]
    pub temperature: Option<f64>,
    /// Initial speed of every particle, in a random direction, instead of a temperature `[length / time]`.
    #[schemars(range(min = 0))]
    pub speed: Option<f64>,
    /// Velocity added to the velocities of all particles `[length / time]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub velocity: Option<[f64; 3]>,
}

/// Region of a fill: the inside of an axis-aligned box, a cylinder, a cone or a sphere.
#[derive(Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("shape", &REGIONS)))]
pub(crate) struct RegionFile {
    /// Shape of the region. It determines which other keys are allowed.
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
    /// Distance between the two ends of a cylinder or cone `[length]`.
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
    /// Name in messages: up to 100 letters, digits, blanks and any of `_ - + . ( )`, the first a letter or digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: Option<String>,
    /// Name of the static species of all particles of the mesh.
    pub species: String,
    /// Shape of the static surface. It determines which other keys are allowed.
    #[schemars(extend("enum" = words(&SURFACES)))]
    pub surface: String,
    /// Largest distance between neighbouring particles `[length]`; by default, too small for moving particles to pass.
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
    /// Sides of a box or rectangle that are left out, where x points to the right, y to the back and z upwards.
    #[schemars(extend("items" = json!({ "type": "string", "enum": words(&BoxSide::NAMES) }), "default" = json!([])))]
    pub open: Option<Vec<String>>,
    /// Centre of the first end of a cylinder or cone `[length]`.
    pub base: Option<[f64; 3]>,
    /// Direction from the first end to the second, of any length.
    pub axis: Option<[f64; 3]>,
    /// Distance between the two ends of a cylinder or cone `[length]`.
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
    /// Ids of the two particles. Ids count from 0, in this order: single particles, files, chains, fills, meshes.
    #[schemars(inner(range(min = 0, max = u32::MAX)))]
    #[serde(deserialize_with = "whole::several")]
    pub particles: [u32; 2],
    /// Name of the interaction that bonds the two particles.
    pub interaction: String,
}
