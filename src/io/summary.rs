//! Numerical results of a run: `summary.json`. The keys are stable, so that programs can rely on them.

mod system;

use system::sizes;
pub use system::{SpeciesSummary, System};

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::folder::SUMMARY;
use super::rates::{Rate, rates};
pub use super::thermo::Column;
use crate::analysis::instruments::Measured;
use crate::analysis::observables::{Equilibrium, OBSERVABLES};
use crate::analysis::published::{PublishedValue, of_flows, of_mixture, of_system};
use crate::analysis::statistics::{Estimate, Stationarity};
use crate::engine::{InletCounts, Simulation};
use crate::model::{Inlet, InputFile, Scene, Separated, Species, StagePlan, StageSwaps, Units, VolumeMoves};
use crate::run::{Finished, MeasuredStage, MeasurementPeriod};

/// Summary of a run: the content of `summary.json`.
///
/// Counts, observables and speed describe the measurement. Energies, momentum and overlaps describe the whole run. A
/// value without meaning for the scene is `null`, and such an observable is absent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the keys are described as a whole")]
pub struct Summary {
    pub version: String,
    pub scene: String,
    pub seed: u64,
    /// Names of the units of length, mass and time; absent if the scene has no names.
    #[serde(default, skip_serializing_if = "Units::are_unnamed")]
    pub units: Units,
    /// Input files of the scene, with checksums.
    #[serde(default)]
    pub inputs: Vec<InputFile>,
    /// Description of the engine that ran.
    pub engine: String,
    /// Number of particles, including static particles.
    pub particles: usize,
    /// Simulated time at the end of the run.
    pub time: f64,
    /// Reason why the run ended, such as `time`; `None` in files without this key.
    #[serde(default)]
    pub ending: Option<String>,
    #[serde(default)]
    pub measured: Option<Period>,
    /// The simulated system, in numbers.
    #[serde(default)]
    pub system: Option<System>,
    /// Factor by which diameters have grown since the start of the scene; 1 without growth.
    #[serde(default = "not_grown")]
    pub diameter_factor: f64,
    /// Volume moves of the barostat in the measurement; absent without a barostat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_moves: Option<VolumeMoves>,
    /// Swap moves of each stage that has them; absent without swap moves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub swaps: Vec<StageSwaps>,
    /// What each inlet did in the whole run; absent without inlets.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub inlets: Vec<InletSummary>,
    pub events: Events,
    pub energy: Energies,
    pub momentum: Momentum,
    pub overlap: Overlaps,
    /// Problem of the run in one line, such as a jam or a failed audit. Absent if there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trouble: Option<String>,
    /// Faults found by the audit, in words; empty if there are none.
    pub faults: Vec<String>,
    /// Whether the observables were stationary during the measurement.
    #[serde(default)]
    pub equilibrated: Equilibrium,
    pub observables: BTreeMap<String, Observable>,
    /// Summaries of the earlier measured stages, in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageSummary>,
    /// Published values from theory and other simulations, at the mean temperature.
    #[serde(default)]
    pub published: Vec<PublishedValue>,
    /// Names and units of the columns of each table, by file name. Empty if the run has no folder.
    #[serde(default)]
    pub columns: BTreeMap<String, Vec<Column>>,
    /// Event rates by kind and species, for the kinds that occurred.
    #[serde(default)]
    pub rates: Vec<Rate>,
    pub speed: Speed,
}

/// Summary of a measured stage, with the keys of [`Summary`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as in `Summary`")]
pub struct StageSummary {
    pub name: String,
    pub measured: Period,
    pub diameter_factor: f64,
    /// Volume moves of the barostat; absent without a barostat.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub volume_moves: Option<VolumeMoves>,
    pub events: Events,
    pub equilibrated: Equilibrium,
    pub observables: BTreeMap<String, Observable>,
    pub published: Vec<PublishedValue>,
    pub rates: Vec<Rate>,
    pub speed: Speed,
}

/// Start and duration of a measurement, in simulated time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as in `MeasurementPeriod`")]
pub struct Period {
    pub start: f64,
    pub duration: f64,
}

/// Event counts. `total` counts physical events: core, capture, release, bounce, wall and exit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as in `EventCounts`")]
pub struct Events {
    pub total: u64,
    /// Number of physical events before the measurement; `None` in files without this key.
    #[serde(default)]
    pub before: Option<u64>,
    pub core: u64,
    pub capture: u64,
    pub release: u64,
    pub bounce: u64,
    pub wall: u64,
    pub transition: u64,
    pub turning_point: u64,
    pub in_invalid_state: u64,
    pub tc_contacts: u64,
    pub tc_altered: u64,
    #[serde(default)]
    pub tc_kept: u64,
    #[serde(default)]
    pub tc_slid: u64,
    #[serde(default)]
    pub tc_lifted: u64,
    #[serde(default)]
    pub tc_returned: u64,
    /// How many times a grain fell asleep; `None` if grains never do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rest: Option<u64>,
    /// How many times a sleeping grain woke up; `None` if grains never sleep.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wake: Option<u64>,
    /// Particles that have left; `None` without an inlet or outlet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exit: Option<u64>,
    /// Particles that have entered, which are not counted in `total`; `None` without an inlet or outlet.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub entry: Option<u64>,
}

/// What an inlet did in the whole run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct InletSummary {
    /// Name of the inlet.
    pub name: String,
    /// Number of particles that have entered.
    pub entered: u64,
    /// Number of particles that left at an outlet and entered again; `None` if no outlet is recirculated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub returned: Option<u64>,
    /// Number of particles that were due but had not entered, because no place was free.
    pub waiting: u64,
    /// Number of times that a particle found no free place.
    pub blocked: u64,
}

impl InletSummary {
    fn of(simulation: &Simulation) -> Vec<Self> {
        let of_one = |(inlet, counts): (&Inlet, InletCounts)| {
            let InletCounts { entered, returned, waiting, blocked, .. } = counts;
            let returned = (!inlet.recirculate.is_empty()).then_some(returned);
            Self { name: inlet.name.clone(), entered, returned, waiting, blocked }
        };
        simulation.scene().inlets().iter().zip(simulation.inlets()).map(of_one).collect()
    }
}

/// Energies at the start and the end of the run, and the error of their balance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "as in `Audit`")]
pub struct Energies {
    pub initial: f64,
    pub r#final: f64,
    pub kinetic: f64,
    /// Kinetic energy of the rotation; `None` without spins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotational: Option<f64>,
    pub potential: f64,
    pub dissipated: f64,
    #[serde(default)]
    pub supplied: f64,
    pub ledger_error_relative: f64,
    /// Largest error of the energy balance that the audit accepts.
    pub ledger_limit: f64,
}

/// Conservation of momentum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Momentum {
    /// Change of the total momentum, relative to the sum of `m |v|` over all particles; `None` if not conserved.
    pub drift: Option<f64>,
    /// Largest drift that the audit accepts.
    pub limit: f64,
}

/// Overlaps of pairs. Depths are relative to the contact distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Overlaps {
    /// Deepest overlap at any event.
    pub deepest_executed: f64,
    /// Deepest overlap at the end of the run.
    pub deepest_final: f64,
    /// Largest overlap that the audit accepts; `None` if the limit is the round-off of the coordinates.
    pub limit: Option<f64>,
    /// Number of pairs that overlapped at the start by more than round-off.
    pub initial: usize,
    /// Number of pairs that overlap at the end by more than round-off.
    pub r#final: usize,
    /// Simulated time at which the last initial overlap was resolved.
    pub resolved_after: Option<f64>,
    /// Overlaps that were removed before the start; `None` if there were none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub separated: Option<Separated>,
}

/// An observable of the run, averaged over the measurement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Observable {
    /// The mean and its standard error.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// Whether the observable was stationary; `None` in files without this key.
    #[serde(default)]
    pub stationarity: Option<Stationarity>,
}

/// Observables that no instrument measures, with names and units: first [`OBSERVABLES`] in their order, then others.
pub(crate) fn beside_instruments<'a>(
    observables: &'a BTreeMap<String, Observable>,
    measured: &'a Measured,
) -> impl Iterator<Item = (&'a str, &'static str, &'a Observable)> {
    let is_measured = |name: &str| measured.number(name).is_some_and(|number| number.mean.is_some());
    // The pressure tensor measures the collision rate under the name `core_rate`.
    let is_known = move |name: &str| is_measured(name) || name == "collision_rate" && is_measured("core_rate");
    let others = observables.keys().map(|name| (name.as_str(), "1"));
    let others = others.filter(|(name, _)| OBSERVABLES.iter().all(|(known, _)| known != name));
    let all = OBSERVABLES.into_iter().chain(others).filter(move |(name, _)| !is_known(name));
    all.filter_map(|(name, unit)| Some((name, unit, observables.get(name)?)))
}

/// Wall time, speed and memory of the run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Speed {
    /// Wall time `[seconds]`.
    pub wall_seconds: f64,
    /// Physical events per second of wall time; `None` for a run too short to time.
    pub events_per_second: Option<f64>,
    /// Core events per second of wall time; `None` for a run too short to time.
    pub contacts_per_second: Option<f64>,
    /// Peak memory of the program, if the system reports it.
    pub peak_memory_bytes: Option<u64>,
}

impl Summary {
    /// Reads the summary of the run in a folder.
    ///
    /// # Errors
    /// If the file cannot be read, or is not a summary.
    pub fn read(run: &Path) -> io::Result<Self> {
        let bytes = fs::read(run.join(SUMMARY))?;
        serde_json::from_slice(&bytes).map_err(io::Error::other)
    }

    /// Returns the summary of a finished run.
    #[must_use]
    pub fn of(finished: &Finished) -> Self {
        let (simulation, audit) = (&finished.simulation, &finished.audit);
        let scene = simulation.scene();
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: scene.name.clone(),
            seed: scene.seed,
            units: scene.units.clone(),
            inputs: scene.inputs.clone(),
            engine: simulation.engine().to_string(),
            particles: simulation.population().iter().sum(),
            time: simulation.time(),
            ending: Some(finished.ending.word().to_owned()),
            measured: Some(Period::of(&finished.measurement)),
            system: Some(System::of(finished)),
            diameter_factor: simulation.scale(),
            volume_moves: finished.volume_moves,
            swaps: finished.swaps.clone(),
            inlets: InletSummary::of(simulation),
            events: events(&finished.measurement, scene),
            energy: Energies {
                initial: audit.initial_energy,
                r#final: audit.energy.total(),
                kinetic: audit.energy.kinetic,
                rotational: scene.is_rough().then_some(audit.energy.rotational),
                potential: audit.energy.potential,
                dissipated: audit.dissipated,
                supplied: audit.event_counts.supplied.total(),
                ledger_error_relative: audit.ledger_error,
                ledger_limit: audit.limits.energy,
            },
            momentum: Momentum { drift: audit.momentum_drift, limit: audit.limits.momentum },
            overlap: Overlaps {
                deepest_executed: audit.event_counts.deepest_overlap,
                deepest_final: audit.deepest_final.map_or(0.0, |overlap| overlap.depth),
                limit: audit.limits.overlap,
                initial: audit.initial.overlaps,
                r#final: audit.final_overlaps,
                resolved_after: audit.initial.resolved_after,
                separated: Some(simulation.scene().separated()).filter(|separated| separated.overlaps > 0),
            },
            trouble: finished.trouble(),
            faults: audit.faults().iter().map(ToString::to_string).collect(),
            equilibrated: finished.equilibrium.clone(),
            observables: observables(&finished.observables, &finished.stationarity),
            stages: finished.stages.iter().map(|stage| StageSummary::of(stage, simulation)).collect(),
            published: published(&finished.observables, simulation, None, scale_of_scene(simulation)),
            columns: BTreeMap::new(),
            rates: rates(simulation, &finished.event_counts_by_species, finished.measurement.duration),
            speed: Speed::of(&finished.measurement),
        }
    }
}

/// Factor by which unfinished growth has changed the diameters. The scene includes completed growth.
fn scale_of_scene(simulation: &Simulation) -> f64 {
    simulation.scale() / simulation.grown()
}

impl StageSummary {
    fn of(stage: &MeasuredStage, simulation: &Simulation) -> Self {
        let scale = stage.diameter_factor / simulation.grown();
        let planned = simulation.scene().run.stages.iter().find(|planned| planned.name == stage.name);
        Self {
            name: stage.name.clone(),
            measured: Period::of(&stage.measurement),
            diameter_factor: stage.diameter_factor,
            volume_moves: stage.volume_moves,
            events: events(&stage.measurement, simulation.scene()),
            equilibrated: stage.equilibrium.clone(),
            observables: observables(&stage.observables, &stage.stationarity),
            published: published(&stage.observables, simulation, planned, scale),
            rates: rates(simulation, &stage.event_counts_by_species, stage.measurement.duration),
            speed: Speed::of(&stage.measurement),
        }
    }
}

impl Period {
    fn of(measurement: &MeasurementPeriod) -> Self {
        Self { start: measurement.start, duration: measurement.duration }
    }
}

impl Speed {
    fn of(measurement: &MeasurementPeriod) -> Self {
        let MeasurementPeriod { wall_seconds, event_counts, .. } = measurement;
        let per_second = |count: u64| (*wall_seconds > 0.0).then(|| count as f64 / wall_seconds);
        Self {
            wall_seconds: *wall_seconds,
            events_per_second: per_second(event_counts.physical()),
            contacts_per_second: per_second(event_counts.core),
            peak_memory_bytes: peak_memory_bytes(),
        }
    }
}

fn observables(
    estimates: &[(&'static str, Estimate)],
    stationarity: &[(&'static str, Stationarity)],
) -> BTreeMap<String, Observable> {
    let observable = |&(name, estimate): &(&'static str, Estimate)| {
        let stationarity = stationarity.iter().find(|(known, _)| *known == name).map(|(_, verdict)| *verdict);
        (name.to_owned(), Observable { estimate, stationarity })
    };
    estimates.iter().map(observable).collect()
}

/// Returns published values for a stage, or for the last measurement if `stage` is `None`. `scale` is the ratio of
/// measured diameters to diameters in the scene.
fn published(
    estimates: &[(&'static str, Estimate)],
    simulation: &Simulation,
    stage: Option<&StagePlan>,
    scale: f64,
) -> Vec<PublishedValue> {
    let temperature = estimates.iter().find(|(name, _)| *name == "temperature").map(|(_, it)| it.mean);
    let (scene, population) = (simulation.scene(), simulation.population());
    let run = &scene.run;
    // With a barostat, the volume may have changed since the measurement.
    let is_other_volume = match stage {
        Some(_) => run.has_barostat(),
        None => run.barostat.is_some(),
    };
    if is_other_volume {
        return Vec::new();
    }
    let (thermostat, gravity) =
        stage.map_or((&run.thermostat, run.gravity), |stage| (&stage.thermostat, stage.gravity));
    let falls = |species: &Species| species.acceleration.norm();
    let gravity = gravity.map_or_else(|| scene.species.iter().map(falls).fold(0.0, f64::max), |gravity| gravity.norm());
    let mut published = of_system(scene, thermostat.as_ref(), &population, scale, temperature);
    if published.is_empty() {
        published = of_mixture(scene, &population, &sizes(simulation, scale), temperature);
    }
    published.extend(of_flows(scene, &population, gravity));
    published
}

fn events(measurement: &MeasurementPeriod, scene: &Scene) -> Events {
    let (has_flow, has_sleep) = (scene.has_flow(), scene.sleep().is_some());
    let event_counts = &measurement.event_counts;
    Events {
        total: event_counts.physical(),
        before: Some(measurement.events_before),
        core: event_counts.core,
        capture: event_counts.capture,
        release: event_counts.release,
        bounce: event_counts.bounce,
        wall: event_counts.wall,
        transition: event_counts.transition,
        turning_point: event_counts.turning_point,
        in_invalid_state: event_counts.in_invalid_state,
        tc_contacts: event_counts.tc_contacts,
        tc_altered: event_counts.tc_altered,
        tc_kept: event_counts.tc_kept,
        tc_slid: event_counts.tc_slid,
        tc_returned: event_counts.tc_returned,
        tc_lifted: event_counts.tc_lifted,
        rest: has_sleep.then_some(event_counts.rest),
        wake: has_sleep.then_some(event_counts.wake),
        exit: has_flow.then_some(event_counts.exit),
        entry: has_flow.then_some(event_counts.entry),
    }
}

fn not_grown() -> f64 {
    1.0
}

/// Peak resident memory `[bytes]`. Linux reports kibibytes.
fn peak_memory_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}
