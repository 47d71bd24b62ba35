//! Single bodies with known motion.

use carom::Vector;
use carom::engine::event::EventKind;
use carom::engine::{Reason, Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, Scene};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use std::f64::consts::PI;

fn body(boundary: [Boundary; 3]) -> SceneBuilder {
    let space = Space { lower: Vector::new(-1.0, 0.0, 2.0), size: Vector::new(4.0, 5.0, 7.0), boundary };
    SceneBuilder::new("one_body").space(space).species(SpeciesDraft::new("A").mass(2.0).diameter(1.0))
}

#[test]
fn a_body_between_walls_returns_after_twice_their_distance_over_its_speed() {
    // The centre of the body can move by 3, 4 and 6 along x, y and z. At speeds of 3/8, 1 and 3/4, the periods are 16,
    // 8 and 16. All contact times are exact.
    let start = (Vector::new(0.25, 1.25, 7.0), Vector::new(0.375, -1.0, 0.75));
    let scene = body([Boundary::walls(1.0); 3])
        .interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between("A", "A"))
        .particle("A", start.0, start.1)
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    for period in 1..=1000 {
        let mut faces = [0; 6];
        let until = Until::time(16.0 * f64::from(period));
        let reason = simulation.advance_with(until, |event| match event.kind {
            EventKind::Surface => faces[usize::from(event.code() - 4)] += 1,
            _ => panic!("{event:?}"),
        });
        assert_eq!(reason, Ok(Reason::Time));
        assert_eq!(faces, [1, 1, 2, 2, 1, 1], "period {period}");
        let now = simulation.snapshot();
        assert_eq!((now.positions[0], now.velocities[0]), start, "period {period}");
    }
}

#[test]
fn a_body_in_a_periodic_box_returns_after_its_length_over_its_speed() {
    let start = (Vector::new(0.0, 1.25, 7.5), Vector::new(0.5, -1.0, 0.875));
    let scene = body([Boundary::Periodic; 3])
        .interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between("A", "A"))
        .particle("A", start.0, start.1)
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    // The periods along x, y and z are 8, 5 and 8, so the body returns every 40 units of time.
    assert_eq!(simulation.advance(Until::time(40_000.0)), Ok(Reason::Time));
    let now = simulation.snapshot();
    assert_eq!(now.velocities[0], start.1);
    assert_eq!(now.images[0], [5000, -8000, 5000]);
    // Each of the 18,000 passages, and the flight before it, rounds a coordinate below 16 once.
    assert!((now.positions[0] - start.0).norm() < 2.0 * 18_000.0 * 8.0 * f64::EPSILON, "{:?}", now.positions[0]);
}

/// Returns the contact times, the heights of the peaks after them, and the final simulation.
fn bounces(restitution: f64, contact_time: f64) -> (Vec<f64>, Vec<f64>, Simulation) {
    let (e, t_c) = (restitution.to_string(), format!("{contact_time:e}"));
    let overrides = [("space.z.restitution", e.as_str()), ("dynamics.contact_time", t_c.as_str())];
    let scene = Scene::from_file_with("configs/bouncing_ball.toml", &overrides).unwrap();
    let mut simulation = Simulation::without_plan(scene);
    let (mut times, mut peaks, mut speed) = (Vec::new(), Vec::new(), 0.0);
    let _ = simulation.advance_with(Until::events(200), |event| {
        // Gravity and mass are 1. The ball returns to the floor at the speed with which it left.
        let arrival = if times.is_empty() { 2.0_f64.sqrt() } else { speed };
        speed = event.normal_impulse() - arrival;
        times.push(event.time);
        peaks.push(0.5 * speed * speed);
    });
    (times, peaks, simulation)
}

#[test]
fn bouncing_ball_heights_decay_geometrically_to_a_finite_rest_time() {
    for (e, rest) in [(0.5_f64, 4.242641), (0.9, 26.870058)] {
        assert!((2.0_f64.sqrt() * (1.0 + e) / (1.0 - e) - rest).abs() < 1e-6);
        let contact_time = 1e-6;
        let (times, peaks, _) = bounces(e, contact_time);
        let mut expected = 2.0_f64.sqrt();
        // The TC model changes only contacts after flights that are shorter than the contact time.
        let dissipative = (1..).take_while(|n| 2.0 * 2.0_f64.sqrt() * e.powi(*n) >= contact_time).count() + 1;
        let mut compared = 0;
        for (n, (time, peak)) in (0..).zip(times.iter().zip(&peaks)) {
            let power = e.powi(n + 1);
            if 2.0 * 2.0_f64.sqrt() * power / e < contact_time {
                break;
            }
            // Each flight adds a round-off of a few units in the last place of the total time.
            let bound = 8.0 * (n + 1) as f64 * rest * f64::EPSILON;
            assert!((time - expected).abs() <= bound, "contact {n} at {time}, expected {expected}");
            assert!((peak - power * power).abs() <= bound, "peak {n} of {peak}, expected {}", power * power);
            expected += 2.0 * 2.0_f64.sqrt() * power;
            compared += 1;
        }
        println!("e = {e}: {} contacts, the last at {:?}, rest expected at {rest}", times.len(), times.last());
        assert_eq!(compared, dissipative, "e = {e}");
        // When the TC model acts, each contact leaves just enough speed for a flight of one contact time.
        let flights: Vec<f64> = times.windows(2).skip(dissipative).map(|pair| pair[1] - pair[0]).collect();
        assert!(flights.len() > 10, "{flights:?}");
        // A flight time is the difference of two rounded contact times.
        let round_off = 4.0 * rest * f64::EPSILON;
        assert!(flights.iter().all(|flight| (flight - contact_time).abs() <= round_off), "{flights:?}");
    }
}

fn elliptic_k(k: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - k * k).sqrt());
    for _ in 0..10 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

/// Returns the mean period of a bob on a bond of length `1 - width` to 1, released from the horizontal.
fn pendulum_period(width: f64, swings: usize) -> f64 {
    let space = Space { lower: Vector::repeat(-2.0), size: Vector::repeat(4.0), boundary: [Boundary::OPEN; 3] };
    let scene = SceneBuilder::new("pendulum")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .species(SpeciesDraft::new("pivot").diameter(0.1).fixed())
        .species(SpeciesDraft::new("bob").mass(1.0).diameter(0.1))
        .interaction(InteractionDraft::new(Model::None).between("pivot", "bob"))
        .interaction(InteractionDraft::new(Model::HardSphere).between("bob", "bob"))
        .interaction(InteractionDraft::new(Potential::bond(1.0 - width, 1.0).unwrap()).named("string"))
        .particle("pivot", Vector::zeros(), Vector::zeros())
        .particle("bob", Vector::new(1.0 - 0.5 * width, 0.0, 0.0), Vector::zeros())
        .bond([0, 1], "string")
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    // The normal of a contact is along the bond. The speed is nearly constant at the lowest point, so the time of a
    // passage is interpolated between two contacts.
    let (mut last, mut passages) = ((0.0, 1.0), Vec::new());
    while passages.len() < 2 * swings + 1 {
        let next = simulation.event_counts().physical() + 1000;
        simulation
            .advance_with(Until::events(next), |event| {
                let side = if event.partner().is_some_and(|id| id.0 == 0) { 1.0 } else { -1.0 };
                let x = side * event.normal.x;
                let now = (event.time, x);
                if (x > 0.0) != (last.1 > 0.0) && event.normal.z * side < 0.0 {
                    passages.push(last.0 + (now.0 - last.0) * last.1 / (last.1 - x));
                }
                last = now;
            })
            .unwrap();
    }
    (passages[2 * swings] - passages[0]) / swings as f64
}

#[test]
fn a_bonded_body_swings_with_the_period_of_a_pendulum() {
    // A pendulum released from the horizontal with L = g = 1 has the period 4 K(sin(pi/4)) = 7.4163.
    let exact = 4.0 * elliptic_k((PI / 4.0).sin());
    assert!((exact - 7.416_298_709).abs() < 1e-9);
    assert!((elliptic_k(0.0) - PI / 2.0).abs() < 1e-15);
    let errors = [1e-2, 1e-3, 1e-4].map(|width| (pendulum_period(width, 10) / exact - 1.0).abs());
    println!("relative errors of the period {errors:?}");
    for (error, width) in errors.iter().zip([1e-2, 1e-3, 1e-4]) {
        assert!(*error < 2.0 * width, "{error} at width {width}");
    }
}

#[test]
fn a_thrown_body_follows_its_parabola_off_a_floor() {
    // With a gravity of 1/2, the body falls 4 to the floor in a time of 4, so its period is 8.
    let boundary = [
        Boundary::Periodic,
        Boundary::OPEN,
        Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(1.0)), upper: Face::Open },
    ];
    let scene = body(boundary)
        .gravity(Vector::new(0.0, 0.0, -0.5))
        .interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between("A", "A"))
        .particle("A", Vector::new(0.0, 1.0, 2.0 + 0.5 + 4.0), Vector::new(1.0, 0.25, 0.0))
        .build()
        .unwrap();
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::time(8.0 * 100.0)).unwrap();
    let now = simulation.snapshot();
    assert_eq!(simulation.event_counts().wall, 100);
    // Contact times up to 800 have rounding errors of a few units in the last place, which shift all later motion.
    assert!((now.positions[0].z - 6.5).abs() < 1e-10, "{}", now.positions[0].z);
    assert!((now.positions[0].y - 201.0).abs() < 800.0 * 4.0 * 100.0 * f64::EPSILON);
    assert_eq!(now.images[0][0], 200);
}
