//! Removes and inserts particles, and compares the engine with a new engine for the same particles.

use super::*;
use crate::engine::Until;
use crate::engine::columns::tests::{mixture, spheres};
use crate::engine::event::Event;
use crate::model::potential::Potential;
use crate::model::random::{Purpose, Random};
use crate::model::scene::Particle;
use crate::model::space::{Boundary, Space, minimum_image};
use crate::model::{ParticleId, Scene};
use crate::scene::{Arrangement, Fill, InteractionDraft, SceneBuilder, SpeciesDraft};
use std::convert::Infallible;
use std::ops::ControlFlow;

fn go_on<const FALLING: bool, const TABLE: bool>(
    engine: &mut Engine<FALLING, TABLE>,
    events: u64,
) -> (Vec<Event>, Vec<(ParticleId, Vector, Vector)>) {
    let mut seen = Vec::new();
    let mut see = |event: &Event| {
        seen.push(*event);
        ControlFlow::Continue(())
    };
    let until = Until::events(engine.counts.executed + events);
    engine.advance(until, &mut Some(&mut see)).unwrap();
    let mut now = Vec::new();
    let Ok(()) = engine.for_each_now(|particle| {
        now.push((particle.id, particle.position, particle.velocity));
        Ok::<(), Infallible>(())
    });
    (seen, now)
}

fn pair(event: &Event, name: impl Fn(ParticleId) -> ParticleId) -> (ParticleId, ParticleId) {
    let (one, other) = (name(event.particle), event.partner().map_or(name(event.particle), name));
    (one.min(other), one.max(other))
}

/// Compares only a few events, because rounding errors grow with each event.
fn goes_on_as_a_new_one<const FALLING: bool, const TABLE: bool>(
    mut engine: Engine<FALLING, TABLE>,
    scene: &Scene,
    name: &str,
) {
    let (mut ids, mut start) = (Vec::new(), scene.clone());
    start.particles.clear();
    let Ok(()) = engine.for_each_now(|now| {
        ids.push(now.id);
        start.particles.push(Particle::new(now.species, now.position, now.velocity));
        Ok::<(), Infallible>(())
    });
    assert!(ids.is_sorted() && ids.len() == engine.particles().len(), "{name}");
    let since = engine.time();
    let mut new = Engine::<FALLING, TABLE>::new(&start);
    let events = ids.len() as u64 / 2;
    let (seen, now) = go_on(&mut engine, events);
    let (expected, expected_now) = go_on(&mut new, events);
    assert!(seen.len() > 30, "{name}: {}", seen.len());
    for (event, expected) in seen.iter().zip(&expected) {
        assert_eq!(pair(event, |id| id), pair(expected, |id| ids[id.0 as usize]), "{name} {}", event.time);
        assert!((event.time - since - expected.time).abs() < 1e-8, "{name}: {} {}", event.time - since, expected.time);
    }
    for ((id, position, velocity), (rank, there, moving)) in now.iter().zip(&expected_now) {
        assert_eq!(*id, ids[rank.0 as usize]);
        let apart = minimum_image(position - there, &engine.state.periods);
        assert!(apart.amax() < 1e-7 && (velocity - moving).amax() < 1e-7, "{name}: {id:?} {apart:?}");
    }
}

/// Returns a random position that is farther than `distance` from all centres.
fn hole<const FALLING: bool, const TABLE: bool>(
    engine: &Engine<FALLING, TABLE>,
    random: &mut Random,
    distance: f64,
) -> Option<Vector> {
    let space = &engine.state.space;
    (0..5_000).find_map(|_| {
        let part = Vector::from_fn(|_, _| random.below(1 << 20) as f64 / f64::from(1 << 20));
        let place = space.lower + part.component_mul(&space.size);
        let is_free = engine.particles().all(|other| {
            let (there, _) = engine.state_at(other, engine.clock.now);
            minimum_image(place - there, &engine.state.periods).norm() > distance
        });
        is_free.then_some(place)
    })
}

fn captured_at<const FALLING: bool, const TABLE: bool>(
    engine: &Engine<FALLING, TABLE>,
    row: u16,
    place: &Vector,
) -> Vec<PairState> {
    let pair = |other: u32| {
        let (there, _) = engine.state_at(other, engine.clock.now);
        let meeting = engine.pairs.rules.meeting(row, engine.row(other));
        let is_captured = minimum_image(place - there, &engine.state.periods).norm_squared() < meeting.squared;
        let partner = engine.id(other).0;
        (meeting.exists && is_captured).then_some(PairState { partner, state: 1, interaction: meeting.interaction })
    };
    engine.particles().filter_map(pair).collect()
}

/// Removes a third of the particles, then inserts particles without overlap.
fn check<const FALLING: bool, const TABLE: bool>(scene: &Scene, name: &str, diameter: f64) {
    let mut random = Random::new(5, Purpose::Velocities, 0);
    let mut engine = Engine::<FALLING, TABLE>::new(scene);
    engine.advance(Until::events(2_000), &mut None).unwrap();
    let count = engine.particles().end;
    let leaving: Vec<u32> = engine.particles().filter(|_| random.below(3) == 0).collect();
    let ids: Vec<u32> = leaving.iter().map(|&particle| engine.id(particle).0).collect();
    engine.remove(&leaving);
    for id in 0..count {
        let number = engine.state.number(id);
        assert_eq!(number.is_none(), ids.contains(&id), "{name}");
        assert!(number.is_none_or(|number| engine.id(number) == ParticleId(id)), "{name}");
    }
    goes_on_as_a_new_one(engine.clone(), scene, name);

    let _ = go_on(&mut engine, 20);
    let mut coming = 0;
    for id in count..count + 30 {
        let Some(place) = hole(&engine, &mut random, diameter) else { break };
        let velocity = random.normal_vector(&engine.state.space);
        let mut record = Record::new(id, place, velocity, engine.clock.now);
        if TABLE {
            let row = u16::try_from(random.below(engine.pairs.rules.species.len())).unwrap();
            record.row = Some(row);
            record.captured = Some(captured_at(&engine, row, &place));
            if engine.pairs.rules.species[usize::from(row)].is_static() {
                record.body.velocity = Vector::zeros();
            }
        }
        engine.insert(&[record]);
        coming += 1;
    }
    assert!(coming > 5, "{name}: {coming}");
    goes_on_as_a_new_one(engine, scene, name);
}

#[test]
fn simulation_stays_consistent_as_particles_leave_and_enter() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    check::<false, false>(&spheres(hard(), 0.1, 256).build().unwrap(), "cells", 1.0);
    check::<false, false>(&spheres(hard(), 0.42, 500).build().unwrap(), "lists", 1.0);
    check::<false, true>(&mixture().build().unwrap(), "mixture", 1.4);
    let walls = Space { boundary: [Boundary::walls(0.9); 3], ..Space::periodic_cube(12.0) };
    let among_static = SceneBuilder::new("static")
        .space(walls)
        .species(SpeciesDraft::new("S").diameter(1.0).fixed())
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard()).between("A", "S"))
        .interaction(InteractionDraft::new(hard()).between("A", "A").restitution(0.9))
        .fill(Fill::new(Arrangement::Random, "S").count(100))
        .fill(Fill::new(Arrangement::Random, "A").count(200))
        .temperature(1.3);
    check::<false, true>(&among_static.build().unwrap(), "static", 1.0);
}
