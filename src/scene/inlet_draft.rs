//! Inlets of a scene before validation.

use crate::Vector;
use crate::model::FillRegion;

/// An inlet: a region in which particles enter during the run.
///
/// ```
/// use carom::Vector;
/// use carom::engine::{Simulation, Until};
/// use carom::model::space::{Boundary, Space};
/// use carom::model::{FillRegion, Region, SurfaceShape};
/// use carom::scene::{InletDraft, InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
///
/// let above = Region { lower: Vector::new(0.0, 0.0, 17.0), upper: Vector::new(20.0, 20.0, 19.0) };
/// let floor = SurfaceShape::Plane { point: Vector::new(0.0, 0.0, 1.0), normal: Vector::z() };
/// let boundary = [Boundary::Periodic, Boundary::Periodic, Boundary::OPEN];
/// let scene = SceneBuilder::new("rain")
///     .space(Space { boundary, ..Space::periodic_cube(20.0) })
///     .species(SpeciesDraft::new("drop").mass(1.0).diameter(1.0))
///     .interaction(InteractionDraft::new(Model::HardSphere).between("drop", "drop"))
///     .inlet(InletDraft::new("cloud", FillRegion::Box(above)).species("drop").rate(2.0).velocity(-Vector::z()))
///     .surface(SurfaceDraft::new("ground", floor).outlet())
///     .build()?;
/// let mut simulation = Simulation::new(scene)?;
/// simulation.advance(Until::time(100.0))?;
/// let counts = simulation.event_counts();
/// assert_eq!(counts.entry, 201);
/// assert_eq!(simulation.snapshot().ids.len() as u64, counts.entry - counts.exit);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct InletDraft {
    pub(crate) name: String,
    /// Names of species, and their relative numbers.
    pub(crate) composition: Vec<(String, f64)>,
    pub(crate) region: FillRegion,
    pub(crate) rate: Option<Rate>,
    pub(crate) velocity: Vector,
    pub(crate) temperature: f64,
    /// Stage of the run from whose beginning the times count. Without a stage, they are simulated times.
    pub(crate) stage: Option<String>,
    pub(crate) from: Option<f64>,
    pub(crate) until: Option<f64>,
    pub(crate) count: Option<u64>,
    pub(crate) keep: Option<u64>,
    /// Names of the outlets whose particles return.
    pub(crate) recirculate: Vec<String>,
}

/// What is expected of an inlet without a rate.
pub(crate) const RATE: &str = "give it, or mass_rate, or `recirculate` with the outlets whose particles return";

/// How much enters per time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rate {
    /// Particles per time `[1 / time]`.
    Number(f64),
    /// Mass per time `[mass / time]`.
    Mass(f64),
}

impl InletDraft {
    /// Creates an inlet. It needs a species and a rate, or an outlet whose particles return.
    #[must_use]
    pub fn new(name: &str, region: FillRegion) -> Self {
        Self {
            name: name.to_owned(),
            composition: Vec::new(),
            region,
            rate: None,
            velocity: Vector::zeros(),
            temperature: 0.0,
            stage: None,
            from: None,
            until: None,
            count: None,
            keep: None,
            recirculate: Vec::new(),
        }
    }

    /// Adds a species.
    #[must_use]
    pub fn species(self, species: &str) -> Self {
        self.share(species, 1.0)
    }

    /// Adds a species with a relative number of particles.
    #[must_use]
    pub fn share(mut self, species: &str, share: f64) -> Self {
        self.composition.push((species.to_owned(), share));
        self
    }

    /// Sets the number of new particles per time `[1 / time]`.
    #[must_use]
    pub fn rate(self, rate: f64) -> Self {
        Self { rate: Some(Rate::Number(rate)), ..self }
    }

    /// Sets the mean mass of the new particles per time `[mass / time]`.
    #[must_use]
    pub fn mass_rate(self, rate: f64) -> Self {
        Self { rate: Some(Rate::Mass(rate)), ..self }
    }

    /// Sets the mean velocity of the particles `[length / time]`.
    #[must_use]
    pub fn velocity(self, velocity: Vector) -> Self {
        Self { velocity, ..self }
    }

    /// Sets the temperature of the Maxwell velocities that are added to the mean velocity `[energy]`.
    #[must_use]
    pub fn temperature(self, temperature: f64) -> Self {
        Self { temperature, ..self }
    }

    /// Sets the time at which the first new particle is due `[time]`; the start of the scene if not set.
    #[must_use]
    pub fn from(self, time: f64) -> Self {
        Self { from: Some(time), ..self }
    }

    /// Sets the time after which no new particle is due `[time]`.
    #[must_use]
    pub fn until(self, time: f64) -> Self {
        Self { until: Some(time), ..self }
    }

    /// Lets the times of the inlet count from the beginning of a stage. All earlier stages must have a given duration.
    #[must_use]
    pub fn in_stage(self, stage: &str) -> Self {
        Self { stage: Some(stage.to_owned()), ..self }
    }

    /// Limits the number of new particles that enter in all.
    #[must_use]
    pub fn count(self, count: u64) -> Self {
        Self { count: Some(count), ..self }
    }

    /// Lets particles enter only while there are fewer moving particles than this in the system.
    #[must_use]
    pub fn keep(self, keep: u64) -> Self {
        Self { keep: Some(keep), ..self }
    }

    /// Adds an outlet, by its name, whose particles return at this inlet.
    #[must_use]
    pub fn recirculate(mut self, outlet: &str) -> Self {
        self.recirculate.push(outlet.to_owned());
        self
    }
}
