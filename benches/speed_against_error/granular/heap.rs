//! Grains that fall on a floor and form a heap.

use super::spring_dashpot::{SpringDashpot, Start};
use super::{COST, Method, UNREST, sheet};
use crate::Outcome;
use crate::clock::Stopwatch;
use crate::sheet::number;
use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::ContactLaw;
use carom::model::space::{Boundary, Face, Space};
use carom::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

pub const SHEET: &str = "granular_heap";

pub const EXPLANATION: &str = "### A heap

216 grains, placed at random, fall on a floor of 6 x 6 diameters with periodic sides, at gravity 1 with a restitution of 0.5 (three seeds).
*Height* is the height of the centre of mass at t = 30. *Difference* is the difference between this height and the height with the stiffest
springs, with the standard error of three heaps. The exact height is not known. The deepest overlap is the deepest in the whole run.";

const GRAINS: u64 = 216;
const BASE: f64 = 6.0;
const TIME: f64 = 30.0;
const RESTITUTION: f64 = 0.5;
const SEEDS: [u64; 3] = [1, 2, 3];

/// Stiffness of the springs and number of time steps per contact. The first values are for the reference.
const BASELINES: [(f64, f64); 5] = [(1e6, 20.0), (1e5, 20.0), (1e4, 50.0), (1e4, 10.0), (1e3, 20.0)];

const CONTACT_TIMES: [f64; 3] = [0.03, 0.01, 0.005];

/// Processor time per particle and unit time, height, kinetic energy per particle, and deepest overlap.
type Run = [f64; 4];

pub fn measure() -> Outcome {
    let columns = [COST, "height", "difference", "+-", UNREST, "deepest overlap"];
    let mut sheet = sheet(SHEET, &columns);
    let mut reference = None;
    let mut push = |method: Method, runs: Vec<Run>| {
        let mean = |k: usize| runs.iter().map(|run| run[k]).sum::<f64>() / runs.len() as f64;
        let variance = runs.iter().map(|run| (run[1] - mean(1)).powi(2)).sum::<f64>() / (runs.len() - 1) as f64;
        let spread = (variance / runs.len() as f64).sqrt();
        let most = runs.iter().map(|run| run[3]).fold(0.0, f64::max);
        let difference = mean(1) - *reference.get_or_insert(mean(1));
        let mut row = method.cells().to_vec();
        row.extend([mean(0), mean(1), difference, spread, mean(2), most].map(number));
        sheet.push(row)
    };
    for (stiffness, steps_per_contact) in BASELINES {
        let runs = SEEDS.iter().map(|&seed| baseline(seed, stiffness, steps_per_contact)).collect::<Outcome<_>>()?;
        push(Method::SpringDashpot { stiffness, steps_per_contact }, runs)?;
    }
    for contact_time in CONTACT_TIMES {
        let runs = SEEDS.iter().map(|&seed| carom(seed, contact_time)).collect::<Outcome<_>>()?;
        push(Method::Carom { contact_time }, runs)?;
    }
    Ok(())
}

fn simulation(seed: u64, contact_time: f64) -> Outcome<Simulation> {
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(RESTITUTION)), upper: Face::Open };
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(BASE, BASE, 24.0),
        boundary: [Boundary::Periodic, Boundary::Periodic, floor],
    };
    let region = (Vector::new(0.0, 0.0, 0.6), Vector::new(BASE, BASE, 14.0));
    let scene = SceneBuilder::new("heap")
        .seed(seed)
        .space(space)
        .gravity(-Vector::z())
        .contact_time(contact_time)
        .species(SpeciesDraft::new("grain").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("grain", "grain").restitution(RESTITUTION))
        .fill(Fill::new(Arrangement::Random, "grain").count(GRAINS).region(region.0, region.1))
        .temperature(0.1)
        .build()?;
    Ok(Simulation::without_plan(scene))
}

fn height(positions: &[Vector]) -> f64 {
    positions.iter().map(|position| position.z).sum::<f64>() / GRAINS as f64
}

fn cost(stopwatch: &Stopwatch) -> f64 {
    stopwatch.seconds() * 1e6 / (GRAINS as f64 * TIME)
}

fn carom(seed: u64, contact_time: f64) -> Outcome<Run> {
    let mut simulation = simulation(seed, contact_time)?;
    let stopwatch = Stopwatch::start();
    simulation.advance(Until::time(TIME))?;
    let cost = cost(&stopwatch);
    let kinetic = simulation.energy().kinetic / GRAINS as f64;
    Ok([cost, height(&simulation.snapshot().positions), kinetic, simulation.event_counts().deepest_overlap])
}

fn baseline(seed: u64, stiffness: f64, steps_per_contact: f64) -> Outcome<Run> {
    let snapshot = simulation(seed, CONTACT_TIMES[0])?.snapshot();
    let start = Start {
        periods: Vector::new(BASE, BASE, f64::INFINITY),
        gravity: 1.0,
        has_floor: true,
        positions: snapshot.positions,
        velocities: snapshot.velocities,
    };
    let mut grains = SpringDashpot::new(start, stiffness, RESTITUTION, steps_per_contact);
    let stopwatch = Stopwatch::start();
    grains.advance(TIME);
    let kinetic = grains.kinetic() / GRAINS as f64;
    Ok([cost(&stopwatch), height(grains.positions()), kinetic, grains.deepest])
}
