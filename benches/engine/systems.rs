//! Benchmark systems, brought to the state in which their events are timed.

use carom::engine::{Simulation, Until};
use carom::model::potential::Potential;
use carom::model::{DiameterDistribution, Scene};
use carom::scene::{Amount, Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};

pub struct System {
    pub name: &'static str,
    pub start: fn() -> Simulation,
    /// Whether the system stays in a steady state. Otherwise, each measurement restarts the system.
    pub is_steady: bool,
}

const fn steady(name: &'static str, start: fn() -> Simulation) -> System {
    System { name, start, is_steady: true }
}

const fn passing(name: &'static str, start: fn() -> Simulation) -> System {
    System { name, start, is_steady: false }
}

pub const SYSTEMS: [System; 10] = [
    steady("hard spheres, phi = 0.10", || hard_spheres(0.1)),
    steady("hard spheres, phi = 0.30", || hard_spheres(0.3)),
    steady("hard spheres, phi = 0.49", || hard_spheres(0.49)),
    steady("individual diameters, phi = 0.49", individual_diameters),
    steady("square well 1.5, rho = 0.5", || square_well(0.5)),
    steady("square well 1.5, rho = 0.8", || square_well(0.8)),
    passing("stepped Lennard-Jones", || configured("stepped_lennard_jones")),
    passing("granular gas", || configured("granular_cooling")),
    passing("hopper", || configured("hopper")),
    passing("pendulum", || configured("pendulum")),
];

const PARTICLES: u64 = 10_976;

fn hard_spheres(packing_fraction: f64) -> Simulation {
    fluid(Potential::hard_sphere(1.0).expect("a valid potential"), Amount::PackingFraction(packing_fraction), 1.0)
}

/// Spheres whose diameters differ by 23 % on average.
fn individual_diameters() -> Simulation {
    let distribution = DiameterDistribution::PowerLaw { exponent: 3.0, lower: 0.725, upper: 1.613 };
    let scene = SceneBuilder::new("individual")
        .species(SpeciesDraft::new("A").mass(1.0).distributed(distribution))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(PARTICLES).packing_fraction(0.49))
        .temperature(1.0)
        .build()
        .expect("a valid scene");
    advanced(scene, 5 * PARTICLES)
}

fn square_well(density: f64) -> Simulation {
    let well = Potential::square_well(1.0, 1.5, 1.0).expect("a valid potential");
    fluid(well, Amount::NumberDensity(density), 2.0)
}

/// A fluid after ten events per particle.
fn fluid(potential: Potential, amount: Amount, temperature: f64) -> Simulation {
    let scene = SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(potential).between("A", "A"))
        .fill(Fill { amount: Some(amount), ..Fill::new(Lattice::FaceCentredCubic, "A").count(PARTICLES) })
        .temperature(temperature)
        .build()
        .expect("a valid scene");
    advanced(scene, 5 * PARTICLES)
}

fn configured(name: &str) -> Simulation {
    advanced(Scene::from_file(format!("configs/{name}.toml")).expect("a valid scene"), 20_000)
}

fn advanced(scene: Scene, events: u64) -> Simulation {
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::events(events)).expect("the TC model prevents an arrest");
    simulation
}
