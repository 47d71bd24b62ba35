//! What must not change a trajectory: where time starts, how it is cut into stretches, how particles are numbered; and what
//! undoes it, reversed velocities.

use carom::Vector;
use carom::potential::Potential;
use carom::scene::{Amount, Lattice, Scene, SceneBuilder};
use carom::simulation::{Simulation, Snapshot, Until};
use carom::space::{Boundary, Space};

/// A fluid on a lattice, to take the particles from.
fn lattice(boundary: [Boundary; 3], lattice: Lattice, count: u64, density: f64) -> Scene {
    SceneBuilder::new("lattice")
        .boundary(boundary)
        .species("A", 1.0, 1.0)
        .interaction("A", "A", Potential::hard_sphere(1.0).unwrap(), 1.0)
        .fill(lattice, "A", count, Amount::NumberDensity(density))
        .temperature(1.0)
        .build()
        .unwrap()
}

/// Given particles in a given box, by their positions and velocities.
fn listed(space: &Space, potential: &Potential, particles: &[(Vector, Vector)]) -> SceneBuilder {
    let mut builder = SceneBuilder::new("listed")
        .space(space.clone())
        .allow_invalid_start(true)
        .species("A", 1.0, 1.0)
        .interaction("A", "A", potential.clone(), 1.0);
    for (position, velocity) in particles {
        builder = builder.particle("A", *position, *velocity);
    }
    builder
}

fn particles(scene: &Scene) -> Vec<(Vector, Vector)> {
    scene.particles.iter().map(|p| (p.position, p.velocity)).collect()
}

const BULK: [Boundary; 3] = [Boundary::Periodic; 3];

fn well() -> Potential {
    Potential::square_well(1.0, 1.5, 1.0).unwrap()
}

#[test]
fn the_start_of_time_changes_nothing() {
    let start = lattice(BULK, Lattice::FaceCentredCubic, 256, 0.6);
    let run = |start_time: f64| {
        let scene = listed(&start.space, &well(), &particles(&start)).start_time(start_time).build().unwrap();
        let mut simulation = Simulation::new(scene);
        let mut events = Vec::new();
        simulation
            .advance_with(Until::events(50_000), |event| {
                events.push((event.kind, event.particle, event.partner, event.impulse.to_bits()));
            })
            .unwrap();
        (events, simulation.snapshot())
    };
    let (events, end) = run(0.0);
    let (late_events, late_end) = run(1e12);
    assert_eq!(events, late_events);
    assert_eq!((&end.positions, &end.velocities), (&late_end.positions, &late_end.velocities));
    assert!((late_end.time - 1e12 - end.time).abs() <= 1e12 * f64::EPSILON);
}

#[test]
fn a_scene_has_one_future_however_it_is_cut() {
    let start = lattice(BULK, Lattice::FaceCentredCubic, 256, 0.6);
    let scene = || listed(&start.space, &well(), &particles(&start)).build().unwrap();
    let whole = |until: Until| {
        let mut simulation = Simulation::new(scene());
        simulation.advance(until).unwrap();
        (simulation.snapshot(), *simulation.tally())
    };
    let by_time = whole(Until::time(20.0));
    assert_eq!(by_time, whole(Until::time(20.0)));
    let mut simulation = Simulation::new(scene());
    for part in 1..=1999 {
        simulation.advance(Until::time(0.01 * f64::from(part))).unwrap();
        let _ = (simulation.snapshot(), simulation.energy(), simulation.deepest_overlap());
    }
    simulation.advance(Until::time(20.0)).unwrap();
    assert_eq!(by_time, (simulation.snapshot(), *simulation.tally()));

    let by_events = whole(Until::events(30_000));
    let mut simulation = Simulation::new(scene());
    for part in 1..=30_000 {
        simulation.advance(Until::events(part)).unwrap();
    }
    let cut = (simulation.snapshot(), *simulation.tally());
    assert_eq!((by_events.0.positions, by_events.0.velocities), (cut.0.positions, cut.0.velocities));
    assert_eq!(by_events.1.virial.to_bits(), cut.1.virial.to_bits());
}

#[test]
fn numbers_are_only_names() {
    let start = lattice(BULK, Lattice::FaceCentredCubic, 256, 0.6);
    let end = |order: &[usize]| -> Vec<(Vector, Vector)> {
        let original = particles(&start);
        let shuffled: Vec<(Vector, Vector)> = order.iter().map(|&k| original[k]).collect();
        let mut simulation = Simulation::new(listed(&start.space, &well(), &shuffled).build().unwrap());
        simulation.advance(Until::time(10.0)).unwrap();
        let Snapshot { positions, velocities, .. } = simulation.snapshot();
        let mut sorted = vec![(Vector::zeros(), Vector::zeros()); order.len()];
        for (at, &k) in order.iter().enumerate() {
            sorted[k] = (positions[at], velocities[at]);
        }
        sorted
    };
    let forwards: Vec<usize> = (0..256).collect();
    let backwards: Vec<usize> = (0..256).rev().collect();
    let shuffled: Vec<usize> = (0..256).map(|k| k * 101 % 256).collect();
    let expected = end(&forwards);
    assert_eq!(expected, end(&backwards));
    assert_eq!(expected, end(&shuffled));
}

/// The largest distance between two states of the same particles.
fn largest(space: &Space, a: &[Vector], b: &[Vector]) -> f64 {
    let apart = |(a, b): (&Vector, &Vector)| carom::space::minimum_image(a - b, &space.periods()).amax();
    a.iter().zip(b).map(apart).fold(0.0, f64::max)
}

#[test]
fn reversed_velocities_retrace_the_run() {
    for potential in [Potential::hard_sphere(1.0).unwrap(), well()] {
        // A warm start, away from the lattice.
        let first = lattice(BULK, Lattice::FaceCentredCubic, 108, 0.7);
        let mut warm = Simulation::new(listed(&first.space, &potential, &particles(&first)).build().unwrap());
        warm.advance(Until::time(2.0)).unwrap();
        let warm = warm.snapshot();
        let start: Vec<(Vector, Vector)> = warm.positions.iter().copied().zip(warm.velocities).collect();

        let time = 0.5;
        let run = |start: &[(Vector, Vector)]| {
            let mut simulation = Simulation::new(listed(&first.space, &potential, start).build().unwrap());
            simulation.advance(Until::time(time)).unwrap();
            (simulation.snapshot(), simulation.tally().physical())
        };
        let (there, events) = run(&start);
        let turned: Vec<(Vector, Vector)> =
            there.positions.iter().zip(&there.velocities).map(|(r, v)| (*r, -v)).collect();
        let (back, events_back) = run(&turned);
        assert_eq!(events, events_back);
        assert!(events > 200, "{events}");

        // Chaos multiplies round-off: as much as it multiplies a shift of one coordinate, measured here.
        let shift = 1e-10;
        let mut shifted = turned.clone();
        shifted[0].0.x += shift;
        let amplification = largest(&first.space, &run(&shifted).0.positions, &back.positions) / shift;
        // Every event rounds coordinates of up to the box's length some ten units, and all may add up.
        let rounded = 10.0 * first.space.size.x * f64::EPSILON * events as f64;
        let error = largest(&first.space, &back.positions, &start.iter().map(|p| p.0).collect::<Vec<_>>());
        println!("{events} events there and back: {error:e}, amplification {amplification:.0}");
        assert!(amplification * rounded < 1e-6, "too chaotic to tell");
        assert!(error < amplification.max(1.0) * rounded, "{error} after {events} events");
    }
}

#[test]
fn flat_scenes_stay_flat_and_straight_ones_straight() {
    let plane = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
    let line = [Boundary::Periodic, Boundary::Flat, Boundary::Flat];
    for (boundary, arrangement, axes) in [(plane, Lattice::Square, 2), (line, Lattice::Line, 1)] {
        for potential in [Potential::hard_sphere(1.0).unwrap(), well()] {
            let scene = lattice(boundary, arrangement, 100, 0.5);
            let space = Space { lower: Vector::new(0.1, 0.2, 0.3), ..scene.space.clone() };
            let moved: Vec<_> = particles(&scene).iter().map(|(r, v)| (r + space.lower, *v)).collect();
            let scene = listed(&space, &potential, &moved).build().unwrap();
            let mut simulation = Simulation::new(scene);
            simulation.advance(Until::events(100_000)).unwrap();
            let end = simulation.snapshot();
            for (position, velocity) in end.positions.iter().zip(&end.velocities) {
                for k in axes..3 {
                    assert_eq!((position[k], velocity[k]), (space.lower[k], 0.0));
                }
            }
        }
    }
}
