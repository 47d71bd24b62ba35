//! Grains that start at rest in contact, under gravity, with the TC model.

use carom::engine::event::EventKind;
use carom::engine::{Reason, Simulation, Until};
use carom::model::Scene;

/// Gravity, contact time and mass of the grains.
pub const G: f64 = 0.7;
const TC: f64 = 1e-2;
pub const MASS: f64 = 1.3;

/// A box with a floor. `first` comes before its tables, `dynamics` is added to its dynamics, and `last` follows.
pub fn scene_above_floor(first: &str, dynamics: &str, last: &str) -> Scene {
    let toml = format!(
        "
{first}
[space]
size = [8.0, 8.0, 20.0]
x = \"walls\"
y = \"walls\"
z = {{ lower = \"wall\", upper = \"open\", restitution = 0.4 }}
[run]
until_time = 100.0
[dynamics]
gravity = [0.0, 0.0, -{G}]
contact_time = {TC}
{dynamics}
[[species]]
name = \"grain\"
mass = {MASS}
diameter = 1.0
[[interaction]]
species = [\"grain\", \"grain\"]
potential = \"hard-sphere\"
restitution = 0.6
{last}"
    );
    Scene::from_toml(&toml, "contact.toml").unwrap()
}

/// The table of a particle.
pub fn listed(position: &[f64; 3], velocity: &[f64; 3]) -> String {
    format!("[[particle]]\nspecies = \"grain\"\nposition = {position:?}\nvelocity = {velocity:?}\n")
}

/// Grains at the given positions with the given velocities.
fn grains(more: &str, start: &[([f64; 3], [f64; 3])]) -> Simulation {
    let particles: String = start.iter().map(|(position, velocity)| listed(position, velocity)).collect();
    Simulation::without_plan(scene_above_floor(more, "", &particles))
}

/// Relative error of the sum of all energies.
pub fn ledger_error(simulation: &Simulation, start: f64) -> f64 {
    let (energy, counts) = (simulation.energy(), simulation.event_counts());
    let supplied = counts.supplied.total();
    (energy.total() + counts.dissipated.total() - supplied - start).abs() / (energy.total().abs() + supplied)
}

#[test]
fn grain_at_rest_on_a_floor_bounces_with_the_contact_time() {
    let mut simulation = grains("", &[([3.0, 4.0, 0.5], [0.0; 3])]);
    let start = simulation.energy().total();
    let mut times = Vec::new();
    let reason = simulation.advance_with(Until::time(1000.5 * TC), |event| {
        assert_eq!(event.kind, EventKind::Surface);
        times.push(event.time);
    });
    assert_eq!(reason, Ok(Reason::Time));
    assert_eq!(times.len(), 1001);
    for (k, time) in times.iter().enumerate() {
        // Each contact rounds the time and the speed a few times.
        assert!((time - k as f64 * TC).abs() < 1e-12, "{k}: {time}");
    }
    let counts = simulation.event_counts();
    // The first contact lifts the grain to the speed `g tc / 2`. All further contacts are elastic.
    assert_eq!((counts.tc_lifted, counts.tc_contacts), (1, 1001));
    let speed = 0.5 * G * TC;
    assert!((counts.supplied.total() / (0.5 * MASS * speed * speed) - 1.0).abs() < 1e-14);
    // Round-off of the times, about 1e-15, is a relative error of 1e-13 in the interval. It may decide that a contact is
    // not recent, and reduce the speed by as much.
    assert!(counts.dissipated.total() < 1e-9 * counts.supplied.total());
    assert!(ledger_error(&simulation, start) < 1e-14);
}

#[test]
fn slow_grain_on_a_floor_has_no_storm_of_events() {
    for velocity in [1e-8, -1e-8, 1e-300] {
        let mut simulation = grains("", &[([3.0, 4.0, 0.5], [0.0, 0.0, velocity])]);
        assert_eq!(simulation.advance(Until::time(100.0 * TC)), Ok(Reason::Time));
        let events = simulation.event_counts().physical();
        assert!((100..=102).contains(&events), "{velocity}: {events}");
    }
}

#[test]
fn piles_at_rest_stay_at_rest() {
    // A column of five grains, and two columns of two that touch each other and the walls.
    let mut places: Vec<[f64; 3]> = (0..5).map(|k| [1.5, 1.5, 0.5 + f64::from(k)]).collect();
    places.extend([[7.5, 7.5, 0.5], [7.5, 7.5, 1.5], [7.5, 6.5, 0.5], [7.5, 6.5, 1.5]]);
    let start: Vec<([f64; 3], [f64; 3])> = places.iter().map(|place| (*place, [0.0; 3])).collect();
    let mut simulation = grains("", &start);
    let energy = simulation.energy().total();
    assert_eq!(simulation.advance(Until::time(200.0 * TC)), Ok(Reason::Time));
    for (k, (position, place)) in simulation.snapshot().positions.iter().zip(&places).enumerate() {
        // A grain at rest rises by `g tc^2 / 8`. Grains above it rise by a few times as much.
        assert!((position.z - place[2]).abs() < 10.0 * G * TC * TC, "{k}: {position}");
    }
    let counts = simulation.event_counts();
    assert!(counts.tc_lifted > 0 && counts.physical() < 200 * 9 * 20, "{counts:?}");
    assert!(ledger_error(&simulation, energy) < 1e-13, "{}", ledger_error(&simulation, energy));
    assert!(simulation.deepest_overlap().is_none_or(|overlap| overlap.depth < 1e-13));
}

#[test]
fn packing_with_overlaps_is_separated_and_comes_to_rest() {
    // Columns on a floor, compressed by a thousandth, as a program with soft grains may leave them.
    let grid = |k: usize| [k % 4, k / 4 % 4, k / 16].map(|n| n as f64);
    let places = (0..96).map(grid).map(|[x, y, z]| [1.0 + x * 1.3, 1.0 + y * 1.3, 0.499 + 0.999 * z]);
    let start: Vec<([f64; 3], [f64; 3])> = places.map(|place| (place, [0.0; 3])).collect();
    let mut simulation = grains("separate_overlaps = 0.01", &start);
    let separated = simulation.scene().separated();
    assert_eq!(separated.overlaps, 96);
    assert!((separated.deepest - 1e-3).abs() < 1e-12 && (0.006..0.01).contains(&separated.farthest), "{separated:?}");
    let energy = simulation.energy().total();
    assert_eq!(simulation.advance(Until::time(20.0)), Ok(Reason::Time));
    assert!(simulation.deepest_overlap().is_none_or(|overlap| overlap.depth < 1e-13));
    assert!(ledger_error(&simulation, energy) < 1e-13);
    // Grains at rest in the TC model move with about `g tc / 2`, times the number of grains that they carry.
    let speed = 6.0 * 0.5 * G * TC;
    assert!(simulation.energy().kinetic < 96.0 * 0.5 * MASS * speed * speed, "{:?}", simulation.energy());
}
