//! What was typed: the TOML of a scene, key by key, before anything is made of it.
//!
//! The comments of the fields, with their units, and the ranges beside them are also what an editor shows: they are the
//! descriptions and the limits of [`schema`](fn@crate::scene::schema).

mod diameter;
mod drive;
mod measure;

pub(crate) use diameter::{DiameterFile, DistributionFile};
pub(crate) use drive::{GrowthFile, StageFile, ThermostatFile};
pub(crate) use measure::MeasureFile;

use std::collections::BTreeMap;
use std::fmt;

use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::value::MapAccessDeserializer;
use serde::de::{Deserializer, Error, MapAccess, Visitor};
use serde_json::json;

use crate::model::Format;
use crate::scene::interactions::MOST_STEPS;
use crate::scene::names::{SCENE, WORD, WORDS};
use crate::scene::parse::plan::AUTOMATIC;
use crate::scene::parse::{ARRANGEMENTS, BOUNDARIES, POTENTIALS, SIDES, SURFACES};
use crate::scene::schema::{keys_by_kind, words};
use crate::scene::surface::BoxSide;

/// A scene of Carom: what is simulated, for how long, and what is measured and written. Reduced units: lengths, masses
/// and energies are what the scene makes them, and Boltzmann's constant is 1.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Carom scene", extend("$id" = "urn:carom:scene", "required" = ["species", "run"]))]
pub(crate) struct SceneFile {
    /// Name of the folder of a run: up to 100 letters, digits, `-` and `_`. The name of the file if not given.
    #[schemars(regex(pattern = SCENE))]
    pub name: Option<String>,
    /// Seed of the random numbers that place particles and draw velocities.
    #[schemars(extend("default" = 1))]
    pub seed: Option<u64>,
    /// Simulated time at the start `[time]`.
    #[schemars(extend("default" = 0.0))]
    pub start_time: Option<f64>,
    /// Whether particles may overlap at the start; the stable rule parts them.
    #[serde(default)]
    pub allow_invalid_start: bool,
    /// The box and its sides.
    #[serde(default)]
    pub space: SpaceFile,
    /// Gravity, and the TC model.
    #[serde(default)]
    pub dynamics: DynamicsFile,
    /// The kinds of particles, at least one.
    #[serde(default)]
    #[schemars(length(min = 1))]
    pub species: Vec<SpeciesFile>,
    /// What two species, or two bonded particles, do to each other.
    #[serde(default)]
    pub interaction: Vec<InteractionFile>,
    /// Single particles.
    #[serde(default)]
    pub particle: Vec<ParticleFile>,
    /// Particles from coordinate files.
    #[serde(default)]
    pub file: Vec<CoordinatesFile>,
    /// Chains of bonded particles.
    #[serde(default)]
    pub chain: Vec<ChainFile>,
    /// Many particles in the box or in a part of it.
    #[serde(default)]
    pub fill: Vec<FillFile>,
    /// Surfaces made of static particles.
    #[serde(default)]
    pub mesh: Vec<MeshFile>,
    /// Single bonds.
    #[serde(default)]
    pub bond: Vec<BondFile>,
    /// When the audit of a run fails, in place of the limits that follow from round-off.
    #[serde(default)]
    pub audit: AuditFile,
    /// Stages before the run, in their order.
    #[serde(default)]
    pub stage: Vec<StageFile>,
    /// How long to run.
    pub run: Option<RunFile>,
    /// What to measure.
    #[serde(default)]
    pub measure: MeasureFile,
    /// What to write.
    #[serde(default)]
    pub output: OutputFile,
}

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

/// `[dynamics]`: gravity, and the TC model.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DynamicsFile {
    /// Acceleration of every species that moves and has none of its own `[length / time^2]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub gravity: Option<[f64; 3]>,
    /// Contact time of the TC model `[time]`; without it the model is off.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub contact_time: Option<f64>,
}

/// `[[species]]`: a kind of particles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpeciesFile {
    /// Name, unique in the scene: up to 64 letters, digits and any of `_ - + . ( )`, beginning with a letter or a digit.
    #[schemars(regex(pattern = WORD))]
    pub name: String,
    /// Diameter `[length]`, or how the diameters are distributed.
    pub diameter: DiameterFile,
    /// Mass `[mass]`; every species that moves has one. That of the mean diameter where diameters are distributed.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass: Option<f64>,
    /// Whether its particles never move.
    #[serde(default, rename = "static")]
    pub is_static: bool,
    /// Constant acceleration `[length / time^2]`; gravity if not given.
    pub acceleration: Option<[f64; 3]>,
}

/// `[[interaction]]`: what two particles do to each other. It has `species`, or a `name` for bonds, or both.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(extend("allOf" = keys_by_kind("potential", &POTENTIALS)))]
pub(crate) struct InteractionFile {
    /// Name for bonds and chains, unique among interactions; as those of species.
    #[schemars(regex(pattern = WORD))]
    pub name: Option<String>,
    /// The two species that interact like this.
    pub species: Option<[String; 2]>,
    /// The potential; it decides which of the other keys there are.
    #[schemars(extend("enum" = words(&POTENTIALS)))]
    pub potential: String,
    /// Distance of contact `[length]`; half the sum of the diameters of the species if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub diameter: Option<f64>,
    /// Outer end of a well, shoulder or bond, in diameters.
    #[schemars(extend("exclusiveMinimum" = 1))]
    pub lambda: Option<f64>,
    /// Depth of the well `[energy]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub well_depth: Option<f64>,
    /// Height of the shoulder or of the core `[energy]`; positive for a shoulder.
    pub height: Option<f64>,
    /// Shortest length of a bond `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub shortest: Option<f64>,
    /// Longest length of a bond `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub longest: Option<f64>,
    /// Radii of the steps `[length]`, the outermost first.
    #[schemars(length(min = 1), extend("items" = json!({ "type": "number", "exclusiveMinimum": 0 })))]
    pub radii: Option<Vec<f64>>,
    /// Energies `[energy]`: outside of the first radius, then inside of each; `inf` first or last is a barrier.
    #[schemars(length(min = 2), with = "Option<Vec<Option<f64>>>")]
    // JSON has no infinity: programs that see TOML as JSON make `inf` a null.
    pub energies: Option<Vec<f64>>,
    /// Distance at which a Lennard-Jones potential is cut off `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub cutoff: Option<f64>,
    /// Number of steps of a Lennard-Jones potential.
    #[schemars(range(min = 1, max = MOST_STEPS))]
    pub steps: Option<u64>,
    /// Energy at which a Lennard-Jones potential gets its hard core `[energy]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub core_energy: Option<f64>,
    /// Ratio of the normal speeds after and before a contact with an infinite barrier.
    #[schemars(range(min = 0, max = 1), extend("default" = 1.0))]
    pub restitution: Option<f64>,
}

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
    /// Which frame of the file, from 0.
    #[serde(default)]
    pub frame: u64,
    /// Name of the interaction that holds the bonds of the file; if not given, each is held by the one whose name the file has.
    pub bond: Option<String>,
    /// What the content of the file must be: `crc32:` and eight hexadecimal digits. Runs keep it with their scene.
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
    pub length: u64,
    /// Number of chains.
    #[schemars(range(min = 1), extend("default" = 1))]
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
    /// Temperature of Maxwell velocities `[energy]`; at rest if not given.
    #[schemars(range(min = 0))]
    pub temperature: Option<f64>,
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
    pub count: Option<u64>,
    /// Particles per volume `[1 / length^D]`, `D` the number of axes that are not flat.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub number_density: Option<f64>,
    /// Fraction of the volume that the particles fill.
    #[schemars(range(max = 1), extend("exclusiveMinimum" = 0))]
    pub packing_fraction: Option<f64>,
    /// The part of the box to fill; all of it if not given.
    pub region: Option<RegionFile>,
    /// Temperature of Maxwell velocities `[energy]`; at rest if not given.
    #[schemars(range(min = 0))]
    pub temperature: Option<f64>,
    /// Velocity that is added to all `[length / time]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub velocity: Option<[f64; 3]>,
}

/// A box, aligned with the axes.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RegionFile {
    /// Lower corner `[length]`.
    pub lower: [f64; 3],
    /// Upper corner `[length]`.
    pub upper: [f64; 3],
}

/// `[[mesh]]`: a surface made of static particles.
#[derive(Debug, Deserialize, JsonSchema)]
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
    /// Lower corner of a box `[length]`.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of a box `[length]`.
    pub upper: Option<[f64; 3]>,
    /// Sides of a box that are left out; x leads to the right, y to the back, z to the top.
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
    /// Radius of a cylinder or sphere `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub radius: Option<f64>,
    /// Centre of a sphere `[length]`.
    pub centre: Option<[f64; 3]>,
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
    pub particles: [u32; 2],
    /// Name of the interaction that holds them.
    pub interaction: String,
}

/// `[audit]`: relative limits in place of those of round-off.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AuditFile {
    /// Largest error of the energy ledger, relative.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub energy: Option<f64>,
    /// Largest drift of the momentum, relative.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub momentum: Option<f64>,
    /// Deepest overlap, relative to the distance of the discontinuity.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub overlap: Option<f64>,
}

/// `[run]`: how long to run: `until_time`, `until_events`, or whichever is first.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunFile {
    /// `auto` ends the equilibration when no observable drifts, at its time or number of events at the latest.
    #[schemars(extend("enum" = AUTOMATIC))]
    pub equilibration: Option<String>,
    /// Duration simulated first, not measured `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub equilibration_time: Option<f64>,
    /// Number of events simulated first, not measured.
    #[schemars(range(min = 1))]
    pub equilibration_events: Option<u64>,
    /// Duration of the measurement `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub until_time: Option<f64>,
    /// Number of events of the measurement.
    #[schemars(range(min = 1))]
    pub until_events: Option<u64>,
    /// What holds the temperature while the run is measured; nothing if not given.
    pub thermostat: Option<ThermostatFile>,
}

/// `[output]`: what to write, in intervals of simulated time.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct OutputFile {
    /// Between two rows of `thermo.csv` `[time]`, in all stages; some 200 rows in each if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thermo_interval: Option<f64>,
    /// Between two frames of `trajectory.xyz` `[time]`; some 20 frames if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub frame_interval: Option<f64>,
    /// Whether every physical event is written to `contacts.csv`.
    #[serde(default)]
    pub contacts: bool,
    /// Whether every event is written to the folder `events`, by columns, with positions and velocities.
    #[serde(default)]
    pub events: bool,
    /// What the trajectory is converted to at the end of the run.
    #[serde(default)]
    #[schemars(extend("items" = json!({ "type": "string", "enum": Format::ALL.map(Format::name) }), "default" = json!([])))]
    pub formats: Vec<String>,
    /// Boxes in which particles are counted, each a column of `thermo.csv`.
    #[serde(default)]
    pub count: Vec<CountFile>,
}

/// `[[output.count]]`: a box in which particles are counted.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CountFile {
    /// Name of the column, unique: up to 100 letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: String,
    /// Lower corner `[length]`.
    pub lower: [f64; 3],
    /// Upper corner `[length]`.
    pub upper: [f64; 3],
}
