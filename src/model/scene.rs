//! A scene: everything that determines a trajectory, in reduced units.

use crate::model::{ContactLaw, TcRule};
use std::borrow::Cow;
use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::diameters::{Diameters, diameters_of_newcomers, ranges_of_diameters, scaled_distance};
use super::predecessor::LastState;
use super::space::Boundary;
use super::{
    AuditPlan, ExchangePlan, IndividualDiameters, Inlet, InputFile, LivePlan, MassRule, MeasurementPlan, OutputPlan,
    Potential, Predecessor, RunPlan, SceneSurface, Separated, Sleep, Space, SpeciesPairs, StaticSurface, SurfaceLaw,
    Units,
};
use crate::Vector;

/// Index into [`Scene::species`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct SpeciesId(pub u32);

/// Index into [`Scene::interactions`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct InteractionId(pub u32);

impl InteractionId {
    /// Returns the index as a 16-bit number for the event loop. Validation limits the number of interactions.
    pub(crate) fn narrow(self) -> u16 {
        u16::try_from(self.0).unwrap_or(u16::MAX)
    }
}

/// Index into [`Scene::particles`], and the id of the particle in every output.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(transparent)]
pub struct ParticleId(pub u32);

impl From<u32> for ParticleId {
    fn from(id: u32) -> Self {
        Self(id)
    }
}

/// A species: mass, diameter and acceleration of its particles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Species {
    /// Name, unique in the scene.
    pub name: String,
    /// Mass `[mass]`; infinite for a static species.
    pub mass: f64,
    /// Diameter in pictures and at walls `[length]`. Particles touch a wall when their centre is half a diameter away.
    pub diameter: f64,
    /// Constant acceleration, usually gravity `[length / time^2]`; static species are not accelerated.
    pub acceleration: Vector,
    /// Moment of inertia `[mass length^2]`; `None` for a uniform sphere, or for a uniform disk in two dimensions.
    pub moment_of_inertia: Option<f64>,
    /// Set if the particles have individual [diameters](Particle::diameter). The mass, the moment of inertia and the
    /// interactions of the species then apply to particles with the diameter of the species. Distances scale with the
    /// mean diameter of a pair.
    pub individual: Option<IndividualDiameters>,
}

impl Species {
    /// Creates a uniform species without acceleration. An infinite mass makes it static.
    #[must_use]
    pub fn new(name: &str, mass: f64, diameter: f64) -> Self {
        let (acceleration, moment_of_inertia) = (Vector::zeros(), None);
        Self { name: name.to_owned(), mass, diameter, acceleration, moment_of_inertia, individual: None }
    }

    /// Whether particles of this species never move, like a surface or a pivot.
    #[must_use]
    pub fn is_static(&self) -> bool {
        self.mass.is_infinite()
    }

    /// Returns the species with the diameter, mass and moment of inertia of a particle with an individual diameter.
    /// Space has the given number of dimensions. A given moment of inertia is proportional to `m d^2`.
    #[must_use]
    pub fn with_diameter(&self, diameter: f64, dimensions: usize) -> Self {
        let (ratio, mass) = (diameter / self.diameter, self.own_mass(diameter, dimensions));
        let moment_of_inertia = self.moment_of_inertia.map(|moment| moment * (mass / self.mass) * ratio * ratio);
        Self { diameter, mass, moment_of_inertia, ..self.clone() }
    }

    /// Mass of a particle with an individual diameter `[mass]`.
    pub(crate) fn own_mass(&self, diameter: f64, dimensions: usize) -> f64 {
        if self.has_different_masses() {
            mass_by_volume(self.mass, [self.diameter, diameter], dimensions)
        } else {
            self.mass
        }
    }

    /// Whether the masses of the particles follow from their individual diameters.
    #[must_use]
    pub fn has_different_masses(&self) -> bool {
        self.individual.as_ref().is_some_and(|individual| individual.masses == MassRule::Volume)
    }

    /// `1 / mass`, exactly 0 for a static species.
    #[must_use]
    pub fn inverse_mass(&self) -> f64 {
        self.mass.recip()
    }

    /// Inverse moment of inertia `1 / I` in a space of the given number of dimensions `[1 / (mass length^2)]`. A
    /// uniform sphere has `I = 2/5 m R^2`, a uniform disk `I = m R^2 / 2`. The result is 0 for a static species and on
    /// a line, where nothing turns.
    #[must_use]
    pub fn inverse_inertia(&self, dimensions: usize) -> f64 {
        let radius = 0.5 * self.diameter;
        let uniform = match dimensions {
            3 => 0.4,
            2 => 0.5,
            _ => return 0.0,
        };
        if self.is_static() {
            0.0
        } else {
            1.0 / self.moment_of_inertia.unwrap_or(uniform * self.mass * radius * radius)
        }
    }
}

/// A pair interaction: a stepped potential, and the contact law of its infinite barriers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interaction {
    /// The stepped potential.
    pub potential: Potential,
    /// Law of contacts at an infinite barrier.
    pub law: ContactLaw,
    /// Name by which bonds refer to the interaction. Interactions for pairs of different diameters may share a name.
    pub name: Option<String>,
}

/// A bonded pair. Its own interaction replaces the interaction of the species.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Bond {
    /// The two particles, in ascending order.
    pub pair: [ParticleId; 2],
    /// Interaction of the bonded pair.
    pub interaction: InteractionId,
}

/// Initial state of a particle.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Particle {
    /// Species of the particle.
    pub species: SpeciesId,
    /// Position `[length]`. It lies inside the box along periodic axes.
    pub position: Vector,
    /// Velocity `[length / time]`, zero for static particles.
    pub velocity: Vector,
    /// Spin: angular velocity about the centre `[1 / time]`. Only rough contacts change the spin.
    #[doc(alias = "angular velocity")]
    pub spin: Vector,
    /// Individual diameter `[length]`; `None` if the species has one diameter for all particles.
    pub diameter: Option<f64>,
}

impl Particle {
    /// Creates a particle without spin.
    #[must_use]
    pub fn new(species: SpeciesId, position: Vector, velocity: Vector) -> Self {
        Self { species, position, velocity, spin: Vector::zeros(), diameter: None }
    }

    /// Sets the diameter `[length]` of a particle whose species has individual diameters.
    #[must_use]
    pub fn diameter(self, diameter: f64) -> Self {
        Self { diameter: Some(diameter), ..self }
    }

    /// Sets the spin `[1 / time]`.
    #[must_use]
    pub fn spin(self, spin: Vector) -> Self {
        Self { spin, ..self }
    }
}

/// Largest relative difference of two distances that differ only by round-off.
const ROUNDING: f64 = 1e-12;

/// Declares `Scene` and `SceneParts` with the same fields. The fields of `SceneParts` are public. `Scene` has a method
/// for each field, which returns the type after `=>`.
macro_rules! scene {
    ($($(#[$doc:meta])* $field:ident: $type:ty => $view:ident $shown:ty,)*) => {
        /// A validated scene: everything that determines a trajectory, and what to measure and write.
        ///
        /// [`SceneBuilder`](crate::scene::SceneBuilder) creates a scene in code, [`Scene::from_file`] from a file, and
        /// [`Scene::new`] from the modified [`SceneParts`] of another scene. All of them validate the scene.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        pub struct Scene {
            $($(#[$doc])* pub(crate) $field: $type,)*
        }

        /// The parts of a scene, which can be modified. [`Scene::into_parts`] returns them, and [`Scene::new`] creates
        /// a scene from them after validation.
        #[derive(Debug, Clone, PartialEq, Default)]
        #[non_exhaustive]
        pub struct SceneParts {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl Scene {
            $(
                $(#[$doc])*
                #[must_use]
                pub fn $field(&self) -> $shown {
                    scene!($view self.$field)
                }
            )*

            /// Returns the parts of the scene.
            #[must_use]
            pub fn into_parts(self) -> SceneParts {
                let Self { $($field),* } = self;
                SceneParts { $($field),* }
            }

            pub(crate) fn of_parts(parts: SceneParts) -> Self {
                let SceneParts { $($field),* } = parts;
                Self { $($field),* }
            }
        }
    };
    (copy $value:expr) => { $value };
    (lent $value:expr) => { &$value };
    (optional $value:expr) => { $value.as_ref() };
}

scene! {
    /// Name of the scene and of its run folder.
    name: String => lent &str,
    /// Seed of all random numbers.
    seed: u64 => copy u64,
    /// Simulated time at which the scene starts `[time]`.
    start_time: f64 => copy f64,
    /// Names of the units of length, mass and time, for outputs.
    units: Units => lent &Units,
    /// The box.
    space: Space => lent &Space,
    /// The species, at least one. [`SpeciesId`] is an index into this list.
    species: Vec<Species> => lent &[Species],
    /// The interactions of species and bonds. [`InteractionId`] is an index into this list.
    interactions: Vec<Interaction> => lent &[Interaction],
    /// The interaction of each pair of species. Pairs without an interaction pass through each other.
    table: SpeciesPairs<InteractionId> => lent &SpeciesPairs<InteractionId>,
    /// Bonds: pairs of particles with their own interactions.
    bonds: Vec<Bond> => lent &[Bond],
    /// The particles at the start. [`ParticleId`] is an index into this list.
    particles: Vec<Particle> => lent &[Particle],
    /// The surfaces made of static particles.
    static_surfaces: Vec<StaticSurface> => lent &[StaticSurface],
    /// Surfaces with which particles collide, besides the walls of the box.
    surfaces: Vec<SceneSurface> => lent &[SceneSurface],
    /// Places where particles enter during the run.
    inlets: Vec<Inlet> => lent &[Inlet],
    /// Temperatures of the lower and the upper wall of each axis `[energy]`; `None` for a reflecting wall or no wall.
    wall_temperatures: [[Option<f64>; 2]; 3] => copy [[Option<f64>; 2]; 3],
    /// Shear rate `dv_x / dy` of a sheared box `[1 / time]`; `None` for a box at rest.
    shear_rate: Option<f64> => copy Option<f64>,
    /// Initial shift along x of the next periodic image along y `[length]`; 0 unless the box is sheared.
    displacement: f64 => copy f64,
    /// Contact time of the TC model `[time]`; `None` switches the model off.
    contact_time: Option<f64> => copy Option<f64>,
    /// Rule of the TC model for contacts in quick succession.
    tc_rule: TcRule => copy TcRule,
    /// When grains at rest fall asleep; `None` if they never do.
    sleep: Option<Sleep> => copy Option<Sleep>,
    /// Whether overlaps at the start are permitted. The stable rule resolves these overlaps.
    allow_invalid_start: bool => copy bool,
    /// Distance by which particles may be moved at the start to remove overlaps `[length]`; `None` to move no particle.
    separate_overlaps: Option<f64> => copy Option<f64>,
    /// What was moved to remove overlaps.
    separated: Separated => copy Separated,
    /// Limits of the audit of a run.
    audit: AuditPlan => copy AuditPlan,
    /// The stages of the run, and the limit of its measurement.
    run: RunPlan => lent &RunPlan,
    /// Output plan: the files that a run writes.
    output: OutputPlan => lent &OutputPlan,
    /// Measurement plan: the instruments of a run.
    measure: MeasurementPlan => lent &MeasurementPlan,
    /// Replica exchange plan, for [`Exchange`](crate::exchange::Exchange); `None` without replica exchange.
    exchange: Option<ExchangePlan> => optional Option<&ExchangePlan>,
    /// The live page of the scene.
    live: LivePlan => lent &LivePlan,
    /// Files that were read to create the scene, besides the scene file.
    inputs: Vec<InputFile> => lent &[InputFile],
    /// The run from whose last state the scene starts, if any.
    predecessor: Option<Predecessor> => optional Option<&Predecessor>,
}

impl Scene {
    /// Returns the unit of a quantity with the names of [`Scene::units`], see [`Units::of`].
    #[must_use]
    pub fn unit_of(&self, unit: &str) -> String {
        self.units.of(unit, self.space.dimensions())
    }

    /// Index of the first random stream of this scene. Earlier runs have used all lower indices.
    pub(crate) fn first_stream(&self) -> usize {
        self.predecessor.as_ref().map_or(0, |run| run.streams)
    }

    /// Index of the first random stream after this run. A scene that continues from the run starts with this stream.
    #[must_use]
    pub fn next_stream(&self) -> usize {
        self.first_stream() + self.run.streams()
    }

    pub(crate) fn last_state(&self) -> Option<&LastState> {
        self.predecessor.as_ref()?.state.as_deref()
    }

    pub(crate) fn forget_last_state(&mut self) {
        if let Some(run) = &mut self.predecessor {
            run.state = None;
        }
    }

    pub(crate) fn grow(&mut self, factor: f64) {
        self.species.iter_mut().for_each(|species| species.diameter *= factor);
        self.particles.iter_mut().filter_map(|particle| particle.diameter.as_mut()).for_each(|own| *own *= factor);
        self.interactions.iter_mut().for_each(|interaction| interaction.potential.grow(factor));
    }

    /// Whether the scene has a thermostat, growing diameters, gravity in the run plan, a sheared box, a thermal wall,
    /// a thermal or moving surface, an inlet or an outlet.
    #[must_use]
    pub fn is_driven(&self) -> bool {
        self.run.is_driven()
            || self.shear_rate.is_some()
            || self.has_thermal_walls()
            || self.has_moving_surfaces()
            || self.has_flow()
    }

    /// Whether the particles have spins: a contact is rough, or a particle spins at the start.
    #[must_use]
    pub fn has_spins(&self) -> bool {
        self.is_rough() || self.particles.iter().any(|particle| particle.spin != Vector::zeros())
    }

    /// Whether any contact is rough.
    #[must_use]
    pub fn is_rough(&self) -> bool {
        let surfaces = self.surfaces.iter().filter_map(|surface| surface.law.contact());
        let mut laws = self.interactions.iter().map(|interaction| interaction.law).chain(surfaces);
        self.has_rough_walls() || laws.any(|law| law.roughness.is_some())
    }

    pub(crate) fn has_rough_walls(&self) -> bool {
        let mut laws = self.space.boundary.iter().flat_map(Boundary::contact_laws).flatten();
        laws.any(|law| law.roughness.is_some())
    }

    /// Whether particles enter or leave during the run: the scene has an inlet or an outlet.
    #[must_use]
    pub fn has_flow(&self) -> bool {
        !self.inlets.is_empty() || self.surfaces.iter().any(|surface| surface.law == SurfaceLaw::Outlet)
    }

    /// Upper bound for the number of particles in the system in addition to the particles at the start. An inlet
    /// without a known bound counts as 0.
    pub(crate) fn entering(&self) -> f64 {
        let end = self.run.latest_end(self.start_time);
        let of_one = |inlet: &Inlet| {
            let by_time = end.map(|end| ((end.min(inlet.until) - inlet.from) * inlet.rate).max(0.0) + 1.0);
            let limits = [by_time, inlet.count.map(|count| count as f64), inlet.keep.map(|keep| keep as f64)];
            limits.into_iter().flatten().reduce(f64::min).unwrap_or(0.0)
        };
        self.inlets.iter().filter(|inlet| inlet.has_new_particles()).map(of_one).sum()
    }

    /// Species of the new particles that enter. A species occurs once for each inlet that contains it.
    pub(crate) fn entering_species(&self) -> impl Iterator<Item = SpeciesId> + '_ {
        self.inlets.iter().flat_map(Inlet::species)
    }

    /// Number of particles of each species at the start.
    pub(crate) fn population(&self) -> Vec<usize> {
        population_of(&self.particles, self.species.len())
    }

    /// Returns for each species whether the scene has particles of it, at the start or later.
    pub(crate) fn occurring_species(&self) -> Vec<bool> {
        let mut occurs = vec![false; self.species.len()];
        let present = self.particles.iter().map(|particle| particle.species);
        present.chain(self.entering_species()).for_each(|species| occurs[species.0 as usize] = true);
        occurs
    }

    /// Whether any surface, or its material, moves at some time.
    #[must_use]
    pub fn has_moving_surfaces(&self) -> bool {
        self.surfaces.iter().any(|surface| surface.moves() || surface.surface_velocity.is_some())
    }

    /// Whether any wall or other surface has a temperature.
    #[must_use]
    pub fn has_thermal_walls(&self) -> bool {
        self.wall_temperatures.iter().flatten().any(Option::is_some)
            || self.surfaces.iter().any(|surface| surface.law.temperature().is_some())
    }

    /// The fraction of the box that the particles fill.
    #[must_use]
    pub fn packing_fraction(&self) -> f64 {
        let dimensions = self.space.dimensions();
        let volume = |particle: &Particle| own_volume(self.diameter(particle), dimensions);
        self.particles.iter().map(volume).sum::<f64>() / self.space.volume()
    }

    /// Factor by which diameters grow from the start to a packing fraction.
    pub(crate) fn growth_to(&self, packing_fraction: f64) -> f64 {
        libm::pow(packing_fraction / self.packing_fraction(), 1.0 / self.space.dimensions() as f64)
    }

    /// The interaction of two species; `None` if they do not interact.
    #[must_use]
    pub fn interaction_of(&self, a: SpeciesId, b: SpeciesId) -> Option<InteractionId> {
        self.table.get(a.0 as usize, b.0 as usize)
    }

    pub(crate) fn has_loose_bonds(&self) -> bool {
        self.bonds.iter().any(|bond| !self.interactions[bond.interaction.0 as usize].potential.is_bond())
    }

    /// Largest distance `[length]` at which two particles, or a particle and a wall, interact. Bonds are ignored.
    #[must_use]
    pub fn longest_range(&self) -> f64 {
        let sizes = self.diameters_of_species();
        let moving = self.species.iter().zip(&sizes).filter(|(species, _)| !species.is_static());
        moving.map(|(_, sizes)| sizes.largest).fold(self.longest_range_of_pairs(), f64::max)
    }

    /// Largest distance at which two particles interact `[length]`. Bonds are ignored.
    pub(crate) fn longest_range_of_pairs(&self) -> f64 {
        let sizes = self.diameters_of_species();
        let range = |([a, b], id): ([usize; 2], InteractionId)| {
            let range = self.interactions[id.0 as usize].potential.range();
            if !self.has_individual_diameters() {
                return range;
            }
            let sum = |of: &dyn Fn(usize) -> f64| 0.5 * (of(a) + of(b));
            scaled_distance(range, sum(&|k| self.species[k].diameter), sum(&|k| sizes[k].largest))
        };
        self.table.iter().map(range).fold(0.0, f64::max)
    }

    /// Largest distance `[length]` at which uncaptured pairs of two species interact, if the particles have the
    /// diameters of their species; negative if they never interact.
    #[must_use]
    pub fn range(&self, a: SpeciesId, b: SpeciesId) -> f64 {
        let is_static = |id: SpeciesId| self.species[id.0 as usize].is_static();
        match self.interaction_of(a, b) {
            Some(id) if !(is_static(a) && is_static(b)) => self.interactions[id.0 as usize].potential.range(),
            _ => -1.0,
        }
    }

    /// Returns an interaction's potential for two particles, given by their species and radii `[length]`.
    pub(crate) fn potential_between(&self, id: InteractionId, pair: [(SpeciesId, f64); 2]) -> Cow<'_, Potential> {
        potential_for(&self.interactions[id.0 as usize].potential, &self.species, pair)
    }

    /// Returns the potential of a bond between its two particles.
    pub(crate) fn potential_of_bond(&self, bond: &Bond) -> Cow<'_, Potential> {
        self.potential_between(bond.interaction, kinds_of_bond(bond, &self.species, &self.particles))
    }

    /// Like [`Self::range`], for particles of given radii `[length]`.
    pub(crate) fn range_with(&self, (a, of_a): (SpeciesId, f64), (b, of_b): (SpeciesId, f64)) -> f64 {
        let range = self.range(a, b);
        if range < 0.0 || !self.has_individual_diameters() {
            return range;
        }
        let [one, other] = [a, b].map(|id| 0.5 * self.species[id.0 as usize].diameter);
        scaled_distance(range, one + other, of_a + of_b)
    }

    /// Whether any species has individual diameters.
    #[must_use]
    pub fn has_individual_diameters(&self) -> bool {
        self.species.iter().any(|species| species.individual.is_some())
    }

    /// Whether a particle never moves.
    pub(crate) fn is_static(&self, particle: &Particle) -> bool {
        self.species[particle.species.0 as usize].is_static()
    }

    /// The particles at the start that are not static.
    pub(crate) fn moving(&self) -> impl Iterator<Item = &Particle> {
        self.particles.iter().filter(|particle| !self.is_static(particle))
    }

    /// Species of a particle, with the diameter, mass and moment of inertia of the particle.
    pub(crate) fn own_species(&self, particle: &Particle) -> Cow<'_, Species> {
        let species = &self.species[particle.species.0 as usize];
        match particle.diameter {
            Some(diameter) => Cow::Owned(species.with_diameter(diameter, self.space.dimensions())),
            None => Cow::Borrowed(species),
        }
    }

    /// Individual diameter of a particle if it has one, otherwise the diameter of its species `[length]`.
    pub(crate) fn diameter(&self, particle: &Particle) -> f64 {
        particle.diameter.unwrap_or(self.species[particle.species.0 as usize].diameter)
    }

    /// Whether two species touch, or begin to interact, at the mean of their diameters.
    pub(crate) fn is_additive(&self, a: usize, b: usize) -> bool {
        let mean = 0.5 * (self.species[a].diameter + self.species[b].diameter);
        let range = self.table.get(a, b).map_or(0.0, |id| self.interactions[id.0 as usize].potential.range());
        (range / mean - 1.0).abs() < ROUNDING
    }

    /// Mass of a particle `[mass]`; infinite if it is static.
    pub(crate) fn mass(&self, particle: &Particle) -> f64 {
        mass_of(particle, &self.species, self.space.dimensions())
    }

    /// The species of a particle.
    #[must_use]
    pub fn species_of(&self, particle: ParticleId) -> &Species {
        &self.species[self.particles[particle.0 as usize].species.0 as usize]
    }
}

/// Returns a potential for two particles, given by their species and radii `[length]`. `potential` applies to the diameters
/// of the species.
pub(crate) fn potential_for<'p>(
    potential: &'p Potential,
    species: &[Species],
    [(a, of_a), (b, of_b)]: [(SpeciesId, f64); 2],
) -> Cow<'p, Potential> {
    if species.iter().all(|species| species.individual.is_none()) {
        return Cow::Borrowed(potential);
    }
    let [one, other] = [a, b].map(|id| 0.5 * species[id.0 as usize].diameter);
    Cow::Owned(potential.scaled(one + other, of_a + of_b))
}

/// Species and radii of the particles of a bond `[length]`.
pub(crate) fn kinds_of_bond(bond: &Bond, species: &[Species], particles: &[Particle]) -> [(SpeciesId, f64); 2] {
    bond.pair.map(|id| {
        let particle = &particles[id.0 as usize];
        let diameter = particle.diameter.unwrap_or(species[particle.species.0 as usize].diameter);
        (particle.species, 0.5 * diameter)
    })
}

/// Number of particles of each species.
pub(crate) fn population_of(particles: &[Particle], species: usize) -> Vec<usize> {
    let mut population = vec![0; species];
    particles.iter().for_each(|particle| population[particle.species.0 as usize] += 1);
    population
}

/// Mass of a particle in a space of the given number of dimensions `[mass]`; infinite if it is static.
pub(crate) fn mass_of(particle: &Particle, species: &[Species], dimensions: usize) -> f64 {
    let species = &species[particle.species.0 as usize];
    particle.diameter.map_or(species.mass, |diameter| species.own_mass(diameter, dimensions))
}

impl Scene {
    /// Returns the range of diameters of each species. If the diameters are individual, this is the range at the start
    /// and in inlets.
    pub(crate) fn diameters_of_species(&self) -> Vec<Diameters> {
        let own = self.particles.iter().filter_map(|particle| Some((particle.species, particle.diameter?)));
        ranges_of_diameters(&self.species, own.chain(diameters_of_newcomers(&self.species, self.entering_species())))
    }
}

/// Mass of a particle whose mass is proportional to its volume `[mass]`. `mass` applies to the first of two diameters, and
/// the result to the second.
pub(crate) fn mass_by_volume(mass: f64, [from, to]: [f64; 2], dimensions: usize) -> f64 {
    mass * own_volume(to, dimensions) / own_volume(from, dimensions)
}

/// Volume of a sphere, area of a disk or length of a rod with the given diameter, `[length^D]` in `D` dimensions.
pub(crate) fn own_volume(diameter: f64, dimensions: usize) -> f64 {
    match dimensions {
        3 => PI / 6.0 * diameter * diameter * diameter,
        2 => PI / 4.0 * diameter * diameter,
        _ => diameter,
    }
}
