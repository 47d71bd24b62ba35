//! Conservation of energy with masses and diameters that are not powers of two. The error grows like a random walk.

use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::Space;
use carom::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

fn drift(scene: Scene, events: u64) -> f64 {
    let mut simulation = Simulation::without_plan(scene);
    let total = |simulation: &Simulation| {
        let energy = simulation.energy();
        energy.kinetic + energy.potential
    };
    let before = total(&simulation);
    simulation.advance(Until::events(events)).unwrap();
    let event_counts = simulation.event_counts();
    assert_eq!(event_counts.physical(), events);
    (total(&simulation) + event_counts.dissipated.total() - before) / before
}

/// Four standard deviations of a random walk. Each event rounds six velocity components three times. The root mean
/// square error is `0.8 eps` times the energy of the pair. This energy is at most the total energy.
fn bound(events: u64) -> f64 {
    4.0 * 0.8 * f64::EPSILON * (events as f64).sqrt()
}

fn two(masses: [f64; 2], diameters: [f64; 2], size: f64) -> Scene {
    let mean = 0.5 * (diameters[0] + diameters[1]);
    SceneBuilder::new("two")
        .species(SpeciesDraft::new("A").mass(masses[0]).diameter(diameters[0]))
        .species(SpeciesDraft::new("B").mass(masses[1]).diameter(diameters[1]))
        .interaction(InteractionDraft::new(Potential::hard_sphere(mean).unwrap()).between("A", "B"))
        .space(Space::periodic_cube(size))
        .particle("A", Vector::repeat(0.5) * diameters[0], Vector::new(1.0, 0.3, 0.2))
        .particle("B", Vector::new(2.0, 0.6, 0.4) * mean, Vector::new(-1.0, 0.1, -0.4))
        .build()
        .unwrap()
}

#[test]
fn elastic_spheres_of_any_masses_keep_their_energy() {
    let mut worst = 0.0_f64;
    for masses in [[10.0, 10.0], [0.1, 0.1], [0.7, 3.0], [3.0, 0.7], [10.0, 0.1], [1.0, 1e3], [1e6, 3.3], [7.7, 7.7e12]]
    {
        let error = drift(two(masses, [1.0, 1.0], 3.0), 100_000);
        println!("{masses:?}: {error:e}");
        worst = worst.max(error.abs());
    }
    // If the two velocity changes were rounded separately, the error for masses of 10 would be 14 times larger.
    assert!(worst < bound(100_000), "{worst:e}");
}

#[test]
fn elastic_spheres_of_any_diameter_keep_their_energy() {
    // The engine multiplies squared distances by 9/16 to keep them away from powers of two. At a diameter of 4/3, the
    // product would be 1, so the engine must not use this factor.
    for (diameter, events) in [(4.0 / 3.0, 1_000_000), (0.7, 100_000), (3.0, 100_000), (1e-3, 100_000)] {
        let error = drift(two([1.0, 1.0], [diameter; 2], 3.0 * diameter), events);
        assert!(error.abs() < bound(events), "{diameter}: {error:e}, bound {:e}", bound(events));
    }
}

#[test]
fn a_mixture_with_walls_wells_and_static_spheres_keeps_its_energy() {
    let scene = Scene::from_toml(
        "
        [space]
        size = [7.0, 6.0, 5.0]
        x = 'walls'
        [[species]]
        name = 'light'
        mass = 0.137
        diameter = 0.61
        [[species]]
        name = 'heavy'
        mass = 91.3
        diameter = 1.37
        [[species]]
        name = 'post'
        static = true
        diameter = 0.9
        [[interaction]]
        species = ['light', 'light']
        potential = 'square-well'
        lambda = 1.7
        well_depth = 0.3
        [[interaction]]
        species = ['light', 'heavy']
        potential = 'hard-sphere'
        [[interaction]]
        species = ['heavy', 'heavy']
        potential = 'square-shoulder'
        lambda = 1.2
        height = 0.7
        [[interaction]]
        species = ['light', 'post']
        potential = 'hard-sphere'
        [[interaction]]
        species = ['heavy', 'post']
        potential = 'hard-sphere'
        [[particle]]
        species = 'post'
        position = [3.5, 3.0, 2.5]
        [[fill]]
        composition = { light = 5.0, heavy = 1.0 }
        arrangement = 'random'
        count = 36
        temperature = 1.3
        [run]
        until_events = 1
        ",
        "mixture.toml",
    )
    .unwrap();
    // The bound assumes that a pair has the total energy. Most pairs have about a twentieth of this energy.
    let error = drift(scene, 300_000);
    assert!(error.abs() < bound(300_000), "{error:e}, bound {:e}", bound(300_000));
}
