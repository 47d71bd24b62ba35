//! A heap of grains at rest, kept alive by the TC model.

use crate::listed::hard_sphere;
use crate::watched::Watched;
use carom::Vector;
use carom::scene::{Arrangement, Fill, Scene, SceneBuilder};
use carom::simulation::{Reason, Until};
use carom::space::{Boundary, Face, Space};

/// The TC model's contact time; gravity, masses and diameters are 1.
const CONTACT_TIME: f64 = 1e-3;
/// Grains.
const COUNT: u64 = 40;

/// Grains that fall into a box with a floor and four walls, some three layers high.
fn grains(restitution: f64) -> Scene {
    let floor = Boundary::Bounded { lower: Face::Wall { restitution }, upper: Face::Open };
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(4.3, 3.7, 16.0),
        boundary: [Boundary::walls(restitution), Boundary::walls(restitution), floor],
    };
    let (lower, upper) = (Vector::new(0.5, 0.5, 0.5), Vector::new(3.8, 3.2, 15.0));
    SceneBuilder::new("heap")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .contact_time(CONTACT_TIME)
        .species("A", 1.0, 1.0)
        .interaction("A", "A", hard_sphere(), restitution)
        .add_fill(Fill::new(Arrangement::Random, "A").count(COUNT).region(lower, upper))
        .temperature(0.1)
        .build()
        .unwrap()
}

fn positions(watched: &Watched) -> Vec<Vector> {
    watched.simulation.snapshot().positions
}

fn farthest(a: &[Vector], b: &[Vector]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
}

fn explore(restitution: f64, events: u64) {
    let mut watched = Watched::new(grains(restitution));
    let begin = std::time::Instant::now();
    let mut last = positions(&watched);
    for k in 0..40 {
        let r = watched.simulation.advance(Until::events(events * (k + 1) / 40));
        assert_eq!(r, Ok(Reason::Events));
        let now = positions(&watched);
        println!(
            "{} events t {:.4} kinetic/N {:.3e} moved {:.3e} altered {} turning {} deepest {:.1e} {:.1} s",
            watched.simulation.tally().physical(),
            watched.simulation.time(),
            watched.simulation.energy().kinetic / COUNT as f64,
            farthest(&last, &now),
            watched.simulation.tally().tc_altered,
            watched.simulation.tally().turning_point,
            watched.simulation.tally().deepest_overlap,
            begin.elapsed().as_secs_f64()
        );
        last = now;
    }
    watched.assert_sound(1.0);
}

#[test]
fn explore_heap() {
    for e in [0.3, 0.5] {
        explore(e, 4_000_000);
    }
}
