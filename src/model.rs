//! Data of a simulation: species, potentials, interactions, the box, the particles, and the plans of a run.
//!
//! Nothing here depends on a file or a key that a user typed; [`Scene`] is what all other layers read.

pub mod barostat;
pub(crate) mod components;
mod energy_weights;
pub mod error;
pub mod exchange_plan;
pub mod input_file;
pub(crate) mod limits;
pub mod live_plan;
pub mod measurement_plan;
pub(crate) mod molecules;
pub mod momentum;
pub mod output_plan;
pub mod potential;
pub mod predecessor;
pub(crate) mod random;
pub mod run_plan;
pub mod scene;
pub mod space;
pub mod species_pairs;
pub(crate) mod state_point;
pub mod static_surface;
pub mod surface;
pub mod surface_motion;
pub mod thermostat;
pub mod threads;
pub mod triangle_mesh;
pub mod umbrella_plan;
pub mod until;

pub use crate::physics::response::ContactLaw;
pub use barostat::{Barostat, BarostatError, VolumeMoves};
pub use energy_weights::EnergyWeights;
pub use error::PotentialError;
pub use exchange_plan::{ExchangeEnsemble, ExchangePlan};
pub use input_file::InputFile;
pub use live_plan::{Colouring, LivePlan, Slider, SliderScale};
pub use measurement_plan::MeasurementPlan;
pub use momentum::Influence;
pub use output_plan::{AuditPlan, CountRegion, CountSpace, Format, OutputPlan, Region};
pub use potential::Potential;
pub use predecessor::Predecessor;
pub use run_plan::{Equilibration, Growth, GrowthTarget, RunPlan, StagePlan};
pub use scene::{Bond, Interaction, InteractionId, Particle, ParticleId, Scene, SceneParts, Species, SpeciesId};
pub use space::Space;
pub use species_pairs::SpeciesPairs;
pub use static_surface::StaticSurface;
pub use surface::{SceneSurface, SurfaceLaw, SurfaceShape};
pub use surface_motion::{MotionKind, SurfaceMotion};
pub use thermostat::{Thermostat, ThermostatError};
pub use threads::Threads;
pub use triangle_mesh::TriangleMesh;
pub use umbrella_plan::UmbrellaPlan;
pub use until::Until;
