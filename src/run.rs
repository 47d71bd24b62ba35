//! Runs of scenes. A run is a series of stages with rows of observables at regular times. Measured stages also have
//! means and frames. [`Run`] executes a scene and returns a [`Finished`] run.

pub mod audit;
mod begin;
mod change;
pub mod checkpoint;
mod driver;
mod forecast;
mod frames;
mod measured_stage;
mod outlook;
mod processes;
mod progress;
mod rate;
mod stage;
mod state;
mod unreached;

pub use begin::{Run, RunError, run};
pub use change::ChangeError;
pub use driver::MOST_EVENTS_PER_PARTICLE;
pub use forecast::{Burden, burdens};
pub(crate) use frames::FrameLimit;
pub use measured_stage::MeasuredStage;
pub use outlook::{NoRate, foreseen_rate};
pub use progress::Progress;
pub(crate) use stage::Settings;
pub use stage::Stage;
pub use state::RunState;
pub use unreached::{Unreached, unreached};

use std::convert::Infallible;

use crate::analysis::instruments::{Instrument, Measured, OwnInstruments, Scalar};
use crate::analysis::observables::{Equilibrium, Row};
use crate::analysis::statistics::{Estimate, Stationarity};
use crate::engine::event::{Event, EventCounts, EventCountsBySpecies};
use crate::engine::{Arrest, EngineError, InvariantBroken, Simulation, Snapshot};
use crate::model::{ParticleId, StageSwaps, VolumeMoves};
use crate::run::audit::Audit;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Receives the rows, frames, events and checkpoints of a run. The recorder `()` discards everything.
pub trait Recorder {
    /// Error of the recorder. An error ends the run.
    type Error;

    /// Records a row: the observables at one time.
    ///
    /// # Errors
    /// If the row cannot be recorded.
    fn row(&mut self, stage: Stage, row: &Row) -> Result<(), Self::Error>;

    /// Records a frame: positions, velocities and additional scalars of all particles.
    ///
    /// # Errors
    /// If the frame cannot be recorded.
    fn frame(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), Self::Error>;

    /// Records the current state of a simulation as a frame, without additional scalars. Override this method to avoid
    /// creating a snapshot.
    ///
    /// # Errors
    /// If the frame cannot be recorded.
    fn frame_of(&mut self, simulation: &Simulation) -> Result<(), Self::Error> {
        self.frame(&simulation.snapshot(), Vec::new())
    }

    /// Whether to call [`Recorder::event`] for every event of the measurement.
    fn has_events(&self) -> bool {
        false
    }

    /// Records an event.
    ///
    /// # Errors
    /// If the event cannot be recorded.
    fn event(&mut self, _event: &Event) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Whether the recorder can store no more data. The run then writes a checkpoint and is interrupted.
    fn is_full(&self) -> bool {
        false
    }

    /// Whether the recorder requests a checkpoint now.
    fn is_checkpoint_due(&self) -> bool {
        false
    }

    /// Records a checkpoint from which the run can be [resumed](Run::resume). This happens when a checkpoint is due,
    /// and before the last row and frame of the run.
    ///
    /// # Errors
    /// If the checkpoint cannot be recorded.
    fn checkpoint(&mut self, _simulation: &Simulation, _course: &RunState) -> Result<(), Self::Error> {
        Ok(())
    }
}

impl Recorder for () {
    type Error = Infallible;

    fn row(&mut self, _stage: Stage, _row: &Row) -> Result<(), Infallible> {
        Ok(())
    }

    fn frame(&mut self, _snapshot: &Snapshot, _scalars: Vec<Scalar>) -> Result<(), Infallible> {
        Ok(())
    }

    fn frame_of(&mut self, _simulation: &Simulation) -> Result<(), Infallible> {
        Ok(())
    }
}

/// Reason for the end of a run.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Ending {
    /// The stage or run reached its limit of simulated time.
    Time,
    /// The stage or run reached its limit of events.
    Events,
    /// A custom instrument reached its end condition: [`Instrument::is_done`].
    Condition,
    /// The run has no time limit, and no further event can occur.
    Idle,
    /// The run has no time limit, and no event has occurred for a million rows or a very long time. Later events are
    /// possible.
    GaveUp,
    /// An automatic equilibration did not end: after very many events, an observable drifts or its drift is unknown.
    Unsettled,
    /// The caller interrupted the run, or the recorder could store no more data.
    Interrupted,
    /// The simulation cannot continue, because of an inelastic collapse or an event storm.
    Arrested(Arrest),
    /// An internal check of the engine failed.
    Broken(InvariantBroken),
    /// Growing spheres cannot reach their target size.
    Jammed(Jam),
    /// A surface appears at a position where it overlaps a particle.
    Blocked(Blocked),
}

impl Ending {
    /// Returns the word that names this ending in output files.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Events => "events",
            Self::Condition => "condition",
            Self::Idle => "idle",
            Self::GaveUp => "gave up",
            Self::Unsettled => "unsettled",
            Self::Interrupted => "interrupted",
            Self::Arrested(_) => "arrested",
            Self::Broken(_) => "broken",
            Self::Jammed(_) => "jammed",
            Self::Blocked(_) => "blocked",
        }
    }

    /// Returns a description of the problem in one line. `None` if the run ended as planned, was interrupted, or has no
    /// further events.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        match self {
            Self::Jammed(jam) => Some(jam.to_string()),
            Self::Blocked(blocked) => Some(blocked.to_string()),
            Self::Arrested(arrest) => Some(arrest.to_string()),
            Self::Broken(broken) => Some(broken.to_string()),
            Self::GaveUp => {
                Some("no event happened during a million rows of output, or for a very long time".to_owned())
            }
            Self::Unsettled => {
                Some("the equilibration did not end: an observable still drifts, or its drift is unknown".to_owned())
            }
            Self::Time | Self::Events | Self::Condition | Self::Idle | Self::Interrupted => None,
        }
    }

    fn is_early(&self) -> bool {
        matches!(
            self,
            Self::Interrupted
                | Self::Arrested(_)
                | Self::Broken(_)
                | Self::Jammed(_)
                | Self::Blocked(_)
                | Self::GaveUp
                | Self::Unsettled
        )
    }
}

impl From<EngineError> for Ending {
    fn from(error: EngineError) -> Self {
        match error {
            EngineError::Arrest(arrest) => Self::Arrested(arrest),
            EngineError::InvariantBroken(broken) => Self::Broken(broken),
        }
    }
}

/// Growing spheres jam below their target packing fraction.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "growing spheres jam: {packing_fraction:.4} of the space is filled at time {time}, where the compressibility factor is \
     {compressibility_factor:.0}, and {target:.4} cannot be reached"
)]
#[non_exhaustive]
pub struct Jam {
    /// Fraction of the space that the spheres fill.
    pub packing_fraction: f64,
    /// Target packing fraction.
    pub target: f64,
    /// Compressibility factor `P V / (N k T)` at this packing fraction; infinite if no sphere can move.
    pub compressibility_factor: f64,
    /// Simulated time `[time]`.
    pub time: f64,
}

impl Jam {
    /// How the user can avoid this error.
    pub const CURE: &'static str = "lower the packing fraction of the stage, let the spheres grow more slowly, or give \
        a compressibility_factor as the target, which is a measure of the distance to jamming";
}

/// A surface that appears at the beginning of a stage and overlaps a particle.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "surface `{surface}` appears with the stage `{stage}` at time {time}, but particle {} is in its way: it extends {} through the surface",
    particle.0,
    crate::base::text::digits(*depth)
)]
#[non_exhaustive]
pub struct Blocked {
    /// The particle that overlaps the surface most deeply.
    pub particle: ParticleId,
    /// Name of the surface.
    pub surface: String,
    /// Name of the stage in which the surface appears.
    pub stage: String,
    /// Depth of the overlap between particle and surface `[length]`.
    pub depth: f64,
    /// Simulated time `[time]`.
    pub time: f64,
}

impl Blocked {
    /// How the user can avoid this error.
    pub const CURE: &'static str = "let the surface exist from the start and move it into place, put it where no \
        particle is, or begin its stage after the particles have left";
}

/// Start, duration, events and wall time of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MeasurementPeriod {
    /// Simulated time at the start of the measurement `[time]`.
    pub start: f64,
    /// Simulated duration `[time]`.
    pub duration: f64,
    /// Number of physical events before the measurement, since the start of the simulation.
    pub events_before: u64,
    /// Event counts of the measurement. The deepest overlap is the deepest of the whole run.
    pub event_counts: EventCounts,
    /// Wall time of the measurement `[seconds]`.
    pub wall_seconds: f64,
}

/// Result of a run.
///
/// Counts, observables and speed refer to the last measurement. The audit spans all stages.
#[derive(Debug)]
#[non_exhaustive]
pub struct Finished {
    /// The simulation in its final state.
    pub simulation: Simulation,
    /// Why the run ended.
    pub ending: Ending,
    /// The stage in which the run ended.
    pub stage: Stage,
    /// The measurement.
    pub measurement: MeasurementPeriod,
    /// Event counts of the measurement, by kind and species.
    pub event_counts_by_species: EventCountsBySpecies,
    /// Mean and standard error of each observable that applies to the scene, by name.
    pub observables: Vec<(&'static str, Estimate)>,
    /// Whether each observable drifted or was stationary, by name.
    pub stationarity: Vec<(&'static str, Stationarity)>,
    /// Whether the system was in equilibrium or a steady state, and reasons to doubt it.
    pub equilibrium: Equilibrium,
    /// Results of the instruments in the scene and of the custom instruments: see [`Measured::number`] and
    /// [`Measured::curve`].
    pub measured: Measured,
    /// Volume moves of the barostat in the measurement; `None` without a barostat.
    pub volume_moves: Option<VolumeMoves>,
    /// Swap moves of each stage that has them.
    pub swaps: Vec<StageSwaps>,
    /// Results of the measured stages before the last measurement, including a stage in which the run ended.
    pub stages: Vec<MeasuredStage>,
    /// Audit of the run: errors of energy and momentum, and overlaps.
    pub audit: Audit,
    /// Why the size on disk limits the number of frames; `None` if it does not.
    pub frames_limit: Option<&'static str>,
    instruments: OwnInstruments,
}

impl Finished {
    /// Returns the mean and standard error of an observable in
    /// [`OBSERVABLES`](crate::analysis::observables::OBSERVABLES), such as `"pressure"`. `None` if the scene does not
    /// have this observable. For instruments, see [`Measured::number`].
    #[must_use]
    pub fn observable(&self, name: &str) -> Option<Estimate> {
        self.observables.iter().find(|(known, _)| *known == name).map(|(_, estimate)| *estimate)
    }

    /// Returns a custom instrument in its final state, by its type and its name in [`Run::instrument`]. `None` if no
    /// instrument has this name and type, or if the last measurement has not begun.
    ///
    /// ```
    /// # use carom::analysis::instruments::{Instrument, Measured, Sample, SystemDescription};
    /// # use carom::engine::event::Event;
    /// # use carom::model::{RunPlan, Until};
    /// # use carom::run::Run;
    /// # use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
    /// # use serde::{Deserialize, Serialize};
    /// #[derive(Clone, Serialize, Deserialize)]
    /// struct Longest {
    ///     from: f64,
    ///     quiet: f64,
    /// }
    ///
    /// impl Instrument for Longest {
    /// #     fn next_sample(&self) -> f64 { f64::INFINITY }
    /// #     fn sample(&mut self, _: &Sample<'_>, _: &SystemDescription) {}
    /// #     fn has_events(&self) -> bool { true }
    /// #     fn report(&self, _: &SystemDescription, _: &mut Measured) {}
    ///     fn event(&mut self, event: &Event, _system: &SystemDescription) {
    ///         self.quiet = self.quiet.max(event.time - self.from);
    ///         self.from = event.time;
    ///     }
    ///     // ...
    /// }
    ///
    /// # let scene = SceneBuilder::new("fluid")
    /// #     .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
    /// #     .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
    /// #     .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(108).packing_fraction(0.3))
    /// #     .temperature(1.0)
    /// #     .run(RunPlan { limit: Until::events(2_000), ..RunPlan::default() })
    /// #     .build()?;
    /// let run = Run::new(scene).instrument("longest", |setup| Longest { from: setup.sample.time, quiet: 0.0 });
    /// let finished = run.finish()?;
    /// let longest = finished.instrument::<Longest>("longest").ok_or("it was measured")?;
    /// assert!(longest.quiet > 0.0 && longest.quiet < finished.measurement.duration);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    #[must_use]
    pub fn instrument<I: Instrument + 'static>(&self, name: &str) -> Option<&I> {
        self.instruments.get(name)
    }

    /// Removes a custom instrument from the run and returns it.
    #[must_use]
    pub fn take_instrument<I: Instrument + 'static>(&mut self, name: &str) -> Option<I> {
        self.instruments.take(name)
    }

    /// Whether the run is complete and the audit found no fault. A run is complete at its planned end, or if no further
    /// event can occur.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        matches!(self.ending, Ending::Time | Ending::Events | Ending::Condition | Ending::Idle)
            && self.audit.faults().is_empty()
    }

    /// Returns why the run is not sound, in one line. `None` if the run is sound, or if it was interrupted and has no
    /// faults.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        let faults: Vec<String> = self.audit.faults().iter().map(ToString::to_string).collect();
        let could_go_on =
            !matches!(self.ending, Ending::Arrested(_) | Ending::Broken(_) | Ending::Jammed(_) | Ending::Blocked(_));
        if could_go_on && !faults.is_empty() {
            return Some(format!("the audit failed: {}", faults.join("; ")));
        }
        match &self.ending {
            Ending::Arrested(arrest) => Some(arrest.told(self.simulation.scene())),
            ending => ending.trouble(),
        }
    }

    /// Whether the run can be continued: no error ended it, and the audit found no fault.
    #[must_use]
    pub fn can_go_on(&self) -> bool {
        !matches!(self.ending, Ending::Arrested(_) | Ending::Broken(_) | Ending::Jammed(_) | Ending::Blocked(_))
            && self.audit.faults().is_empty()
    }
}
