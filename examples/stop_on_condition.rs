//! A granular gas that is simulated until nine tenths of its energy are gone, and stops at the event that does it.

use std::error::Error;
use std::ops::ControlFlow;

use carom::engine::{Reason, Simulation, Until};
use carom::model::Potential;
use carom::scene::{Amount, Lattice, SceneBuilder};

/// The gas, kinetic energy before and after, and why the simulation ended.
pub fn cooled() -> Result<(Simulation, [f64; 2], Reason), Box<dyn Error>> {
    let scene = SceneBuilder::new("gas")
        .species("grain", 1.0, 1.0)
        .interaction("grain", "grain", Potential::hard_sphere(1.0)?, 0.8)
        .fill(Lattice::FaceCentredCubic, "grain", 500, Amount::PackingFraction(0.1))
        .temperature(1.0)
        .build()?;
    let mut simulation = Simulation::new(scene)?;
    let start = simulation.energy().kinetic;
    let mut left = start;
    let reason = simulation.advance_with(Until::events(10_000_000), |event| {
        left -= event.dissipated;
        if left < 0.1 * start { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let end = simulation.energy().kinetic;
    Ok((simulation, [start, end], reason))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (simulation, [start, end], _) = cooled()?;
    let contacts = 2.0 * simulation.event_counts().core as f64 / simulation.moving() as f64;
    println!(
        "kinetic energy from {start:.1} to {end:.1} in {contacts:.1} contacts per grain, t = {}",
        simulation.time()
    );
    Ok(())
}
