//! The file format of a scene: its TOML, key by key, before validation.
//!
//! The comments of the fields, with their units, and the ranges beside them are also what an editor shows: they are the
//! descriptions and the limits of [`schema`](fn@crate::scene::schema).

mod diameter;
mod drive;
mod either;
mod interaction;
mod live;
mod measure;
mod particles;
mod space;
mod surface;

pub(crate) use diameter::{DiameterFile, DistributionFile};
pub(crate) use drive::{BarostatFile, ExchangeFile, GrowthFile, StageFile, ThermostatFile, ThreadsFile, UmbrellaFile};
pub(crate) use interaction::InteractionFile;
pub(crate) use live::{LiveFile, SliderFile};
pub(crate) use measure::MeasureFile;
pub(crate) use particles::{BondFile, ChainFile, CoordinatesFile, FillFile, MeshFile, ParticleFile, RegionFile};
pub(crate) use space::{AxisFile, SideFile, SidesFile, SpaceFile};
pub(crate) use surface::{MotionFile, RotationFile, SurfaceFile};

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::json;

use crate::base::whole;
use crate::model::Format;
use crate::scene::names::{SCENE, WORD, WORDS};
use crate::scene::parse::plan::AUTOMATIC;

/// A scene of Carom: what is simulated, for how long, and what is measured and written. Reduced units: lengths, masses
/// and energies are what the scene makes them, and Boltzmann's constant is 1.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(title = "Carom scene", extend(
    "$id" = "urn:carom:scene",
    "required" = ["run"],
    "anyOf" = json!([{ "required": ["species"] }, { "required": ["start"] }])
))]
pub(crate) struct SceneFile {
    /// Name of the folder of a run: up to 100 letters, digits, `-` and `_`. The name of the file if not given.
    #[schemars(regex(pattern = SCENE))]
    pub name: Option<String>,
    /// Text about the scene, in Markdown; the page of `carom live` shows it, or the comment that the file begins with.
    pub description: Option<String>,
    /// Seed of the random numbers that place particles and draw velocities.
    #[schemars(extend("default" = 1))]
    #[serde(deserialize_with = "whole::given")]
    pub seed: Option<u64>,
    /// Simulated time at the start `[time]`.
    #[schemars(extend("default" = 0.0))]
    pub start_time: Option<f64>,
    /// Whether particles may overlap at the start; the stable rule parts them.
    pub allow_invalid_start: bool,
    /// The run that this one starts from, in place of particles.
    pub start: Option<StartFile>,
    /// The box and its sides.
    pub space: Option<SpaceFile>,
    /// Gravity, and the TC model.
    pub dynamics: Option<DynamicsFile>,
    /// The kinds of particles, at least one; with `start`, those of that run if not given.
    #[schemars(length(min = 1))]
    pub species: Vec<SpeciesFile>,
    /// Interactions of two species, or of two bonded particles; with `start`, those of that run if not given.
    pub interaction: Vec<InteractionFile>,
    /// Single particles.
    pub particle: Vec<ParticleFile>,
    /// Particles from coordinate files.
    pub file: Vec<CoordinatesFile>,
    /// Chains of bonded particles.
    pub chain: Vec<ChainFile>,
    /// Many particles in the box or in a part of it.
    pub fill: Vec<FillFile>,
    /// Surfaces made of static particles.
    pub mesh: Vec<MeshFile>,
    /// Surfaces that particles meet, besides the walls of the box; with `start`, those of that run if not given.
    pub surface: Option<Vec<SurfaceFile>>,
    /// Single bonds.
    pub bond: Vec<BondFile>,
    /// When the audit of a run fails, in place of the limits that follow from round-off.
    pub audit: AuditFile,
    /// Stages before the run, in their order.
    pub stage: Vec<StageFile>,
    /// How long to run.
    pub run: Option<RunFile>,
    /// Replicas at several temperatures, swapped now and then, in place of one run.
    pub exchange: Option<ExchangeFile>,
    /// Measurements.
    pub measure: MeasureFile,
    /// Output.
    pub output: OutputFile,
    /// The page on which the scene runs.
    pub live: LiveFile,
}

impl SceneFile {
    /// The scene with the last state of a run in place of particles, bonds and time of its own.
    pub fn starting_from(self, run: &str) -> Self {
        let start = Some(StartFile { from: run.to_owned(), checksum: None });
        let (particle, file, chain, fill, mesh, bond) = Default::default();
        Self { start, start_time: None, particle, file, chain, fill, mesh, bond, ..self }
    }
}

/// `[start]`: the last state of another run.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct StartFile {
    /// The folder of the run; a relative path starts at the folder of the scene.
    pub from: String,
    /// The checksum that the run's checkpoint ends with: `crc32:` and eight hexadecimal digits. Runs keep it with their scene.
    #[schemars(regex(pattern = "^crc32:[0-9a-f]{8}$"))]
    pub checksum: Option<String>,
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
    #[serde(default, deserialize_with = "whole::given")]
    pub equilibration_events: Option<u64>,
    /// Duration of the measurement `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub until_time: Option<f64>,
    /// Number of events of the measurement.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub until_events: Option<u64>,
    /// Gravity of the equilibration and the measurement `[length / time^2]`; that of `[dynamics]` if not given.
    pub gravity: Option<[f64; 3]>,
    /// Thermostat while the run is measured; none if not given.
    pub thermostat: Option<ThermostatFile>,
    /// Barostat while the run is equilibrated and measured, beside a thermostat of the kind `andersen`; none if not given.
    pub barostat: Option<BarostatFile>,
    /// Threads that everything runs on, with the same bits for any number; 1 if not given, as many as there are cores where it pays for `auto`.
    pub threads: Option<ThreadsFile>,
}

/// `[output]`: what to write, in intervals of simulated time.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct OutputFile {
    /// Between two rows of `thermo.csv` `[time]`, in all stages; some 200 rows in each if not given.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thermo_interval: Option<f64>,
    /// Between two frames of `trajectory.xyz` `[time]`; some 20 frames if not given, no more than fit into 200 MB.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub frame_interval: Option<f64>,
    /// Whether every physical event is written to `contacts.csv`.
    pub contacts: bool,
    /// Whether every event is written to the folder `events`, by columns, with positions and velocities.
    pub events: bool,
    /// Formats into which the trajectory is converted at the end of the run.
    #[schemars(extend("items" = json!({ "type": "string", "enum": Format::ALL.map(Format::name) }), "default" = json!([])))]
    pub formats: Vec<String>,
    /// Boxes in which particles are counted, each a column of `thermo.csv`.
    pub count: Vec<CountFile>,
}

/// `[[output.count]]`: a box, or the inside of a closed mesh, in which particles are counted.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CountFile {
    /// Name of the column, unique: up to 100 letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter or a digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: String,
    /// Lower corner of a box `[length]`.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of a box `[length]`.
    pub upper: Option<[f64; 3]>,
    /// File of a closed mesh in place of a box, STL or OBJ; a relative path starts at the folder of the scene.
    pub path: Option<String>,
    /// Vertices of the file that are nearer to each other than this part of the largest extent of the mesh become one; none if not given.
    #[schemars(range(min = 0, max = 0.01))]
    pub weld: Option<f64>,
    /// Factor by which the mesh of the file is made larger, first.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: Option<f64>,
    /// Direction about which the mesh of the file is turned, and by how many degrees, second.
    pub rotation: Option<RotationFile>,
    /// How far the mesh of the file is moved, last `[length]`.
    pub translation: Option<[f64; 3]>,
    /// The checksum of the file, `crc32:` and eight hexadecimal digits. Runs keep it with their scene.
    pub checksum: Option<String>,
}
