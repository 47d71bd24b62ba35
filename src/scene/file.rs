//! The format of a scene file.
//!
//! The comments of the fields are the descriptions in [`schema`](fn@crate::scene::schema), which editors show. Each
//! comment explains the key to a user, with the unit.

mod diameter;
mod drive;
mod either;
mod inlet;
mod interaction;
mod live;
mod material;
mod measure;
mod particles;
mod restitution;
mod space;
mod surface;
mod surface_velocity;

pub(crate) use diameter::{DiameterFile, DistributionFile};
pub(crate) use drive::{
    BarostatFile, ExchangeFile, GrowthFile, StageFile, SwapFile, ThermostatFile, ThreadsFile, UmbrellaFile,
};
pub(crate) use inlet::InletFile;
pub(crate) use interaction::InteractionFile;
pub(crate) use live::{LiveFile, SliderFile};
pub(crate) use material::MaterialFile;
pub(crate) use measure::MeasureFile;
pub(crate) use particles::{BondFile, ChainFile, CoordinatesFile, FillFile, MeshFile, ParticleFile, RegionFile};
pub(crate) use restitution::{RestitutionFile, VaryingFile};
pub(crate) use space::{AxisFile, SideFile, SidesFile, SpaceFile, WallFile};
pub(crate) use surface::{MotionFile, RotationFile, SurfaceFile};
pub(crate) use surface_velocity::{SurfaceVelocityFile, TurningFile};

use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::json;

use crate::base::whole;
use crate::model::Format;
use crate::scene::names::{SCENE, UNIT, WORD, WORDS};
use crate::scene::parse::TC_RULES;
use crate::scene::parse::diameter::{INDIVIDUAL, MASSES};
use crate::scene::parse::plan::AUTOMATIC;
use crate::scene::schema::words;

/// A scene of Carom: what is simulated, measured and written. The scene chooses the units of length, mass and energy.
/// Boltzmann's constant is 1.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
#[schemars(title = "Carom scene", extend(
    "$id" = "urn:carom:scene",
    "required" = ["run"],
    "anyOf" = json!([{ "required": ["species"] }, { "required": ["start"] }])
))]
pub(crate) struct SceneFile {
    /// Name of the run folder: up to 100 letters, digits, `-` and `_`; the name of the scene file if not given.
    #[schemars(regex(pattern = SCENE))]
    pub name: Option<String>,
    /// Text about the scene in Markdown, for the page of `carom live`. If not given, the first comment in the file is
    /// used.
    pub description: Option<String>,
    /// Seed of the random numbers that place particles and draw velocities.
    #[schemars(extend("default" = 1))]
    #[serde(deserialize_with = "whole::given")]
    pub seed: Option<u64>,
    /// Simulated time at the start `[time]`.
    #[schemars(extend("default" = 0.0))]
    pub start_time: Option<f64>,
    /// Whether particles may overlap at the start. Overlaps never become deeper. They disappear unless gravity or wells
    /// hold the particles together.
    pub allow_invalid_start: bool,
    /// Distance by which particles may be moved at the start to remove overlaps `[length]`. If not given, overlaps are an
    /// error.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub separate_overlaps: Option<f64>,
    /// Start from the last state of another run. The scene then has no particles of its own.
    pub start: Option<StartFile>,
    /// Names of the units in which all numbers are given. Outputs contain them. No number is converted.
    pub units: Option<UnitsFile>,
    /// The box and its sides.
    pub space: Option<SpaceFile>,
    /// Gravity, and the contact time of the TC model.
    pub dynamics: Option<DynamicsFile>,
    /// Species of particles, at least one. A scene with `start` takes them from the earlier run if none are given.
    #[schemars(length(min = 1))]
    pub species: Vec<SpeciesFile>,
    /// Contact laws of materials. Species, walls and surfaces refer to materials by name.
    pub material: Vec<MaterialFile>,
    /// Interactions of species and of bonds. A scene with `start` takes them from the earlier run if none are given.
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
    /// Surfaces besides the walls. A scene with `start` takes them from the earlier run if none are given.
    pub surface: Option<Vec<SurfaceFile>>,
    /// Regions in which particles enter during the run.
    pub inlet: Vec<InletFile>,
    /// Single bonds.
    pub bond: Vec<BondFile>,
    /// Limits of the audit of a run. The default limits follow from round-off.
    pub audit: AuditFile,
    /// Parts of the run before the final part, in order.
    pub stage: Vec<StageFile>,
    /// Settings of the run, such as its length.
    pub run: Option<RunFile>,
    /// Replica exchange between temperatures or distances, instead of a single run.
    pub exchange: Option<ExchangeFile>,
    /// Measurements.
    pub measure: MeasureFile,
    /// Output.
    pub output: OutputFile,
    /// Settings of the page on which the scene runs.
    pub live: LiveFile,
}

impl SceneFile {
    /// Replaces the particles, bonds and time of the scene by the last state of a run.
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
    /// Folder of the run, relative to the folder of the scene.
    pub from: String,
    /// Checksum of the other run's checkpoint: `crc32:` and eight hexadecimal digits. The new run adds the checksum to
    /// its copy of the scene.
    #[schemars(regex(pattern = "^crc32:[0-9a-f]{8}$"))]
    pub checksum: Option<String>,
}

/// `[units]`: names of up to 16 letters.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct UnitsFile {
    /// Name of the unit of length, such as `mm`.
    #[schemars(regex(pattern = UNIT))]
    pub length: String,
    /// Name of the unit of mass, such as `g`.
    #[schemars(regex(pattern = UNIT))]
    pub mass: String,
    /// Name of the unit of time, such as `ms`.
    #[schemars(regex(pattern = UNIT))]
    pub time: String,
}

/// `[dynamics]`: gravity, and the contact time of the TC model.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct DynamicsFile {
    /// Acceleration of every moving species that has no acceleration of its own `[length / time^2]`.
    #[schemars(extend("default" = [0.0, 0.0, 0.0]))]
    pub gravity: Option<[f64; 3]>,
    /// Contact time of the TC model `[time]`. If not given, the model is off.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub contact_time: Option<f64>,
    /// Rule of the TC model for a contact that follows the previous one within the contact time. With `resting`, this
    /// contact is elastic but stays rough, and grains at rest bounce once per contact time. With `luding-mcnamara`, it
    /// is elastic and smooth, as in the published model.
    #[schemars(extend("enum" = words(&TC_RULES), "default" = "resting"))]
    pub tc_rule: Option<String>,
    /// Lets grains at rest fall asleep, so that they cost no events. If not given, no grain falls asleep.
    pub sleep: Option<SleepFile>,
}

/// When grains fall asleep and wake up.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SleepFile {
    /// Time between two searches for grains at rest `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub interval: f64,
    /// A grain falls asleep if two conditions hold since the previous search: it has moved by at most this distance, and its
    /// contacts were less than 4 contact times apart on average. At most 0.05 of the smallest diameter `[length]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub distance: f64,
    /// A particle that hits a sleeping grain at a higher relative speed wakes it `[length / time]`. Faster grains do
    /// not fall asleep.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub wake_speed: f64,
}

/// `[[species]]`: a species of particles.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SpeciesFile {
    /// Unique name: up to 64 letters, digits and any of `_ - + . ( )`, beginning with a letter or a digit.
    #[schemars(regex(pattern = WORD))]
    pub name: String,
    /// Diameter or distribution of diameters `[length]`.
    pub diameter: DiameterFile,
    /// With `individual`, particles have individual diameters. Without this key, a distribution is divided into
    /// classes.
    #[schemars(extend("enum" = [INDIVIDUAL]))]
    pub diameters: Option<String>,
    /// Mass `[mass]`, required for moving species. If diameters are distributed, this is the mass at the mean diameter. If
    /// diameters are individual and `diameter` is a number, this is the mass at that diameter.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub mass: Option<f64>,
    /// Masses of particles with individual diameters: proportional to the volume, or constant.
    #[schemars(extend("enum" = words(&MASSES), "default" = "volume"))]
    pub masses: Option<String>,
    /// Material of the species. It determines the contact laws of the species, except where an interaction has its own.
    pub material: Option<String>,
    /// Whether the particles of the species never move.
    #[serde(default, rename = "static")]
    pub is_static: bool,
    /// Constant acceleration `[length / time^2]`; gravity if not given.
    pub acceleration: Option<[f64; 3]>,
    /// Moment of inertia about an axis through the centre `[mass length^2]`. The default is `2/5 m R^2`, as for a
    /// uniform sphere. In two dimensions it is `m R^2 / 2`, as for a uniform disk.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub moment_of_inertia: Option<f64>,
}

/// `[audit]`: relative limits of the audit of a run.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct AuditFile {
    /// Largest permitted error of the energy ledger, as a fraction.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub energy: Option<f64>,
    /// Largest permitted drift of the momentum, as a fraction.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub momentum: Option<f64>,
    /// Deepest permitted overlap, relative to the distance of the discontinuity.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub overlap: Option<f64>,
}

/// `[run]`: the run, which ends at `until_time` or `until_events`, whichever comes first.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct RunFile {
    /// With `auto`, the equilibration ends when all observables are stationary, but after `equilibration_time` or
    /// `equilibration_events` at the latest.
    #[schemars(extend("enum" = AUTOMATIC))]
    pub equilibration: Option<String>,
    /// Duration simulated before the measurement `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub equilibration_time: Option<f64>,
    /// Number of physical events simulated before the measurement.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub equilibration_events: Option<u64>,
    /// Duration of the measurement `[time]`.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub until_time: Option<f64>,
    /// Largest number of physical events in the measurement.
    #[schemars(range(min = 1))]
    #[serde(default, deserialize_with = "whole::given")]
    pub until_events: Option<u64>,
    /// Gravity of the equilibration and the measurement `[length / time^2]`; the gravity of `[dynamics]` if not given.
    pub gravity: Option<[f64; 3]>,
    /// Thermostat during equilibration and measurement; none if not given.
    pub thermostat: Option<ThermostatFile>,
    /// Barostat during equilibration and measurement; none if not given. It needs a thermostat of the kind `andersen`.
    pub barostat: Option<BarostatFile>,
    /// Swap moves of a mixture of hard spheres during equilibration and measurement; none if not given.
    pub swap: Option<SwapFile>,
    /// Number of threads; 1 if not given. `auto` uses one thread per core, or fewer for few particles. The results do
    /// not depend on this number.
    pub threads: Option<ThreadsFile>,
}

/// `[output]`: what to write, and how often in simulated time.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct OutputFile {
    /// Time between two rows of `thermo.csv`, in all stages `[time]`. If not given, each stage gets about 200 rows.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub thermo_interval: Option<f64>,
    /// Time between two frames of `trajectory.xyz` `[time]`. If not given, about 20 frames are written, at most 200 MB
    /// in total.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub frame_interval: Option<f64>,
    /// Whether every physical event is written to `contacts.csv`.
    pub contacts: bool,
    /// Whether every event is written to the folder `events`, with positions and velocities. Each column has its own
    /// file.
    pub events: bool,
    /// Formats to which the trajectory is converted at the end of the run.
    #[schemars(extend("items" = json!({ "type": "string", "enum": Format::ALL.map(Format::name) }), "default" = json!([])))]
    pub formats: Vec<String>,
    /// Boxes and closed meshes in which particles are counted. Each adds a column to `thermo.csv`.
    pub count: Vec<CountFile>,
}

/// `[[output.count]]`: a box, or the inside of a closed mesh, in which particles are counted.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct CountFile {
    /// Unique name of the column: up to 100 letters, digits, blanks and any of `_ - + . ( )`, beginning with a letter
    /// or a digit.
    #[schemars(regex(pattern = WORDS))]
    pub name: String,
    /// Lower corner of a box `[length]`.
    pub lower: Option<[f64; 3]>,
    /// Upper corner of a box `[length]`.
    pub upper: Option<[f64; 3]>,
    /// STL or OBJ file of a closed mesh, instead of a box, relative to the folder of the scene.
    pub path: Option<String>,
    /// Vertices closer than this fraction of the mesh's largest extent are merged. If not given, no vertices are
    /// merged.
    #[schemars(range(min = 0, max = 0.01))]
    pub weld: Option<f64>,
    /// Factor by which the mesh is scaled before its rotation.
    #[schemars(extend("exclusiveMinimum" = 0))]
    pub scale: Option<f64>,
    /// Axis and angle in degrees of the mesh's rotation, after scaling.
    pub rotation: Option<RotationFile>,
    /// Displacement of the mesh after its rotation `[length]`.
    pub translation: Option<[f64; 3]>,
    /// Checksum of the mesh file: `crc32:` and eight hexadecimal digits. A run adds the checksum to its copy of the
    /// scene.
    pub checksum: Option<String>,
}
