//! Bonds that alternate between two nearly equal lengths.

use crate::listed::{along, line, open_box};
use crate::watched::Watched;
use carom::Vector;
use carom::engine::event::EventKind;
use carom::engine::{Reason, Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::physics::response::Outcome;
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

fn pair(space: &Space, range: f64, is_at_end: bool, restitution: f64, velocity: Vector) -> SceneBuilder {
    let distance = if is_at_end { 1.0 + range } else { 1.0 };
    SceneBuilder::new("bond")
        .space(space.clone())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(
            InteractionDraft::new(Potential::bond(1.0, 1.0 + range).unwrap()).named("link").restitution(restitution),
        )
        .particle("A", along(0.0), -velocity)
        .particle("A", along(distance), velocity)
        .bond([0, 1], "link")
}

#[test]
fn both_ends_of_a_bond_are_met_in_turn() {
    for range in [0.5, 1e-3, 1e-9, 1e-12] {
        for is_at_end in [false, true] {
            for velocity in [1.0, -1.0] {
                let scene = pair(&line(16.0, Boundary::OPEN), range, is_at_end, 1.0, along(velocity));
                let mut watched = Watched::new(scene.build().unwrap());
                let mut kinds = Vec::new();
                let until = Until::events(10_000);
                let reason = watched.simulation.advance_with(until, |event| kinds.push(event.kind));
                println!(
                    "range {range:e}, at end {is_at_end}, velocity {velocity}: time {:e}, deepest {:e}",
                    watched.simulation.time(),
                    watched.simulation.event_counts().deepest_overlap
                );
                assert_eq!(reason, Ok(Reason::Events));
                let [core, bounce] = [Outcome::Core, Outcome::Bounce].map(EventKind::Pair);
                let first = if velocity < 0.0 { core } else { bounce };
                assert_eq!(kinds[0], first);
                assert!(kinds.windows(2).all(|two| two[0] != two[1] && [core, bounce].contains(&two[1])));
                watched.assert_sound(1.0);
                // Between two events, the bond length changes by `range` at a relative speed of 2.
                let expected = 10_000.0 * range / 2.0;
                let inexact = 10_000.0 * 8.0 * f64::EPSILON + range;
                assert!((watched.simulation.time() - expected).abs() <= inexact, "{}", watched.simulation.time());
            }
        }
    }
}

#[test]
fn a_tight_pair_spins_for_a_million_events() {
    for (range, events) in [(1e-3, 100_000), (1e-6, 100_000), (1e-9, 1_000_000)] {
        let velocity = Vector::new(0.125, 0.75, 0.3);
        let scene = pair(&open_box(16.0), range, true, 1.0, velocity).build().unwrap();
        let mut watched = Watched::new(scene);
        let angular = |watched: &Watched| {
            let now = watched.simulation.snapshot();
            let (r, v) = (now.positions[1] - now.positions[0], now.velocities[1] - now.velocities[0]);
            r.cross(&v)
        };
        let before = angular(&watched);
        watched.run(events);
        watched.assert_sound(1.0);
        let drift = (angular(&watched) - before).norm() / before.norm();
        println!("range {range:e}: angular momentum drifted by {drift:.1e}");
        // Each event rounds positions below 16 and velocities below 1 about ten times, with random signs.
        assert!(drift < 4.0 * 10.0 * 16.0 * f64::EPSILON * 1000.0, "{drift:e}");
        let now = watched.simulation.snapshot();
        let distance = (now.positions[1] - now.positions[0]).norm();
        assert!(distance > 1.0 - 1e-14 && distance < 1.0 + range + 1e-14, "{distance}");
    }
}

fn hanging(range: f64, position: Vector, restitution: f64) -> SceneBuilder {
    SceneBuilder::new("pendulum")
        .space(open_box(8.0))
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .species(SpeciesDraft::new("P").diameter(1.0).fixed())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::None).between("P", "A"))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .interaction(
            InteractionDraft::new(Potential::bond(1.0, 1.0 + range).unwrap()).named("link").restitution(restitution),
        )
        .particle("P", Vector::zeros(), Vector::zeros())
        .particle("A", position, Vector::zeros())
        .bond([0, 1], "link")
}

/// A pendulum that starts at an angle to the vertical, midway between the shortest and the longest bond length.
fn pendulum(range: f64, angle: f64, restitution: f64, contact_time: Option<f64>) -> SceneBuilder {
    let position = Vector::new(libm::sin(angle), 0.0, -libm::cos(angle)) * (1.0 + 0.5 * range);
    let mut builder = hanging(range, position, restitution);
    if let Some(time) = contact_time {
        builder = builder.contact_time(time);
    }
    builder
}

#[test]
fn swinging_bead_stays_between_the_ends_of_its_bond() {
    for (range, events) in [(1e-3, 100_000), (1e-6, 100_000), (1e-9, 1_000_000)] {
        let mut watched = Watched::new(pendulum(range, 1.0, 1.0, None).build().unwrap());
        watched.run(events);
        watched.assert_sound(1.0);
        let now = watched.simulation.snapshot().positions[1];
        println!("range {range:e}: {now:?}, time {}", watched.simulation.time());
        assert!(now.norm() > 1.0 - 1e-14 && now.norm() < 1.0 + range + 1e-14);
        assert_eq!(now.y, 0.0);
    }
}

#[test]
fn bead_on_a_lossy_bond_hangs_with_the_tc_model_and_else_arrests() {
    for angle in [0.0_f64, 1e-3, 1.0] {
        let mut held = Simulation::without_plan(pendulum(1e-9, angle, 0.5, Some(1e-4)).build().unwrap());
        let reason = held.advance(Until::time(5.0));
        let now = held.snapshot().positions[1];
        println!("angle {angle}: {} events, {now:?}", held.event_counts().physical());
        assert!(now.norm() > 1.0 - 1e-14 && now.norm() < 1.0 + 1e-9 + 1e-14, "{now}");
        assert_eq!(reason, Ok(Reason::Time));
        assert_eq!(held.event_counts().in_invalid_state, 0);
        let mut free = Simulation::without_plan(pendulum(1e-9, angle, 0.5, None).build().unwrap());
        let arrest = free.advance(Until::time(1000.0)).unwrap_err().arrest().unwrap();
        println!("angle {angle}: {} events, {arrest}", free.event_counts().physical());
        assert!(free.event_counts().physical() < 100_000);
    }
}

#[test]
fn bead_on_a_taut_bond_arrests_without_the_tc_model() {
    let end = |short_by: f64, contact_time: Option<f64>| {
        let mut builder = hanging(0.5, Vector::new(0.0, 0.0, short_by - 1.5), 0.5);
        if let Some(time) = contact_time {
            builder = builder.contact_time(time);
        }
        let mut simulation = Simulation::without_plan(builder.build().unwrap());
        let reason = simulation.advance(Until::events(10_000));
        println!("{short_by:e} {contact_time:?}: {reason:?}, {} events", simulation.event_counts().physical());
        assert!((simulation.snapshot().positions[1].z + 1.5).abs() < 1e-6);
        reason
    };
    // A bead at rest on a fully stretched bond cannot bounce.
    let arrest = end(0.0, None).unwrap_err().arrest().unwrap();
    assert_eq!((arrest.time, arrest.particle.0, arrest.partner.map(|p| p.0)), (0.0, 1, Some(0)));
    for short_by in [0.0, 2.0 * f64::EPSILON, 1e-12, 1e-9] {
        assert_eq!(end(short_by, Some(1e-3)), Ok(Reason::Events));
        assert!(short_by == 0.0 || end(short_by, None).unwrap_err().arrest().unwrap().time < 1e-3);
    }
}
