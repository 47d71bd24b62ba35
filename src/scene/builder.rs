//! A scene built in code, with the same checks as one from a file.

use crate::Vector;
use crate::model::MeasurementPlan;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{AuditPlan, ExchangePlan, InputFile, OutputPlan, RunPlan};
use crate::scene::classes::Origins;
use crate::scene::config_path::ConfigPath;
use crate::scene::unvalidated::{
    Amount, Arrangement, Chain, Fill, Group, Listed, LocatedGroup, Model, SurfaceFill, UnvalidatedBond,
    UnvalidatedInteraction, UnvalidatedSpecies, UnvalidatedStart,
};

/// Builder of a scene: collects its parts; [`SceneBuilder::build`] checks them and places the particles.
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
    pub(crate) name: String,
    pub(crate) seed: u64,
    pub(crate) start_time: f64,
    pub(crate) allow_invalid_start: bool,
    /// `None` derives it from the one fill that has a count and a density.
    pub(crate) size: Option<Vector>,
    pub(crate) lower: Vector,
    pub(crate) boundary: [Boundary; 3],
    pub(crate) wall_temperatures: [[Option<f64>; 2]; 3],
    pub(crate) gravity: Vector,
    pub(crate) shear_rate: Option<f64>,
    pub(crate) displacement: f64,
    pub(crate) contact_time: Option<f64>,
    pub(crate) species: Vec<UnvalidatedSpecies>,
    pub(crate) interactions: Vec<UnvalidatedInteraction>,
    pub(crate) groups: Vec<LocatedGroup>,
    /// Groups of one particle that [`Self::particle`] has added: to count them each time takes long where there are many.
    pub(crate) listed: usize,
    pub(crate) bonds: Vec<UnvalidatedBond>,
    pub(crate) audit: AuditPlan,
    pub(crate) run: RunPlan,
    pub(crate) output: OutputPlan,
    pub(crate) measure: MeasurementPlan,
    pub(crate) exchange: Option<ExchangePlan>,
    pub(crate) inputs: Vec<InputFile>,
    /// The run that it starts from, in place of groups.
    pub(crate) start: Option<UnvalidatedStart>,
    pub(crate) origins: Origins,
}

impl SceneBuilder {
    /// An empty scene: no gravity, no TC model, periodic along every axis, seed 1.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            seed: 1,
            start_time: 0.0,
            allow_invalid_start: false,
            size: None,
            lower: Vector::zeros(),
            boundary: [Boundary::Periodic; 3],
            wall_temperatures: [[None; 2]; 3],
            gravity: Vector::zeros(),
            shear_rate: None,
            displacement: 0.0,
            contact_time: None,
            species: Vec::new(),
            interactions: Vec::new(),
            groups: Vec::new(),
            listed: 0,
            bonds: Vec::new(),
            audit: AuditPlan::default(),
            run: RunPlan::default(),
            output: OutputPlan::default(),
            measure: MeasurementPlan::default(),
            exchange: None,
            inputs: Vec::new(),
            start: None,
            origins: Origins::default(),
        }
    }

    /// The seed of all random numbers.
    pub fn seed(mut self, seed: u64) -> Self {
        self.seed = seed;
        self
    }

    /// Simulated time at the start `[time]`.
    pub fn start_time(mut self, time: f64) -> Self {
        self.start_time = time;
        self
    }

    /// Leaves overlaps at the start to the stable rule.
    pub fn allow_invalid_start(mut self, allow: bool) -> Self {
        self.allow_invalid_start = allow;
        self
    }

    /// The box. Without it, a periodic cube follows from the one fill that has a count and a density.
    pub fn space(mut self, space: Space) -> Self {
        self.size = Some(space.size);
        self.lower = space.lower;
        self.boundary = space.boundary;
        self
    }

    /// Boundary conditions of a box whose size follows from a fill.
    pub fn boundary(mut self, boundary: [Boundary; 3]) -> Self {
        self.boundary = boundary;
        self
    }

    /// Makes both walls of an axis (0, 1, 2) thermal: a particle leaves them with a velocity of this temperature `[energy]`.
    pub fn wall_temperature(self, axis: usize, temperature: f64) -> Self {
        self.wall_temperatures(axis, [Some(temperature); 2])
    }

    /// Makes the lower and the upper wall of an axis (0, 1, 2) thermal, each with its own temperature `[energy]`; without one, it reflects.
    pub fn wall_temperatures(mut self, axis: usize, temperatures: [Option<f64>; 2]) -> Self {
        if let Some(walls) = self.wall_temperatures.get_mut(axis) {
            *walls = temperatures;
        }
        self
    }

    /// The acceleration of every species that moves and has none of its own `[length / time^2]`.
    pub fn gravity(mut self, gravity: Vector) -> Self {
        self.gravity = gravity;
        self
    }

    /// Shears the box: `v_x = rate (y - y_middle)` streams, and images above and below slide along x `[1 / time]`.
    pub fn shear(mut self, rate: f64) -> Self {
        self.shear_rate = Some(rate);
        self
    }

    /// How far the next image up of a sheared box is displaced along x at the start `[length]`.
    pub fn displacement(mut self, displacement: f64) -> Self {
        self.displacement = displacement;
        self
    }

    /// Switches the TC model on `[time]`.
    pub fn contact_time(mut self, time: f64) -> Self {
        self.contact_time = Some(time);
        self
    }

    /// When the run's audit fails.
    pub fn audit(mut self, audit: AuditPlan) -> Self {
        self.audit = audit;
        self
    }

    /// A species that moves.
    pub fn species(mut self, name: &str, mass: f64, diameter: f64) -> Self {
        self.species.push(UnvalidatedSpecies { name: name.to_owned(), mass: Some(mass), diameter, acceleration: None });
        self
    }

    /// A species that never moves.
    pub fn static_species(mut self, name: &str, diameter: f64) -> Self {
        self.species.push(UnvalidatedSpecies { name: name.to_owned(), mass: None, diameter, acceleration: None });
        self
    }

    /// Interaction of two species: a potential and a restitution.
    pub fn interaction(mut self, first: &str, second: &str, potential: Potential, restitution: f64) -> Self {
        self.interactions.push(UnvalidatedInteraction {
            name: None,
            species: Some([first.to_owned(), second.to_owned()]),
            model: Model::Exact(potential),
            diameter: None,
            restitution,
        });
        self
    }

    /// Lets particles of two species pass through each other.
    pub fn no_interaction(mut self, first: &str, second: &str) -> Self {
        self.interactions.push(UnvalidatedInteraction {
            name: None,
            species: Some([first.to_owned(), second.to_owned()]),
            model: Model::None,
            diameter: None,
            restitution: 1.0,
        });
        self
    }

    /// An interaction for bonds, by name.
    pub fn bond_interaction(mut self, name: &str, potential: Potential, restitution: f64) -> Self {
        self.interactions.push(UnvalidatedInteraction {
            name: Some(name.to_owned()),
            species: None,
            model: Model::Exact(potential),
            diameter: None,
            restitution,
        });
        self
    }

    /// One particle.
    pub fn particle(mut self, species: &str, position: Vector, velocity: Vector) -> Self {
        let listed = Listed { species: species.to_owned(), position, velocity };
        let at = ConfigPath::entry("particle", self.listed);
        self.listed += 1;
        self.groups.push(LocatedGroup { at, group: Group::Listed(vec![listed]) });
        self
    }

    /// Particles of one species by number and density; the size of the box follows if it is not given.
    pub fn fill(self, arrangement: impl Into<Arrangement>, species: &str, count: u64, amount: Amount) -> Self {
        self.add_fill(Fill::new(arrangement, species).count(count).amount(amount))
    }

    /// Many particles.
    pub fn add_fill(mut self, fill: Fill) -> Self {
        let at = ConfigPath::entry("fill", self.count_groups(|group| matches!(group, Group::Fill(_))));
        self.groups.push(LocatedGroup { at, group: Group::Fill(fill) });
        self
    }

    /// Maxwell velocities for the fills and chains added so far that have neither a temperature nor a speed yet `[energy]`.
    pub fn temperature(mut self, temperature: f64) -> Self {
        for LocatedGroup { group, .. } in &mut self.groups {
            match group {
                Group::Fill(Fill { temperature: t @ None, speed: None, .. })
                | Group::Chain(Chain { temperature: t @ None, speed: None, .. }) => *t = Some(temperature),
                _ => {}
            }
        }
        self
    }

    /// Equal speeds in random directions for the fills and chains added so far that have neither a temperature nor a speed yet
    /// `[length / time]`.
    ///
    /// Directions come in pairs of opposite ones, three at 120 degrees where a species has an odd number, so that each speed is exactly this
    /// one and the momentum is zero; on a line, the last of an odd number keeps its momentum.
    pub fn speed(mut self, speed: f64) -> Self {
        for LocatedGroup { group, .. } in &mut self.groups {
            match group {
                Group::Fill(Fill { temperature: None, speed: v @ None, .. })
                | Group::Chain(Chain { temperature: None, speed: v @ None, .. }) => *v = Some(speed),
                _ => {}
            }
        }
        self
    }

    /// Bonded chains.
    pub fn chain(mut self, chain: Chain) -> Self {
        let at = ConfigPath::entry("chain", self.count_groups(|group| matches!(group, Group::Chain(_))));
        self.groups.push(LocatedGroup { at, group: Group::Chain(chain) });
        self
    }

    /// A surface of static spheres.
    pub fn static_surface(mut self, surface: SurfaceFill) -> Self {
        let at = ConfigPath::entry("mesh", self.count_groups(|group| matches!(group, Group::Surface(_))));
        self.groups.push(LocatedGroup { at, group: Group::Surface(surface) });
        self
    }

    /// A bond between two particles, by a named interaction.
    pub fn bond(mut self, first: u32, second: u32, interaction: &str) -> Self {
        let at = ConfigPath::entry("bond", self.bonds.len());
        self.bonds.push(UnvalidatedBond { pair: [first, second], interaction: interaction.to_owned(), at });
        self
    }

    /// How long to run.
    pub fn run(mut self, run: RunPlan) -> Self {
        self.run = run;
        self
    }

    /// Output plan.
    pub fn output(mut self, output: OutputPlan) -> Self {
        self.output = output;
        self
    }

    /// Measurement plan.
    pub fn measure(mut self, plan: MeasurementPlan) -> Self {
        self.measure = plan;
        self
    }

    /// Replicas at several temperatures, which are swapped: [`Exchange`](crate::exchange::Exchange) runs them.
    #[doc(alias = "parallel tempering")]
    pub fn exchange(mut self, plan: ExchangePlan) -> Self {
        self.exchange = Some(plan);
        self
    }

    fn count_groups(&self, is_counted: impl Fn(&Group) -> bool) -> usize {
        self.groups.iter().filter(|placed| is_counted(&placed.group)).count()
    }
}
