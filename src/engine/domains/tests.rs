//! Domains beside one engine: the same events, states and counts to the bit.

use super::*;
use crate::Vector;
use crate::engine::Snapshot;
use crate::engine::columns::tests::{mixture, spheres};
use crate::engine::event::Event;
use crate::model::Scene;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::scene::{Arrangement, Fill, SceneBuilder};
use std::ops::ControlFlow;

fn advance<const FALLING: bool, const TABLE: bool>(
    scene: &Scene,
    until: Until,
    domains: Option<&mut Domains<FALLING, TABLE>>,
) -> (Vec<Event>, Snapshot, Engine<FALLING, TABLE>) {
    let mut engine = Engine::<FALLING, TABLE>::new(scene);
    let mut events = Vec::new();
    let mut see = |event: &Event| {
        events.push(*event);
        ControlFlow::Continue(())
    };
    match domains {
        None => {
            engine.advance(until, &mut Some(&mut see)).unwrap();
        }
        Some(domains) => {
            while domains.advance_for(&mut engine, 10_000, until, &mut Some(&mut see)).unwrap().is_none() {}
            domains.join(&mut engine);
        }
    }
    (events, engine.snapshot(), engine)
}

/// Compares runs in numbers of domains, with a halo, with that of one engine; what was done in all of them.
fn compare<const FALLING: bool, const TABLE: bool>(
    scene: &Scene,
    name: &str,
    until: Until,
    (counts, halo): (&[usize], Halo),
) -> DomainWork {
    let (events, snapshot, engine) = advance::<FALLING, TABLE>(scene, until, None);
    let mut work = DomainWork::default();
    for &count in counts {
        let mut domains = Domains::<FALLING, TABLE>::with_halo(count, 2, halo);
        let (seen, there, other) = advance(scene, until, Some(&mut domains));
        let first = events.iter().zip(&seen).position(|(one, other)| one != other);
        assert_eq!(first, None, "{name} {count}: {:?}", domains.work);
        assert_eq!(events.len(), seen.len(), "{name} {count}");
        assert_eq!(there, snapshot, "{name} {count}");
        assert_eq!(other.counts.totals, engine.counts.totals, "{name} {count}");
        assert_eq!(other.counts.by_species, engine.counts.by_species, "{name} {count}");
        assert_eq!(other.counts.transitions_at_event, engine.counts.transitions_at_event, "{name} {count}");
        let standstill =
            |engine: &Engine<FALLING, TABLE>| (engine.clock.standstill.since, engine.clock.standstill.events);
        assert_eq!(standstill(&other), standstill(&engine), "{name} {count}");
        assert!(domains.work.windows > 20, "{name} {count}: {:?}", domains.work);
        work.differences += domains.work.differences;
        work.uncovered += domains.work.uncovered;
    }
    work
}

/// As wide as it is chosen.
const WIDE: Halo = HALO;
/// So thin that errors reach what is owned within a window.
const THIN: Halo = Halo { slack: 0.0, margin: 0.0 };

#[test]
fn domains_have_the_bits_of_one_engine() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let (thin, dense) = (spheres(hard(), 0.1, 4_000).build().unwrap(), spheres(hard(), 0.45, 4_000).build().unwrap());
    let events = Until::events(40_000);
    compare::<false, false>(&thin, "cells", events, (&[2, 3, 8], WIDE));
    compare::<false, false>(&dense, "lists", events, (&[2, 3, 8], WIDE));
    compare::<false, true>(&mixture().build().unwrap(), "mixture", Until::time(5.0), (&[1, 2, 5, 13], WIDE));
    // Walls, a floor that dissipates, gravity, in three dimensions and in two.
    let boundary = [Boundary::walls(0.9); 3];
    let walls = |builder: SceneBuilder, size| builder.space(Space { boundary, ..Space::periodic_cube(size) });
    let falling = walls(mixture(), 14.0).gravity(Vector::new(0.0, 0.1, -0.4)).build().unwrap();
    compare::<true, true>(&falling, "falling", Until::time(4.0), (&[2, 7], WIDE));
    let flat = [Boundary::Periodic, Boundary::walls(1.0), Boundary::Flat];
    let disks = SceneBuilder::new("disks")
        .space(Space { boundary: flat, size: Vector::new(60.0, 20.0, 0.0), ..Space::periodic_cube(1.0) })
        .species("A", 0.7, 1.0)
        .interaction("A", "A", hard(), 0.95)
        .add_fill(Fill::new(Arrangement::Random, "A").count(500))
        .temperature(1.3);
    compare::<false, false>(&disks.build().unwrap(), "disks", Until::time(6.0), (&[2, 5], WIDE));
}

#[test]
fn windows_that_are_wrong_are_undone() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let (thin, dense) = (spheres(hard(), 0.1, 4_000).build().unwrap(), spheres(hard(), 0.45, 4_000).build().unwrap());
    let events = Until::events(20_000);
    let work = [
        compare::<false, false>(&thin, "cells", events, (&[2, 8], THIN)),
        compare::<false, false>(&dense, "lists", events, (&[2, 8], THIN)),
        compare::<false, true>(&mixture().build().unwrap(), "mixture", Until::time(2.0), (&[2, 5], THIN)),
    ];
    assert!(work.iter().all(|work| work.differences > 5), "{work:?}");
    assert!(work.iter().map(|work| work.uncovered).sum::<u64>() > 5, "{work:?}");
}
