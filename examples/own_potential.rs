//! Defines a potential of Yukawa spheres with a hard core and ten steps.

use std::error::Error;

use carom::engine::{Simulation, Until};
use carom::model::Potential;
use carom::scene::{Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

const STEPS: u32 = 10;
const CUTOFF: f64 = 2.0;
const STRENGTH: f64 = 2.0;
const SCREENING: f64 = 2.0;

/// The Yukawa potential `e exp(-k (r - 1)) / r`, with the strength `e` and the screening constant `k`.
fn yukawa(distance: f64) -> f64 {
    STRENGTH * (-SCREENING * (distance - 1.0)).exp() / distance
}

/// Approximates the Yukawa potential by steps. The radii are in descending order and end with the hard core. The first
/// energy is for distances beyond all radii.
pub fn stepped_yukawa() -> Result<Potential, Box<dyn Error>> {
    let width = (CUTOFF - 1.0) / f64::from(STEPS);
    let radii: Vec<f64> = (0..=STEPS).map(|step| CUTOFF - width * f64::from(step)).collect();
    // Mean of the potential over the volume of a shell, int u(r) r^2 dr / int r^2 dr, by the midpoint rule.
    let mean = |outer: f64| {
        let points = (0..100).map(|k| outer - width * (f64::from(k) + 0.5) / 100.0);
        let (energy, volume) = points.fold((0.0, 0.0), |(e, v), r| (e + yukawa(r) * r * r, v + r * r));
        energy / volume
    };
    let steps = radii.iter().take(STEPS as usize).map(|&outer| mean(outer));
    let energies = [0.0].into_iter().chain(steps).chain([f64::INFINITY]).collect();
    Ok(Potential::new(radii, energies)?)
}

/// Simulates a fluid of Yukawa spheres. Returns the final state, and the total energy at the start.
pub fn simulated(events: u64) -> Result<(Simulation, f64), Box<dyn Error>> {
    let scene = SceneBuilder::new("yukawa")
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(stepped_yukawa()?).between("sphere", "sphere"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(256).number_density(0.4))
        .temperature(1.0)
        .build()?;
    let mut simulation = Simulation::new(scene)?;
    let start = simulation.energy();
    simulation.advance(Until::events(events))?;
    Ok((simulation, start.kinetic + start.potential))
}

fn main() -> Result<(), Box<dyn Error>> {
    let (simulation, start) = simulated(100_000)?;
    let energy = simulation.energy();
    println!("potential energy per particle {:.4}", energy.potential / simulation.moving() as f64);
    println!("relative change of the total energy: {:.1e}", (energy.kinetic + energy.potential) / start - 1.0);
    Ok(())
}
