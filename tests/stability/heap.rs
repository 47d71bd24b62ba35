//! A heap of grains at rest. The TC model prevents its collapse.

use crate::listed::hard_sphere;
use crate::watched::Watched;
use carom::Vector;
use carom::engine::{Reason, Until};
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, Scene};
use carom::scene::{Arrangement, Fill, InteractionDraft, SceneBuilder, SpeciesDraft};
use std::time::Instant;

/// Contact time of the TC model. Gravity, masses and diameters are 1.
const CONTACT_TIME: f64 = 3e-3;
const COUNT: u64 = 24;

/// Grains that fall into a box with a floor and four walls. The heap has about three layers.
fn grains(restitution: f64) -> Scene {
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(restitution)), upper: Face::Open };
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(3.3, 2.9, 16.0),
        boundary: [Boundary::walls(restitution), Boundary::walls(restitution), floor],
    };
    let (lower, upper) = (Vector::new(0.5, 0.5, 0.5), Vector::new(2.8, 2.4, 15.0));
    SceneBuilder::new("heap")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .contact_time(CONTACT_TIME)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard_sphere()).between("A", "A").restitution(restitution))
        .fill(Fill::new(Arrangement::Random, "A").count(COUNT).region(lower, upper))
        .temperature(0.1)
        .build()
        .unwrap()
}

fn positions(watched: &Watched) -> Vec<Vector> {
    watched.simulation.snapshot().positions
}

fn farthest(a: &[Vector], b: &[Vector]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

/// Largest displacement of grains in a heap at rest, in units of `g t_c^2`, where `t_c` is the contact time. In a
/// flight of at most `t_c`, a contact opens by up to `g t_c^2 / 8` times the number of layers above. Wedged grains
/// moved by up to 140 in 15 heaps.
const AT_REST: f64 = 300.0;

/// Waits until no grain moves farther than half of [`AT_REST`] in a time of 10.
fn settle(watched: &mut Watched) {
    let mut before = positions(watched);
    for tens in 1..=30 {
        assert_eq!(watched.simulation.advance(Until::time(10.0 * f64::from(tens))), Ok(Reason::Time));
        let now = positions(watched);
        if tens > 2 && farthest(&before, &now) < 0.5 * AT_REST * CONTACT_TIME * CONTACT_TIME {
            return;
        }
        before = now;
    }
    panic!("the grains do not settle");
}

fn rest(restitution: f64, events: u64) {
    let mut watched = Watched::new(grains(restitution));
    settle(&mut watched);
    let (at_rest, since) = (positions(&watched), watched.simulation.time());
    let settled = watched.simulation.event_counts().physical();
    let (mut reach, mut last, begin) = (0.0_f64, since, Instant::now());
    for part in 1..=100 {
        let until = settled + events * part / 100;
        assert_eq!(watched.simulation.advance(Until::events(until)), Ok(Reason::Events));
        let now = watched.simulation.time();
        assert!(now > last, "time stands still at {now}");
        last = now;
        reach = reach.max(farthest(&at_rest, &positions(&watched)));
        // A grain at rest flies for less than the contact time.
        let speed = (2.0 * watched.simulation.energy().kinetic / COUNT as f64).sqrt();
        assert!(speed < 4.0 * CONTACT_TIME, "grains fly at {speed}");
    }
    let rate = events as f64 / begin.elapsed().as_secs_f64();
    println!(
        "e = {restitution}: {settled} events until {since}, then {:.0} per second; moved by up to {:.1} t_c^2",
        rate,
        reach / (CONTACT_TIME * CONTACT_TIME)
    );
    watched.assert_sound(1.0);
    assert!(reach < AT_REST * CONTACT_TIME * CONTACT_TIME, "the heap creeps: {reach:e}");
}

/// `CAROM_HEAP_EVENTS=10000000 cargo test --release --test stability heap -- --nocapture` simulates more events.
#[test]
fn a_heap_at_rest_does_not_creep() {
    let events = std::env::var("CAROM_HEAP_EVENTS").map_or(2_000_000, |events| events.parse().unwrap());
    for restitution in [0.3, 0.5] {
        rest(restitution, events);
    }
}
