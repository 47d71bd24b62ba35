//! Builds a scene in code, with the same checks as for a scene from a file.

use std::collections::BTreeMap;

use crate::Vector;
use crate::base::numbers::id;
use crate::model::space::{Boundary, Space};
use crate::model::{
    AuditPlan, ExchangePlan, LivePlan, MeasurementPlan, OutputPlan, Particle, ParticleId, RunPlan, SceneParts, Sleep,
    SpeciesId, TcRule, Units,
};
use crate::scene::classes::Origins;
use crate::scene::config_path::ConfigPath;
use crate::scene::inlet_draft::InletDraft;
use crate::scene::surface_draft::SurfaceDraft;
use crate::scene::unvalidated::{
    Chain, Fill, Group, InteractionDraft, Listed, LocatedGroup, SpeciesDraft, SurfaceFill, UnvalidatedBond,
    UnvalidatedStart,
};

/// Collects the parts of a scene. [`SceneBuilder::build`] validates the parts and places the particles.
///
/// Methods may be called in any order. Methods named `insert_...` return the id of the new part. Ids of species or
/// particles count from 0 in the order of insertion.
///
/// ```
/// use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
///
/// let scene = SceneBuilder::new("fluid")
///     .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
///     .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
///     .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.4))
///     .temperature(1.0)
///     .build()?;
/// assert_eq!(scene.particles().len(), 500);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[must_use = "a builder does nothing until `build`"]
pub struct SceneBuilder {
    /// Parts that are set directly. The other fields determine the species, interactions, bonds, particles and box
    /// size.
    pub(crate) parts: SceneParts,
    /// Size of the box; `None` if it follows from the only fill with a count and a density.
    pub(crate) size: Option<Vector>,
    pub(crate) gravity: Vector,
    /// Default temperature of fills and chains without temperature and speed.
    pub(crate) temperature: Option<f64>,
    /// Default speed of fills and chains without temperature and speed.
    pub(crate) speed: Option<f64>,
    pub(crate) species: Vec<SpeciesDraft>,
    pub(crate) interactions: Vec<InteractionDraft>,
    pub(crate) groups: Vec<LocatedGroup>,
    /// Number of groups in each table of a scene file, such as `particle` or `fill`.
    pub(crate) entries: BTreeMap<&'static str, usize>,
    /// Id of the next particle; `None` after a group of unknown size.
    pub(crate) next_id: Option<u64>,
    /// First group whose ids were requested after a group of unknown size. Such a scene is rejected.
    pub(crate) unnumbered: Option<ConfigPath>,
    pub(crate) bonds: Vec<UnvalidatedBond>,
    /// Surfaces besides the surfaces in `parts`.
    pub(crate) surfaces: Vec<SurfaceDraft>,
    pub(crate) has_surfaces: bool,
    /// Inlets besides the inlets in `parts`.
    pub(crate) inlets: Vec<InletDraft>,
    /// Earlier run whose last state replaces the groups of particles.
    pub(crate) start: Option<UnvalidatedStart>,
    pub(crate) origins: Origins,
}

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
    /// Creates a builder of an empty scene: no gravity, no TC model, periodic along every axis, seed 1.
    pub fn new(name: &str) -> Self {
        Self {
            parts: SceneParts { name: name.to_owned(), seed: 1, ..SceneParts::default() },
            size: None,
            gravity: Vector::zeros(),
            temperature: None,
            speed: None,
            species: Vec::new(),
            interactions: Vec::new(),
            groups: Vec::new(),
            entries: BTreeMap::new(),
            next_id: Some(0),
            unnumbered: None,
            bonds: Vec::new(),
            surfaces: Vec::new(),
            has_surfaces: false,
            inlets: Vec::new(),
            start: None,
            origins: Origins::default(),
        }
    }

    pub(crate) fn of_parts(parts: SceneParts) -> Self {
        let species = parts.species.iter().map(SpeciesDraft::of).collect();
        Self { size: Some(parts.space.size), species, parts, ..Self::new("") }
    }

    setters! {
        /// Sets the seed of all random numbers.
        seed(seed: u64) => parts.seed;
        /// Sets the simulated time at the start `[time]`.
        start_time(time: f64) => parts.start_time;
        /// Sets whether particles may overlap at the start. Overlaps never grow deeper, and disappear unless gravity or
        /// wells hold the particles together.
        allow_invalid_start(allow: bool) => parts.allow_invalid_start;
        /// Sets the distance by which particles may be moved at the start to remove overlaps `[length]`.
        separate_overlaps(limit: f64) => parts.separate_overlaps;
        /// Sets the names of the units of length, mass and time, for outputs.
        units(units: Units) => parts.units;
        /// Sets the boundary conditions of a box whose size follows from a fill.
        boundary(boundary: [Boundary; 3]) => parts.space.boundary;
        /// Sets the gravity `[length / time^2]`: the acceleration of all moving species without an acceleration of
        /// their own.
        gravity(gravity: Vector) => gravity;
        /// Sets the shear rate of the box `[1 / time]`. The streaming velocity is `v_x = rate (y - y_middle)`, and the
        /// periodic images above and below slide along x.
        shear(rate: f64) => parts.shear_rate;
        /// Sets the initial displacement along x of the periodic image above a sheared box `[length]`.
        displacement(displacement: f64) => parts.displacement;
        /// Switches the TC model on and sets its contact time `[time]`.
        contact_time(time: f64) => parts.contact_time;
        /// Sets the rule of the TC model for contacts in quick succession.
        tc_rule(rule: TcRule) => parts.tc_rule;
        /// Lets grains at rest fall asleep, so that they cost no events. Needs the TC model.
        sleep(sleep: Sleep) => parts.sleep;
        /// Sets the temperature `[energy]` of all fills and chains without temperature and speed.
        temperature(temperature: f64) => temperature;
        /// Sets the speed `[length / time]` of all particles in fills and chains without temperature and speed.
        /// Directions are random.
        ///
        /// Particles of a species move in pairs in opposite directions. In a species with an odd number of particles,
        /// three particles move at 120 degrees to each other. The total momentum is therefore zero. A particle without
        /// partners keeps its momentum: the only particle of a species, or the odd particle in one dimension.
        speed(speed: f64) => speed;
        /// Sets what the live page shows during a run.
        live(live: LivePlan) => parts.live;
        /// Sets the largest errors that the audit of a run accepts.
        audit(audit: AuditPlan) => parts.audit;
        /// Sets the stages, limits and thermostats of the run.
        run(run: RunPlan) => parts.run;
        /// Sets the output of the run.
        output(output: OutputPlan) => parts.output;
        /// Sets the measurements.
        measure(plan: MeasurementPlan) => parts.measure;
        /// Plans a replica exchange at several temperatures, which [`Exchange`](crate::exchange::Exchange) runs.
        #[doc(alias = "parallel tempering")]
        exchange(plan: ExchangePlan) => parts.exchange;
    }

    /// Sets the box. Without a box, the only fill with a count and a density determines a periodic cube.
    pub fn space(mut self, space: Space) -> Self {
        self.size = Some(space.size);
        self.parts.space = space;
        self
    }

    /// Makes both walls of an axis (0, 1, 2) thermal, with a common temperature `[energy]`.
    pub fn wall_temperature(self, axis: usize, temperature: f64) -> Self {
        self.wall_temperatures(axis, [Some(temperature); 2])
    }

    /// Sets the temperatures of the lower and the upper wall of an axis (0, 1, 2) `[energy]`. A wall without a
    /// temperature reflects particles.
    pub fn wall_temperatures(mut self, axis: usize, temperatures: [Option<f64>; 2]) -> Self {
        if let Some(walls) = self.parts.wall_temperatures.get_mut(axis) {
            *walls = temperatures;
        }
        self
    }

    /// Adds a species.
    pub fn species(mut self, species: SpeciesDraft) -> Self {
        self.insert_species(species);
        self
    }

    /// Adds a species and returns its id.
    pub fn insert_species(&mut self, species: SpeciesDraft) -> SpeciesId {
        self.species.push(species);
        SpeciesId(id(self.species.len() - 1))
    }

    /// Adds an interaction between species or in bonds.
    pub fn interaction(mut self, interaction: InteractionDraft) -> Self {
        self.interactions.push(interaction);
        self
    }

    /// Adds a surface that is a boundary for particles.
    pub fn surface(mut self, surface: SurfaceDraft) -> Self {
        self.has_surfaces = true;
        self.surfaces.push(surface);
        self
    }

    /// Adds an inlet, where particles enter during the run.
    pub fn inlet(mut self, inlet: InletDraft) -> Self {
        self.inlets.push(inlet);
        self
    }

    /// Adds a particle.
    pub fn particle(mut self, species: &str, position: Vector, velocity: Vector) -> Self {
        self.push("particle", Group::Listed(Listed::one(species, Particle::new(SpeciesId(0), position, velocity))));
        self
    }

    /// Adds a particle with a spin, the angular velocity about its centre `[1 / time]`.
    pub fn spinning_particle(mut self, species: &str, position: Vector, velocity: Vector, spin: Vector) -> Self {
        self.push(
            "particle",
            Group::Listed(Listed::one(species, Particle::new(SpeciesId(0), position, velocity).spin(spin))),
        );
        self
    }

    /// Adds a particle with an individual diameter `[length]`. Its species must have
    /// [individual diameters](SpeciesDraft::individual_diameters).
    pub fn sized_particle(mut self, species: &str, diameter: f64, position: Vector, velocity: Vector) -> Self {
        let particle = Particle::new(SpeciesId(0), position, velocity).diameter(diameter);
        self.push("particle", Group::Listed(Listed::one(species, particle)));
        self
    }

    /// Adds a particle and returns its id. After a fill or surface with an unknown number of particles, the id is
    /// unknown, and [`Self::build`] returns an error.
    pub fn insert_particle(&mut self, species: &str, position: Vector, velocity: Vector) -> ParticleId {
        self.insert("particle", Group::Listed(Listed::one(species, Particle::new(SpeciesId(0), position, velocity))))
    }

    /// Adds many particles. Without a box, the count and the density of the only fill determine the box.
    pub fn fill(mut self, fill: Fill) -> Self {
        self.push("fill", Group::Fill(fill));
        self
    }

    /// Returns the temperature and the speed of a fill or chain, or else the defaults of the scene.
    pub(crate) fn motion(&self, own: (Option<f64>, Option<f64>)) -> (Option<f64>, Option<f64>) {
        if own == (None, None) { (self.temperature, self.speed) } else { own }
    }

    /// Adds bonded chains.
    pub fn chain(mut self, chain: Chain) -> Self {
        self.push("chain", Group::Chain(chain));
        self
    }

    /// Adds bonded chains and returns the id of the first particle. The other ids follow chain by chain.
    /// [`Self::build`] returns the same error as for [`Self::insert_particle`].
    pub fn insert_chain(&mut self, chain: Chain) -> ParticleId {
        self.insert("chain", Group::Chain(chain))
    }

    /// Adds a surface that consists of static spheres.
    pub fn static_surface(mut self, surface: SurfaceFill) -> Self {
        self.push("mesh", Group::Surface(surface));
        self
    }

    /// Adds a bond between two particles, with a named interaction.
    pub fn bond(mut self, pair: [impl Into<ParticleId>; 2], interaction: &str) -> Self {
        let at = ConfigPath::entry("bond", self.bonds.len());
        let pair = pair.map(|id| id.into().0);
        self.bonds.push(UnvalidatedBond { pair, interaction: interaction.to_owned(), at });
        self
    }

    /// Adds a group of particles. Returns the id of the first particle, if it is known.
    pub(crate) fn push(&mut self, table: &'static str, group: Group) -> Option<u64> {
        let number = self.entries.entry(table).or_default();
        let at = ConfigPath::entry(table, *number);
        *number += 1;
        self.push_at(at, group)
    }

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

    fn insert(&mut self, table: &'static str, group: Group) -> ParticleId {
        // If there are more particles than ids, the validation rejects the scene.
        let first = self.push(table, group).map(|first| ParticleId(u32::try_from(first).unwrap_or(u32::MAX)));
        if let (None, Some(last)) = (first, self.groups.last()) {
            self.unnumbered.get_or_insert_with(|| last.at.clone());
        }
        first.unwrap_or(ParticleId(u32::MAX))
    }
}

#[cfg(test)]
mod tests;
