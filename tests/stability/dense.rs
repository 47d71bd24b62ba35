//! Crystals close to the densest packing, in which every particle stays in its cage.

use crate::listed::{fluid, hard_sphere, listed, particles};
use crate::watched::Watched;
use carom::Vector;
use carom::engine::{Snapshot, Until};
use carom::model::space::Space;
use carom::scene::Amount;

/// The densest packing fraction, `pi / sqrt(18)`.
const DENSEST: f64 = 0.740_480_489_693_061;

fn largest_displacement(space: &Space, start: &[(Vector, Vector)], now: &Snapshot) -> f64 {
    let size = space.size;
    let moved = |k: usize| {
        let image = Vector::from_fn(|axis, _| f64::from(now.images[k][axis]) * size[axis]);
        (now.positions[k] + image - start[k].0).norm()
    };
    (0..start.len()).map(moved).fold(0.0, f64::max)
}

#[test]
fn a_crystal_near_close_packing_stays_sound_for_a_million_events() {
    let scene = fluid(500, Amount::PackingFraction(0.73));
    let (space, start) = (scene.space().clone(), particles(&scene));
    let mut watched = Watched::new(scene);
    watched.run(1_000_000);
    // An event changes the energies of two of the 500 particles. Each may have ten times the mean energy.
    watched.assert_sound(2.0 / 500.0 * 10.0);
    // The bound allows for 32 roundings of each coordinate (see `Overlap::round_off`).
    let deepest = watched.simulation.event_counts().deepest_overlap;
    assert!(deepest < 32.0 * f64::EPSILON * (2.0 * space.size.x + 2.0), "{deepest:e}");
    // Neighbours are 1.005 apart at a packing fraction of 0.73. A particle leaves its cage only if three neighbours are
    // sqrt(3) apart.
    let moved = largest_displacement(&space, &start, &watched.simulation.snapshot());
    println!("largest displacement {moved}");
    assert!(moved < 0.2, "{moved}");
}

#[test]
fn a_crystal_at_a_gap_of_a_millionth_of_a_diameter_stays_sound() {
    // At the packing fraction `phi`, the relative gap between neighbours is `1 - (phi / DENSEST)^(1/3)`.
    for gap in [1e-6_f64, 1e-9] {
        let fraction = DENSEST * (1.0 - gap).powi(3);
        let mut watched = Watched::new(fluid(108, Amount::PackingFraction(fraction)));
        watched.run(300_000);
        watched.assert_sound(2.0 / 108.0 * 10.0);
        let event_counts = watched.simulation.event_counts();
        println!("gap {gap:e}: time {:e}, virial {:e}", watched.simulation.time(), event_counts.virial.total());
        // Near close packing, free-volume theory gives Z -> 3 / (1 - phi / phi_0) = 1 / gap (Salsburg and Wood, J.
        // Chem. Phys. 37, 798, 1962).
        let particles = 107.0;
        let z = 1.0 + event_counts.virial.total() / (3.0 * particles * watched.simulation.time());
        println!("Z gap = {}", z * gap);
        assert!((z * gap - 1.0).abs() < 0.01, "{z}");
    }
}

#[test]
fn a_crystal_at_rest_does_nothing() {
    let scene = fluid(500, Amount::PackingFraction(0.73));
    for velocity in [Vector::zeros(), Vector::new(0.5, -0.25, 0.125)] {
        let start: Vec<_> = particles(&scene).iter().map(|(r, _)| (*r, velocity)).collect();
        let mut watched = Watched::new(listed(scene.space(), &hard_sphere(), 1.0, &start).build().unwrap());
        watched.simulation.advance(Until::time(100.0)).unwrap();
        assert_eq!(watched.simulation.event_counts().physical(), 0);
        watched.assert_sound(1.0);
        let end = watched.simulation.snapshot();
        assert!(end.velocities.iter().all(|v| *v == velocity));
        // A coordinate is rounded when the particle leaves a cell or the box, less than 100 times.
        let moved = |k: usize, axis: usize| {
            end.positions[k][axis] + f64::from(end.images[k][axis]) * scene.space().size[axis] - start[k].0[axis]
        };
        for (k, axis) in (0..500).flat_map(|k| (0..3).map(move |axis| (k, axis))) {
            let error = moved(k, axis) - 100.0 * velocity[axis];
            assert!(error.abs() <= 100.0 * 64.0 * f64::EPSILON, "{error:e}");
        }
    }
}
