//! The results do not depend, bit for bit, on the order in memory or on the number of buckets. They do not change if
//! all particles are replaced by copies.

pub(in crate::engine) mod compare;

use super::Order;
use super::records::Record;
use crate::Vector;
use crate::engine::Until;
use crate::engine::event::{Event, EventCounts};
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::pairs::states::PairState;
use crate::engine::parts::Engine;
use crate::engine::predict::batch::tests::falling;
use crate::engine::prediction::{Contact, Prediction};
use crate::engine::snapshot::Snapshot;
use crate::model::potential::Potential;
use crate::model::random::{Purpose, Random};
use crate::model::space::{Boundary, Space};
use crate::model::{DiameterDistribution, Scene};
use crate::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use std::ops::ControlFlow;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn copies(&mut self, particles: &[u32]) -> Vec<Record> {
        let mut records = Vec::with_capacity(particles.len());
        for &particle in particles {
            let mut record = self.record(particle);
            if self.is_static(particle) {
                // The state of a pair with a static particle is stored with the moving particle only.
                let state =
                    |other| self.pairs.states.get(other, particle).map(|pair| PairState { partner: other, ..pair });
                record.captured = Some(self.particles().filter(|&other| other != particle).filter_map(state).collect());
            }
            let id = |number: u32| self.state.bodies.get(number as usize).map_or(NO_PARTICLE, |body| body.id);
            record.captured.iter_mut().flatten().for_each(|pair| pair.partner = id(pair.partner));
            if let Some(prediction) = &mut record.prediction {
                prediction.partner = id(prediction.partner);
            }
            records.push(record);
        }
        records
    }

    /// Inserts particles. Their ids must be unused, and the particles must not overlap. Pairs with absent particles are
    /// dropped.
    pub(in crate::engine) fn insert(&mut self, records: &[Record]) {
        let added = self.push_records(records);
        for (particle, record) in added.clone().zip(records) {
            for pair in record.captured.iter().flatten() {
                if let Some(partner) = self.state.number(pair.partner) {
                    self.set_pair_state(particle, partner, pair.state, pair.interaction);
                }
            }
        }
        for particle in added.clone() {
            self.fill_list(particle);
        }
        for (particle, record) in added.clone().zip(records) {
            let partner = record.prediction.and_then(|prediction| self.state.number(prediction.partner));
            let is_pair = |it: &Prediction| matches!(it.contact, Contact::Pair(_)) && it.contact_time < f64::INFINITY;
            match record.prediction.filter(|it| !self.is_static(particle) && (partner.is_some() || !is_pair(it))) {
                Some(prediction) => {
                    let partner = partner.unwrap_or(NO_PARTICLE);
                    self.schedule.predictions[particle as usize] = Prediction { partner, ..prediction };
                    self.enqueue(particle);
                }
                None => self.predict_arrival(particle, added.start),
            }
        }
    }
}

/// Runs a scene, and shuffles the particles after each `every` events. `buckets` sets the number of queue buckets.
fn run<const FALLING: bool, const TABLE: bool>(
    scene: &Scene,
    every: u64,
    buckets: Option<usize>,
) -> (Vec<Event>, Snapshot, EventCounts) {
    let mut engine = Engine::<FALLING, TABLE>::new(scene);
    if let Some(buckets) = buckets {
        engine.schedule.queue = engine.schedule.queue.rebuilt(buckets);
        enqueue_all(&mut engine);
    }
    let mut random = Random::new(7, Purpose::Velocities, 0);
    let mut events = Vec::new();
    let mut see = |event: &Event| {
        events.push(*event);
        ControlFlow::Continue(())
    };
    const EVENTS: u64 = 3_000;
    let mut done = 0;
    while done < EVENTS {
        done = (done + every).min(EVENTS);
        let _ = engine.advance(Until::time(200.0).or_events(done), &mut Some(&mut see));
        if every < EVENTS {
            shuffle(&mut engine, &mut random);
        }
    }
    (events, engine.snapshot(), engine.counts.totals)
}

/// Renumbers all particles at random, or replaces them by copies.
fn shuffle<const FALLING: bool, const TABLE: bool>(engine: &mut Engine<FALLING, TABLE>, random: &mut Random) {
    let mut old: Vec<u32> = engine.particles().collect();
    for last in (1..old.len()).rev() {
        old.swap(last, random.below(last + 1));
    }
    if random.below(2) == 0 {
        let copies = engine.copies(&old);
        engine.remove(&old);
        assert!(engine.particles().is_empty() && engine.state.numbers.is_empty());
        engine.insert(&copies);
    } else {
        let count = old.len();
        engine.permute(&Order::of(old, count));
        enqueue_all(engine);
    }
}

fn enqueue_all<const FALLING: bool, const TABLE: bool>(engine: &mut Engine<FALLING, TABLE>) {
    engine.schedule.queue.clear();
    for particle in engine.particles() {
        engine.enqueue(particle);
    }
}

fn is_the_same_in_any_order<const FALLING: bool, const TABLE: bool>(name: &str, scene: &Scene) {
    let plain = run::<FALLING, TABLE>(scene, u64::MAX, None);
    assert!(plain.0.len() > 100, "{name}: {}", plain.0.len());
    for (every, buckets) in
        [(1, None), (10, None), (300, None), (u64::MAX, Some(64)), (u64::MAX, Some(1024)), (7, Some(256))]
    {
        let other = run::<FALLING, TABLE>(scene, every, buckets);
        let first = plain.0.iter().zip(&other.0).position(|(a, b)| a != b);
        let events = first.map(|at| (at, plain.0[at], other.0[at]));
        assert_eq!(events, None, "{name}, shuffled every {every}, {buckets:?} buckets");
        assert!(plain == other, "{name}, shuffled every {every}, {buckets:?} buckets");
    }
}

pub(in crate::engine) fn spheres(potential: Potential, packing_fraction: f64, count: u64) -> SceneBuilder {
    SceneBuilder::new("spheres")
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(potential).between("A", "A").restitution(0.9))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(count).packing_fraction(packing_fraction))
        .temperature(1.3)
}

/// Lattice particles that fly along the axes with equal speeds, so that many contacts are due at once.
fn at_once() -> Scene {
    let mut scene = SceneBuilder::new("lattice")
        .space(Space::periodic_cube(12.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Potential::square_well(1.0, 1.5, 0.5).unwrap()).between("A", "A"));
    for k in 0..216 {
        let at = |n: u32| 1.0 + 2.0 * f64::from(n % 6);
        let velocity = Vector::ith((k % 3) as usize, if k / 3 % 2 == 0 { 1.0 } else { -1.0 });
        scene = scene.particle("A", Vector::new(at(k), at(k / 6), at(k / 36)), velocity);
    }
    scene.build().unwrap()
}

/// Static spheres with low ids. Several particles reach a sphere at the same time, from all sides. These simultaneous
/// contacts differ only in the higher id.
fn against_static_spheres() -> Scene {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let mut scene = SceneBuilder::new("static-spheres")
        .space(Space::periodic_cube(12.0))
        .species(SpeciesDraft::new("S").diameter(1.0).fixed())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard()).between("A", "S"))
        .interaction(InteractionDraft::new(hard()).between("A", "A"));
    let places = (0..64).map(|k| Vector::new(f64::from(k % 4), f64::from(k / 4 % 4), f64::from(k / 16)) * 3.0);
    let (fixed, moving): (Vec<_>, Vec<_>) = places.partition(|place| place.iter().sum::<f64>() % 6.0 == 0.0);
    for place in fixed {
        scene = scene.particle("S", place, Vector::zeros());
    }
    for (k, place) in moving.into_iter().enumerate() {
        scene = scene.particle("A", place, Vector::ith(k % 3, if k / 3 % 2 == 0 { 1.0 } else { -1.0 }));
    }
    scene.build().unwrap()
}

pub(in crate::engine) fn mixture() -> SceneBuilder {
    let mut fill = Fill::new(Lattice::FaceCentredCubic, "A");
    fill.composition = vec![("A".to_owned(), 2.0), ("B".to_owned(), 1.0)];
    let well = |diameter| Potential::square_well(diameter, 1.4, 0.8).unwrap();
    SceneBuilder::new("mixture")
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(3.1).diameter(1.4))
        .interaction(InteractionDraft::new(well(1.0)).between("A", "A"))
        .interaction(InteractionDraft::new(well(1.2)).between("A", "B"))
        .interaction(InteractionDraft::new(well(1.4)).between("B", "B"))
        .fill(fill.count(256).packing_fraction(0.25))
        .temperature(1.0)
}

#[test]
fn results_do_not_depend_on_memory_order_buckets_or_copying() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    is_the_same_in_any_order::<false, false>("cells", &spheres(hard(), 0.1, 256).build().unwrap());
    is_the_same_in_any_order::<false, false>("lists", &spheres(hard(), 0.45, 256).build().unwrap());
    is_the_same_in_any_order::<false, false>("small box", &spheres(hard(), 0.1, 4).build().unwrap());
    is_the_same_in_any_order::<false, true>("mixture", &mixture().build().unwrap());
    let individual = SceneBuilder::new("individual")
        .species(
            SpeciesDraft::new("A").mass(0.7).distributed(DiameterDistribution::Lognormal { mean: 1.0, deviation: 0.3 }),
        )
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(256).packing_fraction(0.35))
        .temperature(1.3);
    is_the_same_in_any_order::<false, true>("individual diameters", &individual.build().unwrap());
    is_the_same_in_any_order::<false, true>("at once", &at_once());
    is_the_same_in_any_order::<false, true>("static spheres", &against_static_spheres());
    is_the_same_in_any_order::<true, true>("falling", &falling());
    is_the_same_in_any_order::<false, true>("TC model", &mixture().contact_time(0.05).build().unwrap());
    is_the_same_in_any_order::<false, true>("sheared", &mixture().shear(0.7).build().unwrap());
    let space = Space { boundary: [Boundary::walls(0.9); 3], ..Space::periodic_cube(12.0) };
    let walled = SceneBuilder::new("walls")
        .space(space)
        .wall_temperatures(0, [Some(2.0), None])
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard()).between("A", "A").restitution(0.9))
        .fill(Fill::new(Arrangement::Random, "A").count(200))
        .temperature(1.3);
    is_the_same_in_any_order::<false, false>("walls", &walled.build().unwrap());
}
