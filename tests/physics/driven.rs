//! External drive: thermostats, sheared boxes, thermal walls.

use carom::Vector;
use carom::engine::event::EventKind;
use carom::engine::{Simulation, Snapshot};
use carom::model::MeasurementPlan;
use carom::model::measurement_plan as plan;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space, displacement_within_period};
use carom::model::{OutputPlan, RunPlan, Scene, StagePlan, Thermostat, Until};
use carom::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

use super::measure::{finish, hard, number};

fn fluid(name: &str, count: u64, fraction: f64) -> SceneBuilder {
    SceneBuilder::new(name)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).packing_fraction(fraction))
        .temperature(1.0)
}

#[test]
fn a_heat_bath_brings_a_fluid_to_its_temperature() {
    let bath = Thermostat::Andersen { temperature: 2.5, rate: 1.0, axes: [true; 3] };
    let run = RunPlan {
        equilibration: Until::time(10.0),
        limit: Until::time(100.0),
        thermostat: Some(bath),
        ..RunPlan::default()
    };
    let finished = finish(fluid("bath", 256, 0.3).run(run).build().unwrap());
    let (name, temperature) = finished.observables[0];
    assert_eq!(name, "temperature");
    let error = temperature.standard_error.unwrap();
    assert!((temperature.mean - 2.5).abs() < 4.0 * error && error < 0.05, "{temperature:?}");
    // Andersen collisions are a Poisson process with a mean rate of 256.
    let expected = 256.0 * 100.0;
    let collisions = finished.measurement.event_counts.thermostat as f64;
    assert!((collisions - expected).abs() < 4.0 * expected.sqrt(), "{collisions}");
}

#[test]
fn andersen_collisions_change_only_the_chosen_axes_of_one_particle() {
    let mut simulation = Simulation::without_plan(fluid("andersen", 108, 0.2).build().unwrap());
    let bath = Thermostat::Andersen { temperature: 4.0, rate: 2.0, axes: [false, true, false] };
    simulation.set_thermostat(Some(&bath), 0).unwrap();
    let (mut collisions, mut squares) = (0, 0.0);
    simulation
        .advance_with(Until::time(20.0), |event| {
            if event.kind == EventKind::Thermostat {
                collisions += 1;
                let (before, after) = (event.before[0], event.after[0]);
                assert_eq!((before.x, before.z), (after.x, after.z));
                assert_ne!(before.y, after.y);
                squares += after.y * after.y;
            }
        })
        .unwrap();
    assert_eq!(simulation.event_counts().thermostat, collisions);
    // If x is Gaussian with mean 0, the variance of `x^2` is `2 <x^2>^2`.
    let mean = squares / collisions as f64;
    assert!((mean / 4.0 - 1.0).abs() < 4.0 * (2.0 / collisions as f64).sqrt(), "{mean}");
}

#[test]
fn a_heat_bath_leaves_flat_axes_alone() {
    for (dimensions, size) in [(1, Vector::new(400.0, 0.0, 0.0)), (2, Vector::new(20.0, 20.0, 0.0))] {
        let boundary = std::array::from_fn(|axis| if axis < dimensions { Boundary::Periodic } else { Boundary::Flat });
        let bath = Thermostat::Andersen { temperature: 1.5, rate: 1.0, axes: [true; 3] };
        let run = RunPlan { limit: Until::time(60.0), thermostat: Some(bath), ..RunPlan::default() };
        let scene = SceneBuilder::new("flat")
            .space(Space { lower: Vector::zeros(), size, boundary })
            .species(SpeciesDraft::new("A").mass(1.7).diameter(1.0))
            .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
            .fill(Fill::new(Arrangement::Random, "A").count(150))
            .temperature(1.5)
            .run(run)
            .build()
            .unwrap();
        let expected: [bool; 3] = std::array::from_fn(|axis| axis < dimensions);
        assert!(matches!(scene.run().thermostat, Some(Thermostat::Andersen { axes, .. }) if axes == expected));
        let finished = finish(scene);
        let snapshot = finished.simulation.snapshot();
        for axis in dimensions..3 {
            let moved = |vectors: &[Vector]| vectors.iter().any(|vector| vector[axis] != 0.0);
            assert!(!moved(&snapshot.velocities) && !moved(&snapshot.positions), "{dimensions} {axis}");
        }
        let (name, temperature) = finished.observables[0];
        let error = temperature.standard_error.unwrap();
        assert_eq!(name, "temperature");
        assert!((temperature.mean - 1.5).abs() < 4.0 * error && error < 0.05, "{dimensions}: {temperature:?}");
        let mut simulation = finished.simulation;
        simulation.set_thermostat(Some(&bath), 1).unwrap();
        simulation.advance(Until::time(70.0)).unwrap();
        assert!(simulation.snapshot().velocities.iter().all(|v| (dimensions..3).all(|axis| v[axis] == 0.0)));
    }
}

#[test]
fn thermostats_that_can_do_nothing_are_refused() {
    let refused = |builder: SceneBuilder, thermostat: Thermostat, expected: &str| {
        let run = RunPlan { limit: Until::time(1.0), thermostat: Some(thermostat), ..RunPlan::default() };
        let error = builder.run(run).build().unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let scaling = Thermostat::Rescaling { temperature: 1.0, interval: 0.1 };
    refused(fluid("falling", 108, 0.2).gravity(Vector::new(0.0, 0.0, -0.1)), scaling, "without gravity");
    let one = SceneBuilder::new("one")
        .space(Space::periodic_cube(5.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"));
    refused(one.particle("A", Vector::repeat(0.5), Vector::repeat(1.0)), scaling, "two or more moving particles");
    let flat = Space {
        size: Vector::new(9.0, 9.0, 0.0),
        boundary: [Boundary::Periodic, Boundary::Periodic, Boundary::Flat],
        ..Space::periodic_cube(9.0)
    };
    let disks = SceneBuilder::new("disks")
        .space(flat)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"));
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [false, false, true] };
    refused(disks.fill(Fill::new(Arrangement::Random, "A").count(20)).temperature(1.0), bath, "flat");
}

/// Returns pressures of an inelastic gas with a rescaling thermostat. `block` is the interval of the tensor averages.
fn scaled_gas(block: f64) -> Vec<(String, f64)> {
    let scaling = Thermostat::Rescaling { temperature: 1.0, interval: 0.25 };
    let tensor = plan::PressureTensor { interval: Some(block) };
    let builder = SceneBuilder::new("gas")
        .species(SpeciesDraft::new("A").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A").restitution(0.8))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(256).packing_fraction(0.2))
        .temperature(1.0)
        .run(RunPlan { limit: Until::time(20.0), thermostat: Some(scaling), ..RunPlan::default() })
        .measure(MeasurementPlan { pressure_tensor: Some(tensor), ..MeasurementPlan::default() });
    let finished = finish(builder.build().unwrap());
    let is_pressure = |name: &str| name.starts_with("pressure");
    let numbers = finished.measured.numbers.into_iter().filter(|number| is_pressure(&number.name));
    numbers.map(|number| (number.name, number.mean.unwrap())).collect()
}

#[test]
fn pressure_includes_rescaling_whatever_the_block_length() {
    // The runs differ only in the order of additions.
    let [few, many] = [5.0, 0.1].map(scaled_gas);
    assert!(few.len() > 1);
    for ((name, few), (_, many)) in few.iter().zip(&many) {
        assert!((few - many).abs() < 1e-10, "{name} {few} {many}");
    }
}

#[test]
fn scaling_holds_the_temperature_and_its_energy_is_counted() {
    let scaling = Thermostat::Rescaling { temperature: 3.0, interval: 0.7 };
    let run = RunPlan { limit: Until::time(5.0), thermostat: Some(scaling), ..RunPlan::default() };
    let finished = finish(fluid("scaling", 256, 0.4).run(run).build().unwrap());
    assert!((finished.audit.event_counts.supplied.total() / (1.5 * 255.0 * 2.0) - 1.0).abs() < 1e-12);
}

/// Asserts that spheres overlap at most by round-off. The next periodic image along y is displaced along x by `shift`.
pub fn assert_no_overlap(scene: &Scene, snapshot: &Snapshot, shift: f64, diameters: &dyn Fn(usize) -> f64) {
    let size = scene.space().size;
    for (i, a) in snapshot.positions.iter().enumerate() {
        for (j, b) in snapshot.positions.iter().enumerate().skip(i + 1) {
            let mut apart: Vector = a - b;
            let up = (apart.y / size.y).round();
            apart.y -= up * size.y;
            apart.x -= up * shift;
            apart.x -= size.x * (apart.x / size.x).round();
            apart.z -= size.z * (apart.z / size.z).round();
            let contact = 0.5 * (diameters(i) + diameters(j));
            assert!(apart.norm() > contact * (1.0 - 1e-12), "{i} {j}: {} at {}", apart.norm(), snapshot.time);
        }
    }
}

#[test]
fn sheared_box_misses_no_contact() {
    // At the higher shear rate, periodic images slide by a diameter between two contacts.
    for rate in [0.1, 3.0] {
        let mut simulation = Simulation::without_plan(fluid("shear", 256, 0.35).shear(rate).build().unwrap());
        let scene = simulation.scene().clone();
        for part in 1..=40 {
            simulation.advance(Until::time(0.1 * f64::from(part))).unwrap();
            let snapshot = simulation.snapshot();
            let slid = rate * scene.space().size.y * snapshot.time;
            assert_no_overlap(&scene, &snapshot, slid, &|_| 1.0);
            let within = displacement_within_period(slid, scene.space().size.x);
            assert!((snapshot.displacement - within).abs() < 1e-12, "{} {within}", snapshot.displacement);
        }
        assert!(simulation.event_counts().core > 5_000);
        let energy = simulation.energy();
        let supplied = simulation.event_counts().supplied.total();
        assert!(energy.thermal > 1.5 * 255.0 && supplied > 0.0);
        let start: f64 = scene.particles().iter().map(|particle| 0.5 * particle.velocity.norm_squared()).sum();
        assert!(((energy.kinetic - start) / supplied - 1.0).abs() < 1e-11, "{} {supplied}", energy.kinetic - start);
    }
}

#[test]
fn gas_between_equal_thermal_walls_takes_their_temperature() {
    let walls = carom::model::space::Boundary::walls(1.0);
    let fill = Fill::new(Lattice::SimpleCubic, "A").count(216).packing_fraction(0.05);
    let run = RunPlan { equilibration: Until::time(200.0), limit: Until::time(1500.0), ..RunPlan::default() };
    let scene = SceneBuilder::new("walls")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .boundary([walls; 3])
        .fill(fill)
        .temperature(5.0)
        .wall_temperature(0, 1.5)
        .wall_temperature(2, 1.5)
        .run(run)
        .build()
        .unwrap();
    let finished = finish(scene);
    let temperature = finished.observables[0].1;
    let error = temperature.standard_error.unwrap();
    // Without the weight of the normal velocity at thermal walls, the gas would be a fifth colder.
    assert!((temperature.mean - 1.5).abs() < 4.0 * error && error < 0.02, "{temperature:?}");
    assert!(finished.audit.event_counts.supplied.total() < 0.0, "it was hotter at the start");
}

fn granular(mass: f64) -> SceneBuilder {
    SceneBuilder::new("granular")
        .species(SpeciesDraft::new("A").mass(mass).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A").restitution(0.8))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.15))
        .temperature(1.0)
}

#[test]
fn means_of_a_rescaled_gas_do_not_depend_on_the_row_interval() {
    let measured = |interval: f64| {
        let thermostat = Some(Thermostat::Rescaling { temperature: 1.0, interval: 1.0 });
        let scene = granular(1.0)
            .output(OutputPlan { thermo_interval: Some(interval), ..OutputPlan::default() })
            .run(RunPlan { limit: Until::time(50.0), thermostat, ..RunPlan::default() });
        let finished = finish(scene.build().unwrap());
        let of = |name: &str| finished.observable(name).unwrap().mean;
        [of("temperature"), of("pressure"), of("compressibility_factor")]
    };
    let (seldom, often) = (measured(1.0), measured(0.0173));
    assert!(often[0] < 0.9, "it cools by a good part between two scalings: {often:?}");
    for (a, b) in seldom.into_iter().zip(often) {
        // The runs differ only in the order in which about 3000 terms are added.
        assert!((a / b - 1.0).abs() < 1e-11, "{seldom:?} {often:?}");
    }
}

#[test]
fn samples_of_a_rescaled_gas_cover_the_time_between_scalings() {
    let scaling = Thermostat::Rescaling { temperature: 1.0, interval: 1.0 };
    let profile =
        plan::Profile { name: "all".into(), bins: [1; 3], lower: None, upper: None, interval: None, species: None };
    let speeds = plan::Speeds { windows: Some(1), ..plan::Speeds::default() };
    let scene = granular(2.3)
        // At equal intervals, each of the 200 samples would be just after a rescaling.
        .run(RunPlan { limit: Until::time(200.0), thermostat: Some(scaling), ..RunPlan::default() })
        .measure(MeasurementPlan { profiles: vec![profile], speeds: Some(speeds), ..MeasurementPlan::default() });
    let finished = finish(scene.build().unwrap());
    let exact = finished.observables[0].1.mean;
    assert!(exact < 0.95, "{exact}");
    let profile = finished.measured.curve("profile_all").unwrap();
    let temperature = profile.series.iter().find(|series| series.name == "temperature").unwrap();
    let (mean, error) = (temperature.values[0].unwrap(), temperature.standard_errors[0].unwrap());
    assert!((mean - exact).abs() < 4.0 * error && error < 0.02, "{mean} +- {error}, {exact}");
}

#[test]
fn net_momentum_left_by_a_heat_bath_counts_in_no_temperature() {
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 2.0, axes: [true; 3] };
    let stage =
        StagePlan { name: "heat".into(), limit: Until::time(3.0), thermostat: Some(bath), ..StagePlan::default() };
    let run = RunPlan { stages: vec![stage], limit: Until::time(5.0), ..RunPlan::default() };
    let finished = finish(fluid("moving", 32, 0.3).run(run).build().unwrap());
    let energy = finished.simulation.energy();
    let common = energy.momentum.norm_squared() / 64.0;
    assert!(common > 0.01, "{common}");
    // The measurement conserves momentum, so 3 (N - 1) velocity components are free.
    let expected = 2.0 * (energy.kinetic - common) / 93.0;
    let temperature = finished.observable("temperature").unwrap();
    assert!((temperature.mean / expected - 1.0).abs() < 1e-12, "{temperature:?} {expected}");
}

#[test]
fn vanishing_shear_rate_gives_the_pressure_at_rest() {
    let pressure = |rate: Option<f64>| {
        let fluid = fluid("slow", 32, 0.1).run(RunPlan { limit: Until::time(200.0), ..RunPlan::default() });
        let scene = rate.map_or(fluid.clone(), |rate| fluid.shear(rate));
        let finished = finish(
            scene
                .measure(MeasurementPlan { pressure_tensor: Some(Default::default()), ..MeasurementPlan::default() })
                .build()
                .unwrap(),
        );
        let (pressure, error) = number(&finished.measured, "pressure");
        (finished.observable("temperature").unwrap().mean, pressure, error)
    };
    let (rest, sheared) = (pressure(None), pressure(Some(1e-9)));
    assert!((sheared.0 - rest.0).abs() < 1e-6, "{rest:?} {sheared:?}");
    // After the first contacts, the trajectories differ, so the pressures agree only within their errors. A wrong
    // number of degrees of freedom, 33 particles instead of 32, would change the pressure by 3 %.
    let error = rest.2.hypot(sheared.2);
    assert!((sheared.1 - rest.1).abs() < 4.0 * error && error < 0.01 * rest.1, "{rest:?} {sheared:?}");
}

#[test]
fn passages_after_the_last_sample_are_counted() {
    let gate = plan::Flow {
        name: "gate".into(),
        axis: Some("x".into()),
        normal: None,
        at: 1.0,
        lower: None,
        upper: None,
        species: None,
        interval: Some(50.0),
        direction: None,
        window: None,
        outlet: None,
    };
    let scene = SceneBuilder::new("two")
        .space(Space::periodic_cube(3.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.1))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .particle("A", Vector::new(0.5, 0.5, 0.5), Vector::new(1.0, 0.0, 0.0))
        .particle("A", Vector::new(2.0, 2.0, 2.0), Vector::new(1.0, 0.0, 0.0))
        .measure(MeasurementPlan { flows: vec![gate], ..MeasurementPlan::default() })
        .run(RunPlan { limit: Until::time(30.2), ..RunPlan::default() });
    let finished = finish(scene.build().unwrap());
    // The particles cross the gate at the times 0.5 + 3 k and 2 + 3 k. Each particle crosses it ten times before 30.2.
    assert_eq!(finished.measured.numbers[0].mean, Some(20.0));
}

fn bath_collisions(scene: SceneBuilder, temperature: f64) -> Vec<(u64, u32)> {
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    let bath = Thermostat::Andersen { temperature, rate: 2.0, axes: [true; 3] };
    simulation.set_thermostat(Some(&bath), 0).unwrap();
    let mut collisions = Vec::new();
    simulation
        .advance_with(Until::time(1.0), |event| {
            if event.kind == EventKind::Thermostat {
                collisions.push((event.time.to_bits(), event.particle.0));
            }
        })
        .unwrap();
    assert!(collisions.len() > 50);
    collisions
}

#[test]
fn different_state_points_with_one_seed_have_different_random_numbers() {
    let pair = || fluid("pair", 108, 0.2);
    let first = bath_collisions(pair(), 1.0);
    assert_eq!(first, bath_collisions(fluid("another_name", 108, 0.2), 1.0), "names change nothing");
    assert_eq!(
        first,
        bath_collisions(pair().species(SpeciesDraft::new("unused").mass(0.7).diameter(0.3)), 1.0),
        "nor do species without particles"
    );
    let well = Potential::square_well(1.0, 1.5, 0.4).unwrap();
    let wells = SceneBuilder::new("pair")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(well).between("A", "A"));
    let wells = wells.fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.2)).temperature(1.0);
    let others = [
        ("temperature", bath_collisions(pair(), 1.1)),
        ("packing fraction", bath_collisions(fluid("pair", 108, 0.21), 1.0)),
        ("potential", bath_collisions(wells, 1.0)),
        ("seed", bath_collisions(pair().seed(99), 1.0)),
    ];
    for (what, other) in others {
        let shared = first.iter().zip(&other).filter(|(a, b)| a.0 == b.0).count();
        assert_eq!(shared, 0, "{what}");
    }
}
