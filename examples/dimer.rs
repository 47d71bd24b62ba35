//! Builds two bonded particles one by one, and counts the events between them in a given time.

use std::error::Error;

use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::Potential;
use carom::model::space::Space;
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

/// Counts the events between two bonded beads in a given time. The bond keeps their distance between 1 and 1.4.
pub fn contacts(duration: f64) -> Result<u64, Box<dyn Error>> {
    let mut scene = SceneBuilder::new("dimer")
        .space(Space::periodic_cube(12.0))
        .species(SpeciesDraft::new("bead").mass(1.3).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("bead", "bead").restitution(0.9))
        .interaction(InteractionDraft::new(Potential::bond(1.0, 1.4)?).named("rope"));
    let first = scene.insert_particle("bead", Vector::new(1.0, 1.0, 1.0), Vector::x());
    let second = scene.insert_particle("bead", Vector::new(2.2, 1.0, 1.0), -Vector::x());
    let scene = scene.bond([first, second], "rope").build()?;
    let mut simulation = Simulation::new(scene)?;
    let mut contacts = 0;
    simulation.advance_with(Until::time(duration), |event| {
        let pair = [Some(event.particle), event.partner()];
        contacts += u64::from(pair.contains(&Some(first)) && pair.contains(&Some(second)));
    })?;
    Ok(contacts)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{} contacts in a time of 10", contacts(10.0)?);
    Ok(())
}
