//! A gas that cools by inelastic contacts, compared with Haff's law.

use super::spring_dashpot::{SpringDashpot, Start};
use super::{COST, Method, sheet};
use crate::Outcome;
use crate::clock::Stopwatch;
use crate::sheet::number;
use carom::engine::{Simulation, Until};
use carom::model::space::Space;
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use std::f64::consts::PI;

pub const SHEET: &str = "granular_cooling";

pub const EXPLANATION: &str = "### A cooling gas

1,372 grains at a packing fraction of 0.10 and a restitution of 0.9 start from the equilibrium of elastic spheres at T = 1 (six seeds).
Haff's law gives `T = 1 / (1 + (1 - e^2)(1 + 3 a2 / 16) omega t / 6)^2` at t = 10, with Enskog's collision rate `omega` and the deviation
`a2` from Maxwell's velocity distribution (van Noije and Ernst, Granular Matter 1, 57, 1998). *Error* is the relative error of the mean over
the seeds, with its standard error. *Ledger* is the relative error of the energy balance: the initial energy minus the final energy and
minus the energy lost in contacts.";

const GRAINS: u64 = 1_372;
const PACKING_FRACTION: f64 = 0.10;
const RESTITUTION: f64 = 0.9;
const TIME: f64 = 10.0;
const SEEDS: [u64; 6] = [1, 2, 3, 4, 5, 6];

/// Stiffness of the springs, and number of time steps per contact.
const BASELINES: [(f64, f64); 7] =
    [(1e3, 20.0), (1e4, 5.0), (1e4, 10.0), (1e4, 20.0), (1e4, 50.0), (1e5, 20.0), (1e6, 20.0)];

/// Processor time per particle and unit time, final energy divided by initial energy, relative error of the energy
/// balance, and deepest overlap.
type Run = [f64; 4];

pub fn measure() -> Outcome {
    let mut sheet = sheet(SHEET, &[COST, "energy left", "error", "+-", "ledger", "deepest overlap"]);
    let starts = SEEDS.iter().map(|&seed| start(seed)).collect::<Outcome<Vec<_>>>()?;
    let mut push = |method: Method, runs: Vec<Run>| {
        let mean = |k: usize| runs.iter().map(|run| run[k]).sum::<f64>() / runs.len() as f64;
        let most = |k: usize| runs.iter().map(|run| run[k].abs()).fold(0.0, f64::max);
        let variance = runs.iter().map(|run| (run[1] - mean(1)).powi(2)).sum::<f64>() / (runs.len() - 1) as f64;
        let spread = (variance / runs.len() as f64).sqrt();
        let error = mean(1) / haff() - 1.0;
        let mut row = method.cells().to_vec();
        row.extend([mean(0), mean(1), error, spread / haff(), most(2), most(3)].map(number));
        sheet.push(row)
    };
    let runs = starts.iter().map(carom).collect::<Outcome<Vec<_>>>()?;
    push(Method::Carom { contact_time: 0.0 }, runs)?;
    for (stiffness, steps_per_contact) in BASELINES {
        let runs = starts.iter().map(|start| baseline(start, stiffness, steps_per_contact)).collect();
        push(Method::SpringDashpot { stiffness, steps_per_contact }, runs)?;
    }
    Ok(())
}

/// Final energy divided by initial energy, by Haff's law.
fn haff() -> f64 {
    let (e, phi) = (RESTITUTION, PACKING_FRACTION);
    let a2 = 16.0 * (1.0 - e) * (1.0 - 2.0 * e * e) / (81.0 - 17.0 * e + 30.0 * e * e * (1.0 - e));
    let at_contact = (1.0 - 0.5 * phi) / (1.0 - phi).powi(3);
    let rate = 4.0 * PI.sqrt() * (6.0 * phi / PI) * at_contact;
    (1.0 + (1.0 - e * e) * (1.0 + 3.0 * a2 / 16.0) * rate * TIME / 6.0).powi(-2)
}

/// Elastic spheres after 20 contacts each.
fn start(seed: u64) -> Outcome<Start> {
    let scene = SceneBuilder::new("elastic")
        .seed(seed)
        .species(SpeciesDraft::new("grain").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("grain", "grain"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "grain").count(GRAINS).packing_fraction(PACKING_FRACTION))
        .temperature(1.0)
        .build()?;
    let mut simulation = Simulation::without_plan(scene);
    simulation.advance(Until::events(10 * GRAINS))?;
    let snapshot = simulation.snapshot();
    Ok(Start {
        periods: simulation.scene().space().size,
        gravity: 0.0,
        has_floor: false,
        positions: snapshot.positions,
        velocities: snapshot.velocities,
    })
}

fn cost(stopwatch: &Stopwatch) -> f64 {
    stopwatch.seconds() * 1e6 / (GRAINS as f64 * TIME)
}

fn carom(start: &Start) -> Outcome<Run> {
    let mut builder = SceneBuilder::new("gas")
        .space(Space::periodic_cube(start.periods.x))
        .species(SpeciesDraft::new("grain").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("grain", "grain").restitution(RESTITUTION))
        // Spheres in contact may overlap by round-off.
        .allow_invalid_start(true);
    for (position, velocity) in start.positions.iter().zip(&start.velocities) {
        builder = builder.particle("grain", *position, *velocity);
    }
    let mut simulation = Simulation::without_plan(builder.build()?);
    let before = simulation.energy().kinetic;
    let stopwatch = Stopwatch::start();
    simulation.advance(Until::time(TIME))?;
    let cost = cost(&stopwatch);
    let (after, event_counts) = (simulation.energy().kinetic, simulation.event_counts());
    Ok([cost, after / before, (after + event_counts.dissipated.total()) / before - 1.0, event_counts.deepest_overlap])
}

fn baseline(start: &Start, stiffness: f64, steps_per_contact: f64) -> Run {
    let mut grains = SpringDashpot::new(start.clone(), stiffness, RESTITUTION, steps_per_contact);
    let before = grains.kinetic();
    let stopwatch = Stopwatch::start();
    grains.advance(TIME);
    let cost = cost(&stopwatch);
    let ledger = (grains.energy() + grains.dissipated) / before - 1.0;
    [cost, grains.kinetic() / before, ledger, grains.deepest]
}
