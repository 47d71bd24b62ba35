//! A ball in the corner of three static spheres, under gravity.

use crate::listed::{hard_sphere, open_box};
use crate::watched::Watched;
use carom::Vector;
use carom::scene::SceneBuilder;
use carom::simulation::{Arrest, Reason, Simulation, Standstill, Until};

/// `sqrt(3) / 2`: the height of a triangle of edge 1.
const TRIANGLE: f64 = 0.866_025_403_784_438_6;

/// Three static spheres in contact with each other, and a ball above the middle of the hole between them, not quite: the corner
/// is at a height of `sqrt(2 / 3) = 0.816`, and the way out over two of the spheres at `sqrt(3) / 2 = 0.866`.
fn corner(restitution: f64, contact_time: Option<f64>, height: f64, velocity: Vector) -> SceneBuilder {
    let mut builder = SceneBuilder::new("corner")
        .space(open_box(8.0))
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .static_species("S", 1.0)
        .species("A", 1.0, 1.0)
        .interaction("S", "A", hard_sphere(), restitution)
        .interaction("A", "A", hard_sphere(), restitution);
    for (x, y) in [(0.0, 0.0), (1.0, 0.0), (0.5, TRIANGLE)] {
        builder = builder.particle("S", Vector::new(x, y, 0.0), Vector::zeros());
    }
    if let Some(time) = contact_time {
        builder = builder.contact_time(time);
    }
    builder.particle("A", Vector::new(0.51, TRIANGLE / 3.0 - 0.003, height), velocity)
}

/// Where the ball touches all three.
fn bottom() -> Vector {
    Vector::new(0.5, TRIANGLE / 3.0, (2.0_f64 / 3.0).sqrt())
}

#[test]
fn an_elastic_ball_jumps_in_the_corner_for_a_million_events() {
    // Too low to get out.
    let mut watched = Watched::new(corner(1.0, None, 0.86, Vector::zeros()).build().unwrap());
    watched.run(1_000_000);
    watched.assert_sound(1.0);
    let now = watched.simulation.snapshot().positions[3];
    assert!(now.z > bottom().z && now.z < TRIANGLE, "{now}");
}

#[test]
fn an_inelastic_ball_comes_to_rest_in_the_corner_and_stays() {
    let contact_time = 1e-3;
    for restitution in [0.0, 0.5, 0.9] {
        let scene = corner(restitution, Some(contact_time), 1.2, Vector::new(0.02, 0.0, 0.0)).build().unwrap();
        let mut watched = Watched::new(scene);
        assert_eq!(watched.simulation.advance(Until::time(60.0)), Ok(Reason::Time));
        let before = watched.simulation.tally().physical();
        // At rest every flight is shorter than the contact time, or the contact after it would take energy. A flight from
        // one of the spheres, on which the ball rests with its weight's part of 1 / (3 cos) = 0.41 along the normal
        // and slides off with the rest, leaves at speeds of up to 0.82 t_c, and a ball at that speed rises by up to
        // v^2 / 2 < t_c^2 above the bottom. Sideways it is kept by slopes of at most 0.7 against the vertical: 2 t_c^2.
        let reach = 8.0 * contact_time * contact_time;
        let mut worst = 0.0_f64;
        for part in 1..=100 {
            assert_eq!(watched.simulation.advance(Until::events(before + 10_000 * part)), Ok(Reason::Events));
            worst = worst.max((watched.simulation.snapshot().positions[3] - bottom()).norm());
        }
        println!(
            "e = {restitution}: {before} events to rest, then up to {worst:.1e} from the bottom, time {}",
            watched.simulation.time()
        );
        watched.assert_sound(1.0);
        assert!(worst < reach, "{worst:e} from the bottom");
    }
}

#[test]
fn without_the_tc_model_the_ball_arrests_in_the_corner() {
    for restitution in [0.0, 0.1, 0.5, 0.9] {
        let mut simulation = Simulation::new(corner(restitution, None, 1.2, Vector::zeros()).build().unwrap());
        let arrest: Arrest = simulation.advance(Until::time(1000.0)).unwrap_err();
        let events = simulation.tally().physical();
        println!("e = {restitution}: {events} events, {arrest}");
        assert_eq!(arrest.particle.0.max(arrest.partner.unwrap().0), 3, "{arrest}");
        assert!(arrest.time < 60.0, "{arrest}");
        assert!(matches!(arrest.standstill, Standstill::Time { .. } | Standstill::Speed { .. }));
        // At most 1,000 and some in no time; as many before, while each contact leaves a part of the speed.
        assert!(events < 20_000, "{events} events");
        assert!((simulation.snapshot().positions[3] - bottom()).norm() < 1e-6);
        assert_eq!(simulation.tally().in_invalid_state, 0);
    }
}

#[test]
fn a_ball_dropped_exactly_in_the_middle_meets_all_three_at_once() {
    let exact = |contact_time| {
        corner(0.5, contact_time, 1.2, Vector::zeros()).particle(
            "A",
            bottom() + Vector::new(0.0, 0.0, 1.5),
            Vector::zeros(),
        )
    };
    let mut simulation = Simulation::new(exact(Some(1e-3)).build().unwrap());
    assert_eq!(simulation.advance(Until::time(30.0)), Ok(Reason::Time));
    assert_eq!(simulation.tally().in_invalid_state, 0);
    println!("{:?}", simulation.snapshot().positions);
}
