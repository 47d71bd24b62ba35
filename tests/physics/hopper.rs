//! The hopper scene in `configs/`.

use carom::Vector;
use carom::engine::{Reason, Simulation, Until};
use carom::model::Scene;

/// Deepest overlap due to rounding. Positions are below 128, and a distance depends on six coordinates.
const ROUND_OFF: f64 = 10.0 * 64.0 * f64::EPSILON;

fn ledger_error(simulation: &Simulation, start: f64) -> f64 {
    let now = simulation.energy();
    (now.kinetic + now.potential + simulation.event_counts().dissipated.total() - start).abs()
}

#[test]
fn every_grain_ends_in_the_container() {
    let mut simulation = Simulation::without_plan(Scene::from_file("configs/hopper.toml").unwrap());
    let start = simulation.energy();
    let grains = simulation.moving();
    assert_eq!(simulation.advance(Until::time(76.0)), Ok(Reason::Time));
    let settling = simulation.snapshot();
    let (lower, upper) = (Vector::new(-16.0, -16.0, 0.0), Vector::new(34.0, 16.0, 14.7));
    for position in &settling.positions[..grains] {
        assert!((0..3).all(|k| lower[k] < position[k] && position[k] < upper[k]), "{position}");
    }
    assert_eq!(simulation.advance(Until::time(80.0)), Ok(Reason::Time));
    let settled = simulation.snapshot();
    let moved = (0..grains).map(|k| (settled.positions[k] - settling.positions[k]).norm()).fold(0.0, f64::max);
    assert!(moved < 2.0, "a grain of diameter 2 still moves by {moved}");
    assert!(simulation.energy().kinetic < 1e-3 * start.potential);
    assert_eq!((simulation.event_counts().in_invalid_state, simulation.event_counts().turning_point), (0, 0));
    assert!(simulation.event_counts().deepest_overlap < ROUND_OFF);
    // Each event rounds the energies of two grains a few times. The energy of a grain is at most m g h = 76.
    let bound = simulation.event_counts().physical() as f64 * 8.0 * 2.0 * 76.0 * f64::EPSILON;
    assert!(ledger_error(&simulation, start.kinetic + start.potential) < bound);
}

#[test]
fn grains_of_any_restitution_flow_without_an_error() {
    for restitution in ["0.0", "0.1", "0.5", "0.9", "0.99", "1.0"] {
        let keys = ["interaction.0", "interaction.1", "space.x", "space.y", "space.z"]
            .map(|key| key.to_owned() + ".restitution");
        let overrides: Vec<(&str, &str)> = keys.iter().map(|key| (key.as_str(), restitution)).collect();
        let scene = Scene::from_file_with("configs/hopper.toml", &overrides).unwrap();
        let mut simulation = Simulation::without_plan(scene);
        let start = simulation.energy();
        assert_eq!(simulation.advance(Until::events(50_000)), Ok(Reason::Events), "{restitution}");
        let bound = 50_000.0 * 8.0 * 2.0 * 76.0 * f64::EPSILON;
        assert!(ledger_error(&simulation, start.kinetic + start.potential) < bound, "{restitution}");
        assert!(simulation.event_counts().deepest_overlap < ROUND_OFF, "{restitution}");
        assert_eq!(simulation.event_counts().in_invalid_state, 0, "{restitution}");
    }
}
