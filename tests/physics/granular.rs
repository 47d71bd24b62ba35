//! Inelastic contacts: Haff's law, inelastic collapse, and the TC model, which prevents collapse.

use crate::measure::Mean;
use carom::Vector;
use carom::engine::event::EventKind;
use carom::engine::{Reason, Simulation, Standstill, Until};
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, Scene};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

fn simulation(builder: SceneBuilder, contact_time: Option<f64>) -> Simulation {
    let builder = match contact_time {
        Some(time) => builder.contact_time(time),
        None => builder,
    };
    Simulation::without_plan(builder.build().unwrap())
}

fn gas(restitution: f64, contact_time: Option<f64>) -> Simulation {
    let builder = SceneBuilder::new("gas")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(restitution))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(1372).packing_fraction(0.10))
        .temperature(1.0);
    simulation(builder, contact_time)
}

#[test]
fn a_granular_gas_cools_by_haffs_law() {
    // Haff's law is T = T0 exp(-(1 - e^2) s / 3) after s contacts per particle. The deviation from Maxwell's
    // distribution, a2 = 16 (1 - e)(1 - 2 e^2) / (81 - 17 e + 30 e^2 (1 - e)), changes the rate by the fraction a2 / 4
    // (van Noije and Ernst, Granular Matter 1, 57, 1998).
    for e in [0.95_f64, 0.9] {
        let a2 = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / (81.0 - 17.0 * e + 30.0 * e * e * (1.0 - e));
        let rate = (1.0 - e * e) / 3.0 * (1.0 + a2 / 4.0);
        // The first contacts dissolve the lattice.
        let mut simulation = gas(e, None);
        let (particles, per_block) = (simulation.moving() as f64, 686);
        simulation.advance(Until::events(5 * per_block)).unwrap();
        let mut last = simulation.energy().kinetic;
        // The measurement ends before clusters form.
        let slopes: Vec<f64> = (1..=15)
            .map(|block| {
                simulation.advance(Until::events((5 + block) * per_block)).unwrap();
                let kinetic = simulation.energy().kinetic;
                let slope = -(kinetic / last).ln() / (2.0 * per_block as f64 / particles);
                last = kinetic;
                slope
            })
            .collect();
        Mean::of(slopes).assert_is(rate, 0.02 * rate, &format!("cooling per contact at e = {e}"));
    }
}

#[test]
fn counted_dissipation_equals_the_energy_loss() {
    let mut simulation = gas(0.8, None);
    let start = simulation.energy().kinetic;
    let mut sum = 0.0;
    simulation.advance_with(Until::events(20_000), |event| sum += event.dissipated).unwrap();
    let lost = start - simulation.energy().kinetic;
    assert!(lost > 0.5 * start);
    // Each of the 20,000 contacts rounds two energies of about T a few times.
    let bound = 20_000.0 * 8.0 * 4.0 * f64::EPSILON;
    assert!((simulation.event_counts().dissipated.total() - lost).abs() < bound);
    assert!((sum - lost).abs() < bound + 20_000.0 * f64::EPSILON * start);
}

fn three_on_a_line(restitution: f64, contact_time: Option<f64>) -> Simulation {
    drifting_line(restitution, contact_time, 0.0)
}

fn drifting_line(restitution: f64, contact_time: Option<f64>, drift: f64) -> Simulation {
    let space = Space {
        lower: Vector::new(-10.0, 0.0, 0.0),
        size: Vector::new(20.0, 0.0, 0.0),
        boundary: [Boundary::OPEN, Boundary::Flat, Boundary::Flat],
    };
    let mut builder = SceneBuilder::new("collapse")
        .space(space)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(restitution));
    for (x, v) in [(-2.0, 1.0), (0.0, 0.01), (2.5, -1.0)] {
        builder = builder.particle("A", Vector::new(x, 0.0, 0.0), Vector::new(v + drift, 0.0, 0.0));
    }
    simulation(builder, contact_time)
}

#[test]
fn three_spheres_collapse_below_a_restitution_of_7_minus_4_sqrt_3() {
    let limit = 7.0 - 4.0 * 3.0_f64.sqrt();
    for below in [0.0, 0.01, 0.03, 0.05, 0.06, limit - 0.001] {
        let mut simulation = three_on_a_line(below, None);
        let arrest = simulation.advance(Until::time(100.0)).unwrap_err().arrest().unwrap();
        println!("e = {below}: {} contacts, {arrest}", simulation.event_counts().core);
        // Each contact leaves only a fraction of the relative speed, which falls below 1e-16 after a few contacts.
        assert!(simulation.event_counts().core < 100);
        // The outer spheres start at distances of 1 and 1.5 from contact, with speeds of about 1.
        assert!(arrest.time > 1.0 && arrest.time < 3.0, "{arrest}");
        assert!(matches!(arrest.standstill, Standstill::Speed { .. }), "{arrest}");
        assert!(arrest.to_string().contains("inelastic collapse"), "{arrest}");
        let pair = [arrest.particle.0, arrest.partner.unwrap().0];
        assert!(pair.contains(&1), "the middle one is part of every contact: {pair:?}");
    }
    // At a restitution of 0.08, relative speeds fall to about 1e-8.
    for above in [0.08, 0.09, 0.2, 0.5, 1.0] {
        let mut simulation = three_on_a_line(above, None);
        assert_eq!(simulation.advance(Until::time(100.0)), Ok(Reason::Time));
        let v = simulation.snapshot().velocities;
        let (left, right) = (v[1].x - v[0].x, v[2].x - v[1].x);
        assert!(left >= 0.0 && right >= 0.0 && left + right > 1e-8, "{left} {right}");
    }
}

#[test]
fn a_collapse_on_the_move_arrests_as_well_as_one_at_rest() {
    for speed in [1.0, -37.0, 1e3] {
        let mut simulation = three_on_a_line(0.05, None);
        let at_rest = simulation.advance(Until::time(100.0)).unwrap_err().arrest().unwrap();
        let mut moving = drifting_line(0.05, None, speed);
        let arrest = moving.advance(Until::time(100.0)).unwrap_err().arrest().unwrap();
        // Larger velocities have larger round-off, so a drifting line collapses slightly earlier.
        assert!((arrest.time - at_rest.time).abs() < 1e-9 * speed.abs(), "{at_rest}, {arrest}");
    }
}

/// An open box with a floor, under gravity.
fn above_floor(height: f64, restitution: f64) -> SceneBuilder {
    let floor = Face::Wall(ContactLaw::smooth(restitution));
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(4.0, 4.0, height),
        boundary: [Boundary::OPEN, Boundary::OPEN, Boundary::Bounded { lower: floor, upper: Face::Open }],
    };
    SceneBuilder::new("floor")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
}

fn column(restitution: f64, contact_time: Option<f64>) -> Simulation {
    let mut builder = above_floor(16.0, restitution)
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(restitution));
    for k in 0..6 {
        builder = builder.particle("A", Vector::new(2.0, 2.0, 0.6 + 1.1 * f64::from(k)), Vector::zeros());
    }
    simulation(builder, contact_time)
}

#[test]
fn a_column_of_spheres_arrests_unless_the_tc_model_holds_it() {
    for e in [0.0, 0.05, 0.3] {
        let mut simulation = column(e, None);
        let arrest = simulation.advance(Until::time(100.0)).unwrap_err().arrest().unwrap();
        println!("e = {e}: {} events, {arrest}", simulation.event_counts().physical());
        assert!(arrest.time < 10.0, "{arrest}");
        assert!(simulation.event_counts().physical() < 100_000, "in bounded time");
        let mut held = column(e, Some(1e-3));
        assert_eq!(held.advance(Until::time(20.0)), Ok(Reason::Time));
        for (k, position) in held.snapshot().positions.iter().enumerate() {
            assert!((position.z - 0.5 - k as f64).abs() < 1e-3, "{k}: {position}");
        }
    }
}

#[test]
fn a_ball_that_comes_to_rest_arrests_unless_the_tc_model_holds_it() {
    let ball = above_floor(4.0, 0.5).interaction(InteractionDraft::new(Model::HardSphere).between("A", "A")).particle(
        "A",
        Vector::new(2.0, 2.0, 1.5),
        Vector::zeros(),
    );
    let arrest = simulation(ball.clone(), None).advance(Until::time(5.0)).unwrap_err().arrest().unwrap();
    // A ball that falls from a height of 1 under a gravity of 1 comes to rest after sqrt(2) (1 + e) / (1 - e).
    assert!((arrest.time - 3.0 * 2.0_f64.sqrt()).abs() < 1e-9, "{arrest}");
    assert_eq!((arrest.particle.0, arrest.partner), (0, None));
    let mut held = simulation(ball, Some(1e-3));
    assert_eq!(held.advance(Until::time(5.0)), Ok(Reason::Time));
    assert!((held.snapshot().positions[0].z - 0.5).abs() < 1e-6);
}

#[test]
fn the_tc_model_ends_the_collapse() {
    for e in [0.03, 0.06] {
        let mut simulation = three_on_a_line(e, Some(1e-6));
        assert_eq!(simulation.advance(Until::time(100.0)), Ok(Reason::Time));
        assert!(simulation.event_counts().tc_altered > 0);
        assert!(simulation.energy().kinetic > 0.0);
        assert!(simulation.deepest_overlap().is_none_or(|overlap| overlap.depth < 1e-14));
    }
}

#[test]
fn contact_times_shorter_than_every_flight_change_nothing() {
    let end = |contact_time| {
        let mut simulation = gas(0.9, contact_time);
        simulation.advance(Until::events(20_000)).unwrap();
        (simulation.snapshot(), simulation.event_counts().tc_altered)
    };
    let (plain, _) = end(None);
    let (with, altered) = end(Some(1e-12));
    assert_eq!(altered, 0);
    assert!(plain == with);
}

#[test]
fn long_contact_times_allow_each_particle_one_inelastic_contact() {
    let mut simulation = gas(0.9, Some(1e6));
    let mut met = vec![false; simulation.moving()];
    simulation
        .advance_with(Until::events(20_000), |event| {
            let EventKind::Pair(_) = event.kind else { panic!("{event:?}") };
            let pair = [event.particle.0 as usize, event.partner().unwrap().0 as usize];
            let is_first = pair.iter().all(|id| !met[*id]);
            for id in pair {
                met[id] = true;
            }
            assert_eq!(event.dissipated > 1e-12, is_first, "{event:?}");
        })
        .unwrap();
    assert!(met.iter().all(|met| *met));
    let event_counts = simulation.event_counts();
    assert!(event_counts.core - event_counts.tc_altered <= met.len() as u64 / 2);
}

#[test]
fn the_scene_of_the_cooling_gas_follows_haffs_law_early() {
    let scene = Scene::from_file("configs/granular_cooling.toml").unwrap();
    let mut simulation = Simulation::without_plan(scene);
    let start = simulation.energy().kinetic;
    // The 10,000 events are 5 contacts per particle. The relative error of the loss is about `1 / sqrt(10_000)`.
    simulation.advance(Until::events(10_000)).unwrap();
    let fall = (start / simulation.energy().kinetic).ln();
    let expected = (1.0 - 0.95 * 0.95) * 5.0 / 3.0;
    println!("ln T0/T = {fall}, Haff {expected}");
    assert!((fall / expected - 1.0).abs() < 4.0 / 10_000.0_f64.sqrt());
}
