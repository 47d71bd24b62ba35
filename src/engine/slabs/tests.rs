//! Compares several threads with a single engine. States, predictions, lists and counts must agree bit for bit.

use super::*;
use crate::Vector;
use crate::engine::domains::tests::{all_of, listed};
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{ContactLaw, Scene};
use crate::scene::{Arrangement, Fill, InteractionDraft, SceneBuilder, SpeciesDraft};

fn compare<const FALLING: bool, const TABLE: bool>(scene: &Scene, name: &str, until: &[Until], narrowest: f64) {
    let mut one = Engine::<FALLING, TABLE>::new(scene);
    let mut others =
        [2, 3].map(|threads| (Engine::<FALLING, TABLE>::new(scene), Slabs { narrowest, ..Slabs::new(threads) }));
    for (step, until) in until.iter().enumerate() {
        let reason = one.advance(*until, &mut None).unwrap();
        for (engine, slabs) in &mut others {
            let name = format!("{name}, {} threads, step {step}", slabs.threads);
            let there = loop {
                let advanced = slabs.advance_for(engine, 10_000, *until, &mut None).expect("slabs");
                if let Some(reason) = advanced.unwrap() {
                    break reason;
                }
            };
            // Some comparisons continue with the slabs, and some cut the system anew.
            let mut copy = (engine.clone(), slabs.clone());
            copy.1.join(&mut copy.0);
            if step % 2 == 0 {
                slabs.join(engine);
            }
            let engine = &copy.0;
            assert_eq!((there, engine.time().to_bits()), (reason, one.time().to_bits()), "{name}");
            assert_eq!(engine.snapshot(), one.snapshot(), "{name}: {:?}", slabs.work);
            assert_eq!(engine.counts.totals, one.counts.totals, "{name}");
            assert_eq!(engine.counts.by_species, one.counts.by_species, "{name}");
            assert_eq!(engine.counts.transitions_at_event, one.counts.transitions_at_event, "{name}");
            let standstill =
                |engine: &Engine<FALLING, TABLE>| (engine.clock.standstill.since, engine.clock.standstill.events);
            assert_eq!(standstill(engine), standstill(&one), "{name}");
            for (here, there) in one.by_id().zip(engine.by_id()) {
                assert_eq!(all_of(&one, here), all_of(engine, there), "{name}");
                assert_eq!(listed(&one, here), listed(engine, there), "{name}");
            }
        }
    }
    for (_, slabs) in &others {
        let [own, of_strips, _] = slabs.work.steps;
        assert!(slabs.work.windows > 20 && own > 100 && of_strips > 100, "{name}: {:?}", slabs.work);
    }
}

/// A long box of a mixture with odd masses.
fn mixture(count: u64, boundary: [Boundary; 3], range: Option<f64>) -> SceneBuilder {
    let potential = |diameter: f64| match range {
        Some(range) => Potential::square_well(diameter, range, 0.7).unwrap(),
        None => Potential::hard_sphere(diameter).unwrap(),
    };
    SceneBuilder::new("mixture")
        .space(Space { size: Vector::new(60.0, 8.0, 7.0), boundary, ..Space::periodic_cube(1.0) })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(1.9).diameter(1.3))
        .interaction(InteractionDraft::new(potential(1.0)).between("A", "A"))
        .interaction(InteractionDraft::new(potential(1.15)).between("A", "B"))
        .interaction(InteractionDraft::new(potential(1.3)).between("B", "B"))
        .fill(Fill::new(Arrangement::Random, "A").count(count))
        .fill(Fill::new(Arrangement::Random, "B").count(count / 2))
        .temperature(1.3)
}

const PERIODIC: [Boundary; 3] = [Boundary::Periodic; 3];

fn times(times: &[f64]) -> Vec<Until> {
    times.iter().map(|time| Until::time(*time)).collect()
}

#[test]
fn threads_match_one_engine_bitwise() {
    let hard = |count: u64| {
        let size = Vector::new(80.0, 7.0, 6.0);
        SceneBuilder::new("spheres")
            .space(Space { size, ..Space::periodic_cube(1.0) })
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
            .interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between("A", "A"))
            .fill(Fill::new(Arrangement::Random, "A").count(count))
            .temperature(1.3)
            .build()
            .unwrap()
    };
    let steps = times(&[0.1, 0.5, 0.5, 1.2]);
    compare::<false, false>(&hard(2_184), "lists", &steps, 2.0);
    compare::<false, false>(&hard(672), "cells", &times(&[0.5, 2.0, 5.0]), 2.0);
    compare::<false, true>(&mixture(900, PERIODIC, None).build().unwrap(), "mixture", &steps, 2.0);
    compare::<false, true>(&mixture(700, PERIODIC, Some(1.4)).build().unwrap(), "wells", &steps, 1.5);
}

#[test]
fn threads_match_one_engine_bitwise_with_walls_gravity_and_friction() {
    let walls = [Boundary::walls(0.9), Boundary::walls(0.8), Boundary::walls(0.95)];
    let steps = times(&[0.1, 0.5, 1.2]);
    let gravity = Vector::new(0.05, 0.1, -0.4);
    let falling = mixture(700, walls, None).gravity(gravity).build().unwrap();
    compare::<true, true>(&falling, "falling", &steps, 2.0);
    let mut dissipative = mixture(700, walls, None).contact_time(0.05);
    dissipative.interactions.iter_mut().for_each(|interaction| interaction.law = ContactLaw::smooth(0.8));
    let thermal = dissipative.wall_temperatures(0, [Some(2.0), None]).wall_temperatures(2, [Some(0.5), Some(3.0)]);
    compare::<false, true>(&thermal.build().unwrap(), "thermal walls", &steps, 2.0);
    let mut rough = mixture(900, PERIODIC, None);
    for interaction in &mut rough.interactions {
        *interaction = interaction.clone().tangential_restitution(0.4).friction(0.3);
    }
    compare::<false, true>(&rough.build().unwrap(), "rough", &steps, 2.0);
    let flat = [Boundary::walls(1.0), Boundary::Periodic, Boundary::Flat];
    let disks = SceneBuilder::new("disks")
        .space(Space { boundary: flat, size: Vector::new(90.0, 12.0, 0.0), ..Space::periodic_cube(1.0) })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between("A", "A").restitution(0.95))
        .fill(Fill::new(Arrangement::Random, "A").count(500))
        .temperature(1.3);
    compare::<false, false>(&disks.build().unwrap(), "disks", &times(&[1.0, 6.0]), 2.0);
}

#[test]
fn runs_on_threads_end_at_a_number_of_events_and_when_nothing_happens_any_more() {
    let scene = mixture(700, PERIODIC, None).build().unwrap();
    let ends: Vec<Until> = [1, 5_000, 5_001, 12_345].map(Until::events).to_vec();
    compare::<false, true>(&scene, "events", &ends, 2.0);
}

#[test]
fn systems_with_static_particles_or_a_short_box_are_not_cut() {
    let wall = SpeciesDraft::new("W").diameter(1.0).fixed();
    let boxed = |builder: SceneBuilder| builder.build().unwrap();
    let with_static = boxed(
        mixture(100, PERIODIC, None)
            .species(wall)
            .interaction(InteractionDraft::new(Potential::hard_sphere(1.0).unwrap()).between("A", "W"))
            .interaction(InteractionDraft::new(Potential::hard_sphere(1.1).unwrap()).between("B", "W"))
            .particle("W", Vector::new(1.0, 1.0, 1.0), Vector::zeros()),
    );
    for (scene, narrowest) in [(with_static, 2.0), (boxed(mixture(100, PERIODIC, None)), 50.0)] {
        let mut engine = Engine::<false, true>::new(&scene);
        let mut slabs = Slabs { narrowest, ..Slabs::new(2) };
        assert!(slabs.advance_for(&mut engine, 10, Until::time(0.1), &mut None).is_none());
        assert_eq!(slabs.work.windows, 0);
    }
}
