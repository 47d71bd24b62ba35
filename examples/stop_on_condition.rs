//! Simulates a granular gas until it has lost nine tenths of its energy.

use std::error::Error;

use carom::engine::{Simulation, Until};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

/// Returns the cooled gas, and the kinetic energy at the start and at the end.
pub fn cooled() -> Result<(Simulation, [f64; 2]), Box<dyn Error>> {
    let scene = SceneBuilder::new("gas")
        .species(SpeciesDraft::new("grain").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("grain", "grain").restitution(0.8))
        .fill(Fill::new(Lattice::FaceCentredCubic, "grain").count(500).packing_fraction(0.1))
        .temperature(1.0)
        .build()?;
    let mut simulation = Simulation::new(scene)?;
    let start = simulation.energy().kinetic;
    let mut left = start;
    for event in simulation.events(Until::events(10_000_000)) {
        left -= event?.dissipated;
        if left < 0.1 * start {
            break;
        }
    }
    let end = simulation.energy().kinetic;
    Ok((simulation, [start, end]))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (simulation, [start, end]) = cooled()?;
    let contacts = 2.0 * simulation.event_counts().core as f64 / simulation.moving() as f64;
    println!(
        "kinetic energy from {start:.1} to {end:.1} in {contacts:.1} contacts per grain, t = {}",
        simulation.time()
    );
    Ok(())
}
