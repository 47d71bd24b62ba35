mod windows;

use std::cell::Cell;
use std::convert::Infallible;
use std::ops::ControlFlow;

use super::*;
use crate::Vector;
use crate::analysis::reweighting::Ensemble;
use crate::engine::{NeedsRun, Simulation};
use crate::model::measurement_plan::{BondOrder, RadialDistribution};
use crate::model::{
    ExchangeEnsemble, ExchangePlan, MeasurementPlan, OutputPlan, Potential, RunPlan, Scene, Space, Until,
};
use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

fn fluid(interval: f64, attempts: u32) -> Scene {
    let limit = Until::time(f64::from(attempts) * interval);
    SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0).unwrap()).between("A", "A"))
        .fill(Fill::new(Lattice::SimpleCubic, "A").count(27).number_density(0.4))
        .exchange(ExchangePlan {
            temperatures: vec![2.0, 1.4, 1.0],
            interval,
            rate: 1.0,
            ensemble: ExchangeEnsemble::Canonical,
            umbrella: None,
        })
        .output(OutputPlan { frame_interval: Some(2.0 * interval), ..OutputPlan::default() })
        .run(RunPlan { equilibration: Until::time(interval), limit, ..RunPlan::default() })
        .build()
        .unwrap()
}

/// A checkpoint, and the number of lines before it.
type Kept = (Vec<u8>, usize);

/// Recorder that keeps rows and frames as text. One in `every` calls of `is_checkpoint_due` requests a checkpoint.
struct Keeper {
    every: usize,
    asked: Cell<usize>,
    lines: Vec<String>,
    kept: Vec<Kept>,
}

impl Keeper {
    fn new(every: usize) -> Self {
        Self { every, asked: Cell::new(0), lines: Vec::new(), kept: Vec::new() }
    }
}

impl ExchangeRecorder for Keeper {
    type Error = Infallible;

    fn row(&mut self, row: &ExchangeRow<'_>) -> Result<(), Infallible> {
        self.lines.push(format!("{row:?}"));
        Ok(())
    }

    fn frame(&mut self, place: usize, simulation: &Simulation) -> Result<(), Infallible> {
        self.lines.push(format!("{place} {:?}", simulation.snapshot()));
        Ok(())
    }

    fn is_checkpoint_due(&self) -> bool {
        self.asked.set(self.asked.get() + 1);
        self.asked.get() >= self.every
    }

    fn checkpoint(&mut self, exchange: &Exchange) -> Result<(), Infallible> {
        self.asked.set(0);
        self.kept.push((postcard::to_allocvec(exchange).unwrap(), self.lines.len()));
        Ok(())
    }
}

fn ran(exchange: Exchange, jobs: usize, every: usize) -> (Exchange, Keeper) {
    let mut keeper = Keeper::new(every);
    let exchange = exchange.execute(jobs, &mut keeper, &mut |_| ControlFlow::Continue(())).unwrap();
    assert!(exchange.is_over());
    (exchange, keeper)
}

/// Checks that a run with checkpoints, and the runs resumed from the checkpoints that `chosen` returns, repeat an
/// uninterrupted run bitwise.
fn assert_resumes(scene: &Scene, (whole, told): (&Exchange, &Keeper), every: usize, chosen: fn(&[Kept]) -> Vec<&Kept>) {
    let end = postcard::to_allocvec(whole).unwrap();
    for jobs in [1, 2] {
        let (paused, keeper) = ran(Exchange::new(scene.clone()).unwrap(), jobs, every);
        assert!(keeper.lines == told.lines && postcard::to_allocvec(&paused).unwrap() == end);
        // With several threads, the number of checkpoints depends on how fast the threads are.
        let fewest = if jobs == 1 { 3 } else { 1 };
        assert!(keeper.kept.len() >= fewest, "{} checkpoints", keeper.kept.len());
        for (bytes, lines) in chosen(&keeper.kept) {
            let (again, rest) = ran(postcard::from_bytes(bytes).unwrap(), 3 - jobs, usize::MAX);
            assert!(rest.lines[..] == told.lines[*lines..]);
            assert!(postcard::to_allocvec(&again).unwrap() == end);
        }
    }
}

/// Some of the checkpoints, at most `count`, evenly spaced.
fn spread(kept: &[Kept], count: usize) -> Vec<&Kept> {
    kept.iter().step_by(kept.len().div_ceil(count)).collect()
}

/// For a single pair, `g(r) exp(U / T)` is the same at all distances outside the core.
#[test]
fn instruments_see_the_replica_that_is_at_their_temperature() {
    let (edge, cutoff) = (4.2, 2.1);
    let scene = SceneBuilder::new("pair")
        .space(Space::periodic_cube(edge))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 1.0).unwrap()).between("A", "B"))
        .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .particle("B", Vector::new(3.0, 3.0, 3.0), Vector::zeros())
        .exchange(ExchangePlan {
            temperatures: vec![0.4, 0.6, 1.0],
            interval: 2.0,
            rate: 1.0,
            ensemble: ExchangeEnsemble::Canonical,
            umbrella: None,
        })
        .measure(MeasurementPlan {
            radial_distribution: Some(RadialDistribution {
                cutoff: Some(cutoff),
                bins: Some(21),
                ..RadialDistribution::default()
            }),
            ..MeasurementPlan::default()
        })
        .run(RunPlan { equilibration: Until::time(20.0), limit: Until::time(8000.0), ..RunPlan::default() })
        .build()
        .unwrap();
    let results = Exchange::new(scene).unwrap().finish().unwrap().results();
    let sphere = |r: f64| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
    let mut worst: f64 = 0.0;
    for at in &results.temperatures {
        let curve = at.measured.curve("radial_distribution").unwrap();
        let series = curve.series.iter().find(|series| series.name.contains("A-B")).unwrap();
        let samples =
            &series.normalisation.as_ref().unwrap().divisors.iter().find(|it| it.name == "samples").unwrap().values;
        assert_eq!(samples[..], [4000.0]);
        let bound = libm::exp(1.0 / at.temperature);
        let well = sphere(1.5) - sphere(1.0);
        let free = edge.powi(3) - sphere(1.5);
        let norm = edge.powi(3) / (well * bound + free);
        for ((r, value), error) in curve.variables[0].values.iter().zip(&series.values).zip(&series.standard_errors) {
            let expected = norm
                * if *r < 1.0 {
                    0.0
                } else if *r < 1.5 {
                    bound
                } else {
                    1.0
                };
            match error.filter(|error| *error > 0.0) {
                Some(error) => worst = worst.max((value.unwrap() - expected).abs() / error),
                None => assert_eq!((value.unwrap(), expected), (0.0, 0.0), "{r}"),
            }
        }
    }
    // The largest deviation of 33 bins, in standard errors.
    assert!(worst < 4.0, "{worst}");
}

/// In short intervals, there are few events. In long intervals, the engine checks for a pause more than once.
#[test]
fn interrupted_exchange_resumes_bitwise() {
    for (interval, attempts, every) in [(0.5, 20, 5), (100.0, 2, 1)] {
        let mut parts = fluid(interval, attempts).into_parts();
        let times = RadialDistribution { interval: Some(1.7 * interval), ..RadialDistribution::default() };
        parts.measure.radial_distribution = Some(times);
        parts.measure.bond_order = Some(BondOrder::default());
        let scene = Scene::new(parts).unwrap();
        let (whole, told) = ran(Exchange::new(scene.clone()).unwrap(), 1, usize::MAX);
        assert_eq!(told.lines.len(), (attempts + 3 * (attempts / 2)) as usize);
        assert_eq!(whole.results().faults, [""; 0]);
        assert_resumes(&scene, (&whole, &told), every, |kept| kept.iter().rev().take(3).collect());
    }
}

/// Some checkpoints are written while the weights are learned, others while the weights are fixed.
#[test]
fn multicanonical_exchange_resumes_bitwise() {
    let mut parts = fluid(0.2, 10).into_parts();
    parts.exchange.as_mut().unwrap().ensemble = ExchangeEnsemble::Multicanonical;
    parts.run.equilibration = Until::time(8.0);
    parts.output.frame_interval = Some(0.4);
    let scene = Scene::new(parts).unwrap();
    let (whole, told) = ran(Exchange::new(scene.clone()).unwrap(), 1, usize::MAX);
    assert_eq!(whole.results().faults, [""; 0]);
    assert!(matches!(whole.ensembles()[0], Ensemble::Multicanonical(_)));
    assert_resumes(&scene, (&whole, &told), 2, |kept| spread(kept, 8));
}

#[test]
fn replicas_have_the_highest_temperature_when_weights_begin() {
    let mut parts = fluid(0.2, 10).into_parts();
    parts.exchange.as_mut().unwrap().ensemble = ExchangeEnsemble::Multicanonical;
    parts.run.equilibration = Until::time(8.0);
    let mut exchange = Exchange::new(Scene::new(parts).unwrap()).unwrap();
    // Kinetic energies of the replicas, scaled to the highest temperature, which is 2.
    let kinetic = |exchange: &Exchange, temperature: &dyn Fn(usize) -> f64| -> Vec<f64> {
        let of = |(place, number): (usize, &usize)| {
            (*number, exchange.replicas[*number].simulation.energy().kinetic * 2.0 / temperature(place))
        };
        let mut all: Vec<(usize, f64)> = exchange.row().replicas.iter().enumerate().map(of).collect();
        all.sort_by_key(|(number, _)| *number);
        all.into_iter().map(|(_, energy)| energy).collect()
    };
    let mut before = Vec::new();
    while exchange.weights().is_none() {
        let time = exchange.next_time();
        for replica in &mut exchange.replicas {
            assert!(replica.go(time, || false).unwrap());
        }
        before = kinetic(&exchange, &|place| exchange.temperatures()[place]);
        exchange.attempt().unwrap();
    }
    let after = kinetic(&exchange, &|_| 2.0);
    let is_same = |(a, b): (&f64, &f64)| (a / b - 1.0).abs() < 1e-12;
    assert!(after.iter().zip(&before).all(is_same), "{after:?}, expected {before:?}");
}

#[test]
fn temperatures_without_overlap_end_a_multicanonical_exchange() {
    let mut parts = fluid(0.2, 10).into_parts();
    let plan = parts.exchange.as_mut().unwrap();
    (plan.ensemble, plan.temperatures) = (ExchangeEnsemble::Multicanonical, vec![0.2, 50.0]);
    parts.run.equilibration = Until::time(8.0);
    let ended = Exchange::new(Scene::new(parts).unwrap()).unwrap().finish();
    assert!(matches!(ended, Err(ExchangeError::NoOverlap)), "{ended:?}");
}

#[test]
fn an_exchange_stops_where_it_is_told_to() {
    let exchange = Exchange::new(fluid(1.0, 1_000_000)).unwrap();
    let exchange = exchange.execute(2, &mut (), &mut |_| ControlFlow::Break(())).unwrap();
    assert!(!exchange.is_over());
    let [attempts, total] = exchange.attempts();
    assert!(attempts < total && total == 1_000_001);
}

#[test]
fn replicas_start_at_their_temperature_with_own_random_numbers() {
    let exchange = Exchange::new(fluid(1.0, 4)).unwrap();
    let kinetic = |place: usize| exchange.simulation_at(place).unwrap().energy().kinetic;
    // With 81 degrees of freedom, the relative standard deviation of the kinetic energy is `sqrt(2 / 81)`.
    for (place, temperature) in exchange.temperatures().iter().enumerate() {
        let relative = kinetic(place) / (1.5 * 27.0 * temperature);
        assert!((relative - 1.0).abs() < 4.0 * (2.0_f64 / 81.0).sqrt(), "{place}: {relative}");
    }
    let velocities = |place: usize| exchange.simulation_at(place).unwrap().snapshot().velocities;
    assert!(velocities(0)[0].normalize() != velocities(1)[0].normalize());
    let (ended, _) = ran(exchange, 1, usize::MAX);
    assert_eq!(ended.row().replicas.len(), 3);
}

#[test]
fn row_lists_potential_energies_after_the_swaps() {
    let mut swapped = 0;
    for attempts in 1..8 {
        let (ended, _) = ran(Exchange::new(fluid(1.0, attempts)).unwrap(), 1, usize::MAX);
        let row = ended.row();
        let energies: Vec<f64> = (0..3).map(|place| ended.simulation_at(place).unwrap().energy().potential).collect();
        assert_eq!(row.potential, energies);
        swapped += usize::from(row.replicas != [0, 1, 2]);
    }
    assert!(swapped > 2, "{swapped}");
}

#[test]
fn planned_exchange_needs_an_exchange_run() {
    let scene = fluid(1.0, 10);
    assert_eq!(Simulation::new(scene.clone()).err(), Some(NeedsRun::Exchange));
    let mut parts = scene.into_parts();
    parts.exchange = None;
    assert_eq!(Exchange::new(Scene::new(parts).unwrap()).err(), Some(StartError::NoPlan));
}

#[test]
fn one_falling_particle_has_the_barometric_energy() {
    let plan = ExchangePlan {
        temperatures: vec![0.5, 1.0, 2.0],
        interval: 3.0,
        rate: 0.5,
        ensemble: ExchangeEnsemble::Canonical,
        umbrella: None,
    };
    let walls = [
        crate::model::space::Boundary::Periodic,
        crate::model::space::Boundary::walls(1.0),
        crate::model::space::Boundary::Periodic,
    ];
    let scene = SceneBuilder::new("column")
        .space(Space { boundary: walls, ..Space::periodic_cube(5.0) })
        .gravity(Vector::new(0.0, -0.7, 0.0))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .particle("A", Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .exchange(plan)
        .run(RunPlan { limit: Until::time(9000.0), ..RunPlan::default() })
        .build()
        .unwrap();
    let results = Exchange::new(scene).unwrap().finish().unwrap().results();
    assert_eq!(results.faults, [""; 0]);
    for at in &results.temperatures {
        // The height of the centre is between 0.5 and 4.5, with the Boltzmann factor `exp(-m g h / T)`.
        let (weight, room) = (1.3 * 0.7, 4.0);
        let x = weight * room / at.temperature;
        let expected = weight * 0.5 + at.temperature * (1.0 - x / x.exp_m1());
        let measured = at.observables["potential_energy_per_particle"];
        let deviation = (measured.mean - expected) / measured.standard_error.unwrap();
        assert!(deviation.abs() < 3.0, "{}: {measured:?}, expected {expected}", at.temperature);
        let heat_capacity = at.observables["heat_capacity_per_particle"];
        let expected = 1.5 + 1.0 - x * x * x.exp() / x.exp_m1().powi(2);
        let deviation = (heat_capacity.mean - expected) / heat_capacity.standard_error.unwrap();
        assert!(deviation.abs() < 3.0, "{}: {heat_capacity:?}, expected {expected}", at.temperature);
        // A continuous energy has no exact levels, but bins.
        assert!(at.populations.iter().all(|it| it.width > 0.0));
        let all: f64 = at.populations.iter().map(|it| it.population.mean).sum();
        assert!((all - 1.0).abs() < 1e-9);
    }
}

#[test]
fn frames_of_large_systems_are_few_unless_their_interval_is_given() {
    let mut scene = fluid(1.0, 100);
    scene.output.frame_interval = None;
    assert_eq!((ExchangeFolder::expected_frames(&scene), ExchangeFolder::frames_limit(&scene)), (60.0, None));
    scene.particles = vec![scene.particles[0]; 100_000];
    assert!(ExchangeFolder::expected_bytes(&scene) < 2.1e8 && ExchangeFolder::frames_limit(&scene).is_some());
    let frames = ExchangeFolder::expected_frames(&scene);
    scene.output.frame_interval = Some(5.0);
    assert_eq!((ExchangeFolder::expected_frames(&scene), ExchangeFolder::frames_limit(&scene)), (60.0, None));
    assert!((3.0..20.0).contains(&frames), "{frames}");
}
