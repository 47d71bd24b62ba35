//! A scene built in code, with the same checks as a scene from a file.

use std::collections::BTreeMap;

use crate::Vector;
use crate::base::numbers::id;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{
    AuditPlan, ExchangePlan, LivePlan, MeasurementPlan, OutputPlan, ParticleId, RunPlan, SceneParts, SpeciesId,
};
use crate::scene::classes::Origins;
use crate::scene::config_path::ConfigPath;
use crate::scene::surface_draft::SurfaceDraft;
use crate::scene::unvalidated::{
    Amount, Arrangement, Chain, Fill, Group, InteractionDraft, Listed, LocatedGroup, Model, SpeciesDraft, SurfaceFill,
    UnvalidatedBond, UnvalidatedStart,
};

/// Builder of a scene. It collects the parts; [`SceneBuilder::build`] validates them and places the
/// particles.
///
/// Ids count from 0 in the order in which particles are added.
///
/// ```
/// use carom::model::potential::Potential;
/// use carom::scene::{Amount, Lattice, SceneBuilder};
///
/// let scene = SceneBuilder::new("fluid")
///     .species("A", 1.0, 1.0)
///     .interaction("A", "A", Potential::hard_sphere(1.0)?, 1.0)
///     .fill(Lattice::FaceCentredCubic, "A", 500, Amount::PackingFraction(0.4))
///     .temperature(1.0)
///     .build()?;
/// assert_eq!(scene.particles().len(), 500);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[must_use = "a builder does nothing until `build`"]
pub struct SceneBuilder {
    /// Parts of the scene known so far. Species, interactions, bonds, particles and the size of the box
    /// follow from the fields below.
    pub(crate) parts: SceneParts,
    /// Size of the box; `None` derives it from the only fill with a count and a density.
    pub(crate) size: Option<Vector>,
    pub(crate) gravity: Vector,
    pub(crate) species: Vec<SpeciesDraft>,
    pub(crate) interactions: Vec<InteractionDraft>,
    pub(crate) groups: Vec<LocatedGroup>,
    /// Number of groups by their table in a scene file.
    pub(crate) entries: BTreeMap<&'static str, usize>,
    /// The id of the next particle; `None` after a group of unknown size.
    pub(crate) next_id: Option<u64>,
    /// The first group whose ids were requested but are unknown.
    pub(crate) unnumbered: Option<ConfigPath>,
    pub(crate) bonds: Vec<UnvalidatedBond>,
    /// Surfaces in addition to the surfaces of the parts.
    pub(crate) surfaces: Vec<SurfaceDraft>,
    pub(crate) has_surfaces: bool,
    /// The run from which the scene starts, instead of groups.
    pub(crate) start: Option<UnvalidatedStart>,
    pub(crate) origins: Origins,
}

/// Declares methods that set one value.
macro_rules! setters {
    ($($(#[$doc:meta])* $method:ident($value:ident: $type:ty) => $($field:ident).+;)*) => {
        $(
            $(#[$doc])*
            pub fn $method(mut self, $value: $type) -> Self {
                self.$($field).+ = $value.into();
                self
            }
        )*
    };
}

impl SceneBuilder {
    /// An empty scene: no gravity, no TC model, periodic along every axis, seed 1.
    pub fn new(name: &str) -> Self {
        Self {
            parts: SceneParts { name: name.to_owned(), seed: 1, ..SceneParts::default() },
            size: None,
            gravity: Vector::zeros(),
            species: Vec::new(),
            interactions: Vec::new(),
            groups: Vec::new(),
            entries: BTreeMap::new(),
            next_id: Some(0),
            unnumbered: None,
            bonds: Vec::new(),
            surfaces: Vec::new(),
            has_surfaces: false,
            start: None,
            origins: Origins::default(),
        }
    }

    /// A builder for a scene with validated species. Interactions, bonds and particles remain parts.
    pub(crate) fn of_parts(parts: SceneParts) -> Self {
        let species = parts.species.iter().map(SpeciesDraft::of).collect();
        Self { size: Some(parts.space.size), species, parts, ..Self::new("") }
    }

    setters! {
        /// The seed of all random numbers.
        seed(seed: u64) => parts.seed;
        /// Simulated time at the start `[time]`.
        start_time(time: f64) => parts.start_time;
        /// Sets whether particles may overlap at the start. The stable rule handles such overlaps.
        allow_invalid_start(allow: bool) => parts.allow_invalid_start;
        /// Boundary conditions of a box whose size follows from a fill.
        boundary(boundary: [Boundary; 3]) => parts.space.boundary;
        /// The acceleration of every moving species that has no acceleration of its own `[length / time^2]`.
        gravity(gravity: Vector) => gravity;
        /// Shears the box: the streaming velocity is `v_x = rate (y - y_middle)`, and images above and below
        /// slide along x `[1 / time]`.
        shear(rate: f64) => parts.shear_rate;
        /// Initial displacement along x of the next image along y in a sheared box `[length]`.
        displacement(displacement: f64) => parts.displacement;
        /// Contact time of the TC model `[time]`. Setting it switches the model on.
        contact_time(time: f64) => parts.contact_time;
        /// Plan of the live page.
        live(live: LivePlan) => parts.live;
        /// Limits of the run's audit.
        audit(audit: AuditPlan) => parts.audit;
        /// The plan of the run.
        run(run: RunPlan) => parts.run;
        /// Output plan.
        output(output: OutputPlan) => parts.output;
        /// Measurement plan.
        measure(plan: MeasurementPlan) => parts.measure;
        /// Replicas at several temperatures with swaps, to be run by [`Exchange`](crate::exchange::Exchange).
        #[doc(alias = "parallel tempering")]
        exchange(plan: ExchangePlan) => parts.exchange;
    }

    /// The box. If no box is set, a periodic cube follows from the only fill with a count and a density.
    pub fn space(mut self, space: Space) -> Self {
        self.size = Some(space.size);
        self.parts.space = space;
        self
    }

    /// Makes both walls of an axis (0, 1, 2) thermal: particles leave them with velocities of this
    /// temperature `[energy]`.
    pub fn wall_temperature(self, axis: usize, temperature: f64) -> Self {
        self.wall_temperatures(axis, [Some(temperature); 2])
    }

    /// Makes the lower and the upper wall of an axis (0, 1, 2) thermal, each with its own temperature
    /// `[energy]`. A wall without a temperature reflects.
    pub fn wall_temperatures(mut self, axis: usize, temperatures: [Option<f64>; 2]) -> Self {
        if let Some(walls) = self.parts.wall_temperatures.get_mut(axis) {
            *walls = temperatures;
        }
        self
    }

    /// Adds a moving species.
    pub fn species(mut self, name: &str, mass: f64, diameter: f64) -> Self {
        self.insert_species(SpeciesDraft::new(name).mass(mass).diameter(diameter));
        self
    }

    /// Adds a species that never moves.
    pub fn static_species(mut self, name: &str, diameter: f64) -> Self {
        self.insert_species(SpeciesDraft::new(name).diameter(diameter).fixed());
        self
    }

    /// Adds a species and returns its id.
    pub fn insert_species(&mut self, species: SpeciesDraft) -> SpeciesId {
        self.species.push(species);
        SpeciesId(id(self.species.len() - 1))
    }

    /// Adds an interaction of two species: a potential and a restitution.
    pub fn interaction(mut self, first: &str, second: &str, potential: Potential, restitution: f64) -> Self {
        self.insert_interaction(InteractionDraft::new(potential).between(first, second).restitution(restitution));
        self
    }

    /// Lets particles of two species pass through each other.
    pub fn no_interaction(mut self, first: &str, second: &str) -> Self {
        self.insert_interaction(InteractionDraft::new(Model::None).between(first, second));
        self
    }

    /// Adds a named interaction for bonds.
    pub fn bond_interaction(mut self, name: &str, potential: Potential, restitution: f64) -> Self {
        self.insert_interaction(InteractionDraft::new(potential).named(name).restitution(restitution));
        self
    }

    /// Adds an interaction of two species, of bonds, or of both.
    pub fn insert_interaction(&mut self, interaction: InteractionDraft) {
        self.interactions.push(interaction);
    }

    /// Adds a surface that particles meet.
    pub fn surface(mut self, surface: SurfaceDraft) -> Self {
        self.insert_surface(surface);
        self
    }

    /// Adds a surface that particles meet.
    pub fn insert_surface(&mut self, surface: SurfaceDraft) {
        self.has_surfaces = true;
        self.surfaces.push(surface);
    }

    /// Adds a particle.
    pub fn particle(mut self, species: &str, position: Vector, velocity: Vector) -> Self {
        self.push("particle", Group::Listed(Listed::one(species, position, velocity)));
        self
    }

    /// Adds a particle and returns its id. [`Self::build`] rejects it after a fill or a surface of unknown
    /// size.
    pub fn insert_particle(&mut self, species: &str, position: Vector, velocity: Vector) -> ParticleId {
        self.insert("particle", Group::Listed(Listed::one(species, position, velocity)))
    }

    /// Adds particles of one species by number and density. The size of the box follows if it is not given.
    pub fn fill(self, arrangement: impl Into<Arrangement>, species: &str, count: u64, amount: Amount) -> Self {
        self.add_fill(Fill::new(arrangement, species).count(count).amount(amount))
    }

    /// Adds many particles.
    pub fn add_fill(mut self, fill: Fill) -> Self {
        self.push("fill", Group::Fill(fill));
        self
    }

    /// Adds many particles and returns the id of the first one. [`Self::build`] rejects the same cases as for
    /// [`Self::insert_particle`].
    pub fn insert_fill(&mut self, fill: Fill) -> ParticleId {
        self.insert("fill", Group::Fill(fill))
    }

    /// Sets Maxwell velocities for all fills and chains added so far that have neither a temperature nor a
    /// speed `[energy]`.
    pub fn temperature(mut self, temperature: f64) -> Self {
        self.at_rest().for_each(|start| *start.0 = Some(temperature));
        self
    }

    /// Sets equal speeds in random directions for all fills and chains added so far that have neither a
    /// temperature nor a speed `[length / time]`.
    ///
    /// Directions are opposite in pairs. If a species has an odd number of particles, three of them have
    /// directions at 120 degrees to each other. Every particle therefore has exactly this speed, and the
    /// momentum is zero. On a line, the last particle of an odd number keeps its momentum.
    pub fn speed(mut self, speed: f64) -> Self {
        self.at_rest().for_each(|start| *start.1 = Some(speed));
        self
    }

    /// Temperature and speed of each fill and chain that has neither.
    fn at_rest(&mut self) -> impl Iterator<Item = (&mut Option<f64>, &mut Option<f64>)> {
        self.groups.iter_mut().filter_map(|placed| match &mut placed.group {
            Group::Fill(Fill { temperature: t @ None, speed: v @ None, .. })
            | Group::Chain(Chain { temperature: t @ None, speed: v @ None, .. }) => Some((t, v)),
            _ => None,
        })
    }

    /// Adds bonded chains.
    pub fn chain(mut self, chain: Chain) -> Self {
        self.push("chain", Group::Chain(chain));
        self
    }

    /// Adds bonded chains and returns the id of the first particle. The others follow chain by chain.
    /// [`Self::build`] rejects the same cases as for [`Self::insert_particle`].
    pub fn insert_chain(&mut self, chain: Chain) -> ParticleId {
        self.insert("chain", Group::Chain(chain))
    }

    /// Adds a surface of static spheres.
    pub fn static_surface(mut self, surface: SurfaceFill) -> Self {
        self.push("mesh", Group::Surface(surface));
        self
    }

    /// Adds a bond between two particles, by a named interaction.
    pub fn bond(mut self, first: u32, second: u32, interaction: &str) -> Self {
        self.insert_bond([first, second].map(ParticleId), interaction);
        self
    }

    /// Adds a bond between two particles, by a named interaction.
    pub fn insert_bond(&mut self, pair: [ParticleId; 2], interaction: &str) {
        let at = ConfigPath::entry("bond", self.bonds.len());
        self.bonds.push(UnvalidatedBond { pair: pair.map(|id| id.0), interaction: interaction.to_owned(), at });
    }

    /// Adds a group of particles, an entry of a table of a scene file. Returns the id of the first one, if
    /// known.
    pub(crate) fn push(&mut self, table: &'static str, group: Group) -> Option<u64> {
        let number = self.entries.entry(table).or_default();
        let at = ConfigPath::entry(table, *number);
        *number += 1;
        self.push_at(at, group)
    }

    /// Adds a group of particles at a config path. Returns the id of the first one, if known.
    pub(crate) fn push_at(&mut self, at: ConfigPath, group: Group) -> Option<u64> {
        let first = self.next_id;
        let count = match &group {
            Group::Listed(listed) => Some(listed.particles.len() as u64),
            Group::Fill(Fill { count: Some(count), as_many_as_fit: false, .. }) => Some(*count),
            Group::Chain(chain) => Some(chain.length.saturating_mul(chain.count)),
            Group::Fill(_) | Group::Surface(_) => None,
        };
        self.next_id = first.zip(count).map(|(first, count)| first.saturating_add(count));
        self.groups.push(LocatedGroup { at, group });
        first
    }

    /// Adds a group of particles and returns the id of the first one.
    fn insert(&mut self, table: &'static str, group: Group) -> ParticleId {
        // If there are more particles than ids, the scene is rejected later.
        let first = self.push(table, group).map(|first| ParticleId(u32::try_from(first).unwrap_or(u32::MAX)));
        if let (None, Some(last)) = (first, self.groups.last()) {
            self.unnumbered.get_or_insert_with(|| last.at.clone());
        }
        first.unwrap_or(ParticleId(u32::MAX))
    }
}

#[cfg(test)]
mod tests;
