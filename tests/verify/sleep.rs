//! Grains that fall asleep and wake up.

use carom::Vector;
use carom::check::verify::{Fault, Quantity};
use carom::engine::event::{Event, EventKind};
use carom::engine::{Simulation, Until};
use carom::model::ParticleId;

use crate::{Recording, prove, scene};

/// Rough grains of two sizes that fall into a box, on a floor that is partly a belt. A large grain follows late.
const GRAINS: &str = "
    seed = 6
    space = { size = [9.0, 1.3, 90.0], x = { lower = 'wall', upper = 'wall', restitution = 0.5 }, y = { lower = 'wall', upper = 'wall', restitution = 0.5 }, z = 'open' }
    dynamics = { gravity = [0.0, 0.0, -1.0], contact_time = 0.01, sleep = { interval = 0.25, distance = 0.01, wake_speed = 0.1 } }
    species = [{ name = 'a', mass = 0.7, diameter = 0.9 }, { name = 'b', mass = 1.3, diameter = 1.1 }]
    interaction = [
        { species = ['a', 'a'], potential = 'hard-sphere', restitution = 0.4, friction = 0.5 },
        { species = ['a', 'b'], potential = 'hard-sphere', restitution = 0.5, friction = 0.4 },
        { species = ['b', 'b'], potential = 'hard-sphere', restitution = 0.5, tangential_restitution = 0.3, friction = 0.6 },
    ]
    surface = [
        { shape = 'parallelogram', corner = [0.0, 0.0, 0.0], edge_1 = [7.0, 0.0, 0.0], edge_2 = [0.0, 1.3, 0.0], restitution = 0.5, friction = 0.45 },
        { shape = 'parallelogram', corner = [7.0, 0.0, 0.0], edge_1 = [2.0, 0.0, 0.0], edge_2 = [0.0, 1.3, 0.0], restitution = 0.5, friction = 0.45, surface_velocity = [0.001, 0.0, 0.0] },
    ]
    fill = [{ composition = { a = 8, b = 8 }, arrangement = 'random', count = 16, region = { lower = [0.0, 0.0, 0.0], upper = [9.0, 1.3, 9.0] } }]
    particle = [{ species = 'b', position = [4.0, 0.6, 80.0], velocity = [0.0, 0.0, 0.0] }]
    run = { until_time = 20.0 }
";

/// Like [`GRAINS`], with individual diameters.
fn sized_grains() -> String {
    let individual = |lower, upper| {
        format!("diameter = {{ distribution = 'uniform', lower = {lower}, upper = {upper} }}, diameters = 'individual'")
    };
    GRAINS
        .replace("diameter = 0.9", &individual(0.7, 1.1))
        .replace("diameter = 1.1", &individual(0.9, 1.2))
        .replace("species = 'b', position", "species = 'b', diameter = 1.15, position")
}

type Spoil = fn(&mut Event);

fn recording() -> Recording {
    Recording::until(scene(GRAINS), Until::time(16.0), usize::MAX)
}

#[test]
fn grains_that_sleep_and_wake_are_proven_from_any_event_on() {
    for text in [GRAINS.to_owned(), sized_grains()] {
        let mut simulation = Simulation::without_plan(scene(&text));
        simulation.advance(Until::time(20.0)).unwrap();
        let counts = *simulation.event_counts();
        assert!(counts.rest > 20 && counts.wake > 8, "{} {}", counts.rest, counts.wake);
        let all = counts.physical();
        let whole = prove(scene(&text), 0, u64::MAX);
        assert!(whole.is_proven(), "{:?}", whole.end);
        assert_eq!(whole.counts.events(), all);
        for part in 1..6 {
            let proof = prove(scene(&text), part * all / 6, all / 8);
            assert!(proof.is_proven(), "{part}: {:?}", proof.end);
        }
    }
}

#[test]
fn grains_wake_at_changes_of_surfaces_and_gravity() {
    let gate = "{ shape = 'parallelogram', corner = [0.0, 0.0, 12.0], edge_1 = [9.0, 0.0, 0.0], edge_2 = [0.0, 1.3, 0.0], \
        restitution = 0.5, friction = 0.45, stages = ['fill'] },";
    let text = GRAINS
        .replace("contact_time = 0.01", "contact_time = 0.005")
        .replace("distance = 0.01, wake_speed = 0.1", "distance = 0.03, wake_speed = 0.3")
        .replace("surface = [", &format!("surface = [{gate}"))
        .replace("lower = [0.0, 0.0, 0.0], upper = [9.0, 1.3, 9.0]", "lower = [0.0, 0.0, 12.0], upper = [9.0, 1.3, 21.0]")
        .replace("run = {", "stage = [{ name = 'fill', until_time = 25.1 }, { name = 'fall', until_time = 20.1 }]\n    run = { gravity = [0.1, 0.0, -1.0],");
    let scene = scene(&text);
    let mut simulation = Simulation::without_plan(scene.clone());
    simulation.advance(Until::time(25.0)).unwrap();
    assert!(simulation.sleeping().len() > 8, "{}", simulation.sleeping().len());
    let whole = prove(scene, 0, u64::MAX);
    assert!(whole.is_proven(), "{:?}", whole.end);
    assert!(whole.duration > 65.0, "{}", whole.duration);
}

#[test]
fn falsified_sleep_is_found() {
    let mut recording = recording();
    assert_eq!(recording.fault(), None);
    let good = recording.events.clone();
    let first = |kind| good.iter().position(|(event, _)| event.kind == kind).unwrap();
    let (rest, wake) = (first(EventKind::Rest), first(EventKind::Wake));
    let particle = |at: usize| good[at].0.particle;

    // An event is left out: a grain stays awake or asleep.
    recording.events.remove(rest);
    let fault = recording.fault();
    assert!(
        matches!(fault, Some((_, Fault::StayedAwake { .. } | Fault::Disturbed { .. } | Fault::Jumped { .. }))),
        "{fault:?}"
    );
    recording.events.clone_from(&good);
    recording.events.remove(wake);
    let fault = recording.fault();
    assert!(matches!(fault, Some((_, Fault::StayedAsleep { .. }))), "{fault:?}");

    // Another grain wakes up, or falls asleep.
    for (at, other) in [(wake, 16), (rest, 16)] {
        recording.events.clone_from(&good);
        assert_ne!(particle(at), ParticleId(other));
        recording.events[at].0.particle = ParticleId(other);
        assert!(recording.fault().is_some());
    }

    // The numbers of the event are slightly different.
    let spoilt: [(Spoil, Quantity); 4] = [
        (|event| event.dissipated *= 1.0 + 1e-7, Quantity::Dissipation),
        (|event| event.impulse *= 1.0 + 1e-7, Quantity::Impulse),
        (|event| event.torques[0] += Vector::y() * 1e-9, Quantity::Torque),
        (|event| event.after[0] += Vector::x() * 1e-9, Quantity::Velocity),
    ];
    for (spoil, expected) in spoilt {
        recording.events.clone_from(&good);
        spoil(&mut recording.events[rest].0);
        let fault = recording.fault();
        assert!(matches!(fault, Some((_, Fault::WrongNumbers { quantity, .. })) if quantity == expected), "{fault:?}");
    }
}

#[test]
fn different_rules_of_sleep_are_found() {
    let mut recording = recording();
    for (rule, wrong) in [
        ("interval = 0.25", "interval = 0.5"),
        ("distance = 0.01", "distance = 0.0001"),
        ("wake_speed = 0.1", "wake_speed = 1.0"),
        (", sleep = { interval = 0.25, distance = 0.01, wake_speed = 0.1 }", ""),
    ] {
        assert_eq!(GRAINS.matches(rule).count(), 1, "{rule}");
        recording.scene = scene(&GRAINS.replace(rule, wrong));
        assert!(recording.fault().is_some(), "{wrong}");
    }
}
