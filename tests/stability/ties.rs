//! Thousands of simultaneous events have a defined order. The result is as symmetric as the start.

use crate::listed::{State, hard_sphere, line, listed};
use carom::Vector;
use carom::engine::event::Event;
use carom::engine::{Reason, Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};

const EDGE: u32 = 16;
const COUNT: usize = (EDGE * EDGE * EDGE) as usize;

/// Lattice spacing perpendicular to the x-axis. It makes cells 2 long, so transitions are exact.
const WIDE: f64 = 3.25;

/// Sheets of particles with a distance of 2 along x. Neighbouring sheets have opposite velocities of 1. All numbers are
/// short binary fractions, so nothing is rounded.
fn sheets() -> (Space, Vec<State>) {
    let at = |k: u32| f64::from(2 * k) + 0.5;
    let across = |k: u32| WIDE * f64::from(k) + 0.5;
    let particles = (0..u32::try_from(COUNT).unwrap())
        .map(|id| {
            let [x, y, z] = [id % EDGE, id / EDGE % EDGE, id / EDGE / EDGE];
            (Vector::new(at(x), across(y), across(z)), Vector::new(if x % 2 == 0 { 1.0 } else { -1.0 }, 0.0, 0.0))
        })
        .collect();
    let mut space = Space::periodic_cube(WIDE * f64::from(EDGE));
    space.size.x = f64::from(2 * EDGE);
    (space, particles)
}

fn run(space: &Space, potential: &Potential, particles: &[State], time: f64) -> (Simulation, Vec<Event>) {
    let mut simulation = Simulation::without_plan(listed(space, potential, 1.0, particles).build().unwrap());
    let mut events = Vec::new();
    assert_eq!(simulation.advance_with(Until::time(time), |event| events.push(*event)), Ok(Reason::Time));
    (simulation, events)
}

fn pair(event: &Event) -> (u32, u32) {
    let (a, b) = (event.particle.0, event.partner().unwrap().0);
    (a.min(b), a.max(b))
}

#[test]
fn sheets_of_a_lattice_collide_all_at_once_and_exactly() {
    let (space, particles) = sheets();
    // The first gaps of 1 close in a time of 0.5, and later gaps of 2 in a time of 1.
    let (simulation, events) = run(&space, &hard_sphere(), &particles, 10.0);
    assert_eq!(events.len(), 10 * COUNT / 2);
    for (round, together) in events.chunks(COUNT / 2).enumerate() {
        let time = 0.5 + round as f64;
        assert!(together.iter().all(|event| event.time == time), "round {round}");
        // Simultaneous events are executed in the order of the lower id of each pair.
        assert!(together.is_sorted_by_key(pair), "round {round}");
    }
    let end = simulation.snapshot();
    for (k, (position, velocity)) in particles.iter().enumerate() {
        assert_eq!((end.positions[k], end.velocities[k]), (*position, *velocity), "{k}");
    }
    assert_eq!(simulation.energy().kinetic, 0.5 * COUNT as f64);
    assert_eq!(simulation.event_counts().deepest_overlap, 0.0);
}

#[test]
fn ties_between_separate_pairs_do_not_depend_on_the_numbering() {
    let (space, particles) = sheets();
    let (expected, _) = run(&space, &hard_sphere(), &particles, 7.25);
    // 1,231 is coprime to the number of particles, so every particle occurs once.
    let order: Vec<usize> = (0..COUNT).map(|k| k * 1231 % COUNT).collect();
    let shuffled: Vec<State> = order.iter().map(|&k| particles[k]).collect();
    let (renumbered, events) = run(&space, &hard_sphere(), &shuffled, 7.25);
    assert_eq!(events.len(), 7 * COUNT / 2);
    let (expected, renumbered) = (expected.snapshot(), renumbered.snapshot());
    for (at, &k) in order.iter().enumerate() {
        assert_eq!(renumbered.positions[at], expected.positions[k]);
        assert_eq!(renumbered.velocities[at], expected.velocities[k]);
    }
}

/// Returns the largest difference between the distances that particles have moved along their initial directions.
/// Asserts that no particle moves perpendicular to the x-axis.
fn asymmetry(simulation: &Simulation, particles: &[State]) -> f64 {
    let (end, size) = (simulation.snapshot(), simulation.scene().space().size.x);
    let moved = |k: usize| {
        let x = end.positions[k].x + f64::from(end.images[k][0]) * size;
        (x - particles[k].0.x) * particles[k].1.x
    };
    let speed = |k: usize| end.velocities[k].x * particles[k].1.x;
    (0..particles.len())
        .map(|k| {
            assert_eq!(end.positions[k].yz(), particles[k].0.yz());
            assert_eq!(end.velocities[k].yz(), particles[k].1.yz());
            (moved(k) - moved(0)).abs().max((speed(k) - speed(0)).abs())
        })
        .fold(0.0, f64::max)
}

#[test]
fn a_lattice_of_square_wells_stays_symmetric() {
    let (space, particles) = sheets();
    // A depth of 3 doubles the relative speed of 2 inside the well. Each particle has a Capture, a Core and a Release
    // with one neighbour, then with the other.
    let well = Potential::square_well(1.0, 1.25, 3.0).unwrap();
    let (simulation, events) = run(&space, &well, &particles, 20.0);
    let event_counts = simulation.event_counts();
    assert_eq!(event_counts.capture, event_counts.core);
    assert_eq!((event_counts.capture - event_counts.release) % (COUNT as u64 / 2), 0);
    assert_eq!(events.len() % (COUNT / 2), 0);
    // Each event rounds positions below 32. The effect of velocity errors grows with time.
    let per_particle = 2.0 * events.len() as f64 / COUNT as f64;
    let bound = 16.0 * f64::EPSILON * 32.0 * per_particle * per_particle;
    for round in events.chunks(COUNT / 2) {
        let spread = round.iter().map(|e| (e.time - round[0].time).abs()).fold(0.0, f64::max);
        assert!(spread <= bound, "{spread:e}, {bound:e}");
    }
    let worst = asymmetry(&simulation, &particles);
    println!("largest difference {worst:e}, bound {bound:e}");
    assert!(worst <= bound);
    let energy = simulation.energy();
    let error = (energy.kinetic + energy.potential) / (0.5 * COUNT as f64) - 1.0;
    assert!(error.abs() <= 16.0 * f64::EPSILON * per_particle, "{error:e}");
}

#[test]
fn a_periodic_row_collides_all_at_once() {
    let count = 1000_usize;
    let space = line(2.0 * count as f64, Boundary::Periodic);
    let particles: Vec<State> = (0..count)
        .map(|k| {
            let x = space.lower.x + 2.0 * k as f64;
            (Vector::new(x, 0.0, 0.0), Vector::new(if k % 2 == 0 { 1.0 } else { -1.0 }, 0.0, 0.0))
        })
        .collect();
    let (simulation, events) = run(&space, &hard_sphere(), &particles, 100.0);
    assert_eq!(events.len(), 100 * count / 2);
    assert!(events.iter().enumerate().all(|(k, event)| event.time == 0.5 + (k / (count / 2)) as f64));
    let end = simulation.snapshot();
    assert!((0..count).all(|k| (end.positions[k], end.velocities[k]) == particles[k]));
}

#[test]
fn a_sphere_struck_from_all_sides_at_once_stays_where_it_is() {
    // Along each axis, three simultaneous events exchange the velocities of two strikers.
    for dimensions in 1..=3 {
        let space = Space {
            lower: Vector::repeat(-4.0),
            size: Vector::from_fn(|k, _| if k < dimensions { 8.0 } else { 0.0 }),
            boundary: std::array::from_fn(|k| if k < dimensions { Boundary::OPEN } else { Boundary::Flat }),
        };
        let centre = Vector::from_fn(|k, _| if k < dimensions { 0.0 } else { -4.0 });
        let mut particles = vec![(centre, Vector::zeros())];
        for (axis, sign) in (0..dimensions).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
            let outwards = Vector::ith(axis, sign);
            particles.push((centre + outwards * 2.0, -outwards));
        }
        let (simulation, events) = run(&space, &hard_sphere(), &particles, 2.0);
        assert_eq!(events.len(), 3 * dimensions);
        assert!(events.iter().all(|event| event.time == 1.0));
        let end = simulation.snapshot();
        for (k, (position, velocity)) in particles.iter().enumerate() {
            assert_eq!((end.positions[k], end.velocities[k]), (*position, -*velocity), "{dimensions} {k}");
        }
    }
}
