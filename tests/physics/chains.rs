//! Bonded chains: the pendulum and the polymers of `configs/`.

use carom::Vector;
use carom::engine::{Simulation, Snapshot, Until};
use carom::model::measurement_plan as plan;
use carom::model::potential::Potential;
use carom::model::space::{Space, minimum_image};
use carom::model::{MassRule, MeasurementPlan, ParticleId, RunPlan, Scene, Thermostat};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

use super::measure::{finish, number};

/// Returns the largest relative amount by which a bond is too long or too short.
fn worst_bond(scene: &Scene, now: &Snapshot) -> f64 {
    let excess = |bond: &carom::model::Bond| {
        let [a, b] = bond.pair.map(|id| now.positions[id.0 as usize]);
        let distance = minimum_image(a - b, &scene.space().periods()).norm();
        let potential: &Potential = &scene.interactions()[bond.interaction.0 as usize].potential;
        let core = potential.core().unwrap();
        ((distance - potential.range()) / potential.range()).max((core - distance) / core)
    };
    scene.bonds().iter().map(excess).fold(f64::NEG_INFINITY, f64::max)
}

/// Tolerance of bond lengths: ten times the spacing of floating-point numbers between 16 and 32.
const BOND_ROUND_OFF: f64 = 10.0 * 16.0 * f64::EPSILON;

fn pendulum(restitution: f64) -> Simulation {
    let value = restitution.to_string();
    let keys: Vec<String> = (0..5).map(|k| format!("interaction.{k}.restitution")).collect();
    let overrides: Vec<(&str, &str)> = keys.iter().map(|key| (key.as_str(), value.as_str())).collect();
    Simulation::without_plan(Scene::from_file_with("configs/pendulum.toml", &overrides).unwrap())
}

#[test]
fn the_energy_of_the_pendulum_never_rises() {
    for restitution in [0.0, 0.5, 0.9, 1.0] {
        let mut simulation = pendulum(restitution);
        let total = |simulation: &Simulation| simulation.energy().kinetic + simulation.energy().potential;
        // The bob has a mass of 100 and can fall by 11.
        let scale = 1100.0;
        let (mut last, mut worst) = (total(&simulation), f64::NEG_INFINITY);
        for event in 1..=20_000 {
            simulation.advance(Until::events(event)).unwrap();
            let now = total(&simulation);
            // Each event rounds a few energies, and the flight before the event rounds the energies of all particles.
            assert!(now <= last + 32.0 * scale * f64::EPSILON, "{restitution}: event {event} adds {}", now - last);
            last = now;
            worst = worst.max(worst_bond(simulation.scene(), &simulation.snapshot()));
        }
        assert!(worst < BOND_ROUND_OFF, "{restitution}: a bond is exceeded by {worst}");
        println!("{restitution}: time {}, energy {last}, worst bond {worst:e}", simulation.time());
        assert_eq!(simulation.event_counts().in_invalid_state, 0);
    }
}

#[test]
fn an_elastic_pendulum_keeps_its_energy() {
    let mut simulation = pendulum(1.0);
    let start = simulation.energy();
    let mut most = 0.0_f64;
    for part in 1..=100 {
        simulation.advance(Until::events(1000 * part)).unwrap();
        let now = simulation.energy();
        most = most.max(now.kinetic);
        let error = now.kinetic + now.potential - start.kinetic - start.potential;
        assert!(error.abs() < 1e-10 * most, "{error} after {} events", 1000 * part);
    }
    assert!(most > 100.0);
    // The beads start at rest and reach speeds of up to 50. The slow start must not determine the precision.
    assert!(simulation.event_counts().deepest_overlap < 1e-13, "{}", simulation.event_counts().deepest_overlap);
}

#[test]
fn an_inelastic_pendulum_comes_to_hang() {
    let mut simulation = pendulum(0.5);
    simulation.advance(Until::events(300_000)).unwrap();
    let now = simulation.energy();
    let bob = simulation.snapshot().positions[10];
    println!("time {}, bob at {bob:?}, kinetic {}", simulation.time(), now.kinetic);
    assert!(worst_bond(simulation.scene(), &simulation.snapshot()) < BOND_ROUND_OFF);
    assert!(bob.xz().norm() < 9.0 * 1.06 + 1.5 * 1.06 + 1e-12);
    let total = now.kinetic + now.potential;
    assert!(total < 0.0, "{total}");
}

#[test]
fn polymers_stay_whole() {
    let mut simulation = Simulation::without_plan(Scene::from_file("configs/polymer.toml").unwrap());
    let start = simulation.energy();
    for part in 1..=10 {
        simulation.advance(Until::events(30_000 * part)).unwrap();
        let scene = simulation.scene();
        assert!(worst_bond(scene, &simulation.snapshot()) < BOND_ROUND_OFF);
        for bond in scene.bonds() {
            assert_eq!(simulation.pair_state(bond.pair[0], bond.pair[1]), 1);
        }
    }
    assert_eq!(
        simulation.pair_state(ParticleId(0), ParticleId(50)),
        simulation.pair_state(ParticleId(50), ParticleId(0))
    );
    let now = simulation.energy();
    // Each of the 300,000 events rounds the energies of two beads a few times. The temperature is near 1.
    let bound = 300_000.0 * 16.0 * 2.0 * f64::EPSILON;
    assert!((now.kinetic + now.potential - start.kinetic - start.potential).abs() < bound);
}

#[test]
fn a_bond_between_individual_diameters_has_its_exact_length() {
    // Between the ends of its range, the length r of the bond of two free beads has the density 4 pi r^2. The sum of the
    // radii is 0.95, so that the range of the bond, 0.9 to 1.5 for diameters of 0.8, is larger by a factor of 0.95 / 0.8.
    let scene = SceneBuilder::new("dumbbell")
        .seed(3)
        .space(Space::periodic_cube(9.0))
        .species(SpeciesDraft::new("A").mass(1.3).diameter(0.8).individual_diameters(MassRule::Volume))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .interaction(InteractionDraft::new(Potential::bond(0.9, 1.5).unwrap()).named("link"))
        .sized_particle("A", 1.3, Vector::new(1.0, 1.0, 1.0), Vector::zeros())
        .sized_particle("A", 0.6, Vector::new(2.4, 1.0, 1.0), Vector::zeros())
        .bond([ParticleId(0), ParticleId(1)], "link")
        .temperature(0.7)
        .measure(MeasurementPlan {
            chains: Some(plan::Chains { interval: Some(0.5), bins: Some(6) }),
            ..MeasurementPlan::default()
        })
        .run(RunPlan {
            limit: Until::time(20_000.0),
            thermostat: Some(Thermostat::Andersen { temperature: 0.7, rate: 1.0, axes: [true; 3] }),
            ..RunPlan::default()
        });
    let finished = finish(scene.build().unwrap());
    let ends = [0.9_f64, 1.5].map(|end| end * 0.95 / 0.8);
    let moment = |power: i32| (ends[1].powi(power + 3) - ends[0].powi(power + 3)) / f64::from(power + 3);
    for (name, exact) in [("bond_length", moment(1) / moment(0)), ("mean_square_bond_length", moment(2) / moment(0))] {
        let (mean, error) = number(&finished.measured, name);
        assert!((mean - exact).abs() < 4.0 * error && error < 3e-3 * exact, "{name}: {mean} +- {error}, {exact}");
    }
    let curve = finished.measured.curve("bond_length").unwrap();
    let width = (ends[1] - ends[0]) / 6.0;
    for (k, &centre) in curve.variables[0].values.iter().enumerate() {
        let [lower, upper] = [centre - 0.5 * width, centre + 0.5 * width];
        let exact = (upper.powi(3) - lower.powi(3)) / 3.0 / moment(0) / width;
        let (value, error) = (curve.series[0].values[k].unwrap(), curve.series[0].standard_errors[k].unwrap());
        assert!((value - exact).abs() < 4.0 * error && error < 0.05 * exact, "{centre}: {value} +- {error}, {exact}");
    }
}
