//! Grains at rest that fall asleep.

use carom::Vector;
use carom::engine::event::{CountedKind, Event, EventKind};
use carom::engine::{Reason, Simulation, Until};
use carom::model::{Particle, ParticleId, Scene, SpeciesId};

use crate::starts_in_contact::{G, MASS, ledger_error, listed, scene_above_floor};

const RESTITUTION: f64 = 0.6;
const WAKE_SPEED: f64 = 0.2;

/// Mass of the lighter species.
const LIGHT: f64 = 0.9;

/// Grains at rest at the given positions, and a species of lighter grains, of which a test may insert some.
fn grains(more: &str, start: &[[f64; 3]]) -> Scene {
    let sleep = format!("sleep = {{ interval = 0.25, distance = 0.01, wake_speed = {WAKE_SPEED} }}");
    let particles: String = start.iter().map(|position| listed(position, &[0.0; 3])).collect();
    let light = format!(
        "
[[species]]
name = \"light\"
mass = {LIGHT}
diameter = 1.0
[[interaction]]
species = [\"grain\", \"light\"]
potential = \"hard-sphere\"
restitution = {RESTITUTION}
"
    );
    scene_above_floor("", &sleep, &(light + &particles + more))
}

/// A light grain.
fn light(position: Vector, velocity: Vector) -> Particle {
    Particle::new(SpeciesId(1), position, velocity)
}

fn events_until(simulation: &mut Simulation, time: f64) -> Vec<Event> {
    let mut events = Vec::new();
    simulation.advance_with(Until::time(time), |event| events.push(*event)).unwrap();
    events
}

#[test]
fn grain_on_a_floor_falls_asleep_and_costs_no_more_events() {
    let mut simulation = Simulation::without_plan(grains("", &[[3.0, 4.0, 0.7]]));
    let start = simulation.energy().total();
    let events = events_until(&mut simulation, 20.0);
    let rest = *events.last().unwrap();
    assert_eq!((rest.kind, rest.after[0]), (EventKind::Rest, Vector::zeros()));
    assert!((rest.time / 0.25 - (rest.time / 0.25).round()).abs() < 1e-12, "at a search: {}", rest.time);
    assert!(rest.time < 5.0, "{}", rest.time);
    let lost = 0.5 * MASS * rest.before[0].norm_squared();
    assert!((rest.dissipated / lost - 1.0).abs() < 1e-14);
    assert!((rest.impulse + rest.before[0] * MASS).norm() < 1e-16);
    assert_eq!(
        (simulation.sleeping().len(), simulation.event_counts().rest, simulation.event_counts().wake),
        (1, 1, 0)
    );
    let snapshot = simulation.snapshot();
    assert_eq!((snapshot.positions[0], snapshot.velocities[0]), (rest.positions[0], Vector::zeros()));
    // The potential energy of a sleeping grain counts.
    assert!((simulation.energy().potential - MASS * G * snapshot.positions[0].z).abs() < 1e-15);
    assert!(ledger_error(&simulation, start) < 1e-14);
}

#[test]
fn grain_that_bounces_or_rolls_does_not_fall_asleep() {
    let mut simulation = Simulation::without_plan(grains("", &[[3.0, 4.0, 0.5]]));
    // The distance in an interval is 0.0125.
    simulation.set_velocities(&[Vector::new(0.05, 0.0, 0.0)]).unwrap();
    simulation.advance(Until::time(30.0)).unwrap();
    assert_eq!(simulation.event_counts().rest, 0);
    // An elastic grain that returns to the same place at each search has too few contacts: it flies for 0.25.
    let elastic = grains("", &[[3.0, 4.0, 0.5]]);
    let mut simulation = Simulation::without_plan(elastic);
    simulation.set_velocities(&[Vector::new(0.0, 0.0, 0.125 * G)]).unwrap();
    simulation.advance(Until::time(0.3)).unwrap();
    assert_eq!(simulation.event_counts().rest, 0);
}

/// A grain falls onto a sleeping grain, exactly above its centre, from a gap of `height`.
fn hit(height: f64) -> (Simulation, Vec<Event>, f64) {
    let scene = grains("", &[[3.0, 4.0, 0.5]]);
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::time(2.0)).unwrap();
    assert_eq!(simulation.sleeping().len(), 1);
    let top = simulation.snapshot().positions[0].z;
    let above = Vector::new(3.0, 4.0, top + 1.0 + height);
    simulation.insert(&[light(above, Vector::zeros())]).unwrap();
    let start = simulation.energy().total() + simulation.event_counts().dissipated.total()
        - simulation.event_counts().supplied.total();
    // The second contact with the floor follows at once.
    let fall = (2.0 * height / G).sqrt();
    let events = events_until(&mut simulation, 2.0 + fall + 1e-3);
    (simulation, events, start)
}

#[test]
fn fast_hit_wakes_a_grain_and_both_masses_count() {
    let height = 0.05;
    let speed = (2.0 * G * height).sqrt();
    assert!(speed > WAKE_SPEED);
    let (simulation, events, start) = hit(height);
    let wake = events.iter().position(|event| event.kind == EventKind::Wake).unwrap();
    let contact = events[wake + 1];
    assert_eq!((contact.time, contact.particle), (events[wake].time, ParticleId(1)));
    assert_eq!(contact.partner(), Some(ParticleId(0)));
    assert!((contact.before[0].z + speed).abs() < 1e-12);
    // `v' = v - (1 + e) m_other / (m + m_other) v`, with the other grain at rest.
    let after = [
        -speed * (1.0 - (1.0 + RESTITUTION) * MASS / (MASS + LIGHT)),
        -speed * (1.0 + RESTITUTION) * LIGHT / (MASS + LIGHT),
    ];
    for (found, expected) in contact.after.iter().zip(after) {
        assert!((found.z - expected).abs() < 1e-12, "{found} {expected}");
    }
    assert!(events.len() > wake + 2, "the woken grain meets the floor");
    assert_eq!(simulation.sleeping().len(), 0);
    assert!(ledger_error(&simulation, start) < 1e-13);
}

#[test]
fn slow_hit_bounces_off_a_sleeping_grain_as_off_a_static_one() {
    let height = 0.02;
    let speed = (2.0 * G * height).sqrt();
    assert!(speed < WAKE_SPEED);
    let (simulation, events, start) = hit(height);
    let contact = events.iter().find(|event| event.partner().is_some()).unwrap();
    assert!((contact.after[0].z - RESTITUTION * speed).abs() < 1e-12);
    assert_eq!(contact.after[1], Vector::zeros());
    assert_eq!((simulation.sleeping().len(), simulation.event_counts().wake), (1, 0));
    assert!(ledger_error(&simulation, start) < 1e-13);
}

#[test]
fn iteration_returns_all_events_of_one_time() {
    let scene = grains("", &[[3.0, 4.0, 0.5], [6.0, 4.0, 0.5]]);
    let expected = events_until(&mut Simulation::without_plan(scene.clone()), 5.0);
    let rests = expected.iter().filter(|event| event.kind == EventKind::Rest);
    let times: Vec<f64> = rests.map(|event| event.time).collect();
    assert!(times.len() == 2 && times[0] == times[1], "{times:?}");
    let mut simulation = Simulation::without_plan(scene);
    let found: Result<Vec<Event>, _> = simulation.events(Until::time(5.0)).collect();
    assert_eq!(found, Ok(expected));
}

#[test]
fn run_ends_when_all_grains_sleep_and_goes_on_when_one_enters() {
    let mut simulation = Simulation::without_plan(grains("", &[[3.0, 4.0, 0.5]]));
    assert_eq!(simulation.advance(Until::events(100_000)), Ok(Reason::Idle));
    assert_eq!(simulation.sleeping(), [ParticleId(0)]);
    simulation.insert(&[light(Vector::new(6.0, 6.0, 0.5), Vector::zeros())]).unwrap();
    assert_eq!(simulation.advance(Until::events(100_000)), Ok(Reason::Idle));
    assert_eq!(simulation.sleeping(), [0, 1].map(ParticleId));
}

#[test]
fn the_entry_of_a_grain_is_no_contact() {
    // Seven contacts are needed until the search at 2.25. Contacts are 0.01 apart, and the first is at the entry.
    for (time, rests) in [(2.1945, 0), (2.1845, 1)] {
        let mut simulation = Simulation::without_plan(grains("", &[[1.0, 1.0, 19.0]]));
        simulation.advance(Until::time(time)).unwrap();
        simulation.insert(&[light(Vector::new(6.0, 6.0, 0.5), Vector::zeros())]).unwrap();
        simulation.advance(Until::time(2.26)).unwrap();
        assert_eq!(simulation.event_counts().rest, rests, "{time}");
    }
}

/// A column of two grains at rest.
fn column() -> Simulation {
    let scene = grains("", &[[3.0, 4.0, 0.5], [3.0, 4.0, 1.5]]);
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::time(10.0)).unwrap();
    assert_eq!(simulation.sleeping().len(), 2, "both grains of the column sleep");
    // Contacts of two grains that are awake, and of one that is, count for the same pair of species.
    let of_species = simulation.event_counts_by_species().entries();
    let core = of_species.iter().find(|(kind, ..)| *kind == CountedKind::Core).unwrap();
    assert_eq!((core.1.as_slice(), core.2), ([0, 0].as_slice(), simulation.event_counts().core));
    simulation
}

#[test]
fn grain_wakes_and_falls_when_its_support_leaves() {
    let mut simulation = column();
    simulation.remove(&[ParticleId(0)]).unwrap();
    assert_eq!(simulation.sleeping().len(), 0);
    let from = simulation.snapshot().positions[0].z;
    simulation.advance(Until::time(10.5)).unwrap();
    let fallen = from - simulation.snapshot().positions[0].z;
    assert!((fallen - 0.5 * G * 0.25).abs() < 1e-12, "{fallen}");
}

#[test]
fn setting_velocities_wakes_all_grains() {
    let mut simulation = column();
    // A program that sets velocities wakes all grains.
    simulation.set_velocities(&[Vector::new(2.0, 0.0, 0.0), Vector::zeros()]).unwrap();
    assert_eq!(simulation.sleeping().len(), 0);
    simulation.advance(Until::time(14.0)).unwrap();
    assert!(simulation.snapshot().positions[1].z < 0.6, "the upper grain has fallen");
}

#[test]
fn mover_wakes_the_grains_that_it_touched() {
    // Two grains lie side by side. The first is pushed away along y, so that it does not hit the second.
    let scene = grains("", &[[3.0, 4.0, 0.5], [4.004, 4.0, 0.5]]);
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::time(10.0)).unwrap();
    assert_eq!(simulation.sleeping().len(), 2);
    let from = Vector::new(3.0, 2.6, simulation.snapshot().positions[0].z);
    let bullet = light(from, Vector::new(0.0, 8.0, 0.0));
    simulation.insert(&[bullet]).unwrap();
    let events = events_until(&mut simulation, 10.3);
    let woken: Vec<(u32, f64)> = events
        .iter()
        .filter(|event| event.kind == EventKind::Wake)
        .map(|event| (event.particle.0, event.time))
        .collect();
    assert!(woken.len() == 2 && woken[0].0 == 0 && (woken[0].1 - 10.05).abs() < 1e-3, "{woken:?}");
    assert_eq!(woken[1], (1, 10.25), "the second wakes at the next search");
    // Nothing else disturbs it, so it falls asleep again.
    simulation.advance(Until::time(11.0)).unwrap();
    assert_eq!(simulation.event_counts().rest, 3);
}

#[test]
fn grains_on_a_belt_stay_awake() {
    let floor = "
[[surface]]
shape = \"parallelogram\"
corner = [0.0, 0.0, 1.0]
edge_1 = [8.0, 0.0, 0.0]
edge_2 = [0.0, 8.0, 0.0]
friction = 0.01
restitution = 0.5
";
    for (velocity, rests) in [("", 1), ("surface_velocity = [0.001, 0.0, 0.0]\n", 0)] {
        let mut simulation = Simulation::without_plan(grains(&format!("{floor}{velocity}"), &[[3.0, 4.0, 1.5]]));
        simulation.advance(Until::time(4.9)).unwrap();
        assert_eq!(simulation.event_counts().rest, rests);
    }
}

#[test]
fn grain_that_rattles_in_a_gap_wakes_its_neighbours() {
    let gap = 2e-8;
    let mut simulation = Simulation::without_plan(grains("", &[[3.0, 4.0, 0.7], [5.0 + gap, 4.0, 0.7]]));
    simulation.advance(Until::time(5.01)).unwrap();
    assert_eq!(simulation.sleeping().len(), 2);
    let [left, right] = [0, 1].map(|k| simulation.snapshot().positions[k]);
    assert!((right - left).norm() < 2.0 + 3.0 * gap && (left.z - right.z).abs() < 1e-4);
    simulation.insert(&[light((left + right) * 0.5, Vector::new(0.05, 0.0, 0.0))]).unwrap();
    let events = events_until(&mut simulation, 5.03);
    let wakes: Vec<usize> = (0..events.len()).filter(|&k| events[k].kind == EventKind::Wake).collect();
    // 64 contacts in a contact time, and 25 contact times between two searches.
    assert_eq!(wakes, [1601, 1603]);
    assert!(events.len() < 2000, "without the rule, there are some 50,000: {}", events.len());
}
