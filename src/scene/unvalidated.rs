//! The parts of an unvalidated scene, which a [`SceneBuilder`](crate::scene::SceneBuilder) collects.

use std::path::PathBuf;

use crate::Vector;
use crate::model::FillRegion;
use crate::model::Region;
use crate::model::error::PotentialError;
use crate::model::potential::Potential;
use crate::model::{ContactLaw, DiameterDistribution, IndividualDiameters, MassRule, Particle, Restitution, Species};
pub use crate::prepare::lattice::Lattice;
pub use crate::prepare::surface::Surface;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, missing, refuse};

/// Density of a fill: number density or packing fraction.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Amount {
    /// Number of particles per volume `[length^-D]`, where `D` is the number of axes that are not flat.
    NumberDensity(f64),
    /// Total volume of the particles divided by the volume of the region.
    PackingFraction(f64),
}

/// Arrangement of the particles of a [`Fill`]: on a lattice or at random.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Arrangement {
    /// On the sites of a lattice that is stretched to fit the region.
    Lattice(Lattice),
    /// At random places, without overlaps.
    Random,
}

impl From<Lattice> for Arrangement {
    fn from(lattice: Lattice) -> Self {
        Self::Lattice(lattice)
    }
}

/// A fill: many particles in a region, on a lattice or at random.
#[derive(Debug, Clone, PartialEq)]
pub struct Fill {
    /// The species and their shares. The sum of the shares need not be 1.
    pub composition: Vec<(String, f64)>,
    /// Arrangement of the particles: on a lattice or at random.
    pub arrangement: Arrangement,
    /// Number of particles; if `None`, it follows from `amount`.
    pub count: Option<u64>,
    /// Density; if `None`, it follows from `count`.
    pub amount: Option<Amount>,
    /// Whether to place particles one by one at random until no more fit, or until `count` or `amount` is reached.
    pub as_many_as_fit: bool,
    /// Region that contains the particles entirely; the whole box if `None`.
    pub region: Option<FillRegion>,
    /// Temperature of the Maxwell velocities `[energy]`. By default, the scene determines the velocities.
    pub temperature: Option<f64>,
    /// Common speed of all particles, in random directions, instead of Maxwell velocities `[length / time]`.
    pub speed: Option<f64>,
    /// Velocity added to the velocity of every particle `[length / time]`.
    pub velocity: Vector,
}

impl Fill {
    /// Creates a fill of one species.
    #[must_use]
    pub fn new(arrangement: impl Into<Arrangement>, species: &str) -> Self {
        Self {
            composition: vec![(species.to_owned(), 1.0)],
            arrangement: arrangement.into(),
            count: None,
            amount: None,
            as_many_as_fit: false,
            region: None,
            temperature: None,
            speed: None,
            velocity: Vector::zeros(),
        }
    }

    /// Sets the number of particles.
    #[must_use]
    pub fn count(self, count: u64) -> Self {
        Self { count: Some(count), ..self }
    }

    /// Sets the number of particles per volume `[length^-D]`, where `D` is the number of axes that are not flat.
    #[must_use]
    pub fn number_density(self, density: f64) -> Self {
        Self { amount: Some(Amount::NumberDensity(density)), ..self }
    }

    /// Sets the total volume of the particles divided by the volume of the region.
    #[must_use]
    pub fn packing_fraction(self, fraction: f64) -> Self {
        Self { amount: Some(Amount::PackingFraction(fraction)), ..self }
    }

    /// Places particles one by one at random, until no more fit or the number from `count` or `amount` is reached.
    #[must_use]
    pub fn as_many_as_fit(self) -> Self {
        Self { as_many_as_fit: true, ..self }
    }

    /// Restricts the fill to a box.
    #[must_use]
    pub fn region(self, lower: Vector, upper: Vector) -> Self {
        self.inside(FillRegion::Box(Region { lower, upper }))
    }

    /// Restricts the fill to a region: a box, a cylinder, a cone or a sphere.
    #[must_use]
    pub fn inside(self, region: FillRegion) -> Self {
        Self { region: Some(region), ..self }
    }
}

/// Chains of bonded particles.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    /// The species of all particles.
    pub species: String,
    /// Number of particles per chain.
    pub length: u64,
    /// Number of chains.
    pub count: u64,
    /// The name of the interaction that bonds each particle to the next.
    pub bond: String,
    /// Distance between neighbours at the start `[length]`; by default the middle of the range of the bond.
    pub spacing: Option<f64>,
    /// Position of the first particle and direction of a straight chain; `None` for random chains without overlaps.
    pub straight: Option<(Vector, Vector)>,
    /// Temperature of the Maxwell velocities `[energy]`. By default, the scene determines the velocities.
    pub temperature: Option<f64>,
    /// Common speed of all particles, in random directions, instead of Maxwell velocities `[length / time]`.
    pub speed: Option<f64>,
}

/// A surface to be covered with static spheres.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceFill {
    /// Name for messages.
    pub name: Option<String>,
    /// Name of the static species.
    pub species: String,
    /// Shape of the surface.
    pub shape: Surface,
    /// Largest distance between neighbouring spheres `[length]`. By default, no moving particle can pass between them.
    pub spacing: Option<f64>,
}

/// Form of a pair potential, before its diameter is known.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
#[allow(missing_docs, reason = "the constructors of `Potential` explain the fields")]
pub enum Model {
    /// No interaction: particles pass through each other.
    None,
    HardSphere,
    SquareWell {
        lambda: f64,
        well_depth: f64,
    },
    SquareShoulder {
        lambda: f64,
        height: f64,
    },
    Penetrable {
        height: f64,
    },
    /// Bond lengths from the diameter to `lambda` times the diameter.
    Bond {
        lambda: f64,
    },
    SteppedLennardJones {
        well_depth: f64,
        cutoff: f64,
        steps: usize,
        core_energy: f64,
    },
    /// A complete potential.
    Exact(Potential),
}

impl From<Potential> for Model {
    fn from(potential: Potential) -> Self {
        Self::Exact(potential)
    }
}

impl Model {
    /// Whether pairs have a hard core, at which they touch.
    pub(crate) fn has_core(&self) -> bool {
        match self {
            Self::None | Self::Penetrable { .. } => false,
            Self::Exact(potential) => potential.core().is_some(),
            _ => true,
        }
    }

    /// Creates the potential of a pair with this diameter; `None` if particles pass through each other.
    pub(crate) fn potential(&self, diameter: f64) -> Result<Option<Potential>, PotentialError> {
        Ok(Some(match *self {
            Self::None => return Ok(None),
            Self::HardSphere => Potential::hard_sphere(diameter)?,
            Self::SquareWell { lambda, well_depth } => Potential::square_well(diameter, lambda, well_depth)?,
            Self::SquareShoulder { lambda, height } => Potential::square_shoulder(diameter, lambda, height)?,
            Self::Penetrable { height } => Potential::penetrable(diameter, height)?,
            Self::Bond { lambda } => Potential::bond(diameter, lambda * diameter)?,
            Self::SteppedLennardJones { well_depth, cutoff, steps, core_energy } => {
                Potential::stepped_lennard_jones(diameter, well_depth, cutoff, steps, core_energy)?
            }
            Self::Exact(ref potential) => potential.clone(),
        }))
    }
}

/// A species of a [`SceneBuilder`](crate::scene::SceneBuilder), moving or static.
///
/// ```
/// use carom::scene::SpeciesDraft;
///
/// let grain = SpeciesDraft::new("grain").mass(1.3).diameter(0.9);
/// let floor = SpeciesDraft::new("floor").diameter(1.0).fixed();
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct SpeciesDraft {
    pub(crate) name: String,
    pub(crate) mass: Option<f64>,
    pub(crate) diameter: f64,
    pub(crate) is_static: bool,
    /// Acceleration instead of gravity.
    pub(crate) acceleration: Option<Vector>,
    /// Moment of inertia; `None` for a uniform sphere or disk.
    pub(crate) moment_of_inertia: Option<f64>,
    /// Set if the particles have individual diameters.
    pub(crate) individual: Option<IndividualDiameters>,
}

impl SpeciesDraft {
    /// Creates a species without a mass, and with a diameter of zero.
    #[must_use]
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            mass: None,
            diameter: 0.0,
            is_static: false,
            acceleration: None,
            moment_of_inertia: None,
            individual: None,
        }
    }

    /// Sets the mass `[mass]`, which every moving species needs.
    #[must_use]
    pub fn mass(self, mass: f64) -> Self {
        Self { mass: Some(mass), ..self }
    }

    /// Sets the diameter `[length]`, which every species needs.
    #[must_use]
    pub fn diameter(self, diameter: f64) -> Self {
        Self { diameter, ..self }
    }

    /// Sets an acceleration instead of gravity `[length / time^2]`.
    #[must_use]
    pub fn acceleration(self, acceleration: Vector) -> Self {
        Self { acceleration: Some(acceleration), ..self }
    }

    /// Sets the moment of inertia about every axis through the centre `[mass length^2]`. The default is a uniform sphere
    /// of the mass and the diameter, or a uniform disk in two dimensions.
    #[must_use]
    pub fn moment_of_inertia(self, moment: f64) -> Self {
        Self { moment_of_inertia: Some(moment), ..self }
    }

    /// Gives the particles individual diameters, see [`SceneBuilder::sized_particle`] and [`Self::distributed`]. A
    /// particle with the diameter of the species has the mass of the species.
    ///
    /// [`SceneBuilder::sized_particle`]: crate::scene::SceneBuilder::sized_particle
    #[must_use]
    pub fn individual_diameters(self, masses: MassRule) -> Self {
        let distribution = self.individual.and_then(|individual| individual.distribution);
        Self { individual: Some(IndividualDiameters { masses, distribution }), ..self }
    }

    /// Gives the particles individual diameters. In a fill, the diameters have a distribution. The diameter of the
    /// species becomes the mean of the distribution.
    ///
    /// ```
    /// use carom::model::DiameterDistribution;
    /// use carom::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};
    ///
    /// let distribution = DiameterDistribution::Lognormal { mean: 1.0, deviation: 0.2 };
    /// let scene = SceneBuilder::new("beads")
    ///     .species(SpeciesDraft::new("bead").mass(1.0).distributed(distribution))
    ///     .interaction(InteractionDraft::new(Model::HardSphere).between("bead", "bead"))
    ///     .fill(Fill::new(Arrangement::Random, "bead").count(100).packing_fraction(0.2))
    ///     .temperature(1.0)
    ///     .build()?;
    /// let diameters: Vec<f64> = scene.particles().iter().filter_map(|particle| particle.diameter).collect();
    /// assert!((diameters.iter().sum::<f64>() / 100.0 - 1.0).abs() < 1e-12);
    /// assert!((scene.packing_fraction() - 0.2).abs() < 1e-12);
    /// # Ok::<(), carom::scene::SceneError>(())
    /// ```
    #[must_use]
    pub fn distributed(self, distribution: DiameterDistribution) -> Self {
        let masses = self.individual.map_or(MassRule::Volume, |individual| individual.masses);
        let diameter = distribution.mean_of(|diameter| diameter);
        let individual = Some(IndividualDiameters { masses, distribution: Some(distribution) });
        Self { individual, diameter, ..self }
    }

    /// Makes all particles of the species static.
    #[must_use]
    pub fn fixed(self) -> Self {
        Self { is_static: true, ..self }
    }

    pub(crate) fn of(species: &Species) -> Self {
        Self {
            name: species.name.clone(),
            mass: (!species.is_static()).then_some(species.mass),
            diameter: species.diameter,
            is_static: species.is_static(),
            acceleration: Some(species.acceleration),
            moment_of_inertia: species.moment_of_inertia,
            individual: species.individual.clone(),
        }
    }

    /// Mass of a particle with an individual diameter, divided by the mass of the species.
    pub(crate) fn ratio_of_masses(&self, diameter: f64, dimensions: usize) -> f64 {
        let species = Species { individual: self.individual.clone(), ..Species::new("", 1.0, self.diameter) };
        species.own_mass(diameter, dimensions)
    }

    pub(crate) fn check_mass(&self, at: &ConfigPath) -> Result<(), SceneError> {
        match self.mass {
            None if !self.is_static => Err(missing(at, "mass", "every species that moves needs a mass")),
            Some(mass) if self.is_static => refuse(at.key("mass"), mass, "no mass: static = true makes it infinite"),
            _ => match self.moment_of_inertia {
                Some(moment) if self.is_static => {
                    refuse(at.key("moment_of_inertia"), moment, "no moment of inertia: static particles do not turn")
                }
                _ => Ok(()),
            },
        }
    }
}

/// An interaction of a [`SceneBuilder`](crate::scene::SceneBuilder), between two species or in bonds.
///
/// A [`Model`] takes the contact distance from the two species. A [`Potential`] has its own contact distance.
///
/// ```
/// use carom::model::Potential;
/// use carom::scene::{InteractionDraft, Model};
///
/// let grains = InteractionDraft::new(Model::HardSphere).between("grain", "grain").restitution(0.9);
/// let wells = InteractionDraft::new(Model::SquareWell { lambda: 1.5, well_depth: 1.0 }).between("A", "B");
/// let ropes = InteractionDraft::new(Potential::bond(1.0, 1.4)?).named("rope");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct InteractionDraft {
    pub(crate) name: Option<String>,
    pub(crate) species: Option<[String; 2]>,
    pub(crate) model: Model,
    /// Contact distance; if `None`, half the sum of the diameters of the two species.
    pub(crate) diameter: Option<f64>,
    pub(crate) law: ContactLaw,
}

impl InteractionDraft {
    /// Creates an interaction with a restitution of 1 from a potential, or from the form of a potential.
    #[must_use]
    pub fn new(model: impl Into<Model>) -> Self {
        Self { name: None, species: None, model: model.into(), diameter: None, law: ContactLaw::smooth(1.0) }
    }

    /// Applies the interaction to pairs of particles of two species, which may be the same.
    #[must_use]
    pub fn between(self, first: &str, second: &str) -> Self {
        Self { species: Some([first.to_owned(), second.to_owned()]), ..self }
    }

    /// Sets the name by which bonds refer to the interaction.
    #[must_use]
    pub fn named(self, name: &str) -> Self {
        Self { name: Some(name.to_owned()), ..self }
    }

    /// Sets the contact distance, if the model has one `[length]`. The default is the mean diameter of the two species.
    #[must_use]
    pub fn diameter(self, diameter: f64) -> Self {
        Self { diameter: Some(diameter), ..self }
    }

    /// Sets the ratio of the normal speeds after and before a contact with an infinite barrier: a number from 0 to 1, or a
    /// function of the speed.
    #[must_use]
    pub fn restitution(self, restitution: impl Into<Restitution>) -> Self {
        Self { law: ContactLaw { restitution: restitution.into(), ..self.law }, ..self }
    }

    /// Makes the cores rough. Contacts without sliding multiply the tangential velocity of the surfaces by `-b`, where
    /// `b` is the tangential restitution, -1 to 1. Without [`Self::friction`], contacts never slide.
    #[must_use]
    pub fn tangential_restitution(self, restitution: f64) -> Self {
        Self { law: self.law.with_tangential_restitution(restitution), ..self }
    }

    /// Makes the cores rough. The friction coefficient is the largest ratio of the tangential to the normal impulse.
    /// Without [`Self::tangential_restitution`], contacts that do not slide leave the surfaces rolling.
    #[must_use]
    pub fn friction(self, coefficient: f64) -> Self {
        Self { law: self.law.with_friction(coefficient), ..self }
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Listed {
    /// Names of species. A species may have no particles.
    pub names: Vec<String>,
    /// The particles, whose species are indices into `names`.
    pub particles: Vec<Particle>,
    /// Whether the particles come from arrays such as `positions`, rather than from tables or a file.
    pub are_rows: bool,
}

impl Listed {
    pub fn one(species: &str, particle: Particle) -> Self {
        Self { names: vec![species.to_owned()], particles: vec![particle], are_rows: false }
    }

    /// Config path of a value of a particle: a key such as `position`, or a row of an array such as `positions`.
    pub fn place(&self, at: &ConfigPath, keys: [&'static str; 2], row: usize) -> ConfigPath {
        if self.are_rows { at.key(keys[1]).index(row) } else { at.key(keys[0]) }
    }
}

/// A `[[bond]]` before validation, or a bond of a coordinate file.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UnvalidatedBond {
    pub pair: [u32; 2],
    pub interaction: String,
    pub at: ConfigPath,
}

/// A start from the end of an earlier run. Parts that are missing in the scene are taken from the run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct UnvalidatedStart {
    pub from: PathBuf,
    /// Expected checksum of the last checkpoint in `from`; `None` if not set in the scene.
    pub checksum: Option<String>,
    pub has_seed: bool,
    pub has_space: bool,
    pub has_lower: bool,
    pub has_dynamics: bool,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Group {
    Listed(Listed),
    Fill(Fill),
    Chain(Chain),
    Surface(SurfaceFill),
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LocatedGroup {
    pub at: ConfigPath,
    pub group: Group,
}
