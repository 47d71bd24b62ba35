//! Newton's cradle: moving spheres strike a line of resting spheres in contact.

use crate::listed::{State, along, hard_sphere, line, listed, open_box};
use crate::watched::Watched;
use carom::Vector;
use carom::engine::{Reason, Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::Boundary;
use carom::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

/// Five spheres in a row. The strikers come from the left at a speed of 1 and arrive at time 1. The other spheres rest
/// at `first` and at the positions that `next` computes.
fn row(first: f64, diameter: f64, mut next: impl FnMut(f64) -> f64, strikers: usize) -> Vec<State> {
    let mut particles: Vec<State> =
        (0..strikers).rev().map(|k| (along(first - 1.0 - diameter * (k + 1) as f64), along(1.0))).collect();
    let mut x = first;
    for _ in strikers..5 {
        particles.push((along(x), along(0.0)));
        x = next(x);
    }
    particles
}

fn cradle(diameter: f64, boundary: Boundary, particles: &[State]) -> Simulation {
    let mut builder = SceneBuilder::new("cradle")
        .space(line(16.0, boundary))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(diameter))
        .interaction(InteractionDraft::new(Potential::hard_sphere(diameter).unwrap()).between("A", "A"))
        // By rounding, spheres in contact may overlap by one unit in the last place.
        .allow_invalid_start(true);
    for (position, velocity) in particles {
        builder = builder.particle("A", *position, *velocity);
    }
    Simulation::without_plan(builder.build().unwrap())
}

#[test]
fn as_many_spheres_leave_as_strike_with_the_same_speed() {
    for strikers in 1..=4 {
        let mut simulation = cradle(1.0, Boundary::OPEN, &row(0.0, 1.0, |x| x + 1.0, strikers));
        let mut times = Vec::new();
        assert_eq!(simulation.advance_with(Until::time(2.0), |event| times.push(event.time)), Ok(Reason::Time));
        // Each striker causes one collision per resting sphere, all at time 1.
        assert_eq!(times, vec![1.0; strikers * (5 - strikers)]);
        let end = simulation.snapshot();
        let leaving = 5 - strikers;
        for k in 0..5 {
            assert_eq!(end.velocities[k], along(if k < leaving { 0.0 } else { 1.0 }), "{strikers} strike, {k}");
        }
        assert_eq!(simulation.event_counts().deepest_overlap, 0.0);
        assert_eq!(end.positions[4].x, (4 - strikers) as f64 + 1.0);
    }
}

#[test]
fn a_cradle_between_walls_swings_for_ever() {
    for strikers in 1..=4 {
        let mut simulation = cradle(1.0, Boundary::walls(1.0), &row(0.0, 1.0, |x| x + 1.0, strikers));
        for part in 1..=100 {
            assert_eq!(simulation.advance(Until::events(1000 * part)), Ok(Reason::Events));
            assert_eq!(simulation.energy().kinetic, 0.5 * strikers as f64);
        }
        assert_eq!(simulation.event_counts().deepest_overlap, 0.0);
        assert!(simulation.snapshot().velocities.iter().all(|v| [0.0, 1.0, -1.0].contains(&v.x)));
    }
}

#[test]
fn gaps_and_overlaps_of_a_rounding_make_no_difference() {
    // Diameter, first position and next position. Gaps and overlaps are as small as rounding errors.
    type Next = fn(f64) -> f64;
    let rows: [(f64, f64, Next); 5] = [
        (1.0, 0.0, |x| (x + 1.0).next_up()),
        (1.0, 0.1, |x| x + 1.0),
        (0.1, 0.1, |x| x + 0.1),
        (0.7, -0.3, |x| x + 0.7),
        (1.0 / 3.0, 1.0 / 7.0, |x| x + 1.0 / 3.0),
    ];
    for (which, (diameter, first, next)) in rows.into_iter().enumerate() {
        for strikers in 1..=4 {
            let start = row(first, diameter, next, strikers);
            let mut simulation = cradle(diameter, Boundary::OPEN, &start);
            assert_eq!(simulation.advance(Until::time(3.0)), Ok(Reason::Time));
            let events = simulation.event_counts().physical();
            // A velocity is passed on at most five times, with a few rounding errors each time.
            let bound = 5.0 * 8.0 * f64::EPSILON;
            let end = simulation.snapshot();
            let error = |k: usize| (end.velocities[k].x - if k < 5 - strikers { 0.0 } else { 1.0 }).abs();
            let worst = (0..5).map(error).fold(0.0, f64::max);
            println!("row {which}, {strikers} strike: {events} events, speeds off by {worst:.1e}");
            assert!(worst <= bound, "row {which}, {strikers} strike: {:?}", end.velocities);
            // Round-off may leave small speeds, which cause further contacts.
            assert!(events <= 2 * 25, "{events} events");
            assert_eq!(simulation.event_counts().in_invalid_state, 0);
        }
    }
}

fn of_masses(masses: [f64; 5], restitution: f64) -> SceneBuilder {
    let mut builder = SceneBuilder::new("masses").space(line(64.0, Boundary::OPEN));
    let names = ["A", "B", "C", "D", "E"];
    for (name, mass) in names.iter().zip(masses) {
        builder = builder.species(SpeciesDraft::new(name).mass(mass).diameter(1.0));
    }
    for (k, a) in names.iter().enumerate() {
        for b in &names[k..] {
            builder = builder.interaction(InteractionDraft::new(hard_sphere()).between(a, b).restitution(restitution));
        }
    }
    for (k, name) in names.iter().enumerate() {
        let (x, v) = if k == 0 { (-1.0, 1.0) } else { (k as f64, 0.0) };
        builder = builder.particle(name, along(x), along(v));
    }
    builder
}

#[test]
fn different_masses_keep_energy_and_momentum_in_few_events() {
    for masses in [
        [1.0, 2.0, 3.0, 4.0, 5.0],
        [1.0, 0.3, 7.0, 0.01, 2.0],
        [100.0, 1.0, 1.0, 1.0, 100.0],
        [1e-6, 1.0, 1e6, 1.0, 1e-3],
        [1.0, 1e-3, 1.0, 1e-3, 1.0],
    ] {
        let mut watched = Watched::new(of_masses(masses, 1.0).build().unwrap());
        let momentum = watched.simulation.energy().momentum.x;
        assert_eq!(watched.simulation.advance(Until::time(10.0)), Ok(Reason::Time));
        let events = watched.simulation.event_counts().physical();
        println!(
            "{masses:?}: {events} events, velocities {:?}",
            watched.simulation.snapshot().velocities.iter().map(|v| v.x).collect::<Vec<_>>()
        );
        watched.assert_sound(1.0);
        let after = watched.simulation.energy();
        let scale: f64 = masses.iter().map(|m| (2.0 * after.kinetic * m).sqrt()).sum();
        let drift = (after.momentum.x - momentum).abs();
        assert!(drift <= 8.0 * f64::EPSILON * scale * (1.0 + events as f64), "{drift:e}");
        // A light sphere of mass m between two spheres of mass M bounces about pi/2 sqrt(M/m) times. This is 50 at a
        // mass ratio of 1000. At most two spheres are light.
        assert!(events < 400, "{events} events");
    }
}

#[test]
fn inelastic_cradle_has_the_exact_final_speed_and_ledger() {
    let mut watched = Watched::new(of_masses([1.0; 5], 0.9).build().unwrap());
    assert_eq!(watched.simulation.advance(Until::time(10.0)), Ok(Reason::Time));
    watched.assert_sound(1.0);
    let last = watched.simulation.snapshot().velocities[4].x;
    assert!((last - 0.95_f64.powi(4)).abs() < 8.0 * 4.0 * f64::EPSILON, "{last}");
}

#[test]
fn long_row_transmits_a_blow_to_its_last_sphere() {
    let count = 1000_usize;
    let mut start: Vec<State> = (0..count).map(|k| (along(k as f64), along(0.0))).collect();
    start[0] = (along(-1.0), along(1.0));
    let space = line(4096.0, Boundary::OPEN);
    let mut simulation = Simulation::without_plan(listed(&space, &hard_sphere(), 1.0, &start).build().unwrap());
    assert_eq!(simulation.advance(Until::time(2.0)), Ok(Reason::Time));
    assert_eq!(simulation.event_counts().core, count as u64 - 1);
    let end = simulation.snapshot();
    // Sphere `k` comes to rest at the position `k`.
    let is_at = |k: usize, x: f64| (end.positions[k] - along(x)).norm() <= 2.0 * f64::EPSILON * count as f64;
    assert!(end.velocities[count - 1] == along(1.0) && is_at(count - 1, count as f64));
    assert!((0..count - 1).all(|k| end.velocities[k] == along(0.0) && is_at(k, k as f64)));
}

#[test]
fn pairs_with_speeds_one_ulp_apart_separate_at_once() {
    // The impulse is as small as the rounding errors of the velocities. The pair must separate, or the event repeats
    // forever.
    let (mut pairs, mut most) = (0, 0);
    for index in 0..2000_u16 {
        let k = f64::from(index);
        let normal = Vector::new(libm::sin(k), libm::cos(1.7 * k), libm::sin(0.6 * k + 1.0)).normalize();
        let velocity = Vector::new(1.0 + 0.01 * k, 3.0, -2.0);
        let mut slower = velocity;
        let axis = usize::from(index) % 3;
        slower[axis] =
            if normal[axis] * velocity[axis] < 0.0 { velocity[axis].next_up() } else { slower[axis].next_down() };
        let start = [(Vector::zeros(), velocity), (normal, slower)];
        let builder = listed(&open_box(64.0), &hard_sphere(), [1.0, 0.9, 0.5][usize::from(index) % 3], &start);
        let mut simulation =
            Simulation::without_plan(builder.allow_invalid_start(true).contact_time(1e-30).build().unwrap());
        assert_eq!(simulation.advance(Until::time(1.0)), Ok(Reason::Time));
        let events = simulation.event_counts().physical();
        pairs += u64::from(events > 0);
        most = most.max(events);
    }
    println!("{pairs} pairs met, up to {most} times");
    assert!(pairs > 500, "{pairs} pairs");
    assert!(most <= 4, "{most} events");
}
