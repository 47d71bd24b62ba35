//! Particles enter and leave both engines at random times between events.

use crate::{EVENTS, Recipe, SLOWEST, TOLERANCE, kind, pair, recipe};
use carom::Vector;
use carom::check::reference::{self, Reference};
use carom::engine::event::Event;
use carom::engine::{Simulation, Until};
use carom::model::{Particle, ParticleId, Scene, SpeciesId};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;

/// A change of the population, at a time `after` the previous change.
#[derive(Debug, Clone)]
pub struct Change {
    after: f64,
    leaving: Vec<prop::sample::Index>,
    entering: Vec<(u32, [f64; 3], [f64; 3])>,
    is_saved: bool,
    domains: usize,
}

pub fn change() -> impl Strategy<Value = Change> {
    (
        0.02..0.4_f64,
        prop::collection::vec(any::<prop::sample::Index>(), 0..3),
        prop::collection::vec(
            (0..3_u32, prop::array::uniform3(0.0..1.0_f64), prop::array::uniform3(-1.5..1.5_f64)),
            0..4,
        ),
        prop::bool::weighted(0.3),
        prop::sample::select(vec![0, 0, 0, 1, 2]),
    )
        .prop_map(|(after, leaving, entering, is_saved, domains)| Change {
            after,
            leaving,
            entering,
            is_saved,
            domains,
        })
}

#[derive(Debug, Clone, Copy, Default)]
pub struct Tally {
    sequences: usize,
    pub events: usize,
    pub entered: usize,
    left: usize,
    refused: usize,
}

/// Returns the number of equal events, or `None` if rounding errors end the comparison.
pub fn same_events(ours: &[Event], theirs: &[reference::Event], until: f64) -> Result<Option<usize>, TestCaseError> {
    for (k, expected) in theirs.iter().enumerate() {
        let next = theirs.get(k + 1).map_or(until, |next| next.time);
        let speed = (expected.before[0] - expected.before[1]).dot(&expected.normal).abs();
        if speed < SLOWEST || next - expected.time < TOLERANCE {
            return Ok(None);
        }
        let Some(found) = ours.get(k) else { return Err(TestCaseError::fail(format!("missing: {expected:?}"))) };
        let between = (expected.particle.0, expected.partner.map(|partner| partner.0));
        prop_assert_eq!((kind(found), pair(found)), (Some(expected.kind), between), "{:?} {:?}", found, expected);
        prop_assert!((found.time - expected.time).abs() < TOLERANCE, "{found:?} {expected:?}");
    }
    prop_assert_eq!(ours.len(), theirs.len(), "{:?}", ours.last());
    Ok(Some(ours.len()))
}

fn total(simulation: &Simulation) -> f64 {
    let (energy, counts) = (simulation.energy(), simulation.event_counts());
    energy.total() + counts.dissipated.total() - counts.supplied.total()
}

fn check_energy(simulation: &Simulation, at_start: f64) -> Result<(), TestCaseError> {
    let energy = simulation.energy();
    let scale = 1.0 + energy.kinetic + energy.rotational + at_start.abs();
    let change = (total(simulation) - at_start).abs();
    prop_assert!(change < 1e-9 * scale, "energy {change} of {scale}");
    Ok(())
}

fn run(recipe: &Recipe, changes: &[Change], tally: &Cell<Tally>) -> Result<(), TestCaseError> {
    let Some(scene) = recipe.scene() else { return Err(TestCaseError::reject("no such scene")) };
    run_scene(&scene, recipe.roughness.is_some(), changes, tally)
}

/// Compares the engines between changes of the population. New particles of the species 0 and 1 move, and particles of
/// the species 2 are static.
pub fn run_scene(scene: &Scene, has_spins: bool, changes: &[Change], tally: &Cell<Tally>) -> Result<(), TestCaseError> {
    let mut simulation = Simulation::without_plan(scene.clone());
    let mut reference = Reference::new(scene).map_err(|error| TestCaseError::fail(error.to_string()))?;
    let (at_start, size) = (total(&simulation), scene.space().size);
    // Rounding errors grow with the number of collisions of each particle.
    let most = EVENTS.max(scene.particles().len() / 2);
    let (mut seen, mut count) = (0, tally.get());
    count.sequences += 1;
    for change in changes {
        let until = simulation.time() + change.after;
        let mut ours = Vec::new();
        if simulation.advance_with(Until::time(until), |event| ours.push(*event)).is_err() {
            break;
        }
        let theirs: Vec<_> = std::iter::from_fn(|| reference.step_before(until)).take(100 * EVENTS).collect();
        let Some(events) = same_events(&ours, &theirs, until)? else { break };
        (seen, count.events) = (seen + events, count.events + events);
        if seen > most {
            break;
        }
        if change.is_saved {
            let bytes = postcard::to_stdvec(&simulation).expect("a simulation that can be saved");
            simulation = postcard::from_bytes(&bytes).expect("the same simulation");
        }
        if change.domains > 0 {
            simulation.set_domains(change.domains, 1);
        }
        let ids = simulation.snapshot().ids;
        let mut leaving: Vec<ParticleId> =
            change.leaving.iter().filter(|_| !ids.is_empty()).map(|index| *index.get(&ids)).collect();
        leaving.sort_unstable();
        leaving.dedup();
        simulation.remove(&leaving).map_err(|error| TestCaseError::fail(error.to_string()))?;
        leaving.iter().for_each(|particle| reference.remove(*particle));
        count.left += leaving.len();
        for (species, place, velocity) in &change.entering {
            let is_static = *species == 2;
            let place = Vector::from_fn(|axis, _| (0.1 + 0.8 * place[axis]) * size[axis]);
            let velocity = if is_static { Vector::zeros() } else { Vector::from(*velocity) };
            let spins = has_spins && !is_static;
            let spin = if spins { place.cross(&velocity) / size[0] } else { Vector::zeros() };
            let new = Particle::new(SpeciesId(*species), place, velocity).spin(spin);
            match simulation.insert(&[new]) {
                Ok(ids) => {
                    prop_assert_eq!(&ids, &[reference.insert(new)]);
                    count.entered += 1;
                }
                Err(_) => count.refused += 1,
            }
        }
        check_energy(&simulation, at_start)?;
        let snapshot = simulation.snapshot();
        for (id, velocity) in snapshot.ids.iter().zip(&snapshot.velocities) {
            let expected = reference.velocities()[id.0 as usize];
            prop_assert!((velocity - expected).amax() < 1e2 * TOLERANCE, "{id:?}");
            let spin = snapshot.index(*id).and_then(|index| snapshot.spins.get(index).copied()).unwrap_or_default();
            prop_assert!((spin - reference.spins()[id.0 as usize]).amax() < 1e2 * TOLERANCE, "{id:?}");
        }
    }
    tally.set(count);
    Ok(())
}

/// `CAROM_POPULATIONS` sets the number of sequences.
#[test]
fn both_engines_agree_while_particles_enter_and_leave() {
    let cases = std::env::var("CAROM_POPULATIONS").map_or(400, |cases| cases.parse().expect("a number of sequences"));
    let config = ProptestConfig { cases, max_global_rejects: cases.max(1_000), ..ProptestConfig::default() };
    let mut runner = TestRunner::new(config);
    let tally = Cell::new(Tally::default());
    let strategy = (recipe(), prop::collection::vec(change(), 2..10));
    let result = runner.run(&strategy, |(recipe, changes)| run(&recipe, &changes, &tally));
    result.unwrap_or_else(|failure| panic!("{failure}"));
    let tally = tally.get();
    println!("{tally:?}");
    let sequences = tally.sequences;
    assert!(tally.events > 10 * sequences && tally.entered > sequences && tally.left > sequences, "{tally:?}");
}

#[test]
fn population_errors_name_the_particle_and_change_nothing() {
    let recipe = Recipe { seed: 3, count: 12, boundary: [1, 1, 1], statics: 1, ..crate::PLAIN };
    let mut simulation = Simulation::without_plan(recipe.scene().expect("a valid scene"));
    simulation.advance(Until::time(0.3)).expect("no arrest");
    let before = simulation.snapshot();
    let place = before.positions[5];
    let new = |species, position, velocity| Particle::new(SpeciesId(species), position, velocity);
    let (rest, middle) = (Vector::zeros(), Vector::repeat(4.0));
    for (particle, message) in [
        (new(7, middle, rest), "particle 13 has species number 7, expected a species of the scene"),
        (new(0, Vector::repeat(f64::NAN), rest), "a component of particle 13 is not a number from -1e50 to 1e50"),
        (new(2, middle, Vector::x()), "particle 13 cannot move along axis 0"),
    ] {
        assert_eq!(simulation.insert(&[particle]).expect_err(message).to_string(), message);
    }
    let overlap = simulation.insert(&[new(1, place, rest)]).expect_err("an overlap").to_string();
    assert!(overlap.starts_with("particle 13 overlaps with particle 5"), "{overlap}");
    let in_wall = simulation.insert(&[new(0, Vector::new(0.2, 4.0, 4.0), rest)]).expect_err("in a wall").to_string();
    assert!(in_wall.starts_with("particle 13 overlaps with a wall"), "{in_wall}");
    let twice = simulation.remove(&[ParticleId(4), ParticleId(4)]).expect_err("twice").to_string();
    assert_eq!(twice, "no particle 4 to remove, expected each id of a present particle once");
    assert!(simulation.remove(&[ParticleId(99)]).is_err());
    assert_eq!(simulation.snapshot(), before);
}
