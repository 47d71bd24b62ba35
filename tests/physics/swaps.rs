//! Swap moves: the same bits after pauses and on several threads, and averages that do not change.

use carom::engine::Snapshot;
use carom::model::measurement_plan::{PressureTensor, RadialDistribution, Relaxation};
use carom::model::{
    Barostat, DiameterDistribution, MassRule, MeasurementPlan, RunPlan, Scene, StagePlan, Swap, Thermostat, Until,
};
use carom::run::{Finished, Run};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

use super::pauses::finished_with_pauses;

fn mixture(plan: RunPlan) -> Scene {
    let measure = MeasurementPlan {
        pressure_tensor: Some(PressureTensor::default()),
        radial_distribution: Some(RadialDistribution::default()),
        ..MeasurementPlan::default()
    };
    mixture_with(256, plan, measure)
}

fn mixture_with(count: u64, plan: RunPlan, measure: MeasurementPlan) -> Scene {
    let names = ["small", "middle", "large"];
    let sizes = [(0.8, 0.7), (1.0, 1.3), (1.2, 1.3)];
    let mut scene = SceneBuilder::new("mixture").seed(5);
    for (name, (diameter, mass)) in names.into_iter().zip(sizes) {
        scene = scene.species(SpeciesDraft::new(name).mass(mass).diameter(diameter));
    }
    for (k, a) in names.into_iter().enumerate() {
        for b in &names[..=k] {
            scene = scene.interaction(InteractionDraft::new(Model::HardSphere).between(a, b));
        }
    }
    let composition = names.map(|name| (name.to_owned(), 1.0)).to_vec();
    let fill = Fill { composition, ..Fill::new(Lattice::FaceCentredCubic, names[0]) };
    let scene = scene.fill(fill.count(count).packing_fraction(0.35)).temperature(1.0);
    scene.measure(measure).run(plan).build().unwrap()
}

/// Spheres with individual diameters.
fn sized(count: u64, plan: RunPlan) -> Scene {
    let diameters = DiameterDistribution::Uniform { lower: 0.8, upper: 1.2 };
    SceneBuilder::new("sized")
        .seed(5)
        .species(SpeciesDraft::new("A").mass(0.7).individual_diameters(MassRule::Volume).distributed(diameters))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).packing_fraction(0.35))
        .temperature(1.0)
        .run(plan)
        .build()
        .unwrap()
}

fn swap(interval: f64) -> Option<Swap> {
    Some(Swap { interval, attempts: None, largest_ratio: None })
}

/// Returns the final state, the results and the final volume of a run.
fn end(scene: &Scene, threads: usize, pause: Option<u64>) -> (Snapshot, String, f64) {
    let finished = finished_with_pauses(scene, threads, pause);
    assert!(finished.swaps.iter().all(|stage| stage.moves.accepted > 100), "{:?}", finished.swaps);
    let results = format!("{:?} {:?} {:?}", finished.observables, finished.volume_moves, finished.swaps);
    (finished.simulation.snapshot(), results, finished.simulation.volume())
}

#[test]
fn pauses_do_not_change_a_run_with_swap_moves() {
    let bath = Some(Thermostat::Andersen { temperature: 1.0, rate: 0.5, axes: [true; 3] });
    let stage = StagePlan {
        name: "mix".to_owned(),
        limit: Until::time(2.0),
        thermostat: bath,
        // Volume moves must know the exchanged species and diameters.
        barostat: Some(Barostat { pressure: 3.0, interval: 0.02, amplitude: Some(0.003) }),
        swap: swap(0.07),
        ..StagePlan::default()
    };
    let plan = RunPlan { stages: vec![stage], limit: Until::time(1.5), swap: swap(0.11), ..RunPlan::default() };
    for scene in [mixture(plan.clone()), sized(256, plan)] {
        let whole = end(&scene, 1, None);
        assert!((whole.2 / scene.space().volume() - 1.0).abs() > 0.005, "{}", whole.2);
        assert_eq!(end(&scene, 1, Some(1_234)), whole);
    }
}

#[test]
fn threads_do_not_change_a_run_with_swap_moves() {
    let plan = RunPlan { limit: Until::time(0.4), swap: swap(0.11), ..RunPlan::default() };
    // Smaller systems run on one thread.
    for scene in [mixture_with(4_000, plan.clone(), MeasurementPlan::default()), sized(4_000, plan)] {
        let whole = end(&scene, 1, None);
        assert_eq!(end(&scene, 2, Some(5_001)), whole);
        assert_eq!(end(&scene, 3, None), whole);
    }
}

#[test]
fn swap_moves_change_no_average() {
    let of = |swap| {
        let plan = RunPlan { equilibration: Until::time(5.0), limit: Until::time(60.0), swap, ..RunPlan::default() };
        Run::new(mixture(plan)).finish().unwrap()
    };
    let (with, without) = (of(swap(0.1)), of(None));
    assert!(with.swaps[1].moves.acceptance().unwrap() > 0.05, "{:?}", with.swaps);
    for name in ["compressibility_factor", "collision_rate"] {
        let [one, other] = [&with, &without].map(|finished| finished.observable(name).unwrap());
        let error = libm::hypot(one.standard_error.unwrap(), other.standard_error.unwrap());
        assert!((one.mean - other.mean).abs() < 5.0 * error, "{name}: {one:?} {other:?}");
        assert!(error < 0.02 * one.mean, "{name}: {error}");
    }
    // Instruments must know the current species and masses.
    let pairs = ["small_small", "small_middle", "small_large", "middle_middle", "middle_large", "large_large"];
    let contacts = pairs.map(|pair| format!("contact_value_{pair}"));
    for name in contacts.iter().map(String::as_str).chain(["compressibility_factor", "pressure_xx"]) {
        let [one, other] =
            [&with, &without].map(|finished| finished.measured.number(name).unwrap().estimate().unwrap());
        let error = libm::hypot(one.standard_error.unwrap(), other.standard_error.unwrap());
        assert!((one.mean - other.mean).abs() < 5.0 * error, "{name}: {one:?} {other:?}");
        assert!(error < 0.1 * one.mean, "{name}: {error} {one:?}");
    }
    // The rates by species depend on equipartition between the masses.
    let rates = |finished: &Finished| {
        let entries = finished.event_counts_by_species.entries();
        entries.into_iter().map(|(_, _, count)| count as f64).collect::<Vec<f64>>()
    };
    let (one, other) = (rates(&with), rates(&without));
    assert_eq!(one.len(), other.len());
    for (one, other) in one.iter().zip(&other) {
        // Counts of collisions fluctuate a little more than Poisson's distribution.
        assert!((one - other).abs() < 8.0 * (one + other).sqrt(), "{one} {other}");
    }
}

/// A run that ends after a number of events estimates its duration with a pilot run, whose swap moves must not remain.
#[test]
fn pilot_runs_leave_no_exchanged_species_behind() {
    let of = |limit| {
        let plan = RunPlan { limit, swap: swap(0.02), ..RunPlan::default() };
        let measure = MeasurementPlan {
            relaxation: Some(Relaxation { interval: Some(0.05), span: Some(1.0), ..Relaxation::default() }),
            ..MeasurementPlan::default()
        };
        Run::new(mixture_with(256, plan, measure)).finish().unwrap()
    };
    let by_events = of(Until::events(20_000));
    let by_time = of(Until::time(by_events.simulation.time()));
    let values = |finished: &Finished| finished.measured.curve("relaxation").unwrap().series[0].values.clone();
    let (one, other) = (values(&by_time), values(&by_events));
    assert!(one.len() > 6 && one.len() == other.len(), "{one:?} {other:?}");
    for (one, other) in one.into_iter().zip(other) {
        assert!((one.unwrap() - other.unwrap()).abs() < 1e-9, "{one:?} {other:?}");
    }
}
