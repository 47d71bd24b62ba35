//! Event-driven simulations of scenes.

/// Evaluates an expression for the engine of a simulation, which has one of four types.
macro_rules! with_engine {
    ($simulation:expr, $engine:ident => $body:expr) => {
        match $simulation {
            Chosen::FreeHard($engine) => $body,
            Chosen::FreeTable($engine) => $body,
            Chosen::FallingHard($engine) => $body,
            Chosen::FallingTable($engine) => $body,
        }
    };
}

mod arrange;
mod array;
mod audit;
mod build;
mod clock;
mod columns;
pub(crate) mod communicator;
mod confinement;
mod contact;
mod distances;
mod domains;
mod drive;
mod error;
pub mod event;
mod event_loop;
mod hardware;
mod idle;
mod images;
mod indices;
mod ledger;
mod look_ahead;
mod marks;
mod neighbours;
mod observe;
mod order;
pub(crate) mod pairs;
mod parts;
mod population;
mod predict;
mod prediction;
mod progress;
mod schedule;
mod set_state;
mod single_thread;
mod sizes;
mod slabs;
mod snapshot;
mod sources;
mod start;
mod state;
mod states;
pub(crate) mod surfaces;
mod swap;
mod threads;
mod undo_log;
mod volume_move;

use crate::engine::event::{Event, EventCounts, EventCountsBySpecies};
pub use crate::model::Until;
use crate::model::{ParticleId, Scene, Threads};
use neighbours::ranges::Ranges;
use observe::Observe;
use pairs::rows::Rows;
use parts::Engine;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

pub use audit::Overlap;
pub use communicator::Communicator;
pub use domains::DomainWork;
pub use error::{Arrest, EngineError, Invariant, InvariantBroken, Standstill};
pub use neighbours::Search;
pub(crate) use neighbours::cell_list::CellList;
pub use observe::{EventSequence, ObserverResult};
pub use set_state::{PairStates, SetStateError};
pub use single_thread::SingleThread;
pub use slabs::ThreadWork;
pub use snapshot::{Energy, ParticleNow, Snapshot};
pub use sources::inlet::InletCounts;
pub use start::NeedsRun;
pub use states::{Elapsed, States};
pub(crate) use volume_move::Scaling;

/// The reason why an advance ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The time limit was reached.
    Time,
    /// The limit on the number of events was reached.
    Events,
    /// No time limit was given, and no further event is expected.
    ///
    /// Usually this is proved: no particle will reach a surface, and no two particles will meet. If it is not proved,
    /// no event is predicted, but round-off may hide events after a very long flight.
    Idle,
    /// The observer returned [`std::ops::ControlFlow::Break`]. The simulation is at the last event that was
    /// passed to the observer.
    Observer,
}

/// The engine for a scene. It is chosen once, at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EngineChoice {
    /// Whether particles accelerate, so that their trajectories are parabolas.
    pub is_falling: bool,
    /// Whether the engine has a table of potentials. Without a table, the scene has a single species of hard spheres.
    pub has_table: bool,
    /// Method of the neighbour search at the start. During a run it changes with the density.
    pub search: Search,
    /// Number of levels of the neighbour lists at the start. Particles of similar size share a level.
    pub levels: usize,
}

impl EngineChoice {
    /// Chooses the engine for a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let is_falling = scene.accelerations().any(|acceleration| acceleration.iter().any(|a| *a != 0.0));
        // Sleeping particles have their own row in the table.
        let is_one_hard_sphere = scene.species.len() == 1
            && !scene.has_individual_diameters()
            && scene.sleep.is_none()
            && scene.bonds.is_empty()
            && !scene.species[0].is_static()
            && scene.table.get(0, 0).is_some_and(|id| {
                let potential = &scene.interactions[id.0 as usize].potential;
                potential.is_hard_sphere() && !potential.is_bond()
            });
        let rows = Rows::of(scene);
        let ranges = Ranges::of(scene, &rows);
        Self {
            is_falling,
            has_table: !is_one_hard_sphere,
            search: Search::of(scene, &rows, &ranges),
            levels: ranges.level_count(),
        }
    }
}

impl fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pairs = if self.has_table { "a table of potentials with pair states" } else { "one hard-sphere species" };
        let motion = if self.is_falling { "falling" } else { "force-free" };
        write!(f, "{motion} particles, {pairs}, {}", self.search)?;
        match self.search {
            Search::Lists { .. } if self.levels > 1 => write!(f, " and {} levels of sizes", self.levels),
            _ => Ok(()),
        }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
enum Chosen {
    FreeHard(Engine<false, false>),
    FreeTable(Engine<false, true>),
    FallingHard(Engine<true, false>),
    FallingTable(Engine<true, true>),
}

/// A simulation: a scene that moves from event to event.
///
/// A copy continues with the same results, bit for bit. Independent replicas can run in threads:
///
/// ```
/// use carom::engine::{Simulation, Until};
/// use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
///
/// let scene = SceneBuilder::new("replica")
///     .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
///     .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
///     .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(108).packing_fraction(0.2))
///     .temperature(1.0);
/// let simulations: Result<Vec<Simulation>, Box<dyn std::error::Error>> =
///     (1..=4).map(|seed| Ok(Simulation::new(scene.clone().seed(seed).build()?)?)).collect();
/// let times = std::thread::scope(|scope| {
///     let run = |mut simulation: Simulation| simulation.advance(Until::events(5_000)).map(|_| simulation.time());
///     let threads: Vec<_> = simulations?.into_iter().map(|simulation| scope.spawn(move || run(simulation))).collect();
///     threads.into_iter().map(|thread| thread.join().expect("no panic")).collect::<Result<Vec<f64>, _>>()
///         .map_err(Box::<dyn std::error::Error>::from)
/// })?;
/// assert!(times.iter().all(|time| *time > 0.0) && times[0] != times[1]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[doc(alias = "replica")]
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Simulation {
    scene: Scene,
    choice: EngineChoice,
    engine: Chosen,
    /// Ratio of the diameters in `scene` to the diameters at the start of the simulation.
    scale: f64,
    first_diameters: Vec<f64>,
    #[serde(skip)]
    threads: Threads,
    /// Connection to other processes that simulate the same system.
    #[serde(skip)]
    communicator: Option<Arc<dyn Communicator>>,
}

impl Simulation {
    /// The scene from which the simulation started. After a growth, the scene has the diameters and the state at the
    /// end of the growth. With a barostat, it has the current box.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The kind of engine that runs the simulation.
    #[must_use]
    pub fn engine(&self) -> EngineChoice {
        self.choice
    }

    /// Current simulated time `[time]`.
    #[must_use]
    pub fn time(&self) -> f64 {
        with_engine!(&self.engine, engine => engine.time())
    }

    /// Counts of the events so far.
    #[must_use]
    pub fn event_counts(&self) -> &EventCounts {
        with_engine!(&self.engine, engine => &engine.counts.totals)
    }

    /// Event counts so far, by kind and species.
    #[must_use]
    pub fn event_counts_by_species(&self) -> EventCountsBySpecies {
        if self.choice.has_table {
            return with_engine!(&self.engine, engine => engine.counts.by_species.of_rows(engine.pairs.rules.rows.species()));
        }
        let species = self.population().iter().position(|count| *count > 0).unwrap_or(0);
        EventCountsBySpecies::of_one_species(species, self.event_counts())
    }

    /// Advances the simulation to a time, or to a total number of events. Does nothing if the limit has passed.
    ///
    /// Two successive advances give the same results as a single advance, bit for bit.
    ///
    /// # Errors
    /// [`EngineError::Arrest`] if time does not advance, [`EngineError::InvariantBroken`] if the state is impossible.
    pub fn advance(&mut self, until: Until) -> Result<Reason, EngineError> {
        self.advance_observed(until, None)
    }

    /// Advances the simulation, and calls `observe` at every event.
    ///
    /// A closure that returns nothing receives all events. A closure that returns
    /// [`ControlFlow`](std::ops::ControlFlow) can end the run with a break; the result is then [`Reason::Observer`]. A
    /// stop does not change later results. [`Self::events`] iterates over the events instead.
    ///
    /// # Errors
    /// [`EngineError::Arrest`] if time does not advance, [`EngineError::InvariantBroken`] if the state is impossible.
    #[doc(alias = "callback")]
    #[doc(alias = "observer")]
    pub fn advance_with<R: ObserverResult>(
        &mut self,
        until: Until,
        mut observe: impl FnMut(&Event) -> R,
    ) -> Result<Reason, EngineError> {
        self.advance_observed(until, Some(&mut |event| observe(event).control()))
    }

    /// Advances the simulation as [`Self::advance`] does, but pauses after a number of steps and returns `None`.
    ///
    /// A step is an event, a cell transition, a new prediction, or other work of similar cost. At least one step is
    /// done. Pauses do not change any event.
    ///
    /// # Errors
    /// [`EngineError::Arrest`] if time does not advance, [`EngineError::InvariantBroken`] if the state is impossible.
    pub fn advance_for(&mut self, steps: u64, until: Until) -> Result<Option<Reason>, EngineError> {
        let reason = self.advance_unsettled(steps, until, None);
        self.complete();
        reason
    }

    /// Combines [`Self::advance_for`] and [`Self::advance_with`].
    ///
    /// # Errors
    /// [`EngineError::Arrest`] if time does not advance, [`EngineError::InvariantBroken`] if the state is impossible.
    pub fn advance_for_with<R: ObserverResult>(
        &mut self,
        steps: u64,
        until: Until,
        mut observe: impl FnMut(&Event) -> R,
    ) -> Result<Option<Reason>, EngineError> {
        let reason = self.advance_unsettled(steps, until, Some(&mut |event| observe(event).control()));
        self.complete();
        reason
    }

    /// Advances like [`Self::advance_for`]. With several threads, only the event counts are up to date until
    /// [`Self::settle`] is called.
    pub(crate) fn advance_unsettled(
        &mut self,
        steps: u64,
        until: Until,
        mut observe: Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        if self.event_counts().physical() >= until.last_event() {
            return Ok(Some(Reason::Events));
        }
        if until.last_time() < self.time() {
            return Ok(Some(Reason::Time));
        }
        with_engine!(&mut self.engine, engine => engine.advance_on_cores(steps.max(1), until, &mut observe))
    }

    fn advance_observed(&mut self, until: Until, mut observe: Observe<'_>) -> Result<Reason, EngineError> {
        if self.event_counts().physical() >= until.last_event() {
            return Ok(Reason::Events);
        }
        if until.last_time() < self.time() {
            return Ok(Reason::Time);
        }
        loop {
            let reason =
                with_engine!(&mut self.engine, engine => engine.advance_on_cores(u64::MAX, until, &mut observe));
            if let Some(reason) = reason.transpose() {
                self.complete();
                return reason;
            }
        }
    }

    /// Writes the current positions and velocities of all particles into `states`, and the time in full precision.
    pub fn states(&self, states: &mut States) {
        with_engine!(&self.engine, engine => engine.states(states));
    }

    /// All captured pairs and their nonzero states. Each pair is listed once, lower id first.
    #[must_use]
    pub fn captured_pairs(&self) -> Vec<([ParticleId; 2], u16)> {
        with_engine!(&self.engine, engine => engine.captured_pairs())
    }

    /// Returns true if it can be shown that no further event will happen.
    pub(crate) fn is_over(&self) -> bool {
        with_engine!(&self.engine, engine => engine.is_over())
    }

    /// The deepest current overlap of all pairs and walls, or `None` if nothing overlaps.
    #[must_use]
    pub fn deepest_overlap(&self) -> Option<Overlap> {
        with_engine!(&self.engine, engine => engine.deepest_overlap())
    }

    /// The current overlaps of all pairs and walls that are too deep to be round-off.
    #[must_use]
    pub fn real_overlaps(&self) -> Vec<Overlap> {
        with_engine!(&self.engine, engine => engine.real_overlaps())
    }

    /// Number of radii of the potential through which a pair has been captured; 0 for an uncaptured pair.
    #[must_use]
    pub fn pair_state(&self, a: ParticleId, b: ParticleId) -> u16 {
        with_engine!(&self.engine, engine => engine.state_of_pair(a, b))
    }

    /// Requests large memory pages after the simulation has been read from a checkpoint.
    pub(crate) fn enlarge(&self) {
        with_engine!(&self.engine, engine => engine.enlarge());
    }

    pub(crate) fn set_limit(&mut self, limit: Until) {
        self.scene.run.limit = limit;
    }

    /// Number of particles that are not static.
    #[must_use]
    pub fn moving(&self) -> usize {
        let population = self.population();
        self.scene
            .species
            .iter()
            .zip(population)
            .filter(|(species, _)| !species.is_static())
            .map(|(_, count)| count)
            .sum()
    }

    /// Number of particles of each species.
    #[must_use]
    pub fn population(&self) -> Vec<usize> {
        with_engine!(&self.engine, engine => engine.state.population(&engine.pairs.rules.rows, self.scene.species.len()))
    }

    /// Number of axes along which particles can move.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.scene.space.dimensions()
    }
}
