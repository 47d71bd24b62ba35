use std::convert::Infallible;
use std::ops::ControlFlow;

use super::*;
use crate::Vector;
use crate::analysis::instruments::test_system::{Recorded, equilibrate, instrument, measure, number, report, start};
use crate::analysis::observables::Row;
use crate::engine::{Simulation, Snapshot, Until};
use crate::model::space::{Boundary, Face, Space};
use crate::model::{ContactLaw, MassRule, OutputPlan, RunPlan, Scene};
use crate::run::{Recorder, Run, Stage};
use crate::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

const DIAMETERS: [f64; 3] = [1.4, 0.8, 1.1];
const MASSES: [f64; 3] = [1.7, 0.9, 2.3];

fn plan(interval: f64) -> Plan {
    Plan { interval: Some(interval), bins: None }
}

const PAIRS: [(&str, &str); 6] = [("A", "A"), ("A", "B"), ("B", "B"), ("A", "C"), ("B", "C"), ("C", "C")];

/// Three unlike balls on top of each other on the floor of a pipe, with the TC model.
fn column() -> SceneBuilder {
    let mut scene = pipe();
    for ((name, diameter), mass) in ["A", "B", "C"].into_iter().zip(DIAMETERS).zip(MASSES) {
        scene = scene.species(SpeciesDraft::new(name).mass(mass).diameter(diameter));
    }
    for (one, other) in PAIRS {
        scene = scene.interaction(InteractionDraft::new(Model::HardSphere).between(one, other).restitution(0.5));
    }
    ["A", "B", "C"]
        .into_iter()
        .zip(heights())
        .fold(scene, |scene, (name, height)| scene.particle(name, Vector::new(4.0, 4.0, height), Vector::zeros()))
}

/// The same balls with individual diameters. Their masses are proportional to their volumes.
fn individual_column() -> SceneBuilder {
    let scene = pipe()
        .species(SpeciesDraft::new("A").mass(MASSES[0]).diameter(DIAMETERS[0]).individual_diameters(MassRule::Volume))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(0.5));
    DIAMETERS.into_iter().zip(heights()).fold(scene, |scene, (diameter, height)| {
        scene.sized_particle("A", diameter, Vector::new(4.0, 4.0, height), Vector::zeros())
    })
}

/// Heights of the centres of the balls.
fn heights() -> [f64; 3] {
    let [a, b, c] = DIAMETERS;
    [0.5 * a, a + 0.5 * b, a + b + 0.5 * c]
}

fn pipe() -> SceneBuilder {
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(0.5)), upper: Face::Open };
    let space = Space { boundary: [Boundary::Periodic, Boundary::Periodic, floor], ..Space::periodic_cube(9.0) };
    SceneBuilder::new("column").space(space).gravity(Vector::new(0.0, 0.0, -1.3)).contact_time(1e-3)
}

/// `V stress_zz` of the balls in the column: each contact adds the weight above it times the radius.
fn exact(masses: [f64; 3]) -> [f64; 3] {
    let [a, b, c] = masses.map(|mass| 1.3 * mass);
    let weights = [a + b + c, b + c, c, 0.0];
    [0, 1, 2].map(|ball| 0.5 * DIAMETERS[ball] * (weights[ball] + weights[ball + 1]))
}

fn volume(ball: usize) -> f64 {
    own_volume(DIAMETERS[ball], 3)
}

#[test]
fn balls_in_a_column_carry_the_weight_above_them() {
    check_column(column(), MASSES);
}

#[test]
fn balls_with_individual_diameters_carry_the_weight_above_them() {
    check_column(individual_column(), DIAMETERS.map(|diameter| MASSES[0] * (diameter / DIAMETERS[0]).powi(3)));
}

fn check_column(scene: SceneBuilder, masses: [f64; 3]) {
    let (system, mut simulation) = start(scene.build().unwrap());
    simulation.advance(Until::time(1.0)).unwrap();
    let mut stress =
        instrument(&simulation, &system, 40.0, |setup| Recorded::new(ParticleStress::new(&plan(4.0), setup)));
    measure(&mut simulation, &system, &mut stress, 40.0);
    let snapshot = simulation.snapshot();
    let columns = scalars(Some(&stress.again), &Sample::of(&snapshot), &system);
    let names: Vec<&str> = columns.iter().map(|column| &*column.name).collect();
    let stresses = ["xx", "yy", "zz", "xy", "xz", "yz"].map(|name| format!("contact_stress_{name}"));
    assert_eq!(names[0], "contact_pressure");
    assert_eq!(names[1..], stresses);
    let mut pressures = [0.0; 3];
    for (ball, exact) in exact(masses).into_iter().enumerate() {
        let [pressure, x, y, z, ..] = [0, 1, 2, 3].map(|column: usize| columns[column].values[ball] * volume(ball));
        // In an interval of 4, the balls gain momentum of up to `m g t_c`.
        assert!((z / exact - 1.0).abs() < 1e-3, "{ball}: {z} {exact}");
        assert!(x.abs() + y.abs() < 1e-12 && (pressure - z / 3.0).abs() < 1e-12);
        pressures[ball] = exact / 3.0 / volume(ball);
    }
    let measured = report(&stress, &system);
    let mean = pressures.iter().sum::<f64>() / 3.0;
    assert!((number(&measured, "contact_pressure").mean.unwrap() / mean - 1.0).abs() < 1e-3);
    let square = pressures.iter().map(|pressure| (pressure - mean).powi(2)).sum::<f64>() / 3.0;
    let deviation = number(&measured, "contact_pressure_deviation").mean.unwrap();
    assert!((deviation / (square.sqrt() / mean) - 1.0).abs() < 5e-3, "{deviation} {}", square.sqrt() / mean);
    // Ten intervals of three balls, in bins of width 0.1.
    let densities = &measured.curves[0].series[0].values;
    for pressure in pressures {
        let bin = Bins::over(0.0, LARGEST, 100).index(pressure / mean).unwrap();
        assert!((densities[bin].unwrap() - 10.0 / 3.0).abs() < 1e-12, "{pressure}");
    }
    assert!((densities.iter().flatten().sum::<f64>() * 0.1 - 1.0).abs() < 1e-12);
}

/// A mixture in two or three dimensions, with walls along y. Its contacts are rough, so that `r_a J_b` is not symmetric.
fn mixture(is_flat: bool) -> Scene {
    let wall =
        Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(1.0)), upper: Face::Wall(ContactLaw::smooth(1.0)) };
    let last = if is_flat { Boundary::Flat } else { Boundary::Periodic };
    let size = Vector::new(9.0, 8.0, if is_flat { 0.0 } else { 7.0 });
    let space = Space { boundary: [Boundary::Periodic, wall, last], size, ..Space::periodic_cube(9.0) };
    let mut scene = SceneBuilder::new("mixture").seed(7).space(space);
    for ((name, diameter), mass) in ["A", "B", "C"].into_iter().zip(DIAMETERS).zip(MASSES) {
        scene = scene.species(SpeciesDraft::new(name).mass(mass).diameter(diameter));
    }
    for (one, other) in PAIRS {
        let contact = InteractionDraft::new(Model::HardSphere).between(one, other);
        scene = scene.interaction(contact.tangential_restitution(0.3));
    }
    for name in ["A", "B", "C"] {
        scene = scene.fill(Fill::new(Arrangement::Random, name).count(8));
    }
    scene.temperature(1.3).build().unwrap()
}

#[test]
fn stresses_of_all_particles_add_up_to_the_virial() {
    for is_flat in [false, true] {
        let scene = mixture(is_flat);
        let (system, mut simulation) = start(scene);
        equilibrate(&mut simulation, 50);
        let dimensions = if is_flat { 2 } else { 3 };
        let mut stress =
            instrument(&simulation, &system, 20.0, |setup| Recorded::new(ParticleStress::new(&plan(20.0), setup)));
        let mut expected = [0.0; 9];
        let end = simulation.time() + 20.0;
        let show = |event: &Event| {
            stress.event(event, &system);
            let line = event.normal * event.distance;
            (0..9).for_each(|k| expected[k] += line[k / 3] * event.impulse[k % 3]);
        };
        simulation.advance_with(Until::time(end), show).unwrap();
        let snapshot = simulation.snapshot();
        stress.sample(&Sample { time: end, ..Sample::of(&snapshot) }, &system);
        let columns = scalars(Some(&stress.again), &Sample::of(&snapshot), &system);
        assert_eq!(columns.len(), if is_flat { 4 } else { 7 });
        let volumes: Vec<f64> =
            snapshot.species.iter().map(|id| own_volume(DIAMETERS[id.0 as usize], dimensions)).collect();
        for column in &columns[1..] {
            let [a, b] = [2, 1].map(|back| column.name.as_bytes()[column.name.len() - back] - b'x').map(usize::from);
            let sum: f64 = column.values.iter().zip(&volumes).map(|(value, volume)| value * volume * 20.0).sum();
            let exact = 0.5 * (expected[3 * a + b] + expected[3 * b + a]);
            assert!((sum - exact).abs() < 1e-11 * expected[0], "{}: {sum} {exact}", column.name);
        }
    }
}

#[test]
fn a_contact_divides_the_line_in_the_ratio_of_the_diameters() {
    // Two rods of different diameters collide once. Both have the same impulse, and each the stress `J R / (2 R t)`.
    let space = Space { boundary: [Boundary::OPEN, Boundary::Flat, Boundary::Flat], ..Space::periodic_cube(9.0) };
    let scene = SceneBuilder::new("rods")
        .space(Space { size: Vector::new(20.0, 0.0, 0.0), ..space })
        .species(SpeciesDraft::new("A").mass(1.7).diameter(1.4))
        .species(SpeciesDraft::new("B").mass(0.6).diameter(0.5))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "B"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("B", "B"))
        .particle("A", Vector::new(3.0, 0.0, 0.0), Vector::new(1.0, 0.0, 0.0))
        .particle("B", Vector::new(6.0, 0.0, 0.0), Vector::new(-1.0, 0.0, 0.0))
        .build()
        .unwrap();
    let (system, mut simulation) = start(scene);
    let mut stress =
        instrument(&simulation, &system, 4.0, |setup| Recorded::new(ParticleStress::new(&plan(4.0), setup)));
    let of = |simulation: &Simulation, stress: &ParticleStress| {
        scalars(Some(stress), &Sample::of(&simulation.snapshot()), &system)
    };
    assert_eq!(of(&simulation, &stress.again)[0].values, [0.0; 2]);
    measure(&mut simulation, &system, &mut stress, 4.0);
    let impulse = 2.0 * 1.7 * 0.6 / 2.3 * 2.0;
    for column in of(&simulation, &stress.again) {
        for value in column.values {
            assert!((value - impulse / 8.0).abs() < 1e-14, "{}: {value}", column.name);
        }
    }
    // An interval without contacts.
    measure(&mut simulation, &system, &mut stress, 4.0);
    assert_eq!(of(&simulation, &stress.again)[0].values, [0.0; 2]);
    let mean = number(&report(&stress, &system), "contact_pressure").mean.unwrap();
    assert!((mean - impulse / 16.0).abs() < 1e-14, "{mean}");
}

#[test]
fn particles_that_enter_have_their_own_diameters() {
    let text = "seed = 4\n\
        space = { size = [5.0, 5.0, 20.0], x = 'open', z = { lower = 'wall', upper = 'open', restitution = 0.6 } }\n\
        dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 0.01 }\n\
        species = [{ name = 'A', mass = 1.7, diameter = 1.4 }, { name = 'B', mass = 0.6, \
        diameter = { distribution = 'uniform', lower = 0.5, upper = 0.9 }, diameters = 'individual' }]\n\
        interaction = [{ species = ['A', 'A'], potential = 'hard-sphere', restitution = 0.6 }, \
        { species = ['A', 'B'], potential = 'hard-sphere', restitution = 0.6 }, \
        { species = ['B', 'B'], potential = 'hard-sphere', restitution = 0.6 }]\n\
        inlet = [{ name = 'feed', composition = { A = 0.5, B = 0.5 }, velocity = [0.0, 0.0, -1.0], rate = 5.0, \
        region = { lower = [1.5, 0.0, 12.0], upper = [5.0, 5.0, 19.0] } }]\n\
        surface = [{ name = 'drain', shape = 'plane', point = [0.7, 0.0, 0.0], normal = [1.0, 0.0, 0.0], outlet = true }]\n\
        run = { until_time = 9.0 }";
    let (system, mut simulation) = start(Scene::from_toml(text.to_owned(), "rain.toml").unwrap());
    let mut stress =
        instrument(&simulation, &system, 9.0, |setup| Recorded::new(ParticleStress::new(&plan(3.0), setup)));
    let mut lines: BTreeMap<u32, f64> = BTreeMap::new();
    let mut diameters = BTreeMap::new();
    while stress.next_sample() <= 9.0 {
        let time = stress.next_sample();
        lines.clear();
        let show = |event: &Event| {
            stress.event(event, &system);
            if event.kind == EventKind::Entry {
                diameters.insert(event.particle.0, event.distance);
            }
            let work = event.normal.dot(&event.impulse) * event.distance;
            match (event.kind, event.partner()) {
                (EventKind::Pair(_), Some(other)) => {
                    let [one, two] = [event.particle.0, other.0].map(|id| diameters[&id]);
                    *lines.entry(event.particle.0).or_default() += work * one / (one + two);
                    *lines.entry(other.0).or_default() += work * two / (one + two);
                }
                (EventKind::Surface, _) => *lines.entry(event.particle.0).or_default() += work,
                _ => {}
            }
        };
        simulation.advance_with(Until::time(time), show).unwrap();
        stress.sample(&Sample { time, ..Sample::of(&simulation.snapshot()) }, &system);
    }
    let snapshot = simulation.snapshot();
    let first = snapshot.ids[0].0;
    assert!(first > 0 && snapshot.ids.len() > 10, "some have left: {first} {}", snapshot.ids.len());
    let columns = scalars(Some(&stress.again), &Sample::of(&snapshot), &system);
    for ((id, value), diameter) in snapshot.ids.iter().zip(&columns[0].values).zip(&snapshot.diameters) {
        assert_eq!(diameters[&id.0], *diameter);
        let expected = lines.get(&id.0).map_or(0.0, |sum| sum / (3.0 * 3.0 * own_volume(*diameter, 3)));
        assert!((value - expected).abs() < 1e-12 * (1.0 + expected), "{id:?}: {value} {expected}");
    }
    assert!(columns[0].values.iter().filter(|value| **value > 0.0).count() > 10);
    assert!(snapshot.diameters.iter().any(|diameter| *diameter < 0.65));
    assert!(number(&report(&stress, &system), "contact_pressure").mean.unwrap() > 0.0);
}

#[derive(Default)]
struct Frames(Vec<(f64, Vec<Scalar>)>);

impl Recorder for Frames {
    type Error = Infallible;

    fn row(&mut self, _: Stage, _: &Row) -> Result<(), Infallible> {
        Ok(())
    }

    fn frame(&mut self, snapshot: &Snapshot, scalars: Vec<Scalar>) -> Result<(), Infallible> {
        self.0.push((snapshot.time, scalars));
        Ok(())
    }
}

#[test]
fn frames_contain_the_stress_since_the_frame_before() {
    let scene = column()
        .run(RunPlan { limit: Until::time(8.0), ..RunPlan::default() })
        .output(OutputPlan { frame_interval: Some(2.0), ..OutputPlan::default() })
        .measure(crate::model::MeasurementPlan { particle_stress: Some(plan(2.0)), ..Default::default() })
        .build()
        .unwrap();
    let mut frames = Frames::default();
    Run::without_start(scene).execute(&mut frames, &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(frames.0.len(), 5);
    for (time, scalars) in &frames.0 {
        let share = if *time == 0.0 { 0.0 } else { 1.0 };
        for (ball, exact) in exact(MASSES).into_iter().enumerate() {
            let z = scalars[3].values[ball] * volume(ball);
            // While the balls come to rest, they gain some momentum.
            assert!((z - share * exact).abs() < 0.02 * exact, "{time}, {ball}: {z} {exact}");
        }
    }
}
