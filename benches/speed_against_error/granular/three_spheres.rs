//! The example of Bamme and Sbalzarini: three elastic spheres on a line, with an exact solution.

use super::spring_dashpot::{SpringDashpot, Start};
use super::{COST, Method, sheet, timed};
use crate::Outcome;
use crate::sheet::number;
use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::model::space::{Boundary, Space};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

pub const SHEET: &str = "granular_three_spheres";

pub const EXPLANATION: &str = "### Three spheres on a line

Elastic spheres on a line collide twice; their positions at t = 10 are known exactly. In the scene `configs/elastic_spheres_1d.toml`, here
in units of the diameter, the first two spheres overlap by 0.02 at the start and approach each other. With the paper's stable rule, they
collide at once. In a second initial state, there is a gap of 0.02 instead of the overlap.";

pub const VALID: &str = "three spheres: valid start";
pub const OVERLAPPED: &str = "three spheres: overlapped start";

const TIME: f64 = 10.0;

/// Initial position of the middle sphere, and exact final positions of all spheres.
const STARTS: [(&str, f64, [f64; 3]); 2] =
    [(VALID, 1.02, [-19.98, 23.0, 42.0]), (OVERLAPPED, 0.98, [-20.0, 23.0, 41.98])];

const VELOCITIES: [f64; 3] = [4.0, -2.0, 2.0];

pub fn measure() -> Outcome {
    let mut sheet = sheet(SHEET, &["start", COST, "position error", "energy error", "deepest overlap"]);
    for (name, middle, exact) in STARTS {
        let mut push = |method: Method, result: [f64; 4]| {
            let mut row = method.cells().to_vec();
            row.push(name.to_owned());
            row.extend(result.map(number));
            sheet.push(row)
        };
        push(Method::Carom { contact_time: 0.0 }, carom(middle, exact)?)?;
        for stiffness in [1e3, 1e4, 1e5, 1e6] {
            for steps_per_contact in [10.0, 30.0, 100.0] {
                let result = baseline(middle, exact, stiffness, steps_per_contact);
                push(Method::SpringDashpot { stiffness, steps_per_contact }, result)?;
            }
        }
    }
    Ok(())
}

fn positions(middle: f64) -> [f64; 3] {
    [0.0, middle, 4.0]
}

fn farthest(found: &[Vector], exact: [f64; 3]) -> f64 {
    found.iter().zip(exact).map(|(found, exact)| (found.x - exact).abs()).fold(0.0, f64::max)
}

fn scene(middle: f64) -> Outcome<Scene> {
    let space = Space {
        lower: Vector::new(-2.0, 0.0, 0.0),
        size: Vector::new(8.0, 0.0, 0.0),
        boundary: [Boundary::OPEN, Boundary::Flat, Boundary::Flat],
    };
    let mut builder = SceneBuilder::new("three-spheres")
        .space(space)
        .allow_invalid_start(true)
        .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"));
    for (position, velocity) in positions(middle).into_iter().zip(VELOCITIES) {
        builder = builder.particle("sphere", Vector::x() * position, Vector::x() * velocity);
    }
    Ok(builder.build()?)
}

fn carom(middle: f64, exact: [f64; 3]) -> Outcome<[f64; 4]> {
    let scene = scene(middle)?;
    let run = || {
        let mut simulation = Simulation::without_plan(scene.clone());
        simulation.advance(Until::time(TIME)).map(|_| simulation)
    };
    let (cost, simulation) = timed(run);
    let simulation = simulation?;
    let energy = simulation.energy().kinetic / initial_energy() - 1.0;
    let deepest = simulation.event_counts().deepest_overlap;
    Ok([cost / (3.0 * TIME), farthest(&simulation.snapshot().positions, exact), energy, deepest])
}

fn initial_energy() -> f64 {
    0.5 * VELOCITIES.iter().map(|v| v * v).sum::<f64>()
}

fn baseline(middle: f64, exact: [f64; 3], stiffness: f64, steps_per_contact: f64) -> [f64; 4] {
    let start = Start {
        periods: Vector::repeat(f64::INFINITY),
        gravity: 0.0,
        has_floor: false,
        positions: positions(middle).iter().map(|&x| Vector::x() * x).collect(),
        velocities: VELOCITIES.iter().map(|&v| Vector::x() * v).collect(),
    };
    let (cost, grains) = timed(|| {
        let mut grains = SpringDashpot::new(start.clone(), stiffness, 1.0, steps_per_contact);
        grains.advance(TIME);
        grains
    });
    [
        cost / (3.0 * TIME),
        farthest(grains.positions(), exact),
        grains.kinetic() / initial_energy() - 1.0,
        grains.deepest,
    ]
}
