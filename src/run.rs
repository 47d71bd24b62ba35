//! A run: stages with rows at regular times. The last stage, and any other measured stage, also has
//! means and frames.
//!
//! A [`Run`] is set up and executed, and returns a [`Finished`] run.

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
use crate::model::{ParticleId, VolumeMoves};
use crate::run::audit::Audit;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// Recorder of a run: receives its rows, frames, events and checkpoints. `()` keeps nothing.
pub trait Recorder {
    /// Error of the recorder, which ends the run.
    type Error;

    /// Records a row of measurements of any stage of the run.
    ///
    /// # Errors
    /// If the row cannot be recorded.
    fn row(&mut self, stage: Stage, row: &Row) -> Result<(), Self::Error>;

    /// Records the positions and velocities of all particles, and the other scalars measured for each
    /// particle.
    ///
    /// # Errors
    /// If the frame cannot be recorded.
    fn frame(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), Self::Error>;

    /// Records the present state of a simulation, without other scalars of the particles. A recorder can
    /// implement this without memory for a snapshot.
    ///
    /// # Errors
    /// If the frame cannot be recorded.
    fn frame_of(&mut self, simulation: &Simulation) -> Result<(), Self::Error> {
        self.frame(&simulation.snapshot(), Vec::new())
    }

    /// Whether every event of the measurement is passed to [`Recorder::event`].
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

    /// Whether nothing more can be recorded. The run is then interrupted after a checkpoint.
    fn is_full(&self) -> bool {
        false
    }

    /// Whether it is time for a checkpoint.
    fn is_checkpoint_due(&self) -> bool {
        false
    }

    /// Records everything needed to [resume](Run::resume) the run from its present state. This is called when
    /// a checkpoint is due, and at the end of the run before its last row and frame.
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
    /// The simulated time was reached.
    Time,
    /// The number of events was reached.
    Events,
    /// A custom instrument has reached its end condition: [`Instrument::is_done`].
    Condition,
    /// There is no time limit, and it can be shown that nothing will happen any more.
    Idle,
    /// There is no time limit. Nothing has happened for a million rows or a very long time, but it cannot be
    /// shown that nothing ever will.
    GaveUp,
    /// An automatic equilibration without a limit did not end. After very many events an observable still
    /// drifts, or its drift is unknown.
    Unsettled,
    /// The caller ended the run.
    Interrupted,
    /// The dynamics came to rest in a way that requires infinitely many events.
    Arrested(Arrest),
    /// The engine met an impossible state.
    Broken(InvariantBroken),
    /// Growing spheres cannot reach their target size.
    Jammed(Jam),
    /// A surface appears at the position of a particle.
    Blocked(Blocked),
}

impl Ending {
    /// Returns the word for this ending in files.
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

    /// Returns the problem in one line; `None` for an ending that the scene or the caller requests, and for
    /// the end of all events.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        match self {
            Self::Jammed(jam) => Some(jam.to_string()),
            Self::Blocked(blocked) => Some(blocked.to_string()),
            Self::Arrested(arrest) => Some(arrest.to_string()),
            Self::Broken(broken) => Some(broken.to_string()),
            Self::GaveUp => Some("nothing has happened for a million rows, or for a very long time".to_owned()),
            Self::Unsettled => {
                Some("the equilibration reached its limit before the observables were stationary".to_owned())
            }
            Self::Time | Self::Events | Self::Condition | Self::Idle | Self::Interrupted => None,
        }
    }

    /// Whether this ending ends the whole run, in any stage.
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
    /// Suggestion for the user.
    pub const CURE: &'static str = "lower the packing fraction of the stage, let the spheres grow more slowly, or up to a \
        compressibility_factor, which says when they are close enough to jamming";
}

/// A surface that appears in a stage at the position of a particle.
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
    /// Suggestion for the user.
    pub const CURE: &'static str = "let the surface be there from the start and move into its place, put it where no particle is, or begin its stage when the particles have \
        left";
}

/// Time, events and speed of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MeasurementPeriod {
    /// Simulated time at its start `[time]`.
    pub start: f64,
    /// Simulated duration `[time]`.
    pub duration: f64,
    /// Physical events before it, since the start of the simulation.
    pub events_before: u64,
    /// Event counts of the measurement, except for the deepest overlap, which is the deepest of the whole
    /// run.
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
    /// Means and standard errors by name, only of the observables that apply to the scene.
    pub observables: Vec<(&'static str, Estimate)>,
    /// Whether each observable was stationary, by name.
    pub stationarity: Vec<(&'static str, Stationarity)>,
    /// Whether the system was in equilibrium, or in a steady state.
    pub equilibrium: Equilibrium,
    /// Results of the scene's instruments and of the custom instruments: [`Measured::number`],
    /// [`Measured::curve`].
    pub measured: Measured,
    /// Volume moves of the barostat in the measurement; `None` without a barostat.
    pub volume_moves: Option<VolumeMoves>,
    /// The measured stages before the last measurement that have begun.
    pub stages: Vec<MeasuredStage>,
    /// Audit of the run.
    pub audit: Audit,
    /// Why there are no more frames, if their size on disk limits their number.
    pub frames_limit: Option<&'static str>,
    /// The custom instruments.
    instruments: OwnInstruments,
}

impl Finished {
    /// Returns the mean of an observable with its standard error, by its name in
    /// [`OBSERVABLES`](crate::analysis::observables::OBSERVABLES), such as `"pressure"`. `None` if the
    /// observable does not apply to the scene. [`Measured::number`] returns the results of instruments.
    #[must_use]
    pub fn observable(&self, name: &str) -> Option<Estimate> {
        self.observables.iter().find(|(known, _)| *known == name).map(|(_, estimate)| *estimate)
    }

    /// Returns a custom instrument in its final state, by its type and the name under which
    /// [`Run::instrument`] registered it. `None` if no instrument has this name and type, or if the last
    /// measurement has not begun.
    ///
    /// ```
    /// # use carom::analysis::instruments::{Instrument, Measured, Sample, SystemDescription};
    /// # use carom::engine::event::Event;
    /// # use carom::model::{Limit, Potential, RunPlan};
    /// # use carom::run::Run;
    /// # use carom::scene::{Amount, Lattice, SceneBuilder};
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
    /// #     .species("sphere", 1.0, 1.0)
    /// #     .interaction("sphere", "sphere", Potential::hard_sphere(1.0)?, 1.0)
    /// #     .fill(Lattice::FaceCentredCubic, "sphere", 108, Amount::PackingFraction(0.3))
    /// #     .temperature(1.0)
    /// #     .run(RunPlan { limit: Limit::events(2_000), ..RunPlan::default() })
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

    /// Removes a custom instrument from the run and returns it, as [`Self::instrument`] does by reference.
    #[must_use]
    pub fn take_instrument<I: Instrument + 'static>(&mut self, name: &str) -> Option<I> {
        self.instruments.take(name)
    }

    /// Whether the run reached an end that the scene requests, or the end of all events, and the audit found
    /// no fault.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        matches!(self.ending, Ending::Time | Ending::Events | Ending::Condition | Ending::Idle)
            && self.audit.faults().is_empty()
    }

    /// Returns why the run is not sound, in one line. `None` for a sound run, and for an interrupted run
    /// without faults.
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

    /// Whether the run may reach a sound end if it continues.
    #[must_use]
    pub fn can_go_on(&self) -> bool {
        !matches!(self.ending, Ending::Arrested(_) | Ending::Broken(_) | Ending::Jammed(_) | Ending::Blocked(_))
            && self.audit.faults().is_empty()
    }
}
