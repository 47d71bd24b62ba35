//! A run: stages with rows at even times. The last stage, and others that are measured, have means and frames.
//!
//! A [`Run`] is put together, executed, and leaves what has [`Finished`].

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
    /// Why something could not be kept: ends the run.
    type Error;

    /// Keeps a row of measurements, of any stage of the run.
    ///
    /// # Errors
    /// If it cannot be kept.
    fn row(&mut self, stage: Stage, row: &Row) -> Result<(), Self::Error>;

    /// Keeps the positions and velocities of all particles, and what else is measured of each.
    ///
    /// # Errors
    /// If they cannot be kept.
    fn frame(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), Self::Error>;

    /// Keeps the state of a simulation as it is now, where nothing else is measured of each particle: for recorders that need no memory for a snapshot.
    ///
    /// # Errors
    /// If they cannot be kept.
    fn frame_of(&mut self, simulation: &Simulation) -> Result<(), Self::Error> {
        self.frame(&simulation.snapshot(), Vec::new())
    }

    /// Whether every event of the measurement is shown to [`Recorder::event`].
    fn has_events(&self) -> bool {
        false
    }

    /// Keeps an event.
    ///
    /// # Errors
    /// If it cannot be kept.
    fn event(&mut self, _event: &Event) -> Result<(), Self::Error> {
        Ok(())
    }

    /// Whether no more can be kept: the run is interrupted, after a checkpoint.
    fn is_full(&self) -> bool {
        false
    }

    /// Whether it is time for a checkpoint.
    fn is_checkpoint_due(&self) -> bool {
        false
    }

    /// Keeps all that is needed to [resume](Run::resume) the run from here. Asked for when due, and at the end of the run before its last row and frame.
    ///
    /// # Errors
    /// If it cannot be kept.
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
    /// An instrument of the user has come to what it was to end at: [`Instrument::is_done`].
    Condition,
    /// Nothing will happen any more, as can be shown, and there is no time limit.
    Idle,
    /// There is no time limit, nothing has happened for a million rows or an endless time, and nothing shows that it never will.
    GaveUp,
    /// An equilibration was to end by itself and has no limit, and after very many events something still drifts, or is not known.
    Unsettled,
    /// The caller wanted no more.
    Interrupted,
    /// The dynamics came to rest in a way that needs infinitely many events.
    Arrested(Arrest),
    /// The engine met an impossible state.
    Broken(InvariantBroken),
    /// Spheres that grow cannot become as large as they should.
    Jammed(Jam),
    /// A surface appears where a particle is.
    Blocked(Blocked),
}

impl Ending {
    /// Its word in files.
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

    /// Why it is no good end, in a line; `None` of one that the scene or the caller asks for.
    #[must_use]
    pub fn trouble(&self) -> Option<String> {
        match self {
            Self::Jammed(jam) => Some(jam.to_string()),
            Self::Blocked(blocked) => Some(blocked.to_string()),
            Self::Arrested(arrest) => Some(arrest.to_string()),
            Self::Broken(broken) => Some(broken.to_string()),
            Self::GaveUp => Some("nothing has happened for a million rows, or for a very long time".to_owned()),
            Self::Unsettled => Some("the equilibration did not come to an end by itself".to_owned()),
            Self::Time | Self::Events | Self::Condition | Self::Idle | Self::Interrupted => None,
        }
    }

    /// Whether a run ends there, in whatever stage it is.
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

/// Spheres that jam while they grow, below the packing fraction that they should come to.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "growing spheres jam: {packing_fraction:.4} of the space is filled at time {time}, where the compressibility factor is \
     {compressibility_factor:.0}, and {target:.4} cannot be reached"
)]
#[non_exhaustive]
pub struct Jam {
    /// The part of the space that they fill.
    pub packing_fraction: f64,
    /// The part that they should.
    pub target: f64,
    /// `P V / (N k T)` there, which is infinite where no sphere can move.
    pub compressibility_factor: f64,
    /// When `[time]`.
    pub time: f64,
}

impl Jam {
    /// Cure: what the user can do.
    pub const CURE: &'static str = "lower the packing fraction of the stage, let the spheres grow more slowly, or up to a \
        compressibility_factor, which says when they are close enough to jamming";
}

/// A surface that a stage puts where a particle is.
#[derive(Debug, Clone, PartialEq, Error)]
#[error(
    "surface `{surface}` appears with the stage `{stage}` at time {time}, where particle {} is: it reaches {} through the surface",
    particle.0,
    crate::base::text::digits(*depth)
)]
#[non_exhaustive]
pub struct Blocked {
    /// The particle that is deepest in it.
    pub particle: ParticleId,
    /// Name of the surface.
    pub surface: String,
    /// Name of the stage that it is there from.
    pub stage: String,
    /// How far the particle reaches through it `[length]`.
    pub depth: f64,
    /// When `[time]`.
    pub time: f64,
}

impl Blocked {
    /// Cure: what the user can do.
    pub const CURE: &'static str = "let the surface be there from the start and move into its place, put it where no particle is, or begin its stage when the particles have \
        left";
}

/// Time, events and speed of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MeasurementPeriod {
    /// Simulated time at its start `[time]`.
    pub start: f64,
    /// Simulated time that it took `[time]`.
    pub duration: f64,
    /// Physical events before it, since the start of the simulation.
    pub events_before: u64,
    /// Event counts of the measurement; the deepest overlap is that of the whole run.
    pub event_counts: EventCounts,
    /// Wall time that it took `[seconds]`.
    pub wall_seconds: f64,
}

/// Result of a run.
///
/// Counts, observables and speed are those of the last measurement. The audit spans all stages.
#[derive(Debug)]
#[non_exhaustive]
pub struct Finished {
    /// The simulation as it stands.
    pub simulation: Simulation,
    /// Why it ended.
    pub ending: Ending,
    /// In which stage it ended.
    pub stage: Stage,
    /// The measurement.
    pub measurement: MeasurementPeriod,
    /// Event counts of the measurement, by kind and species.
    pub event_counts_by_species: EventCountsBySpecies,
    /// Means and standard errors by name, only of observables that apply to the scene.
    pub observables: Vec<(&'static str, Estimate)>,
    /// Whether each of them was stationary, by name.
    pub stationarity: Vec<(&'static str, Stationarity)>,
    /// Whether it was in equilibrium, or in a steady state.
    pub equilibrium: Equilibrium,
    /// Results of the instruments, of the scene and of the user: [`Measured::number`], [`Measured::curve`].
    pub measured: Measured,
    /// Volume moves of the barostat of the measurement; `None` without one.
    pub volume_moves: Option<VolumeMoves>,
    /// The measured stages before it, as far as they were begun.
    pub stages: Vec<MeasuredStage>,
    /// Audit of the run.
    pub audit: Audit,
    /// Why it has no more frames, where that is because of what they take on the disk.
    pub frames_limit: Option<&'static str>,
    /// Instruments of the user.
    instruments: OwnInstruments,
}

impl Finished {
    /// Mean of an observable with its standard error, by its name in [`OBSERVABLES`](crate::analysis::observables::OBSERVABLES): `"pressure"`. `None` of what means nothing for the scene.
    /// What an instrument has measured is [`Measured::number`].
    #[must_use]
    pub fn observable(&self, name: &str) -> Option<Estimate> {
        self.observables.iter().find(|(known, _)| *known == name).map(|(_, estimate)| *estimate)
    }

    /// Instrument of the user as the run has left it, by the name under which [`Run::instrument`] has registered it, and by its type. `None` if no instrument has this name
    /// and type, or the last measurement has not begun.
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

    /// Takes the instrument out that [`Self::instrument`] shows; it is not there any more afterwards.
    #[must_use]
    pub fn take_instrument<I: Instrument + 'static>(&mut self, name: &str) -> Option<I> {
        self.instruments.take(name)
    }

    /// Whether it came to an end that the scene asks for, or to that of all events, and its audit has nothing to object to.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        matches!(self.ending, Ending::Time | Ending::Events | Ending::Condition | Ending::Idle)
            && self.audit.faults().is_empty()
    }

    /// Why it is not, in a line; `None` also where it was interrupted, which is no fault of its own.
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

    /// Whether going on with it may lead to such an end.
    #[must_use]
    pub fn can_go_on(&self) -> bool {
        !matches!(self.ending, Ending::Arrested(_) | Ending::Broken(_) | Ending::Jammed(_) | Ending::Blocked(_))
            && self.audit.faults().is_empty()
    }
}
