//! Compares domains with a single engine. Events, states and counts must agree bit for bit.

use super::*;
use crate::Vector;
use crate::engine::Search;
use crate::engine::columns::tests::compare::{all_of, compare_records, listed};
use crate::engine::columns::tests::{mixture, spheres};
use crate::engine::communicator::tests::in_processes;
use crate::engine::event::{Event, EventKind};
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::prediction::absent;
use crate::engine::sources::andersen::Bath;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{ContactLaw, RunPlan, Scene, Thermostat};
use crate::scene::{Arrangement, Chain, Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
use std::ops::ControlFlow;

fn begun<const FALLING: bool, const TABLE: bool>(scene: &Scene) -> Engine<FALLING, TABLE> {
    let mut engine = Engine::new(scene);
    if let Some(Thermostat::Andersen { temperature, rate, axes }) = scene.run().thermostat {
        engine.set_bath(Some(Bath { temperature, rate, axes }), scene.seed(), 0);
    }
    engine
}

/// A finished run.
struct Run<const FALLING: bool, const TABLE: bool> {
    events: Vec<Event>,
    reason: Reason,
    engine: Engine<FALLING, TABLE>,
}

fn advance<const FALLING: bool, const TABLE: bool>(
    scene: &Scene,
    until: Until,
    domains: Option<&mut Domains<FALLING, TABLE>>,
) -> Run<FALLING, TABLE> {
    let mut engine = begun(scene);
    let mut events = Vec::new();
    let mut see = |event: &Event| {
        events.push(*event);
        ControlFlow::Continue(())
    };
    let reason = match domains {
        None => engine.advance(until, &mut Some(&mut see)).unwrap(),
        Some(domains) => {
            let reason = loop {
                if let Some(reason) = domains.advance_for(&mut engine, 10_000, until, &mut Some(&mut see)).unwrap() {
                    break reason;
                }
            };
            domains.join(&mut engine);
            reason
        }
    };
    Run { events, reason, engine }
}

fn compare<const FALLING: bool, const TABLE: bool>(
    scene: &Scene,
    name: &str,
    until: Until,
    (counts, halo): (&[usize], Halo),
) -> DomainWork {
    let one = advance::<FALLING, TABLE>(scene, until, None);
    let mut work = DomainWork::default();
    for &count in counts {
        let there = compare_with(&one, scene, &format!("{name} {count}"), until, Team::new(count, 2, None), halo);
        work.differences += there.differences;
        work.uncovered += there.uncovered;
    }
    work
}

fn compare_with<const FALLING: bool, const TABLE: bool>(
    one: &Run<FALLING, TABLE>,
    scene: &Scene,
    name: &str,
    until: Until,
    team: Team,
    halo: Halo,
) -> DomainWork {
    let mut domains = Domains::<FALLING, TABLE>::with(team, halo);
    domains.checked = Some(0);
    let there = advance(scene, until, Some(&mut domains));
    let first = one.events.iter().zip(&there.events).position(|(one, other)| one != other);
    assert_eq!(first, None, "{name}: {:?}", domains.work);
    assert_eq!((one.events.len(), one.reason), (there.events.len(), there.reason), "{name}");
    let (engine, other) = (&one.engine, &there.engine);
    assert_eq!(other.snapshot(), engine.snapshot(), "{name}");
    compare_records(engine, other, name);
    assert_eq!(other.counts.totals, engine.counts.totals, "{name}");
    assert_eq!(other.counts.by_species, engine.counts.by_species, "{name}");
    assert_eq!(other.counts.transitions_at_event, engine.counts.transitions_at_event, "{name}");
    let standstill = |engine: &Engine<FALLING, TABLE>| (engine.clock.standstill.since, engine.clock.standstill.events);
    assert_eq!(standstill(other), standstill(engine), "{name}");
    assert_eq!(other.neighbours.search(), engine.neighbours.search(), "{name}");
    assert!(domains.work.windows > 20, "{name}: {:?}", domains.work);
    // With the usual halo, no particle leaves its domain before it is handed over.
    assert!(halo.margin < WIDE.margin || domains.work.uncovered == 0, "{name}: {:?}", domains.work);
    domains.work
}

/// The expanding cluster is searched with lists at first, and with cells later.
#[test]
fn domains_change_the_search_when_a_cluster_expands() {
    for boundary in [Boundary::Periodic, Boundary::OPEN] {
        let fill = Fill::new(Lattice::FaceCentredCubic, "A").count(2_048);
        let scene = SceneBuilder::new("cluster")
            .space(Space { boundary: [boundary; 3], ..Space::periodic_cube(80.0) })
            .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A").restitution(0.95))
            .fill(fill.region(Vector::repeat(34.0), Vector::repeat(46.0)))
            .temperature(1.3)
            .build()
            .unwrap();
        let first = begun::<false, false>(&scene).neighbours.search();
        let until = Until::time(12.0);
        let one = advance::<false, false>(&scene, until, None);
        assert!(matches!(first, Search::Lists { .. }), "{first:?}");
        assert_eq!(one.engine.neighbours.search(), Search::Cells, "{boundary:?}");
        for count in [2, 3] {
            let name = format!("{boundary:?} {count}");
            let work = compare_with(&one, &scene, &name, until, Team::new(count, 2, None), WIDE);
            // The domains, not the single engine, ran the system before and after the change.
            assert!(work.serial == 0 && work.cuts >= 2, "{name}: {work:?}");
        }
    }
}

#[test]
fn multiple_processes_match_one_engine_bitwise() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let dense = spheres(hard(), 0.45, 4_000).build().unwrap();
    let one = advance::<false, false>(&dense, Until::events(20_000), None);
    for (processes, each, halo) in [(2, 1, WIDE), (3, 2, WIDE), (2, 2, THIN), (5, 1, WIDE)] {
        let work = in_processes(processes, |communicator| {
            let team = Team::new(each, 1, Some(communicator));
            compare_with(&one, &dense, &format!("{processes} x {each}"), Until::events(20_000), team, halo)
        });
        let undone = |work: &DomainWork| (work.windows, work.differences, work.uncovered, work.steps);
        assert!(work.iter().all(|one| undone(one) == undone(&work[0])), "{work:?}");
        assert!(halo.margin > 0.0 || work[0].differences > 5, "{work:?}");
    }
    let small = spheres(hard(), 0.2, 1_000).build().unwrap();
    let one = advance::<false, false>(&small, Until::events(75_000), None);
    assert!(one.engine.clock.epochs > 10, "{}", one.engine.clock.epochs);
    in_processes(2, |communicator| {
        let team = Team::new(1, 1, Some(communicator));
        compare_with(&one, &small, "small", Until::events(75_000), team, WIDE)
    });
    let mixture = bathed(mixture(), 0.2);
    let one = advance::<false, true>(&mixture, Until::time(3.0), None);
    for (processes, each) in [(2, 1), (4, 2)] {
        in_processes(processes, |communicator| {
            let team = Team::new(each, 1, Some(communicator));
            compare_with(&one, &mixture, &format!("{processes} x {each}"), Until::time(3.0), team, WIDE)
        });
    }
}

/// Spheres whose contacts also change spins.
fn rough(packing_fraction: f64, count: u64) -> Scene {
    let mut scene = spheres(Potential::hard_sphere(1.0).unwrap(), packing_fraction, count);
    let law = scene.interactions.remove(0);
    scene.interaction(law.tangential_restitution(0.4).friction(0.3)).build().unwrap()
}

const WIDE: Halo = HALO;
/// A halo without slack or margin: errors of copies reach owned particles within a window.
const THIN: Halo = Halo { slack: 0.0, margin: 0.0 };

#[test]
fn domains_match_one_engine_bitwise() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let (thin, dense) = (spheres(hard(), 0.1, 4_000).build().unwrap(), spheres(hard(), 0.45, 4_000).build().unwrap());
    let events = Until::events(20_000);
    compare::<false, false>(&thin, "cells", events, (&[2, 3, 8], WIDE));
    compare::<false, false>(&dense, "lists", events, (&[2, 3, 8], WIDE));
    compare::<false, true>(&mixture().build().unwrap(), "mixture", Until::time(3.0), (&[1, 2, 5, 13], WIDE));
    // This run has many epochs.
    let small = spheres(hard(), 0.45, 1_000).build().unwrap();
    compare::<false, false>(&small, "small", Until::events(75_000), (&[2, 3], WIDE));
    let boundary = [Boundary::walls(0.9); 3];
    let walls = |builder: SceneBuilder, size| builder.space(Space { boundary, ..Space::periodic_cube(size) });
    let falling = walls(mixture(), 14.0).gravity(Vector::new(0.0, 0.1, -0.4)).build().unwrap();
    compare::<true, true>(&falling, "falling", Until::time(2.0), (&[2, 7], WIDE));
    let flat = [Boundary::Periodic, Boundary::walls(1.0), Boundary::Flat];
    let disks = SceneBuilder::new("disks")
        .space(Space { boundary: flat, size: Vector::new(60.0, 20.0, 0.0), ..Space::periodic_cube(1.0) })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(hard()).between("A", "A").restitution(0.95))
        .fill(Fill::new(Arrangement::Random, "A").count(500))
        .temperature(1.3);
    compare::<false, false>(&disks.build().unwrap(), "disks", Until::time(3.0), (&[2, 5], WIDE));
}

/// The bonds can be much longer than the range of the neighbour search.
fn chains() -> SceneBuilder {
    let chain = Chain {
        species: "bead".into(),
        length: 8,
        count: 60,
        bond: "link".into(),
        spacing: Some(1.3),
        straight: None,
        temperature: Some(1.0),
        speed: None,
    };
    SceneBuilder::new("chains")
        .species(SpeciesDraft::new("bead").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("bead", "bead"))
        .interaction(InteractionDraft::new(Potential::bond(0.8, 2.6).unwrap()).named("link"))
        .space(Space { size: Vector::new(30.0, 9.0, 8.0), ..Space::periodic_cube(1.0) })
        .chain(chain)
}

fn bathed(builder: SceneBuilder, rate: f64) -> Scene {
    let bath = Thermostat::Andersen { temperature: 1.7, rate, axes: [true, false, true] };
    builder.run(RunPlan { thermostat: Some(bath), ..RunPlan::default() }).build().unwrap()
}

#[test]
fn domains_with_heat_bath_or_long_bonds_match_one_engine_bitwise() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    for (halo, counts) in [(WIDE, [1, 2, 3, 8]), (THIN, [1, 2, 5, 13])] {
        let halo = (&counts[..], halo);
        compare::<false, true>(&chains().build().unwrap(), "chains", Until::time(3.0), halo);
        compare::<false, true>(&bathed(chains(), 0.4), "chains in a bath", Until::time(2.0), halo);
        let events = Until::events(10_000);
        compare::<false, false>(&bathed(spheres(hard(), 0.45, 1_000), 0.3), "lists in a bath", events, halo);
        compare::<false, false>(&bathed(spheres(hard(), 0.1, 1_000), 3.0), "cells in a bath", events, halo);
        compare::<false, true>(&bathed(mixture(), 0.5), "mixture in a bath", Until::time(2.0), halo);
    }
}

fn advance_to<const FALLING: bool, const TABLE: bool>(
    engine: &mut Engine<FALLING, TABLE>,
    time: f64,
    domains: Option<&mut Domains<FALLING, TABLE>>,
) {
    let until = Until::time(time);
    match domains {
        None => assert_eq!(engine.advance(until, &mut None).unwrap(), Reason::Time),
        Some(domains) => {
            while domains.advance_for(engine, 10_000, until, &mut None).unwrap().is_none() {}
            domains.join(engine);
        }
    }
}

#[test]
fn domains_match_one_engine_bitwise_after_a_cold_start() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let well = Potential::square_well(1.0, 1.5, 1.0).unwrap();
    let cold =
        [spheres(hard(), 0.1, 300), spheres(well, 0.2, 64)].map(|builder| builder.temperature(0.0).build().unwrap());
    compare_cold::<false, false>(&cold[0]);
    compare_cold::<false, true>(&cold[1]);
}

/// Compares runs of a system at rest that gets a heat bath at once, within the first epoch, or after many epochs.
fn compare_cold<const FALLING: bool, const TABLE: bool>(scene: &Scene) {
    let bath = Bath { temperature: 1.0, rate: 1.0, axes: [true; 3] };
    for rest in [0.0, 0.3, 50.0, 5e4] {
        let run = |mut domains: Option<Domains<FALLING, TABLE>>| {
            let mut engine = Engine::<FALLING, TABLE>::new(scene);
            advance_to(&mut engine, rest, domains.as_mut());
            engine.set_bath(Some(bath), 7, 1);
            advance_to(&mut engine, rest + 8.0, domains.as_mut());
            assert!(engine.counts.executed > 1_000, "{}", engine.counts.executed);
            engine
        };
        let one = run(None);
        for domains in [2, 3] {
            let there = run(Some(Domains::with(Team::new(domains, 2, None), WIDE)));
            let name = format!("{domains} domains, at rest for {rest}");
            let all = |engine: &Engine<FALLING, TABLE>| (engine.snapshot(), engine.counts.totals, engine.clock.epochs);
            assert!(all(&there) == all(&one), "{name}");
            compare_records(&one, &there, &name);
        }
    }
}

#[test]
fn domains_with_tc_model_and_thermal_walls_match_one_engine_bitwise() {
    let space = Space { boundary: [Boundary::walls(0.9); 3], ..Space::periodic_cube(14.0) };
    let mut builder = mixture().space(space).contact_time(0.05);
    builder.interactions.iter_mut().for_each(|interaction| interaction.law = ContactLaw::smooth(0.8));
    let builder = builder.wall_temperatures(0, [Some(2.0), None]).wall_temperatures(2, [Some(0.5), Some(3.0)]);
    let (scene, until) = (builder.build().unwrap(), Until::time(5.0));
    let Run { engine, .. } = advance::<false, true>(&scene, until, None);
    let redrawn: u32 = engine.sources.surface_random.iter().flat_map(|random| &random.contacts).sum();
    assert!(engine.counts.totals.tc_altered > 100 && redrawn > 100, "{redrawn}");
    compare::<false, true>(&scene, "TC model", until, (&[2, 3, 7], WIDE));
    let work = compare::<false, true>(&scene, "TC model, thin halo", until, (&[2, 3, 5, 8], THIN));
    assert!(work.differences > 5, "{work:?}");
}

/// Pairs of particles that approach each other in separate lanes, in a box that is open along y. A pair is given by the
/// positions, relative to the middle of the lane, and the velocities of its particles.
fn lanes(boundary: Boundary, pair: impl Fn(f64) -> [(Vector, Vector); 2]) -> Scene {
    let mut scene = SceneBuilder::new("lanes")
        .space(Space { boundary: [boundary, Boundary::OPEN, boundary], ..Space::periodic_cube(24.0) })
        .species(SpeciesDraft::new("A").mass(0.7).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"));
    for lane in 0..256 {
        // The places are irregular, so that particles enter cells at different times.
        let place = |number: u32, part: f64| 1.5 + 1.4 * f64::from(number) + 0.3 * (f64::from(lane) * part).fract();
        let middle = Vector::new(place(lane % 16, 0.618_034), 12.0, place(lane / 16, 0.414_214));
        // Halves avoid events at round times. `check_window` counts an event at exactly the end of a window, but the
        // domains leave it to the next window.
        for (position, velocity) in pair(f64::from(lane) + 0.5) {
            scene = scene.particle("A", middle + position, velocity);
        }
    }
    scene.build().unwrap()
}

#[test]
fn gas_that_has_dispersed_ends_at_the_same_time_in_domains() {
    let run = |scene: &Scene, name: &str| {
        let one = advance::<false, false>(scene, Until::default(), None);
        assert_eq!((one.reason, one.events.len()), (Reason::Idle, 256), "{name}");
        [2, 3].map(|count| {
            let name = format!("{name}, {count} domains");
            compare_with(&one, scene, &name, Until::default(), Team::new(count, 2, None), WIDE).serial
        })
    };
    // All particles leave the cells at about the same time. Nothing is predicted then.
    let serial = std::array::from_fn::<_, 16, _>(|k| {
        let nearest = 4.0 + 0.25 * k as f64;
        let scene = lanes(Boundary::OPEN, |lane| {
            let away = |part: f64| Vector::y() * (nearest + 3.0 * (lane * part).fract());
            [(-away(0.618_034), Vector::y()), (away(0.414_214), -Vector::y())]
        });
        run(&scene, &format!("out of cells from {nearest}"))
    });
    // After many short windows, the single engine ends the run. At least one of the runs ends in the domains.
    assert!(serial.contains(&[0, 0]), "{serial:?}");
    // All particles recede from each other along y. They keep entering cells along x and z.
    let scene = lanes(Boundary::Periodic, |lane| {
        let middle = Vector::y() * (0.05 * (lane - 128.0));
        let velocity = Vector::new(0.917, 2.0 * middle.y, 0.643);
        let approach = Vector::y() * (1.025 + 1e-6 * lane);
        [-1.0, 1.0].map(|side| (middle + Vector::y() * (0.6 * side), velocity - approach * side))
    });
    assert_eq!(run(&scene, "apart"), [0, 0]);
}

#[test]
fn observer_can_stop_domains_at_any_event() {
    let scene = bathed(mixture(), 2.0);
    let (mut one, mut whole) = (begun::<false, true>(&scene), begun::<false, true>(&scene));
    let mut domains = Domains::with(Team::new(3, 2, None), WIDE);
    let mut baths = 0;
    for stretch in 0..60 {
        let (mut seen, mut seen_there) = (Vec::new(), Vec::new());
        let most = 1 + stretch * 37 % 800;
        let keep = |event: &Event, seen: &mut Vec<Event>| {
            seen.push(*event);
            if seen.len() == most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let end = Until::time(1e9);
        let reason = one.advance(end, &mut Some(&mut |event| keep(event, &mut seen))).unwrap();
        assert_eq!(reason, Reason::Observer);
        let mut see = |event: &Event| keep(event, &mut seen_there);
        while domains.advance_for(&mut whole, 1_000, end, &mut Some(&mut see)).unwrap().is_none() {}
        domains.settle(&mut whole);
        assert_eq!(seen_there, seen, "{stretch}");
        assert_eq!(whole.snapshot(), one.snapshot(), "{stretch}");
        assert_eq!(whole.counts.totals, one.counts.totals, "{stretch}");
        baths += usize::from(seen[most - 1].kind == EventKind::Thermostat);
    }
    assert!(baths > 5, "{baths}");
}

#[test]
fn wrong_windows_are_rolled_back() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let (thin, dense) = (spheres(hard(), 0.1, 4_000).build().unwrap(), spheres(hard(), 0.45, 4_000).build().unwrap());
    let events = Until::events(20_000);
    let work = [
        compare::<false, false>(&thin, "cells", events, (&[2, 8], THIN)),
        compare::<false, false>(&dense, "lists", events, (&[2, 8], THIN)),
        compare::<false, false>(&rough(0.45, 4_000), "rough", events, (&[2, 8], THIN)),
        compare::<false, true>(&mixture().build().unwrap(), "mixture", Until::time(3.0), (&[2, 3, 5, 8, 13], THIN)),
    ];
    assert!(work.iter().all(|work| work.differences > 5), "{work:?}");
    assert!(work.iter().map(|work| work.uncovered).sum::<u64>() > 5, "{work:?}");
}

/// Number of rounds. `CAROM_BARRIERS=10000 cargo test --release --lib barrier` compares more often.
fn rounds() -> usize {
    std::env::var("CAROM_BARRIERS").map_or(12, |rounds| rounds.parse().unwrap())
}

/// Compares owned particles with a single engine, and copies with their owners, after every hundred steps. Returns the
/// number of comparisons.
fn barriers<const FALLING: bool, const TABLE: bool>(scene: &Scene, name: &str, count: usize, halo: Halo) -> usize {
    let (mut one, mut whole) = (begun::<FALLING, TABLE>(scene), begun::<FALLING, TABLE>(scene));
    let mut domains = Domains::<FALLING, TABLE>::with(Team::new(count, 2, None), halo);
    let end = Until::time(f64::INFINITY);
    let mut compared = 0;
    for _ in 0..rounds() {
        assert_eq!(domains.advance_for(&mut whole, 100, end, &mut None).unwrap(), None, "{name}");
        let Some(cut) = &domains.cut else { continue };
        let time = one.clock.start + (whole.clock.epoch + cut.now);
        one.advance(Until { time: Some(time), ..end }, &mut None).unwrap();
        // Because of rounding, the two engines may stop at different times or in different epochs.
        if one.clock.epoch != whole.clock.epoch || one.since_epoch(time) != cut.now {
            continue;
        }
        compared += 1;
        for domain in &cut.domains {
            for particle in domain.engine.particles() {
                let held = domain.held[particle as usize];
                if domain.owned.has(particle) {
                    let there = one.state.number(domain.engine.state.bodies[particle as usize].id).unwrap();
                    assert_eq!(all_of(&domain.engine, particle), all_of(&one, there), "{name} {compared}");
                    assert_eq!(listed(&domain.engine, particle), listed(&one, there), "{name} {compared}");
                    continue;
                }
                let owner = &cut.domains[usize::from(held.owner)];
                let there = owner.here[held.whole as usize];
                assert!(owner.owned.has(there) && owner.held[there as usize].known_to & domain.bit != 0, "{name}");
                // Copies that lack some of their pairs are not compared.
                let captured = owner.engine.record(there).captured.unwrap_or_default();
                let here = |other: u32| domain.here[owner.held[other as usize].whole as usize];
                if captured.iter().all(|pair| here(pair.partner) != NO_PARTICLE) {
                    let copy = all_of(&domain.engine, particle);
                    assert_eq!(copy, all_of(&owner.engine, there), "{name} {compared}");
                }
            }
        }
    }
    compared
}

#[test]
fn domains_match_one_engine_and_copies_match_owners_at_each_barrier() {
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let (thin, dense) = (spheres(hard(), 0.1, 1_000).build().unwrap(), spheres(hard(), 0.45, 1_000).build().unwrap());
    // At this low density, flights are long. When an outdated contact is due, the partner may be far away.
    let rare = spheres(hard(), 0.005, 1_000).build().unwrap();
    let well = Potential::square_well(1.0, 1.5, 1.0).unwrap();
    let wells = spheres(well, 0.3, 1_000).build().unwrap();
    let bath = bathed(spheres(hard(), 0.45, 1_000), 0.3);
    for (halo, least) in [(WIDE, 40), (THIN, 2)] {
        let compared = [
            barriers::<false, false>(&thin, "cells", 3, halo),
            barriers::<false, false>(&rare, "rare", 2, halo),
            barriers::<false, false>(&rare, "rare", 3, halo),
            barriers::<false, false>(&dense, "lists", 3, halo),
            barriers::<false, true>(&mixture().build().unwrap(), "mixture", 5, halo),
            barriers::<false, true>(&wells, "wells", 4, halo),
            barriers::<false, true>(&chains().build().unwrap(), "chains", 3, halo),
            barriers::<false, true>(&chains().build().unwrap(), "chains in two", 2, halo),
            barriers::<false, false>(&dense, "lists in two", 2, halo),
            barriers::<false, false>(&bath, "bath", 3, halo),
            barriers::<false, false>(&rough(0.45, 1_000), "rough", 3, halo),
        ];
        println!("{compared:?}");
        assert!(compared.iter().all(|compared| compared * 60 > least * rounds()), "{compared:?}");
    }
}

#[test]
fn copy_with_unmatched_steps_is_resent_and_may_count_as_difference() {
    let scene = spheres(Potential::hard_sphere(1.0).unwrap(), 0.45, 4_000).build().unwrap();
    let mut engine = Engine::<false, false>::new(&scene);
    let mut domains = Domains::with(Team::new(2, 1, None), WIDE);
    let mut cut = domains.cut_up(&mut engine);
    let copies: Vec<u32> = cut.domains[1].engine.particles().filter(|&id| !cut.domains[1].owned.has(id)).collect();
    for (hash, readers, difference) in [(Some(7), 2, Some(0.5)), (Some(7), 1, None), (None, 2, None)] {
        cut.domains[1].begin_window();
        cut.domains[1].note(copies[3], hash, 0.5, readers);
        let compared = cut.domains[0].compare(&cut.regions, &cut.domains[1].reports(2));
        assert_eq!(compared.difference, difference);
        let whole = cut.domains[1].held[copies[3] as usize].whole;
        assert_eq!(compared.to_publish, [(cut.domains[0].here[whole as usize], 2)]);
    }
}

#[test]
fn absent_partners_are_found_by_their_ids_after_a_removal() {
    let mut engine =
        Engine::<false, false>::new(&spheres(Potential::hard_sphere(1.0).unwrap(), 0.45, 4_000).build().unwrap());
    let removed = engine.state.number(7).unwrap();
    engine.remove(&[removed]);
    let mut domains = Domains::with(Team::new(2, 1, None), WIDE);
    let mut cut = domains.cut_up(&mut engine);
    let particle = cut.domains[0].owned_particles().next().unwrap();
    let whole = cut.domains[0].held[particle as usize].whole;
    cut.domains[0].engine.schedule.predictions[particle as usize].partner = absent(2_000);
    domains.cut = Some(cut);
    domains.complete(&mut engine);
    let partner = engine.schedule.predictions[whole as usize].partner;
    assert_eq!(engine.state.bodies[partner as usize].id, 2_000);
}

#[test]
fn copies_that_differ_only_in_their_spin_are_noticed() {
    let mut engine = Engine::<false, false>::new(&rough(0.45, 1_000));
    let mut domains = Domains::with(Team::new(2, 1, None), WIDE);
    let mut cut = domains.cut_up(&mut engine);
    let domain = &mut cut.domains[1];
    let copy = domain.engine.particles().find(|&id| !domain.owned.has(id)).unwrap();
    let digests = [Vector::zeros(), Vector::z() * f64::MIN_POSITIVE].map(|spin| {
        domain.begin_window();
        domain.engine.state.spins[copy as usize] = spin;
        domain.note_contact(&cut.regions, copy, None, 0.5);
        domain.touched[domain.touch(copy).unwrap()].digest
    });
    assert!(digests[0] != 0 && digests[0] != digests[1], "{digests:?}");
}

#[test]
fn last_events_run_at_once_for_any_step_limit() {
    let scene = spheres(Potential::hard_sphere(1.0).unwrap(), 0.45, 4_000).build().unwrap();
    let until = Until::events(40_000);
    let mut one = begun::<false, false>(&scene);
    one.advance(until, &mut None).unwrap();
    let mut whole = begun::<false, false>(&scene);
    let mut domains = Domains::with(Team::new(2, 1, None), WIDE);
    let ends = (0..2_000).any(|_| domains.advance_for(&mut whole, 1, until, &mut None).unwrap().is_some());
    assert!(ends && domains.work.serial <= 2, "{:?}", domains.work);
    domains.settle(&mut whole);
    assert_eq!((whole.snapshot(), whole.counts.executed), (one.snapshot(), 40_000));
}
