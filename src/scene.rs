//! A validated scene: everything that decides a trajectory, in reduced units.
//!
//! A [`Scene`] is built from a scene file ([`Scene::from_file`], [`Scene::from_toml`]) or in code with a
//! [`SceneBuilder`]. Either way it has passed the same checks: a simulation can be made of it without further questions.
//! [`schema`](fn@schema) tells editors which keys a scene file can have.
//!
//! text -> `file` (what was typed, in its `source`) -> `reading` -> [`SceneBuilder`] (the parts) -> `build` (the checks, with
//! `groups`, `filling`, `placement`, `surface` and `start`) -> [`Scene`]. A [`SceneError`] knows its [`Place`] in the scene, and
//! the source turns that into a line.

mod build;
mod builder;
mod classes;
mod coordinates;
mod dense;
mod diagnostic;
mod draft;
mod file;
mod filling;
mod groups;
mod input;
mod interactions;
mod lattice;
mod limits;
mod mesh;
mod momentum;
pub(crate) mod names;
mod occupancy;
mod pairs;
mod place;
mod placement;
mod planning;
mod plans;
mod random;
mod reading;
mod record;
mod schema;
mod sizes;
mod source;
mod stage;
mod start;
mod surface;
mod velocity;

use serde::{Deserialize, Serialize};
use std::path::Path;

pub use builder::SceneBuilder;
pub use diagnostic::{SceneError, SceneErrorKind};
pub use draft::{Amount, Arrangement, Chain, Fill, Lattice, MeshDraft, Model, Region, Surface};
pub use input::InputFile;
pub use mesh::{Gap, Leak, Mesh};
pub use momentum::Influence;
pub use pairs::SpeciesPairs;
pub use place::{Place, Step};
pub(crate) use random::{Purpose, Random};
pub(crate) use record::{with_limit, without_limit};
pub use schema::schema;
pub(crate) use stage::{EQUILIBRATION, MEASUREMENT};
pub use stage::{Growth, GrowthTarget, Limit, RunPlan, StagePlan, Thermostat};
pub use surface::Side;

use crate::Vector;
use crate::output::Format;
use crate::potential::Potential;
use crate::space::Space;

/// Index into [`Scene::species`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct SpeciesId(pub u32);

/// Index into [`Scene::interactions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct InteractionId(pub u32);

impl InteractionId {
    /// As the event loop writes it; a scene has no more interactions than these numbers.
    pub(crate) fn narrow(self) -> u16 {
        u16::try_from(self.0).unwrap_or(u16::MAX)
    }
}

/// Index into [`Scene::particles`], and the particle's name in every output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ParticleId(pub u32);

/// What particles of one kind have in common.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Species {
    /// Name, unique in the scene.
    pub name: String,
    /// Mass `[mass]`; infinite for a static species.
    pub mass: f64,
    /// Diameter `[length]`: contact with walls at half of it, and the size in pictures.
    pub diameter: f64,
    /// Constant acceleration `[length / time^2]`: gravity, unless the species is static.
    pub acceleration: Vector,
}

impl Species {
    /// Whether particles of this species never move: a mesh, a pivot.
    #[must_use]
    pub fn is_static(&self) -> bool {
        self.mass.is_infinite()
    }

    /// `1 / mass`, exactly 0 for a static species.
    #[must_use]
    pub fn inverse_mass(&self) -> f64 {
        self.mass.recip()
    }
}

/// What two particles do to each other: a potential, and how much speed its infinite barriers give back.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interaction {
    /// The steps.
    pub potential: Potential,
    /// Ratio of the normal speeds after and before a contact with an infinite barrier, in `[0, 1]`.
    pub restitution: f64,
    /// Name, for bonds; several have the same where it stands for pairs of different diameters.
    pub name: Option<String>,
}

/// A pair with an interaction of its own, which replaces the one of its species.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bond {
    /// The two particles, in ascending order.
    pub pair: [ParticleId; 2],
    /// What holds them.
    pub interaction: InteractionId,
}

/// One particle at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Particle {
    /// What kind it is.
    pub species: SpeciesId,
    /// Position `[length]`, inside the box along periodic axes.
    pub position: Vector,
    /// Velocity `[length / time]`, zero for static particles.
    pub velocity: Vector,
}

/// When the audit of a run fails, where the limits that follow from round-off do not fit. All are relative.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct AuditPlan {
    /// Largest error of the energy ledger.
    pub energy: Option<f64>,
    /// Largest drift of the momentum.
    pub momentum: Option<f64>,
    /// Deepest overlap, of the distance of the discontinuity.
    pub overlap: Option<f64>,
}

/// A box in which a run counts particles as time goes on: a container that fills, a half of the space.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CountRegion {
    /// Name of the column, unique in the scene.
    pub name: String,
    /// Where.
    pub region: Region,
}

impl CountRegion {
    /// Whether a point is inside; the lower faces belong to the box, the upper ones to its neighbour. Along flat axes
    /// everything is.
    #[must_use]
    pub fn contains(&self, point: &Vector) -> bool {
        let Region { lower, upper } = &self.region;
        (0..3).all(|k| (lower[k]..upper[k]).contains(&point[k]) || (lower[k] == upper[k] && point[k] == lower[k]))
    }
}

/// What to write, in intervals of simulated time `[time]`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct OutputPlan {
    /// Between two rows of `thermo.csv`, in all stages; `None` lets the run choose some 200 rows in each.
    pub thermo_interval: Option<f64>,
    /// Between two frames of `trajectory.xyz`; `None` lets the run choose some 20 frames.
    pub frame_interval: Option<f64>,
    /// Where to count particles, a column of `thermo.csv` each.
    pub regions: Vec<CountRegion>,
    /// Whether every physical event is written to `contacts.csv`.
    pub has_contacts: bool,
    /// Whether every event is written to the folder `events`, with positions and velocities.
    pub has_event_log: bool,
    /// Formats that the trajectory is converted to at the end.
    pub formats: Vec<Format>,
}

/// A validated scene. The fields are public to read; [`SceneBuilder`] makes one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Scene {
    /// Name: the folder of a run.
    pub name: String,
    /// Seed of the random numbers that placed the particles and drew their velocities.
    pub seed: u64,
    /// Simulated time at the start `[time]`.
    pub start_time: f64,
    /// The box.
    pub space: Space,
    /// The species, at least one.
    pub species: Vec<Species>,
    /// The interactions that `table` and `bonds` refer to.
    pub interactions: Vec<Interaction>,
    /// The interactions of each two species; those without one pass through each other.
    pub table: SpeciesPairs<InteractionId>,
    /// Pairs that interact differently from their species.
    pub bonds: Vec<Bond>,
    /// The particles, in the order of their ids.
    pub particles: Vec<Particle>,
    /// The surfaces among the particles; empty if there are none.
    pub meshes: Vec<Mesh>,
    /// Temperature of the walls of each axis `[energy]`; `None` where they reflect.
    pub wall_temperatures: [Option<f64>; 3],
    /// Shear rate `dv_x / dy` of a sheared box `[1 / time]`; `None` for a box at rest.
    pub shear_rate: Option<f64>,
    /// Displacement at the start of the next image up along y, along x; 0 unless the box is sheared `[length]`.
    pub displacement: f64,
    /// Contact time of the TC model `[time]`; `None` switches the model off.
    pub contact_time: Option<f64>,
    /// Whether overlaps at the start are left to the stable rule instead of being an error.
    pub allow_invalid_start: bool,
    /// When the run's audit fails.
    pub audit: AuditPlan,
    /// How long.
    pub run: RunPlan,
    /// What to write.
    pub output: OutputPlan,
    /// What to measure.
    pub measure: crate::measure::Plan,
    /// The files that the particles come from, in the order of the tables that name them.
    pub inputs: Vec<InputFile>,
}

impl Scene {
    /// Reads a scene from a file.
    ///
    /// # Errors
    /// [`SceneError`] if the file cannot be read, or with the first mistake in it.
    pub fn from_file(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::from_file_with(path, &[])
    }

    /// Reads a scene from a file, with some of its values replaced.
    ///
    /// An override is a path of keys, with dots between them, and a value in TOML or a bare word: `("seed", "5")`,
    /// `("interaction.0.restitution", "0.1")` or, by name, `("species.A.mass", "2")`. What the file does not give is added.
    ///
    /// # Errors
    /// As [`Scene::from_file`]; a mistake in an override shows the override.
    pub fn from_file_with(path: impl AsRef<Path>, overrides: &[(&str, &str)]) -> Result<Self, SceneError> {
        let path = path.as_ref();
        Self::from_toml_with(read_text(path)?, path, overrides)
    }

    /// Reads a scene from its text. `name` stands for the file: in messages, as the scene's name unless the text gives
    /// one, and as the place where relative paths start.
    ///
    /// # Errors
    /// [`SceneError`] with the first mistake.
    pub fn from_toml(text: impl Into<String>, name: impl AsRef<Path>) -> Result<Self, SceneError> {
        Self::from_toml_with(text, name, &[])
    }

    /// Reads a scene from its text, with some of its values replaced as in [`Scene::from_file_with`].
    ///
    /// # Errors
    /// [`SceneError`] with the first mistake.
    pub fn from_toml_with(
        text: impl Into<String>,
        name: impl AsRef<Path>,
        overrides: &[(&str, &str)],
    ) -> Result<Self, SceneError> {
        let path = name.as_ref();
        let source = source::Source::new(&path.to_string_lossy(), text.into(), overrides);
        let file = source.read()?;
        let stem: String = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
        // A file may be called what it likes; the folder of a run has a plain name.
        let plain: String =
            stem.chars().map(|c| if c.is_ascii_alphanumeric() || c == '-' { c } else { '_' }).take(100).collect();
        let name = if plain.is_empty() { "scene" } else { &plain };
        let directory = path.parent().unwrap_or(Path::new(""));
        let builder = reading::parts(file, name, directory);
        builder.and_then(|builder| builder.build()).map_err(|error| source.located(error))
    }

    /// Makes all diameters and hard cores larger by a factor.
    pub(crate) fn grow(&mut self, factor: f64) {
        self.species.iter_mut().for_each(|species| species.diameter *= factor);
        self.interactions.iter_mut().for_each(|interaction| interaction.potential.grow(factor));
    }

    /// Whether anything acts from outside: a thermostat, a growth, a sheared box, a thermal wall.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.run.is_driven() || self.shear_rate.is_some() || self.wall_temperatures.iter().any(Option::is_some)
    }

    /// The fraction of the box that the particles fill.
    #[must_use]
    pub fn packing_fraction(&self) -> f64 {
        let dimensions = self.space.dimensions();
        let volume = |particle: &Particle| {
            let diameter = self.species[particle.species.0 as usize].diameter;
            filling::own_volume(diameter, dimensions)
        };
        self.particles.iter().map(volume).sum::<f64>() / self.space.volume()
    }

    /// The interaction of two species, if they have one.
    #[must_use]
    pub fn interaction_of(&self, a: SpeciesId, b: SpeciesId) -> Option<InteractionId> {
        self.table.get(a.0 as usize, b.0 as usize)
    }

    /// The distance beyond which no two particles and no particle and wall interact, unless they are bonded `[length]`.
    #[must_use]
    pub fn longest_range(&self) -> f64 {
        let potentials = self.table.iter().map(|(_, id)| self.interactions[id.0 as usize].potential.range());
        let diameters = self.species.iter().filter(|s| !s.is_static()).map(|s| s.diameter);
        potentials.chain(diameters).fold(0.0, f64::max)
    }

    /// The distance at which strangers of two species interact, negative if they never do `[length]`.
    #[must_use]
    pub fn range(&self, a: SpeciesId, b: SpeciesId) -> f64 {
        let is_static = |id: SpeciesId| self.species[id.0 as usize].is_static();
        match self.interaction_of(a, b) {
            Some(id) if !(is_static(a) && is_static(b)) => self.interactions[id.0 as usize].potential.range(),
            _ => -1.0,
        }
    }

    /// The species of a particle.
    #[must_use]
    pub fn species_of(&self, particle: ParticleId) -> &Species {
        &self.species[self.particles[particle.0 as usize].species.0 as usize]
    }
}

/// The text of a scene's file.
fn read_text(path: &Path) -> Result<String, SceneError> {
    let bytes = std::fs::read(path).map_err(|source| {
        SceneError::new(Place::root(), SceneErrorKind::Unreadable { path: path.to_owned(), source })
    })?;
    String::from_utf8(bytes).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        // The characters that could be read are enough to show the line.
        let text = String::from_utf8_lossy(error.as_bytes()).into_owned();
        SceneError::new(Place::root(), SceneErrorKind::NotText { offset }).in_source(
            &path.to_string_lossy(),
            std::sync::Arc::new(text),
            offset..offset,
        )
    })
}
