//! A column of grains at rest. The heights of the grains are known exactly.

use super::spring_dashpot::{SpringDashpot, Start};
use super::{COST, Method, UNREST, sheet, timed};
use crate::Outcome;
use crate::sheet::number;
use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, Scene};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

pub const SHEET: &str = "granular_column";

pub const EXPLANATION: &str = "### A column at rest

Ten grains, each 0.1 above the one below it, fall on a floor at gravity 1 with a restitution of 0.5. At t = 30 they should lie on top of
each other, at heights 0.5, 1.5, ... The error is the largest error of a height.";

const GRAINS: usize = 10;
const TIME: f64 = 30.0;
const RESTITUTION: f64 = 0.5;

pub fn measure() -> Outcome {
    let mut sheet = sheet(SHEET, &[COST, "height error", UNREST, "deepest overlap"]);
    let mut push = |method: Method, result: [f64; 4]| {
        let mut row = method.cells().to_vec();
        row.extend(result.map(number));
        sheet.push(row)
    };
    for contact_time in [0.03, 0.01, 0.003, 0.001] {
        push(Method::Carom { contact_time }, carom(contact_time)?)?;
    }
    for stiffness in [1e3, 1e4, 1e5, 1e6] {
        for steps_per_contact in [10.0, 50.0] {
            push(Method::SpringDashpot { stiffness, steps_per_contact }, baseline(stiffness, steps_per_contact))?;
        }
    }
    Ok(())
}

fn positions() -> Vec<Vector> {
    (0..GRAINS).map(|k| Vector::new(2.0, 2.0, 0.6 + 1.1 * k as f64)).collect()
}

fn error(positions: &[Vector]) -> f64 {
    let heights = positions.iter().enumerate();
    heights.map(|(k, position)| (position.z - 0.5 - k as f64).abs()).fold(0.0, f64::max)
}

/// Number of particles, multiplied by the simulated time.
const AMOUNT: f64 = GRAINS as f64 * TIME;

fn scene(contact_time: f64) -> Outcome<Scene> {
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(RESTITUTION)), upper: Face::Open };
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(4.0, 4.0, 16.0),
        boundary: [Boundary::OPEN, Boundary::OPEN, floor],
    };
    let mut builder = SceneBuilder::new("column")
        .space(space)
        .gravity(-Vector::z())
        .contact_time(contact_time)
        .species(SpeciesDraft::new("grain").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("grain", "grain").restitution(RESTITUTION));
    for position in positions() {
        builder = builder.particle("grain", position, Vector::zeros());
    }
    Ok(builder.build()?)
}

fn carom(contact_time: f64) -> Outcome<[f64; 4]> {
    let scene = scene(contact_time)?;
    let (cost, simulation) = timed(|| {
        let mut simulation = Simulation::without_plan(scene.clone());
        simulation.advance(Until::time(TIME)).map(|_| simulation)
    });
    let simulation = simulation?;
    let kinetic = simulation.energy().kinetic / GRAINS as f64;
    Ok([cost / AMOUNT, error(&simulation.snapshot().positions), kinetic, simulation.event_counts().deepest_overlap])
}

fn baseline(stiffness: f64, steps_per_contact: f64) -> [f64; 4] {
    let start = Start {
        periods: Vector::repeat(f64::INFINITY),
        gravity: 1.0,
        has_floor: true,
        positions: positions(),
        velocities: vec![Vector::zeros(); GRAINS],
    };
    let (cost, grains) = timed(|| {
        let mut grains = SpringDashpot::new(start.clone(), stiffness, RESTITUTION, steps_per_contact);
        grains.advance(TIME);
        grains
    });
    [cost / AMOUNT, error(grains.positions()), grains.kinetic() / GRAINS as f64, grains.deepest]
}
