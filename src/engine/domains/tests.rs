//! Domains beside one engine: the same events, states and counts to the bit.

use super::*;
use crate::engine::Snapshot;
use crate::engine::columns::tests::{mixture, spheres};
use crate::engine::event::Event;
use crate::model::Scene;
use crate::model::potential::Potential;
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

fn compare<const FALLING: bool, const TABLE: bool>(scene: &Scene, name: &str, until: Until, counts: &[usize]) {
    let (events, snapshot, engine) = advance::<FALLING, TABLE>(scene, until, None);
    for &count in counts {
        let mut domains = Domains::<FALLING, TABLE>::new(count, 2, Halo { slack: 0.5, margin: 1.5 });
        let (seen, there, other) = advance(scene, until, Some(&mut domains));
        println!("{name} {count}: {} events, {:?}", seen.len(), domains.work);
        let first = events.iter().zip(&seen).position(|(one, other)| one != other);
        assert_eq!(first, None, "{name} {count}");
        assert_eq!(events.len(), seen.len(), "{name} {count}");
        assert_eq!(there, snapshot, "{name} {count}");
        assert_eq!(other.counts.totals, engine.counts.totals, "{name} {count}");
        assert!(domains.work.windows > 20, "{name} {count}");
    }
}

#[test]
fn domains_have_the_bits_of_one_engine() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let events = Until::events(60_000);
    compare::<false, false>(&spheres(hard(), 0.1, 4_000).build().unwrap(), "cells", events, &[2, 3, 8]);
    compare::<false, false>(&spheres(hard(), 0.45, 4_000).build().unwrap(), "lists", events, &[2, 3, 8]);
    compare::<false, true>(&mixture().build().unwrap(), "mixture", Until::time(20.0), &[1, 2, 5]);
}
