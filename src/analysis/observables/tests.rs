//! Means of temperature and energy, compared with integrals from event to event.

use super::Observer;
use crate::Vector;
use crate::analysis::statistics::Stationarity;
use crate::engine::{Simulation, Until};
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{FillRegion, Region, Scene, SurfaceShape, Thermostat};
use crate::scene::{Arrangement, Fill, InletDraft, InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};

fn mixture(space: Space) -> SceneBuilder {
    let well = |diameter, depth| Potential::square_well(diameter, 1.4, depth).unwrap();
    let fill =
        |species: &str, count| Fill { temperature: Some(1.3), ..Fill::new(Arrangement::Random, species).count(count) };
    SceneBuilder::new("mixture")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(3.1).diameter(1.2))
        .interaction(InteractionDraft::new(well(1.0, 0.9)).between("A", "A").restitution(0.8))
        .interaction(InteractionDraft::new(well(1.1, -0.3)).between("A", "B").restitution(0.9))
        .interaction(InteractionDraft::new(well(1.2, 0.5)).between("B", "B").restitution(0.7))
        .fill(fill("A", 12))
        .fill(fill("B", 7))
}

/// Means of the kinetic energy and of the pair energy, each from an observer and from a sum over all events.
fn means(scene: Scene, bath: Option<&Thermostat>) -> [[f64; 2]; 2] {
    let mut observer = Observer::new(&scene);
    observer.set_thermostat(&scene, bath);
    let freedom = observer.applicable().degrees_of_freedom;
    let mut simulation = Simulation::without_plan(scene);
    simulation.set_planned_thermostat(bath, 7, 0);
    simulation.advance(Until::time(0.3)).unwrap();
    observer.row(&simulation);
    let count = simulation.scene().particles.len() as f64;
    let energies = |simulation: &Simulation| [simulation.energy().kinetic, simulation.energy().pair];
    let (mut now, mut last, mut sums) = (simulation.time(), energies(&simulation), [0.0; 2]);
    let (from, to) = (now, 4.0);
    let mut events = simulation.events(Until::time(to));
    while let Some(event) = events.next() {
        let event = event.unwrap();
        (0..2).for_each(|k| sums[k] += last[k] * (event.time - now));
        (now, last) = (event.time, energies(events.simulation()));
    }
    (0..2).for_each(|k| sums[k] += last[k] * (to - now));
    observer.row(&simulation);
    let mean = |name: &str| observer.estimates().iter().find(|(known, _)| *known == name).unwrap().1.mean;
    let observed = [0.5 * freedom * mean("temperature"), count * mean("potential_energy_per_particle")];
    [observed, sums.map(|sum| sum / (to - from))]
}

#[test]
fn means_of_temperature_and_energy_are_exact_however_rare_the_rows_are() {
    let bath = Thermostat::Andersen { temperature: 1.3, rate: 2.0, axes: [true; 3] };
    let cube = Space::periodic_cube(5.3);
    let slit = Space { boundary: [Boundary::walls(0.9), Boundary::Periodic, Boundary::Periodic], ..cube.clone() };
    let flat =
        Space { boundary: [Boundary::Periodic, Boundary::Periodic, Boundary::Flat], ..Space::periodic_cube(9.0) };
    let flat = Space { size: crate::Vector::new(9.0, 9.0, 0.0), ..flat };
    for (what, scene, bath) in [
        ("bath", mixture(cube.clone()), Some(&bath)),
        ("cooling slit", mixture(slit.clone()), None),
        ("thermal walls", mixture(slit).wall_temperature(0, 0.8), None),
        ("bath in a plane", mixture(flat), Some(&bath)),
    ] {
        let [observed, exact] = means(scene.build().unwrap(), bath);
        for k in 0..2 {
            let scale = exact[0].abs() + exact[1].abs();
            assert!((observed[k] - exact[k]).abs() < 1e-11 * scale, "{what}, {k}: {observed:?} {exact:?}");
        }
    }
}

fn elastic(space: Space, count: u64) -> SceneBuilder {
    let fill = Fill { temperature: Some(1.3), ..Fill::new(Arrangement::Random, "A").count(count) };
    SceneBuilder::new("elastic")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(fill)
}

fn of_temperature(
    scene: &Scene,
    bath: Option<&Thermostat>,
    intervals: u32,
    change: impl Fn(&mut Simulation),
) -> (Option<f64>, Stationarity) {
    let mut observer = Observer::new(scene);
    observer.set_thermostat(scene, bath);
    let mut simulation = Simulation::without_plan(scene.clone());
    simulation.set_planned_thermostat(bath, 7, 0);
    for row in 0..=intervals {
        simulation.advance(Until::time(0.7 * f64::from(row))).unwrap();
        observer.row(&simulation);
        change(&mut simulation);
    }
    let stationarity = observer.stationarity().into_iter().find(|(name, _)| *name == "temperature").unwrap().1;
    let (_, estimate) = observer.estimates().into_iter().find(|(name, _)| *name == "temperature").unwrap();
    (estimate.standard_error, stationarity)
}

#[test]
fn a_conserved_temperature_has_no_error_however_short_or_long_the_run_is() {
    let cube = Space::periodic_cube(5.3);
    let slit = |e| Space { boundary: [Boundary::walls(e), Boundary::Periodic, Boundary::Periodic], ..cube.clone() };
    let scaling = Thermostat::Rescaling { temperature: 1.3, interval: 0.25 };
    let andersen = Thermostat::Andersen { temperature: 1.3, rate: 1.0, axes: [true; 3] };
    let cases = [
        ("fluid", elastic(cube.clone(), 40), None),
        ("two", elastic(cube.clone(), 2), None),
        ("slit", elastic(slit(1.0), 40), None),
        ("scaled", elastic(cube.clone(), 40), Some(&scaling)),
    ];
    for (what, scene, bath) in &cases {
        let scene = scene.build().unwrap();
        for intervals in [1, 3, 30, 300] {
            let found = of_temperature(&scene, *bath, intervals, |_| ());
            assert_eq!(found, (Some(0.0), Stationarity::Constant), "{what}, {intervals} intervals");
        }
    }
    let changing = [
        ("heat bath", elastic(cube.clone(), 40), Some(&andersen)),
        ("wall that dissipates", elastic(slit(0.9), 40), None),
        ("thermal wall", elastic(slit(1.0), 40).wall_temperature(0, 1.0), None),
        ("shear", elastic(cube.clone(), 40).shear(0.1), None),
        ("wells", mixture(cube.clone()), None),
    ];
    for (what, scene, bath) in &changing {
        let found = of_temperature(&scene.build().unwrap(), *bath, 5, |_| ());
        assert_eq!(found, (None, Stationarity::Unknown), "{what}");
    }
    let scene = elastic(cube, 40).build().unwrap();
    let faster = |simulation: &mut Simulation| simulation.scale_velocities(1.1, &crate::Vector::zeros());
    assert_eq!(of_temperature(&scene, None, 5, faster), (None, Stationarity::Unknown), "set by a program");
}

fn on_a_line(mass: f64, potential: &Potential) -> SceneBuilder {
    let boundary = [Boundary::Periodic, Boundary::Flat, Boundary::Flat];
    let space = Space { boundary, size: Vector::new(9.0, 0.0, 0.0), ..Space::periodic_cube(9.0) };
    let mut builder = SceneBuilder::new("line").space(space);
    for (name, mass) in [("A", 1.3), ("B", mass)] {
        builder = builder.species(SpeciesDraft::new(name).mass(mass).diameter(1.0));
    }
    for pair in [["A", "A"], ["A", "B"], ["B", "B"]] {
        builder = builder.interaction(InteractionDraft::new(potential.clone()).between(pair[0], pair[1]));
    }
    for (name, x, v) in [("A", 1.0, 0.9), ("A", 4.0, -0.4), ("B", 7.0, 0.2)] {
        builder = builder.particle(name, Vector::new(x, 0.0, 0.0), Vector::new(v, 0.0, 0.0));
    }
    builder
}

#[test]
fn particles_that_enter_or_leave_change_the_velocities_on_a_line() {
    let line = || on_a_line(1.3, &Potential::hard_sphere(1.0).unwrap());
    let only_exchanges = |scene: &SceneBuilder| scene.build().unwrap().only_exchanges_velocities_with(None);
    assert!(only_exchanges(&line()));
    let region = FillRegion::Box(Region { lower: Vector::zeros(), upper: Vector::x() * 9.0 });
    let inlet = InletDraft::new("rain", region).species("A").rate(1.0);
    assert!(!only_exchanges(&line().inlet(inlet)));
    let drain = SurfaceShape::Sphere { centre: Vector::x() * 5.7, radius: 0.1, is_inside: false };
    assert!(!only_exchanges(&line().surface(SurfaceDraft::new("drain", drain).outlet())));
}

#[test]
fn equal_hard_particles_on_a_line_have_no_errors() {
    let hard = Potential::hard_sphere(1.0).unwrap();
    let well = Potential::square_well(1.0, 1.5, 0.2).unwrap();
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 1.0, axes: [true; 3] };
    let observed = |builder: SceneBuilder, bath: Option<&Thermostat>| {
        let mut simulation = Simulation::without_plan(builder.build().unwrap());
        simulation.set_thermostat(bath, 0).unwrap();
        let mut observer = Observer::new(simulation.scene());
        observer.set_thermostat(simulation.scene(), bath);
        for row in 0..400 {
            simulation.advance(Until::time(2.5 * f64::from(row))).unwrap();
            observer.row(&simulation);
        }
        let pressure = observer.estimates().into_iter().find(|(name, _)| *name == "pressure").unwrap().1;
        let answer =
            observer.equilibrium(&observer.stationarity(), simulation.event_counts(), simulation.scene().units());
        (pressure.standard_error.is_some(), answer.to_string())
    };
    let (has_error, answer) = observed(on_a_line(1.3, &hard), None);
    assert!(!has_error && answer.contains("only exchange velocities"), "{answer}");
    for (builder, bath) in
        [(on_a_line(2.1, &hard), None), (on_a_line(1.3, &well), None), (on_a_line(1.3, &hard), Some(&bath))]
    {
        let (has_error, answer) = observed(builder, bath);
        assert!(has_error && !answer.contains("exchange"), "{answer}");
    }
}
