//! A scene: everything that decides a trajectory, in reduced units.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::{
    AuditPlan, InputFile, MeasurementPlan, OutputPlan, Potential, RunPlan, Space, SpeciesPairs, StaticSurface,
};
use crate::Vector;

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
    /// Whether particles of this species never move: a surface, a pivot.
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

/// A validated scene. The fields are public to read; [`SceneBuilder`](crate::scene::SceneBuilder) makes one.
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
    pub static_surfaces: Vec<StaticSurface>,
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
    pub measure: MeasurementPlan,
    /// The files that the particles come from, in the order of the tables that name them.
    pub inputs: Vec<InputFile>,
}

impl Scene {
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
            own_volume(diameter, dimensions)
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

/// Volume of a sphere, area of a disk, length of a rod `[length^D]`.
pub(crate) fn own_volume(diameter: f64, dimensions: usize) -> f64 {
    match dimensions {
        3 => PI / 6.0 * diameter * diameter * diameter,
        2 => PI / 4.0 * diameter * diameter,
        _ => diameter,
    }
}
