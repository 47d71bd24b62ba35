//! A validated scene: everything that decides a trajectory, in reduced units.
//!
//! A [`Scene`] is built from a scene file ([`Scene::from_file`], [`Scene::from_toml`]) or in code with a
//! [`SceneBuilder`]. Either way it has passed the same checks: a simulation can be made of it without further questions.

use crate::Vector;
use crate::potential::Potential;
use crate::space::Space;

/// Index into [`Scene::species`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SpeciesId(pub u32);

/// Index into [`Scene::interactions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct InteractionId(pub u32);

/// Index into [`Scene::particles`], and the particle's name in every output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
#[serde(transparent)]
pub struct ParticleId(pub u32);

/// What particles of one kind have in common.
#[derive(Debug, Clone, PartialEq)]
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
#[derive(Debug, Clone, PartialEq)]
pub struct Interaction {
    /// The steps.
    pub potential: Potential,
    /// Ratio of the normal speeds after and before a contact with an infinite barrier, in `[0, 1]`.
    pub restitution: f64,
}

/// A pair with an interaction of its own, which replaces the one of its species.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bond {
    /// The two particles, in ascending order.
    pub pair: [ParticleId; 2],
    /// What holds them.
    pub interaction: InteractionId,
}

/// One particle at the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Particle {
    /// What kind it is.
    pub species: SpeciesId,
    /// Position `[length]`, inside the box along periodic axes.
    pub position: Vector,
    /// Velocity `[length / time]`, zero for static particles.
    pub velocity: Vector,
}

/// When to stop: at a time, after a number of physical events, or at whichever comes first.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limit {
    /// Simulated time from the start of the stretch `[time]`.
    pub time: Option<f64>,
    /// Number of physical events (Core, Capture, Release, Bounce, wall) from the start of the stretch.
    pub events: Option<u64>,
}

/// How long to run, and what to do first.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RunPlan {
    /// Simulated first, without measuring.
    pub equilibration: Limit,
    /// The measured stretch, after the equilibration.
    pub limit: Limit,
}

/// What to write, in intervals of simulated time `[time]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutputPlan {
    /// Between two rows of `thermo.csv`; `None` lets the run choose some 200 rows.
    pub thermo_interval: Option<f64>,
    /// Between two frames of `trajectory.xyz`; `None` lets the run choose some 20 frames.
    pub frame_interval: Option<f64>,
}

/// A validated scene. The fields are public to read; [`SceneBuilder`] makes one.
#[derive(Debug, Clone, PartialEq)]
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
    /// `species x species`, row by row and symmetric: the interaction of each two species; `None` where they pass
    /// through each other.
    pub table: Vec<Option<InteractionId>>,
    /// Pairs that interact differently from their species.
    pub bonds: Vec<Bond>,
    /// The particles, in the order of their ids.
    pub particles: Vec<Particle>,
    /// Contact time of the TC model `[time]`; `None` switches the model off.
    pub contact_time: Option<f64>,
    /// Whether overlaps at the start are left to the stable rule instead of being an error.
    pub allow_invalid_start: bool,
    /// How long.
    pub run: RunPlan,
    /// What to write.
    pub output: OutputPlan,
}

impl Scene {
    /// The interaction of two species, if they have one.
    #[must_use]
    pub fn interaction_of(&self, a: SpeciesId, b: SpeciesId) -> Option<InteractionId> {
        self.table[a.0 as usize * self.species.len() + b.0 as usize]
    }

    /// The distance beyond which no two particles and no particle and wall interact, unless they are bonded `[length]`.
    #[must_use]
    pub fn longest_range(&self) -> f64 {
        let potentials = self.table.iter().flatten().map(|id| self.interactions[id.0 as usize].potential.range());
        let diameters = self.species.iter().filter(|s| !s.is_static()).map(|s| s.diameter);
        potentials.chain(diameters).fold(0.0, f64::max)
    }

    /// The species of a particle.
    #[must_use]
    pub fn species_of(&self, particle: ParticleId) -> &Species {
        &self.species[self.particles[particle.0 as usize].species.0 as usize]
    }
}
