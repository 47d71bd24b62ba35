//! Runs replicas of a fluid in threads, each with its own seed, and averages their results.

use std::error::Error;
use std::thread;

use carom::engine::{Simulation, Until};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

fn contact_rate(seed: u64) -> Result<f64, Box<dyn Error + Send + Sync>> {
    let scene = SceneBuilder::new("replica")
        .seed(seed)
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(256).packing_fraction(0.2))
        .temperature(1.0)
        .build()?;
    let mut simulation = Simulation::new(scene)?;
    simulation.advance(Until::events(10_000))?;
    let (start, contacts) = (simulation.time(), simulation.event_counts().core_contacts());
    simulation.advance(Until::events(40_000))?;
    let contacts = (simulation.event_counts().core_contacts() - contacts) as f64;
    Ok(contacts / (simulation.time() - start) / simulation.moving() as f64)
}

/// The contact rate per particle in each replica.
pub fn contact_rates(replicas: u64) -> Result<Vec<f64>, Box<dyn Error + Send + Sync>> {
    thread::scope(|scope| {
        let threads: Vec<_> = (1..=replicas).map(|seed| scope.spawn(move || contact_rate(seed))).collect();
        threads.into_iter().map(|thread| thread.join().map_err(|_| "a replica failed")?).collect()
    })
}

/// Mean and standard error of independent values.
pub fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let (mean, error) = mean_and_error(&contact_rates(8)?);
    println!("contacts per particle and unit time: {mean:.3} +- {error:.3}");
    Ok(())
}
