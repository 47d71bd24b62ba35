//! A simulation: a scene in motion.

/// Runs an expression with the chosen engine, whatever its type.
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
mod audit;
mod batch;
mod build;
mod clock;
mod columns;
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
mod neighbours;
mod observe;
mod order;
mod own_interactions;
pub(crate) mod pairs;
mod parts;
mod predict;
mod prediction;
mod reach;
mod schedule;
mod set_state;
mod snapshot;
mod sources;
mod start;
mod state;
mod states;
pub(crate) mod surfaces;
mod threads;
pub(crate) mod transport;
mod volume_move;

use crate::engine::event::{Event, EventCounts, EventCountsBySpecies};
use crate::model::space::Boundary;
use crate::model::{Limit, ParticleId, Scene, Threads};
use parts::Engine;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

pub use audit::Overlap;
pub use domains::{DomainWork, SingleThread};
pub use error::{Arrest, EngineError, Invariant, InvariantBroken, Standstill};
pub use neighbours::Search;
pub(crate) use neighbours::cell_list::CellList;
pub use observe::{EventSequence, Observe, ObserverResult};
pub use set_state::{PairStates, SetStateError};
pub use snapshot::{Energy, ParticleNow, Snapshot};
pub use start::NeedsRun;
pub use states::{Elapsed, States};
pub use transport::Transport;
pub(crate) use volume_move::Scaling;

/// How far to go: whichever comes first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Until {
    /// Simulated time `[time]`, absolute; infinite for no limit.
    pub time: f64,
    /// Number of physical events since the start of the simulation.
    pub events: u64,
}

impl Until {
    /// Up to a simulated time.
    #[must_use]
    pub fn time(time: f64) -> Self {
        Self { time, events: u64::MAX }
    }

    /// Up to a number of physical events since the start.
    #[must_use]
    pub fn events(events: u64) -> Self {
        Self { time: f64::INFINITY, events }
    }
}

/// Why a stretch of a simulation ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Reason {
    /// The simulated time was reached.
    Time,
    /// The number of events was reached.
    Events,
    /// No time limit was given, and it was shown that nothing will ever happen again: all pairs recede where nothing comes back, and
    /// there is no wall on the way. Or nothing is foreseen, though rounding may hide what would happen after a very long way.
    Idle,
    /// The observer asked for it, with [`std::ops::ControlFlow::Break`]: the simulation is at the event that was shown last.
    Observer,
}

/// The engine that was chosen for a scene, once and at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct EngineChoice {
    /// Whether particles accelerate, so that flights are parabolas.
    pub is_falling: bool,
    /// Whether pairs are looked up in a table of potentials, with a memory of pair states; otherwise there is one species
    /// of hard spheres.
    pub has_table: bool,
    /// How neighbours are found at the start; a run changes that with the density.
    pub search: Search,
}

impl EngineChoice {
    /// The engine for a scene.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        let is_falling = scene.accelerations().any(|acceleration| acceleration.iter().any(|a| *a != 0.0));
        let is_one_hard_sphere = scene.species.len() == 1
            && scene.bonds.is_empty()
            && !scene.species[0].is_static()
            && scene.table.get(0, 0).is_some_and(|id| {
                let potential = &scene.interactions[id.0 as usize].potential;
                potential.is_hard_sphere() && !potential.is_bond()
            });
        Self { is_falling, has_table: !is_one_hard_sphere, search: Search::of(scene) }
    }
}

impl fmt::Display for EngineChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pairs = if self.has_table { "a table of potentials with pair states" } else { "one hard-sphere species" };
        let motion = if self.is_falling { "falling" } else { "force-free" };
        write!(f, "{motion} particles, {pairs}, {}", self.search)
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
enum Chosen {
    FreeHard(Engine<false, false>),
    FreeTable(Engine<false, true>),
    FallingHard(Engine<true, false>),
    FallingTable(Engine<true, true>),
}

/// A simulation: a scene in motion, from event to event.
///
/// A copy goes on to the same bits. It is `Send`, so that independent replicas run in threads:
///
/// ```
/// use carom::engine::{Simulation, Until};
/// use carom::model::Potential;
/// use carom::scene::{Amount, Lattice, SceneBuilder};
///
/// let scene = SceneBuilder::new("replica")
///     .species("sphere", 1.0, 1.0)
///     .interaction("sphere", "sphere", Potential::hard_sphere(1.0)?, 1.0)
///     .fill(Lattice::FaceCentredCubic, "sphere", 108, Amount::PackingFraction(0.2))
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
    /// How much larger the diameters of the scene are than at the start.
    scale: f64,
    /// Diameters of the species at the start `[length]`.
    first_diameters: Vec<f64>,
    /// Threads that it was given; part of no state.
    #[serde(skip)]
    threads: Threads,
    /// How it talks to other processes that simulate it, too; part of no state.
    #[serde(skip)]
    transport: Option<Arc<dyn Transport>>,
}

impl Simulation {
    /// The scene that it started from; after a growth with the diameters and the state at its end, with a barostat in the box that it has now.
    #[must_use]
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Which engine runs it.
    #[must_use]
    pub fn engine(&self) -> EngineChoice {
        self.choice
    }

    /// Simulated time now `[time]`.
    #[must_use]
    pub fn time(&self) -> f64 {
        with_engine!(&self.engine, engine => engine.time())
    }

    /// Event counts so far.
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

    /// Goes on until a time or a number of events; not at all if that has passed.
    ///
    /// Where a stretch ends does not change what happens: two stretches are one long one, bit for bit.
    ///
    /// # Errors
    /// [`EngineError::Arrest`] if events go on without time, [`EngineError::InvariantBroken`] in an impossible state.
    pub fn advance(&mut self, until: Until) -> Result<Reason, EngineError> {
        self.advance_observed(until, None)
    }

    /// Goes on, and shows every event to `observe` as it happens.
    ///
    /// A closure that returns nothing sees them all; one that returns [`ControlFlow`](std::ops::ControlFlow) ends the run with [`Reason::Observer`] after the
    /// event at which it breaks. To go on from there gives the same bits as a run without a stop. [`Self::events`] hands events out one after the other.
    ///
    /// # Errors
    /// [`EngineError::Arrest`] if events go on without time, [`EngineError::InvariantBroken`] in an impossible state.
    #[doc(alias = "callback")]
    #[doc(alias = "observer")]
    pub fn advance_with<R: ObserverResult>(
        &mut self,
        until: Until,
        mut observe: impl FnMut(&Event) -> R,
    ) -> Result<Reason, EngineError> {
        self.advance_observed(until, Some(&mut |event| observe(event).control()))
    }

    /// Goes on as [`Self::advance_with`] does, with an observer if one is given, but pauses with `None` after a number of steps: an event, a cell transition, a
    /// prediction again, whatever takes about as long; at least one is done.
    ///
    /// Between two events there can be any number of other steps, so this is for a caller that looks up in between. Where it pauses
    /// changes no event.
    ///
    /// # Errors
    /// [`EngineError::Arrest`] if events go on without time, [`EngineError::InvariantBroken`] in an impossible state.
    pub fn advance_for(
        &mut self,
        steps: u64,
        until: Until,
        observe: Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        let reason = self.advance_unsettled(steps, until, observe);
        self.complete();
        reason
    }

    /// Goes on as [`Self::advance_for`] does. With several threads only the counts of events are up to date where it pauses, until [`Self::settle`]; where it
    /// ends, the state is, too.
    pub(crate) fn advance_unsettled(
        &mut self,
        steps: u64,
        until: Until,
        mut observe: Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        if self.event_counts().physical() >= until.events {
            return Ok(Some(Reason::Events));
        }
        if until.time < self.time() {
            return Ok(Some(Reason::Time));
        }
        with_engine!(&mut self.engine, engine => engine.advance_on_cores(steps.max(1), until, &mut observe))
    }

    /// [`Self::advance_with`] without a type parameter.
    fn advance_observed(&mut self, until: Until, mut observe: Observe<'_>) -> Result<Reason, EngineError> {
        if self.event_counts().physical() >= until.events {
            return Ok(Reason::Events);
        }
        if until.time < self.time() {
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

    /// Writes where everything is now into `states`, with all the digits of the time that the engine has.
    pub fn states(&self, states: &mut States) {
        with_engine!(&self.engine, engine => engine.states(states));
    }

    /// All pairs that are not in state 0, each once, lower id first, and their states.
    #[must_use]
    pub fn captured_pairs(&self) -> Vec<([ParticleId; 2], u16)> {
        with_engine!(&self.engine, engine => engine.captured_pairs())
    }

    /// Whether it can be shown that nothing will ever happen again.
    pub(crate) fn is_over(&self) -> bool {
        with_engine!(&self.engine, engine => engine.is_over())
    }

    /// The deepest overlap now, of all pairs and walls; `None` if nothing overlaps.
    #[must_use]
    pub fn deepest_overlap(&self) -> Option<Overlap> {
        with_engine!(&self.engine, engine => engine.deepest_overlap())
    }

    /// The overlaps now that are deeper than round-off explains, of all pairs and walls.
    #[must_use]
    pub fn real_overlaps(&self) -> Vec<Overlap> {
        with_engine!(&self.engine, engine => engine.real_overlaps())
    }

    /// The state of a pair: through how many radii of its potential it has been captured.
    #[must_use]
    pub fn pair_state(&self, a: ParticleId, b: ParticleId) -> u16 {
        with_engine!(&self.engine, engine => engine.state_of_pair(a, b))
    }

    /// Asks for large pages, after it was read from a checkpoint.
    pub(crate) fn enlarge(&self) {
        with_engine!(&self.engine, engine => engine.enlarge());
    }

    /// Gives the measured stretch another end.
    pub(crate) fn set_limit(&mut self, limit: Limit) {
        self.scene.run.limit = limit;
    }

    /// Number of particles that move.
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

    /// Number of axes along which particles move.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.scene.space.boundary.iter().filter(|b| **b != Boundary::Flat).count()
    }
}
