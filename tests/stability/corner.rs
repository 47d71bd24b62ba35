//! A ball under gravity, in the corner of three static spheres.

use crate::listed::{hard_sphere, open_box};
use crate::watched::Watched;
use carom::Vector;
use carom::engine::{Arrest, Reason, Simulation, Until};
use carom::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};

/// `sqrt(3) / 2`, the height of an equilateral triangle.
const TRIANGLE: f64 = 0.866_025_403_784_438_6;

/// Three static spheres in contact, and a ball above the hole between them. The ball rests at a height of `sqrt(2 / 3)
/// = 0.816`, and can escape at `sqrt(3) / 2 = 0.866`.
fn corner(restitution: f64, contact_time: Option<f64>, position: Vector, velocity: Vector) -> SceneBuilder {
    let mut builder = SceneBuilder::new("corner")
        .space(open_box(8.0))
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .species(SpeciesDraft::new("S").diameter(1.0).fixed())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard_sphere()).between("S", "A").restitution(restitution))
        .interaction(InteractionDraft::new(hard_sphere()).between("A", "A").restitution(restitution));
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.5, TRIANGLE)] {
        builder = builder.particle("S", Vector::new(x, y, 0.0), Vector::zeros());
    }
    if let Some(time) = contact_time {
        builder = builder.contact_time(time);
    }
    builder.particle("A", position, velocity)
}

/// The ball touches all three spheres at this position.
fn bottom() -> Vector {
    Vector::new(0.5, TRIANGLE / 3.0, (2.0_f64 / 3.0).sqrt())
}

fn aside(height: f64) -> Vector {
    Vector::new(0.51, TRIANGLE / 3.0 - 0.003, height)
}

fn ball(watched: &Watched) -> Vector {
    watched.simulation.snapshot().positions[3]
}

#[test]
fn an_elastic_ball_jumps_in_the_corner_for_a_million_events() {
    // The ball starts too low to escape.
    let mut watched = Watched::new(corner(1.0, None, aside(0.86), Vector::zeros()).build().unwrap());
    watched.run(1_000_000);
    watched.assert_sound(1.0);
    let now = ball(&watched);
    assert!(now.z > bottom().z && now.z < TRIANGLE, "{now}");
}

#[test]
fn an_inelastic_ball_comes_to_rest_in_the_corner_and_stays() {
    let contact_time = 1e-3;
    for (restitution, events) in [(0.0, 100_000), (0.5, 1_000_000), (0.9, 100_000)] {
        let velocity = Vector::new(0.02, 0.0, 0.0);
        let scene = corner(restitution, Some(contact_time), aside(0.86), velocity).build().unwrap();
        let mut watched = Watched::new(scene);
        let above_bottom = |watched: &Watched| {
            let energy = watched.simulation.energy();
            energy.kinetic + energy.potential - bottom().z
        };
        assert_eq!(watched.simulation.advance(Until::time(60.0)), Ok(Reason::Time));
        let (before, mut last) = (watched.simulation.event_counts().physical(), above_bottom(&watched));
        let mut worst = 0.0_f64;
        for part in 1..=100 {
            assert_eq!(watched.simulation.advance(Until::events(before + events / 100 * part)), Ok(Reason::Events));
            worst = worst.max((ball(&watched) - bottom()).norm());
            // The energy never grows, except by rounding errors.
            let now = above_bottom(&watched);
            assert!(now <= last + 4.0 * 16.0 * f64::EPSILON * (events as f64 / 100.0).sqrt(), "{now:e}, {last:e}");
            last = now;
        }
        println!(
            "e = {restitution}: {before} events to rest, {worst:.1e} from the bottom, energy {last:.1e}, time {}",
            watched.simulation.time()
        );
        watched.assert_sound(1.0);
        // Contacts dissipate no energy after flights shorter than the contact time t_c. Such a flight begins with a
        // speed of at most t_c / 2. With restitution 0, the ball bounces along the groove between two spheres and loses
        // energy slowly.
        assert!(last < contact_time * contact_time, "{last:e}");
        assert!(restitution == 0.0 || worst < contact_time * contact_time, "{worst:e}");
    }
}

#[test]
fn without_the_tc_model_the_ball_arrests_in_the_corner() {
    for restitution in [0.0, 0.1, 0.5, 0.9] {
        let scene = corner(restitution, None, aside(0.86), Vector::zeros()).build().unwrap();
        let mut simulation = Simulation::without_plan(scene);
        let arrest: Arrest = simulation.advance(Until::time(1000.0)).unwrap_err().arrest().unwrap();
        let events = simulation.event_counts().physical();
        println!("e = {restitution}: {events} events, {arrest} at {:?}", simulation.snapshot().positions[3] - bottom());
        assert_eq!(arrest.particle.0.max(arrest.partner.unwrap().0), 3, "{arrest}");
        assert!(arrest.time < 60.0, "{arrest}");
        // An arrest is reported after about 1,000 events in which time hardly advances.
        assert!(events < 20_000, "{events} events");
        assert_eq!(simulation.event_counts().in_invalid_state, 0);
    }
}

#[test]
fn a_ball_dropped_exactly_into_the_middle_meets_all_three_at_once() {
    for restitution in [0.1, 0.5] {
        let start = bottom() + Vector::new(0.0, 0.0, 0.5);
        let scene = corner(restitution, Some(1e-3), start, Vector::zeros()).build().unwrap();
        let mut watched = Watched::new(scene);
        let mut times = Vec::new();
        watched.simulation.advance_with(Until::events(12), |event| times.push(event.time)).unwrap();
        assert!(times[..3].iter().all(|time| (time - 1.0).abs() < 16.0 * f64::EPSILON), "{times:?}");
        assert_eq!(watched.simulation.advance(Until::time(30.0)), Ok(Reason::Time));
        watched.assert_sound(1.0);
    }
}
