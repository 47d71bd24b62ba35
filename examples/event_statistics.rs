//! Counts captures, releases and bounces of square wells, and averages their impulses.

use std::collections::BTreeMap;
use std::error::Error;

use carom::engine::event::{EventKind, Outcome};
use carom::engine::{Simulation, Until};
use carom::model::Potential;
use carom::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

/// Number of events and sum of the impulses, for each outcome.
pub type Statistics = BTreeMap<&'static str, (u64, f64)>;

/// Runs a square-well fluid for a number of events. Returns the statistics of these events.
pub fn statistics(events: u64) -> Result<Statistics, Box<dyn Error>> {
    let well = Potential::square_well(1.0, 1.5, 1.0)?;
    let scene = SceneBuilder::new("wells")
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(well).between("sphere", "sphere"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(500).number_density(0.5))
        .temperature(2.0)
        .build()?;
    let mut simulation = Simulation::new(scene)?;
    let mut statistics = Statistics::new();
    for event in simulation.events(Until::events(events)) {
        let event = event?;
        let name = match event.kind {
            EventKind::Pair(Outcome::Core) => "core",
            EventKind::Pair(Outcome::Capture) => "capture",
            EventKind::Pair(Outcome::Release) => "release",
            EventKind::Pair(Outcome::Bounce) => "bounce",
            _ => "other",
        };
        let (count, impulse) = statistics.entry(name).or_default();
        *count += 1;
        *impulse += event.normal_impulse();
    }
    Ok(statistics)
}

fn main() -> Result<(), Box<dyn Error>> {
    let events = 100_000;
    for (name, (count, impulse)) in statistics(events)? {
        let part = 100.0 * count as f64 / events as f64;
        println!("{name:8} {part:5.1} % of the events, mean impulse {:+.3}", impulse / count as f64);
    }
    Ok(())
}
