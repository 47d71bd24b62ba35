//! The file format of a scene: its TOML, key by key, before validation.
//!
//! Editors show the comments and ranges of the fields: they become the descriptions and limits of
//! [`schema`](fn@crate::scene::schema). So each comment says what the key means to a user, with its unit.

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

/// A scene of Carom: what is simulated, for how long, and what is measured and written. Units are reduced: the scene
/// chooses the units of length, mass and energy, and Boltzmann's constant is 1.
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
    /// Text about the scene in Markdown, shown on the page of `carom live`. Without it the page shows the comment at
    /// the top of the file.
    pub description: Option<String>,
    /// Seed of the random numbers that place particles and draw velocities.
    #[schemars(extend("default" = 1))]
    #[serde(deserialize_with = "whole::given")]
    pub seed: Option<u64>,
    /// Simulated time at the start `[time]`.
    #[schemars(extend("default" = 0.0))]
    pub start_time: Option<f64>,
    /// Whether particles may overlap at the start. The stable rule lets no overlap grow deeper. Overlaps disappear
    /// unless gravity or
    /// wells hold them.
    pub allow_invalid_start: bool,
    /// The run from which this one starts, instead of particles.
    pub start: Option<StartFile>,
    /// The box and its sides.
    pub space: Option<SpaceFile>,
    /// Gravity, and the TC model.
    pub dynamics: Option<DynamicsFile>,
    /// Species of particles, at least one. With `start`, the species of that run if not given.
    #[schemars(length(min = 1))]
    pub species: Vec<SpeciesFile>,
    /// Interactions of two species or of two bonded particles. With `start`, the interactions of that run if not given.
    pub interaction: Vec<InteractionFile>,
    /// Single particles.
    pub particle: Vec<ParticleFile>,
    /// Particles from coordinate files.
    pub file: Vec<CoordinatesFile>,
    /// Chains of bonded particles.
    pub chain: Vec<ChainFile>,
    /// Many particles in the box or in part of it.
    pub fill: Vec<FillFile>,
    /// Surfaces made of static particles.
    pub mesh: Vec<MeshFile>,
    /// Surfaces that particles collide with, in addition to the walls of the box. With `start`, the surfaces of that
    /// run if not given.
    pub surface: Option<Vec<SurfaceFile>>,
    /// Single bonds.
    pub bond: Vec<BondFile>,
    /// Limits of the audit of a run. They replace the limits that follow from round-off.
    pub audit: AuditFile,
    /// Stages before the run, in order.
    pub stage: Vec<StageFile>,
    /// How long to run.
    pub run: Option<RunFile>,
    /// Replicas at several temperatures or in several windows that are swapped at intervals, instead of one run.
    pub exchange: Option<ExchangeFile>,
    /// Measurements.
    pub measure: MeasureFile,
    /// Output.
    pub output: OutputFile,
    /// The page on which the scene runs.
    pub live: LiveFile,
}

impl SceneFile {
    /// The scene with the last state of a run instead of its own particles, bonds and time.
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
    /// Folder of the run. A relative path starts at the folder of the scene.
    pub from: String,
    /// The checksum at the end of that run's checkpoint: `crc32:` and eight hexadecimal digits. Runs store it with
    /// their scene.
    #[schemars(regex(pattern = "^crc32:[0-9a-f]{8}$"))]
    pub checksum: Option<String>,
}

/// `[dynamics]`: gravity, and the TC model.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DynamicsFile {
    /// Acceleration of every moving species without an acceleration of its own `[length / time^2]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub gravity: Option<[f64; 3]>,
    /// Contact time of the TC model `[time]`. Without it the model is off.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub contact_time: Option<f64>,
}

/// `[[species]]`: a species of particles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpeciesFile {
    /// Name, unique in the scene. Up to 64 letters, digits and any of `_ - + . ( )`. The first character is a letter
    /// or a digit.
    #[schemars(regex(pattern = WORD))]
    pub name: String,
    /// Diameter or distribution of diameters `[length]`.
    pub diameter: DiameterFile,
    /// Mass `[mass]`. Every moving species needs one. With a distribution of diameters, it is the mass at the mean
    /// diameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass: Option<f64>,
    /// Whether the particles of the species never move.
    #[serde(default, rename = "static")]
    pub is_static: bool,
    /// Constant acceleration `[length / time^2]`; gravity if not given.
    pub acceleration: Option<[f64; 3]>,
}

/// `[audit]`: relative limits that replace the limits from round-off.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AuditFile {
    /// Largest relative error of the energy ledger.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub energy: Option<f64>,
    /// Largest relative drift of the momentum.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub momentum: Option<f64>,
    /// Deepest overlap, relative to the distance of the discontinuity.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub overlap: Option<f64>,
}

/// `[run]`: length of the run. It ends at `until_time` or `until_events`, whichever comes first.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunFile {
    /// With `auto`, the equilibration ends when no observable drifts. It never exceeds its time or number of events.
    #[schemars(extend("enum" = AUTOMATIC))]
    pub equilibration: Option<String>,
    /// Duration simulated before the measurement `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub equilibration_time: Option<f64>,
    /// Number of events simulated before the measurement.
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
    /// Gravity of the equilibration and the measurement `[length / time^2]`; the gravity of `[dynamics]` if not given.
    pub gravity: Option<[f64; 3]>,
    /// Thermostat during the measurement; none if not given.
    pub thermostat: Option<ThermostatFile>,
    /// Barostat during equilibration and measurement; none if not given. It needs a thermostat of the kind `andersen`.
    pub barostat: Option<BarostatFile>,
    /// Number of threads of the run; 1 if not given. With `auto`, one per core where it pays. Any number gives the
    /// same bits.
    pub threads: Option<ThreadsFile>,
}

/// `[output]`: what to write, in intervals of simulated time.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct OutputFile {
    /// Time between two rows of `thermo.csv` `[time]`, in all stages. If not given, each stage gets about 200 rows.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thermo_interval: Option<f64>,
    /// Time between two frames of `trajectory.xyz` `[time]`. If not given, about 20 frames are written, but at most
    /// 200 MB.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub frame_interval: Option<f64>,
    /// Whether every physical event is written to `contacts.csv`.
    pub contacts: bool,
    /// Whether every event is written to the folder `events` with positions and velocities, one file for each column.
    pub events: bool,
    /// Formats to which the trajectory is converted at the end of the run.
    #[schemars(extend("items" = json!({ "type": "string", "enum": Format::ALL.map(Format::name) }), "default" = json!([])))]
    pub formats: Vec<String>,
    /// Boxes and meshes in which particles are counted. Each becomes a column of `thermo.csv`.
    pub count: Vec<CountFile>,
}

/// `[[output.count]]`: a box, or the inside of a closed mesh, in which particles are counted.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CountFile {
    /// Name of the column, unique. Up to 100 letters, digits, blanks and any of `_ - + . ( )`. The first character is
    /// a letter or a digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: String,
    /// Lower corner of a box `[length]`.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of a box `[length]`.
    pub upper: Option<[f64; 3]>,
    /// STL or OBJ file of a closed mesh, instead of a box. Its path is relative to the folder of the scene.
    pub path: Option<String>,
    /// Distance within which vertices of the file are merged, as a fraction of the largest extent of the mesh. No
    /// vertices are merged if not given.
    #[schemars(range(min = 0, max = 0.01))]
    pub weld: Option<f64>,
    /// Factor by which the mesh is scaled. Scaling comes before rotation.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: Option<f64>,
    /// Axis and angle in degrees by which the mesh is rotated, after scaling.
    pub rotation: Option<RotationFile>,
    /// Vector by which the mesh is moved, after rotation `[length]`.
    pub translation: Option<[f64; 3]>,
    /// Checksum of the file: `crc32:` and eight hexadecimal digits. Runs store it with their scene.
    pub checksum: Option<String>,
}
