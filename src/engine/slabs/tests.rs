//! Compares several threads with a single engine. States, predictions, lists and counts must agree bit for bit.

use super::*;
use crate::Vector;
use crate::engine::Simulation;
use crate::engine::columns::tests::compare::compare_records;
use crate::engine::event::{Event, EventKind};
use crate::engine::sources::andersen::Bath;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{ContactLaw, DiameterDistribution, Scene};
use crate::scene::{Arrangement, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use proptest::prelude::*;
use std::ops::ControlFlow;

/// Smallest width of slabs in these tests. It is smaller than usual, so that the systems can be small.
const NARROW: f64 = 2.0;

/// Number of random scenes. `CAROM_SLABS=1000 cargo test --release --lib random_systems_on_threads` tests more.
fn cases() -> u32 {
    std::env::var("CAROM_SLABS").map_or(6, |cases| cases.parse().unwrap())
}

/// Several threads, even if one thread is faster.
fn slabs_of(threads: usize) -> Slabs {
    Slabs::always(threads, NARROW)
}

/// Advances an engine on threads. Each call advances by some steps, and may then join the threads.
fn advance<const FALLING: bool, const TABLE: bool>(
    engine: &mut Engine<FALLING, TABLE>,
    slabs: &mut Slabs,
    until: Until,
    (steps, joins): (u64, bool),
    observe: &mut Observe<'_>,
) -> Reason {
    loop {
        let reason = match slabs.advance_for(engine, steps, until, observe) {
            Some(reason) => reason.unwrap(),
            None => engine.advance_for(steps, until, observe).unwrap(),
        };
        if joins {
            slabs.join(engine);
        }
        if let Some(reason) = reason {
            return reason;
        }
    }
}

/// Advances two engines, the second one on threads. Both have observers or none, which see the same events. The
/// observers end the run after `most` events.
fn advance_both<const FALLING: bool, const TABLE: bool>(
    one: &mut Engine<FALLING, TABLE>,
    (other, slabs): (&mut Engine<FALLING, TABLE>, &mut Slabs),
    until: Until,
    (steps, joins): (u64, bool),
    most: Option<usize>,
) -> [Reason; 2] {
    let Some(most) = most else {
        let reason = one.advance(until, &mut None).unwrap();
        return [reason, advance(other, slabs, until, (steps, joins), &mut None)];
    };
    let mut seen = [(); 2].map(|()| Vec::<Event>::new());
    let [mut here, mut there] = seen.each_mut().map(|events| {
        move |event: &Event| {
            events.push(*event);
            if events.len() == most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    });
    let reason = one.advance(until, &mut Some(&mut here)).unwrap();
    let reasons = [reason, advance(other, slabs, until, (steps, joins), &mut Some(&mut there))];
    assert!(seen[0] == seen[1], "{} and {} events", seen[0].len(), seen[1].len());
    reasons
}

fn assert_equal<const FALLING: bool, const TABLE: bool>(
    (one, reason): (&Engine<FALLING, TABLE>, Reason),
    (other, there): (&Engine<FALLING, TABLE>, Reason),
    name: &str,
) {
    assert_eq!((there, other.time().to_bits()), (reason, one.time().to_bits()), "{name}");
    assert_eq!(other.snapshot(), one.snapshot(), "{name}");
    assert_eq!(other.counts.totals, one.counts.totals, "{name}");
    assert_eq!(other.counts.by_species, one.counts.by_species, "{name}");
    assert_eq!(other.counts.transitions_at_event, one.counts.transitions_at_event, "{name}");
    let standstill = |engine: &Engine<FALLING, TABLE>| (engine.clock.standstill.since, engine.clock.standstill.events);
    assert_eq!(standstill(other), standstill(one), "{name}");
    compare_records(one, other, name);
}

fn compare<const FALLING: bool, const TABLE: bool>(scene: &Scene, name: &str, until: &[Until]) {
    compare_in_bath::<FALLING, TABLE>(scene, None, name, until);
}

fn compare_in_bath<const FALLING: bool, const TABLE: bool>(
    scene: &Scene,
    rate: Option<f64>,
    name: &str,
    until: &[Until],
) {
    let begin = || {
        let mut engine = Engine::<FALLING, TABLE>::new(scene);
        engine.set_bath(rate.map(|rate| Bath { temperature: 1.7, rate, axes: [true, false, true] }), 7, 0);
        engine
    };
    for threads in [2, 3] {
        let (mut one, mut engine, mut slabs) = (begin(), begin(), slabs_of(threads));
        for (step, until) in until.iter().enumerate() {
            let name = format!("{name}, {threads} threads, step {step}");
            // Every second part of a run has an observer. Some observers end it.
            let most = [None, Some(usize::MAX), None, Some(777)][step % 4];
            let work = (10_000, false);
            let [reason, there] = advance_both(&mut one, (&mut engine, &mut slabs), *until, work, most);
            // Some comparisons continue with the slabs, and some cut the system anew.
            let mut copy = (engine.clone(), slabs.clone());
            copy.1.join(&mut copy.0);
            if step % 2 == 0 {
                slabs.join(&mut engine);
            }
            assert_equal((&one, reason), (&copy.0, there), &name);
        }
        let [deep, near, _] = slabs.work.steps;
        assert!(slabs.work.windows > 20 && deep > 100 && near > 100, "{name}: {:?}", slabs.work);
        assert!(rate.is_none() || one.counts.totals.thermostat > 100, "{name}: {:?}", one.counts.totals);
    }
}

fn hard(diameter: f64) -> Potential {
    Potential::hard_sphere(diameter).unwrap()
}

/// Spheres of one species in a long box, at a given number density. Only dense spheres have lists.
fn spheres(density: f64, size: Vector) -> SceneBuilder {
    let arrangement: Arrangement = if density > 0.6 { Lattice::BodyCentredCubic.into() } else { Arrangement::Random };
    let count = crate::base::numbers::trunc_to_u64(density * size.product());
    SceneBuilder::new("spheres")
        .space(Space { size, ..Space::periodic_cube(1.0) })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"))
        .fill(Fill::new(arrangement, "A").count(count))
        .temperature(1.3)
}

/// A mixture with odd masses in a long box.
fn mixture(count: u64, boundary: [Boundary; 3], range: Option<f64>) -> SceneBuilder {
    let potential = |diameter: f64| match range {
        Some(range) => Potential::square_well(diameter, range, 0.7).unwrap(),
        None => hard(diameter),
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
    let size = Vector::new(80.0, 7.0, 6.0);
    let steps = times(&[0.1, 0.4, 0.4, 0.7]);
    compare::<false, false>(&spheres(0.9, size).build().unwrap(), "lists", &steps);
    compare::<false, false>(&spheres(0.2, size).build().unwrap(), "cells", &times(&[0.5, 2.0, 3.0]));
    compare::<false, true>(&mixture(900, PERIODIC, None).build().unwrap(), "mixture", &steps);
    compare::<false, true>(&mixture(700, PERIODIC, Some(1.4)).build().unwrap(), "wells", &steps);
    compare::<false, true>(&individual_diameters().build().unwrap(), "individual diameters", &steps);
}

/// Spheres of all diameters in a long box.
fn individual_diameters() -> SceneBuilder {
    SceneBuilder::new("individual")
        .space(Space { size: Vector::new(80.0, 8.0, 8.0), ..Space::periodic_cube(1.0) })
        .species(SpeciesDraft::new("A").mass(0.7).distributed(DiameterDistribution::Uniform { lower: 0.6, upper: 1.4 }))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Arrangement::Random, "A").count(2_500))
        .temperature(1.3)
}

#[test]
fn threads_match_one_engine_bitwise_with_walls_gravity_and_friction() {
    let walls = [Boundary::walls(0.9), Boundary::walls(0.8), Boundary::walls(0.95)];
    let steps = times(&[0.1, 0.5, 1.2]);
    let gravity = Vector::new(0.05, 0.1, -0.4);
    let falling = mixture(700, walls, None).gravity(gravity).build().unwrap();
    compare::<true, true>(&falling, "falling", &steps);
    let mut dissipative = mixture(700, walls, None).contact_time(0.05);
    dissipative.interactions.iter_mut().for_each(|interaction| interaction.law = ContactLaw::smooth(0.8));
    let thermal = dissipative.wall_temperatures(0, [Some(2.0), None]).wall_temperatures(2, [Some(0.5), Some(3.0)]);
    compare::<false, true>(&thermal.build().unwrap(), "thermal walls", &steps);
    let mut rough = mixture(900, PERIODIC, None);
    for interaction in &mut rough.interactions {
        *interaction = interaction.clone().tangential_restitution(0.4).friction(0.3);
    }
    compare::<false, true>(&rough.build().unwrap(), "rough", &steps);
    let flat = [Boundary::walls(1.0), Boundary::Periodic, Boundary::Flat];
    let disks = SceneBuilder::new("disks")
        .space(Space { boundary: flat, size: Vector::new(90.0, 12.0, 0.0), ..Space::periodic_cube(1.0) })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A").restitution(0.95))
        .fill(Fill::new(Arrangement::Random, "A").count(500))
        .temperature(1.3);
    compare::<false, false>(&disks.build().unwrap(), "disks", &times(&[1.0, 6.0]));
}

#[test]
fn runs_on_threads_end_at_the_same_number_of_events() {
    let scene = mixture(700, PERIODIC, None).build().unwrap();
    let ends: Vec<Until> = [1, 5_000, 5_001, 12_345].map(Until::events).to_vec();
    compare::<false, true>(&scene, "events", &ends);
}

/// Static particles are everywhere, also at the faces between slabs.
#[test]
fn threads_match_one_engine_bitwise_with_static_particles() {
    let law = |builder: SceneBuilder, law: fn(InteractionDraft) -> InteractionDraft| {
        let wall = SpeciesDraft::new("W").diameter(0.9).fixed();
        builder
            .species(wall)
            .interaction(law(InteractionDraft::new(hard(0.95)).between("A", "W")))
            .interaction(law(InteractionDraft::new(hard(1.1)).between("B", "W")))
            .fill(Fill::new(Arrangement::Random, "W").count(150))
            .build()
            .unwrap()
    };
    let steps = times(&[0.1, 0.8, 1.5, 3.0]);
    compare::<false, true>(&law(mixture(500, PERIODIC, None), |law| law), "static", &steps);
    let rough = law(mixture(500, PERIODIC, None), |law| law.tangential_restitution(0.4).friction(0.3));
    compare_in_bath::<false, true>(&rough, Some(0.5), "rough static", &steps);
    let falling = mixture(500, [Boundary::walls(0.9); 3], None).gravity(Vector::new(0.0, 0.0, -0.3));
    compare::<true, true>(&law(falling, |law| law.restitution(0.9)), "falling on static", &steps);
}

#[test]
fn threads_match_one_engine_bitwise_in_a_heat_bath() {
    let size = Vector::new(80.0, 7.0, 6.0);
    let steps = times(&[0.1, 0.4, 0.7, 0.75, 0.8]);
    compare_in_bath::<false, false>(&spheres(0.9, size).build().unwrap(), Some(3.0), "lists", &steps);
    let late = times(&[0.5, 1.5, 2.0]);
    compare_in_bath::<false, false>(&spheres(0.2, size).build().unwrap(), Some(0.3), "cells", &late);
    let wells = mixture(700, PERIODIC, Some(1.4)).build().unwrap();
    compare_in_bath::<false, true>(&wells, Some(1.0), "wells", &steps);
}

/// Each observer ends the run in the middle of a window, at any kind of event.
#[test]
fn observers_end_runs_on_threads_at_their_event() {
    let scene = mixture(700, PERIODIC, Some(1.4)).build().unwrap();
    let begin = || {
        let mut engine = Engine::<false, true>::new(&scene);
        engine.set_bath(Some(Bath { temperature: 1.7, rate: 2.0, axes: [true; 3] }), 7, 0);
        engine
    };
    let (mut one, mut engine, mut slabs) = (begin(), begin(), slabs_of(3));
    for most in [1_000, 1, 1, 300, usize::MAX, 2_345, usize::MAX, 1] {
        let until = Until::time(one.time() + 0.4);
        let [reason, there] = advance_both(&mut one, (&mut engine, &mut slabs), until, (u64::MAX, false), Some(most));
        assert_eq!(reason == Reason::Observer, most < usize::MAX);
        slabs.join(&mut engine);
        assert_equal((&one, reason), (&engine, there), &format!("{most} events"));
    }
    assert!(slabs.work.windows > 100, "{:?}", slabs.work);
}

/// An iterator ends a run after each event. It must not cut the system again for each of them.
#[test]
fn iteration_over_events_continues_on_one_thread() {
    let scene = spheres(0.9, Vector::new(200.0, 5.0, 5.0)).build().unwrap();
    let mut simulation = Simulation::without_plan(scene);
    simulation.set_threads(2);
    let events: Vec<Event> = simulation.events(Until::events(100)).map(Result::unwrap).collect();
    assert_eq!(events.len(), 100);
    assert!(events.iter().all(|event| matches!(event.kind, EventKind::Pair(_))));
    assert_eq!(simulation.thread_work().unwrap().cuts, 1);
}

/// The limit of the run is in the first window, so one thread finds each event.
#[test]
fn iteration_over_the_last_events_continues_on_one_thread() {
    let scene = spheres(0.9, Vector::new(70.0, 5.0, 5.0)).build().unwrap();
    let (mut engine, mut slabs) = (Engine::<false, false>::new(&scene), slabs_of(2));
    for number in 1..=10 {
        let mut stop = |_: &Event| ControlFlow::Break(());
        let reason = slabs.advance_for(&mut engine, u64::MAX, Until::events(10), &mut Some(&mut stop));
        assert_eq!((reason.unwrap().unwrap(), engine.counts.executed), (Some(Reason::Observer), number));
    }
    assert_eq!(slabs.work.cuts, 1);
}

#[test]
fn a_short_box_is_not_cut() {
    let scene = mixture(100, PERIODIC, None).build().unwrap();
    let mut engine = Engine::<false, true>::new(&scene);
    let mut slabs = Slabs { narrowest: 50.0, ..slabs_of(2) };
    assert_eq!(slabs.advance_for(&mut engine, 10, Until::time(0.1), &mut None), Some(Ok(None)));
    assert_eq!((slabs.work.windows, slabs.is_refused()), (0, true));
}

type FreeHard = Engine<false, false>;

/// Runs a system of equal hard spheres on one thread.
fn run_alone(scene: &Scene, until: Until) -> (FreeHard, Reason) {
    let mut engine = FreeHard::new(scene);
    let reason = engine.advance(until, &mut None).unwrap();
    (engine, reason)
}

/// Runs the same system on several threads. Both runs must end in the same state.
fn assert_same_end(
    scene: &Scene,
    until: Until,
    (one, reason): (&FreeHard, Reason),
    slabs: &mut Slabs,
    pauses: (u64, bool),
) {
    let mut engine = FreeHard::new(scene);
    let there = advance(&mut engine, slabs, until, pauses, &mut None);
    slabs.join(&mut engine);
    assert_equal((one, reason), (&engine, there), &format!("{pauses:?} {:?}", slabs.work));
}

/// Pauses after a few steps often come at the end of an epoch, when nobody has the queue.
#[test]
fn short_advances_match_one_engine_bitwise() {
    let scene = spheres(0.9, Vector::new(70.0, 5.0, 5.0)).build().unwrap();
    let until = Until::time(1.5);
    let (one, reason) = run_alone(&scene, until);
    assert!(one.clock.epochs > 2, "{}", one.clock.epochs);
    for pauses in [(100, false), (700, true)] {
        assert_same_end(&scene, until, (&one, reason), &mut slabs_of(2), pauses);
    }
}

/// From the second epoch on, the slabs would be too narrow.
#[test]
fn one_thread_continues_if_the_system_cannot_be_cut_any_more() {
    let scene = spheres(0.9, Vector::new(70.0, 5.0, 5.0)).build().unwrap();
    let until = Until::time(3.0);
    let (one, reason) = run_alone(&scene, until);
    let (mut engine, mut slabs) = (FreeHard::new(&scene), slabs_of(2));
    assert!(slabs.advance_for(&mut engine, 100, until, &mut None).unwrap().unwrap().is_none());
    slabs.narrowest = 100.0;
    let there = advance(&mut engine, &mut slabs, until, (u64::MAX, false), &mut None);
    assert_equal((&one, reason), (&engine, there), "narrow");
}

#[test]
fn windows_that_are_much_too_long_become_shorter() {
    let scene = spheres(0.9, Vector::new(80.0, 5.0, 5.0)).build().unwrap();
    let mut engine = Engine::<false, false>::new(&scene);
    let mut slabs = Slabs { length: 1e3, ..slabs_of(2) };
    advance(&mut engine, &mut slabs, Until::events(30_000), (u64::MAX, false), &mut None);
    let [deep, _, rest] = slabs.work.steps;
    assert!(rest < deep / 2, "{:?}", slabs.work);
}

/// All spheres of a lattice move alike in pairs, so that very many events are due at the same time.
#[test]
fn simultaneous_events_match_one_engine_bitwise() {
    let size = Vector::new(60.0, 6.0, 6.0);
    let mut scene = SceneBuilder::new("lattice")
        .space(Space { size, ..Space::periodic_cube(1.0) })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard(1.0)).between("A", "A"));
    for number in 0..40 * 4 * 4_u32 {
        let [x, y, z] = [number % 40, number / 40 % 4, number / 160];
        let direction = if (x + y + z) % 2 == 0 { 1.0 } else { -1.0 };
        let position = 1.5 * Vector::new(f64::from(x), f64::from(y), f64::from(z));
        scene = scene.particle("A", position, direction * Vector::new(1.0, 0.0, 0.5));
    }
    compare::<false, false>(&scene.build().unwrap(), "lattice", &times(&[2.0, 8.0, 20.0]));
}

/// Long windows have conflicts. One thread repeats such a window.
#[test]
fn windows_with_conflicts_are_repeated() {
    let size = Vector::new(80.0, 7.0, 6.0);
    let dense = spheres(0.9, size).build().unwrap();
    let dilute = spheres(0.2, size).build().unwrap();
    for (scene, time) in [(dense, 1.5), (dilute, 6.0)] {
        let until = Until::time(time);
        let (one, reason) = run_alone(&scene, until);
        for (threads, fewest) in [(2, 1_000.0), (3, 2_000.0)] {
            let mut slabs = Slabs { fewest, ..slabs_of(threads) };
            assert_same_end(&scene, until, (&one, reason), &mut slabs, (u64::MAX, false));
            assert!(slabs.work.conflicts > 10, "{:?}", slabs.work);
        }
    }
}

/// Many windows have few steps or none.
#[test]
fn few_particles_match_one_engine_bitwise() {
    let scene = spheres(0.05, Vector::new(70.0, 8.6, 4.5)).build().unwrap();
    compare::<false, false>(&scene, "few", &times(&[1.0, 10.0, 30.0]));
}

#[test]
fn memory_set_apart_for_threads_is_used_again() {
    let scene = spheres(0.9, Vector::new(60.0, 6.0, 6.0)).build().unwrap();
    let mut engine = Engine::<false, false>::new(&scene);
    let mut slabs = slabs_of(2);
    let mut size_after = |time: f64| {
        advance(&mut engine, &mut slabs, Until::time(time), (500, true), &mut None);
        engine.neighbours.verlet().unwrap().lists.memory()
    };
    let (early, late) = (size_after(1.0), size_after(3.0));
    assert!(2 * late < 3 * early, "{early} {late}");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(cases()) })]
    #[test]
    fn random_systems_on_threads_match_one_engine_bitwise(
        density in prop::sample::select(vec![0.05, 0.15, 0.3, 0.6, 0.8, 0.95]),
        edges in (30.0..90.0_f64, 4.2..9.0_f64, 4.2..9.0_f64),
        threads in 2..5_usize,
        narrowest in 0.5..3.0_f64,
        (kind, is_lattice, rate) in (0..5_u32, prop::bool::weighted(0.1), prop::option::weighted(0.4, 0.01..3.0_f64)),
        steps in prop::collection::vec(
            (1..20_000_u64, any::<bool>(), 200..6_000_u64, prop::option::of(1..4_000_usize)),
            1..4,
        ),
    ) {
        let size = Vector::new(edges.0, edges.1, edges.2);
        let potential = match kind {
            0 => Potential::square_well(1.0, 1.3, 0.6).unwrap(),
            1 => Potential::new(vec![1.4, 1.2, 1.0], vec![0.0, 0.3, -0.7, f64::INFINITY]).unwrap(),
            _ => hard(1.0),
        };
        let law = InteractionDraft::new(potential).between("A", "A");
        let law = match kind {
            2 => law.restitution(0.9),
            3 => law.tangential_restitution(0.3).friction(0.4),
            _ => law,
        };
        let arrangement = if is_lattice || density > 0.6 { Lattice::FaceCentredCubic.into() } else { Arrangement::Random };
        let count = crate::base::numbers::trunc_to_u64(density * size.product());
        let scene = SceneBuilder::new("random")
            .space(Space { size, ..Space::periodic_cube(1.0) })
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
            .interaction(law)
            .fill(Fill::new(arrangement, "A").count(count))
            .temperature(1.3);
        // Some lattices do not fit into a long box.
        let Ok(scene) = scene.build() else { return Ok(()) };
        if kind < 2 || kind == 3 {
            check::<true>(&scene, (threads, narrowest), rate, &steps);
        } else {
            check::<false>(&scene, (threads, narrowest), rate, &steps);
        }
    }
}

type Step = (u64, bool, u64, Option<usize>);

fn check<const TABLE: bool>(scene: &Scene, (threads, narrowest): (usize, f64), rate: Option<f64>, steps: &[Step]) {
    let begin = || {
        let mut engine = Engine::<false, TABLE>::new(scene);
        engine.set_bath(rate.map(|rate| Bath { temperature: 0.9, rate, axes: [true, true, false] }), 7, 0);
        engine
    };
    let (mut one, mut other) = (begin(), begin());
    let mut slabs = Slabs { narrowest, ..slabs_of(threads) };
    for &(some, joins, more, most) in steps {
        let until = Until::events(one.counts.executed + more);
        let [reason, there] = advance_both(&mut one, (&mut other, &mut slabs), until, (some, joins), most);
        slabs.join(&mut other);
        assert_equal((&one, reason), (&other, there), &format!("{:?}", slabs.work));
    }
}
