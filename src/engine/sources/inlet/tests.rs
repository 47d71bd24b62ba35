use crate::Vector;
use crate::check::reference::{EventKind as ReferenceKind, Reference};
use crate::engine::event::{Event, EventKind, Other};
use crate::engine::neighbours::Search;
use crate::engine::{Chosen, Reason, Simulation, Until};
use crate::model::{FillRegion, Particle, Region, Scene, SpeciesId};
use std::collections::VecDeque;

/// A box with a floor that is an outlet, and two kinds of grains.
fn flow(seed: u32, inlet: &str, more: &str) -> Scene {
    Scene::from_toml(text_of_flow(seed, inlet, more), "flow.toml").unwrap()
}

/// Like [`flow`], with an individual diameter for each small grain.
fn flow_of_sizes(seed: u32, inlet: &str, more: &str) -> Scene {
    let distribution = "{ distribution = 'uniform', lower = 0.3, upper = 0.9 }, diameters = 'individual'";
    let text = text_of_flow(seed, inlet, more).replace("diameter = 0.6", &format!("diameter = {distribution}"));
    Scene::from_toml(text, "flow.toml").unwrap()
}

fn text_of_flow(seed: u32, inlet: &str, more: &str) -> String {
    format!(
        "
        seed = {seed}
        space = {{ size = [9.0, 7.0, 30.0], x = 'walls', y = 'walls', z = 'open' }}
        dynamics = {{ gravity = [0.0, 0.0, -1.0] }}
        species = [{{ name = 'grain', mass = 1.3, diameter = 1.0 }}, {{ name = 'small', mass = 0.7, diameter = 0.6 }}]
        interaction = [
            {{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.8 }},
            {{ species = ['grain', 'small'], potential = 'square-well', lambda = 1.4, well_depth = 0.3 }},
            {{ species = ['small', 'small'], potential = 'hard-sphere' }},
        ]
        surface = [
            {{ name = 'drain', shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }},
            {{ name = 'ball', shape = 'sphere', centre = [4.0, 3.0, 9.0], radius = 2.0, restitution = 0.9 }},
        ]
        inlet = [{{ {inlet} }}]
        run = {{ until_time = 40 }}
        {more}"
    )
}

const DROPS: &str = "composition = { grain = 1, small = 2 }, temperature = 0.2, \
    region = { lower = [1.0, 1.0, 24.0], upper = [8.0, 6.0, 29.0] }";

/// A rain of grains.
fn rain(more: &str, inlet: &str) -> Scene {
    flow(7, &format!("{DROPS}, {inlet}"), more)
}

/// The inlet's species and mass of a particle that enters.
fn newcomer(event: &Event) -> (SpeciesId, f64) {
    let Other::Inlet { inlet: 0, species } = event.other else { panic!("{event:?}") };
    let mass = event.impulse.dot(&event.after[0]) / event.after[0].norm_squared();
    assert!((event.impulse - event.after[0] * mass).norm() < 1e-12, "{event:?}");
    (species, mass)
}

fn events(scene: &Scene, until: f64) -> (Simulation, Vec<Event>) {
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    let mut events = Vec::new();
    simulation.advance_with(Until::time(until), |event| events.push(*event)).unwrap();
    (simulation, events)
}

#[test]
fn energy_and_momentum_of_a_flow_are_in_the_ledger() {
    for scene in [rain("", "rate = 6.0"), flow_of_sizes(7, &format!("{DROPS}, rate = 6.0"), "")] {
        check_ledger(scene);
    }
}

fn check_ledger(scene: Scene) {
    let mut simulation = Simulation::new(scene).unwrap();
    let mut brought = Vector::zeros();
    for time in [5.0, 11.0, 23.0, 40.0] {
        simulation
            .advance_with(Until::time(time), |event| {
                brought += if matches!(event.kind, EventKind::Entry) { event.impulse } else { Vector::zeros() }
            })
            .unwrap();
        let (energy, counts) = (simulation.energy(), simulation.event_counts());
        let balance = energy.total() + counts.dissipated.total() - counts.supplied.total();
        let scale = counts.supplied.total().abs() + energy.kinetic + energy.potential.abs();
        assert!(balance.abs() < 1e-12 * scale.max(1.0), "{time}: {balance} of {scale}");
        assert_eq!(simulation.snapshot().ids.len() as u64, counts.entry - counts.exit);
        assert_eq!(simulation.unsound_index(), None);
    }
    let counts = simulation.event_counts();
    assert_eq!(counts.entry, 241, "one grain at time 0, and six per unit of time");
    assert!(counts.exit > 150 && counts.core > 50 && counts.capture > 20, "{counts:?}");
    assert!(brought.norm() > 0.0);
}

/// Runs a scene in both engines, and asserts that their events agree. If the inlet has no new particles, also asserts
/// that particles return in the order in which they left. Returns the simulation at the end, and the number of exits.
fn compared_with_reference(scene: &Scene, until: f64) -> (Simulation, usize) {
    let (simulation, found) = events(scene, until);
    let mut alone = scene.clone();
    alone.inlets.clear();
    let mut reference = Reference::new(&alone).unwrap();
    let mut exits = 0;
    let mut kinds: Vec<(SpeciesId, f64)> =
        scene.particles.iter().map(|particle| (particle.species, scene.mass(particle))).collect();
    let (mut outside, mut returned) = (VecDeque::new(), 0);
    for event in &found {
        if let EventKind::Entry = event.kind {
            assert!(reference.step_before(event.time).is_none(), "{event:?}");
            let (id, mass) = newcomer(event);
            let species = &scene.species[id.0 as usize];
            let diameter = species.individual.as_ref().map(|_| species.diameter * libm::cbrt(mass / species.mass));
            assert!(diameter.is_some() || (mass - species.mass).abs() < 1e-12, "{event:?}");
            let particle = Particle { diameter, ..Particle::new(id, event.positions[0], event.after[0]) };
            assert_eq!(reference.insert(particle), event.particle);
            kinds.push((id, mass));
            if !scene.inlets[0].has_new_particles() {
                let (first, its_mass): (SpeciesId, f64) = outside.pop_front().unwrap();
                assert!(first == id && (its_mass / mass - 1.0).abs() < 1e-12, "{event:?}");
                returned += 1;
            }
            continue;
        }
        let expected = reference.step_before(until + 1.0).expect("an event");
        let who = [Some(event.particle), event.partner()];
        let same = [who, [who[1], who[0]]].contains(&[Some(expected.particle), expected.partner]);
        assert!(same && (event.time - expected.time).abs() < 1e-6, "{event:?} {expected:?}");
        if let EventKind::Exit = event.kind {
            exits += 1;
            outside.push_back(kinds[event.particle.0 as usize]);
            assert!(matches!(expected.kind, ReferenceKind::Exit { number: 0 }), "{expected:?}");
            assert!((event.before[0] - expected.before[0]).norm() < 1e-5);
            assert_eq!(event.after[0], Vector::zeros());
        }
    }
    let counts = simulation.inlets()[0];
    if !scene.inlets[0].has_new_particles() {
        assert_eq!((counts.returned, counts.waiting), (returned, outside.len() as u64));
    }
    (simulation, exits)
}

#[test]
fn flow_is_the_flow_of_the_reference_engine() {
    for (seed, inlet) in
        [(1, "rate = 3.0"), (2, "rate = 9.0"), (3, "rate = 5.0, keep = 20"), (4, "rate = 8.0, count = 60")]
    {
        // Round-off of the diameters grows fast.
        let unlike = flow_of_sizes(7, &format!("{DROPS}, {inlet}"), "");
        for (mut scene, until, fewest) in [(rain("", inlet), 14.0, 10), (unlike, 9.0, 3)] {
            scene.seed = seed;
            let (simulation, exits) = compared_with_reference(&scene, until);
            assert!(exits >= fewest, "{exits}");
            assert_eq!(simulation.unsound_index(), None);
        }
    }
}

#[test]
fn dense_flow_is_the_flow_of_the_reference_engine() {
    // These systems use neighbour lists, and the other tests use cells. In a dense system, small differences grow fast.
    // The runs are therefore short.
    for (potential, packing_fraction) in
        [("'hard-sphere'", 0.55), ("'square-well', lambda = 1.9, well_depth = 0.1", 0.3)]
    {
        let toml = format!(
            "
            seed = 5
            space = {{ size = [6.0, 6.0, 20.0], x = 'walls', y = 'walls', z = {{ lower = 'wall', upper = 'open' }} }}
            dynamics = {{ gravity = [0.0, 0.0, -0.5] }}
            species = [{{ name = 'atom', mass = 1.3, diameter = 1.0 }}]
            interaction = [{{ species = ['atom', 'atom'], potential = {potential} }}]
            surface = [{{ name = 'drain', shape = 'disc', centre = [3.0, 3.0, 0.2], axis = [0.0, 0.0, 1.0], radius = 2.7, outlet = true }}]
            fill = [{{ species = 'atom', arrangement = 'fcc', packing_fraction = {packing_fraction}, region = {{ lower = [0.0, 0.0, 0.5], upper = [6.0, 6.0, 8.0] }}, temperature = 1.0 }}]
            inlet = [{{ species = 'atom', region = {{ lower = [0.0, 0.0, 11.0], upper = [6.0, 6.0, 18.0] }}, velocity = [0.0, 0.0, -12.0], temperature = 0.1, rate = 60.0 }}]
            run = {{ until_time = 9 }}"
        );
        let (simulation, exits) = compared_with_reference(&Scene::from_toml(&toml, "dense.toml").unwrap(), 0.4);
        let entries = simulation.event_counts().entry;
        assert!(exits > 5 && entries > 15, "{potential}: {exits} {entries}");
        let search = with_engine!(&simulation.engine, engine => engine.neighbours.search());
        assert!(matches!(search, Search::Lists { .. }), "{potential}: {search:?}");
        assert_eq!(simulation.unsound_index(), None);
    }
}

#[test]
fn pairs_with_many_particles_that_enter_are_captured() {
    // The engine searches cells from the start. Nothing leaves, because an exit would create all tables anew.
    let toml = "
        space = { size = [12.0, 12.0, 12.0], x = 'walls', y = 'walls', z = 'walls' }
        species = [{ name = 'atom', mass = 1.3, diameter = 1.0 }]
        interaction = [{ species = ['atom', 'atom'], potential = 'square-well', lambda = 1.5, well_depth = 2.0 }]
        fill = [{ species = 'atom', arrangement = 'random', count = 100, temperature = 1.0 }]
        inlet = [{ species = 'atom', region = { lower = [0.0, 0.0, 0.0], upper = [12.0, 12.0, 12.0] }, temperature = 1.0, rate = 100.0 }]
        run = { until_time = 3 }";
    let (simulation, exits) = compared_with_reference(&Scene::from_toml(toml, "gas.toml").unwrap(), 1.0);
    assert_eq!((simulation.event_counts().entry, exits), (101, 0));
    with_engine!(&simulation.engine, engine => {
        assert_eq!(engine.neighbours.search(), Search::Cells);
        let is_captured = |particle: u32| !engine.pairs.states.of(particle).is_empty();
        assert!(engine.particles().filter(|particle| *particle >= 100 && is_captured(*particle)).count() > 10);
    });
}

#[test]
fn grains_that_enter_touch_no_surface() {
    let mut scene = rain("", "rate = 9.0");
    // The region contains the drain and the ball.
    scene.inlets[0].region = FillRegion::Box(Region { lower: Vector::zeros(), upper: Vector::new(9.0, 7.0, 13.0) });
    let (_, all) = events(&scene, 30.0);
    let entries: Vec<&Event> = all.iter().filter(|event| event.kind == EventKind::Entry).collect();
    assert!(entries.len() > 200, "{}", entries.len());
    for event in entries {
        let (place, is_large) = (event.positions[0], (event.impulse - event.after[0] * 1.3).norm() < 1e-12);
        let radius = if is_large { 0.5 } else { 0.3 };
        let from_ball = (place - Vector::new(4.0, 3.0, 9.0)).norm() - 2.0;
        assert!(place.z - 1.0 > radius && from_ball > radius, "{event:?}");
    }
}

#[test]
fn all_waiting_grains_enter_when_there_is_room() {
    // At first, a large sphere covers the region. It leaves with the velocity 4.
    let toml = "
        space = { size = [20.0, 20.0, 20.0], x = 'walls', y = 'walls', z = 'walls' }
        species = [{ name = 'large', mass = 7.0, diameter = 8.0 }, { name = 'small', mass = 0.3, diameter = 0.5 }]
        interaction = [
            { species = ['large', 'small'], potential = 'hard-sphere' },
            { species = ['small', 'small'], potential = 'hard-sphere' },
        ]
        particle = [{ species = 'large', position = [10.0, 10.0, 10.0], velocity = [4.0, 0.0, 0.0] }]
        inlet = [{ species = 'small', region = { shape = 'sphere', centre = [10.0, 10.0, 10.0], radius = 2.0 }, rate = 10.0, count = 16 }]
        run = { until_time = 3 }";
    let (simulation, all) = events(&Scene::from_toml(toml, "covered.toml").unwrap(), 3.0);
    let times: Vec<f64> = all.iter().filter(|event| event.kind == EventKind::Entry).map(|event| event.time).collect();
    assert_eq!((times.len(), simulation.inlets()[0].waiting), (16, 0));
    let at_once = |time: f64| times.iter().filter(|other| **other == time).count();
    // The sphere begins to uncover the region at 0.56. All 16 particles are due at 1.5.
    assert!(times[0] > 0.56 && times.iter().any(|time| at_once(*time) >= 4), "{times:?}");
}

#[test]
fn pauses_and_copies_do_not_change_a_flow() {
    let unlike = [flow_of_sizes(7, &format!("{DROPS}, rate = 7.0, keep = 40"), ""), flow_of_sizes(2, NARROW, FILL)];
    for scene in [rain("", "rate = 7.0, keep = 40"), mill(WIDE), mill(NARROW)].into_iter().chain(unlike) {
        check_pauses(scene);
    }
}

fn check_pauses(scene: Scene) {
    let (whole, all) = events(&scene, 30.0);
    let mut paused = Simulation::new(scene.clone()).unwrap();
    let mut seen = Vec::new();
    let mut steps = 1;
    loop {
        let reason = paused.advance_for_with(steps, Until::time(30.0), |event| seen.push(*event)).unwrap();
        steps = steps % 97 + 1;
        let bytes = postcard::to_stdvec(&paused).unwrap();
        paused = postcard::from_bytes(&bytes).unwrap();
        assert_eq!(paused.unsound_index(), None);
        if reason.is_some() {
            break;
        }
    }
    assert_eq!(seen, all);
    assert_eq!(paused.snapshot(), whole.snapshot());
    assert_eq!(paused.event_counts(), whole.event_counts());
    let mut one_by_one = Simulation::new(scene).unwrap();
    let each: Vec<Event> = one_by_one.events(Until::time(30.0)).map(Result::unwrap).collect();
    assert_eq!(each, all);
}

#[test]
fn grains_wait_for_a_place_and_the_inlet_catches_up() {
    // The region has room for one grain, which needs a time of 1 to leave it.
    let toml = |more: &str| {
        let toml = format!(
            "
            space = {{ size = [3.0, 3.0, 20.0], x = 'walls', y = 'walls', z = 'open' }}
            species = [{{ name = 'grain', mass = 1.0, diameter = 1.0 }}]
            interaction = [{{ species = ['grain', 'grain'], potential = 'hard-sphere' }}]
            surface = [{{ shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }}]
            inlet = [{{ species = 'grain', region = {{ lower = [1.0, 1.0, 18.0], upper = [2.0, 2.0, 19.0] }}, velocity = [0.0, 0.0, -1.0], {more} }}]
            run = {{ until_time = 40 }}"
        );
        Simulation::new(Scene::from_toml(&toml, "pipe.toml").unwrap()).unwrap()
    };
    let mut free = toml("rate = 0.5");
    free.advance(Until::time(20.5)).unwrap();
    let counts = free.inlets()[0];
    assert_eq!((counts.entered, counts.waiting, counts.blocked), (11, 0, 0));
    // The first grain has travelled 17 lengths when it touches the drain at a height of 1.5.
    assert_eq!(free.event_counts().exit, 2);

    let mut crowded = toml("rate = 4.0, count = 20");
    crowded.advance(Until::time(4.9)).unwrap();
    let counts = crowded.inlets()[0];
    // A grain finds a place when the previous one has travelled by more than a diameter, at the fifth attempt.
    assert_eq!((counts.entered, counts.waiting), (4, 16));
    assert!(counts.blocked >= 12, "{counts:?}");
    crowded.advance(Until::time(60.0)).unwrap();
    assert_eq!((crowded.inlets()[0].entered, crowded.inlets()[0].waiting, crowded.event_counts().exit), (20, 0, 20));
    assert_eq!(crowded.snapshot().ids.len(), 0);

    let mut kept = toml("rate = 10.0, keep = 6");
    kept.advance(Until::time(40.0)).unwrap();
    assert_eq!(kept.snapshot().ids.len(), 6);
    assert!(kept.event_counts().exit > 5);
    let mut late = toml("rate = 0.5, from = 3.0, until = 7.5");
    late.advance(Until::time(2.9)).unwrap();
    assert_eq!(late.event_counts().entry, 0);
    late.advance(Until::time(20.0)).unwrap();
    assert_eq!(late.event_counts().entry, 3);
}

#[test]
fn spins_and_moving_outlets_are_in_the_ledger() {
    let toml = "
        seed = 3
        space = { size = [8.0, 8.0, 40.0], x = 'walls', y = 'walls', z = 'open' }
        dynamics = { gravity = [0.0, 0.1, -1.0], contact_time = 1e-4 }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.8, friction = 0.4 }]
        surface = [
            { name = 'drain', shape = 'disc', centre = [4.0, 4.0, 2.0], axis = [0.0, 0.0, 1.0], radius = 9.0, outlet = true,
              motion = [{ kind = 'oscillation', amplitude = [0.0, 0.0, 1.0], frequency = 0.3 }] },
            { name = 'ball', shape = 'sphere', centre = [4.0, 3.0, 12.0], radius = 2.0, friction = 0.5 },
        ]
        inlet = [{ species = 'grain', region = { shape = 'sphere', centre = [4.0, 4.0, 30.0], radius = 3.0 }, rate = 5.0 }]
        run = { until_time = 40 }";
    let mut simulation = Simulation::new(Scene::from_toml(toml, "rough.toml").unwrap()).unwrap();
    let (mut spin, mut brought) = (Vector::zeros(), Vector::zeros());
    let mut see = |event: &Event| {
        if event.kind == EventKind::Exit {
            spin += event.torques[0];
            brought += event.impulse - event.after[0] * 1.3 + event.before[0] * 1.3;
        }
    };
    simulation.advance_with(Until::time(40.0), &mut see).unwrap();
    let (energy, counts) = (simulation.energy(), simulation.event_counts());
    let balance = energy.total() + counts.dissipated.total() - counts.supplied.total();
    assert!(balance.abs() < 1e-11 * counts.supplied.total().abs(), "{balance}");
    assert!(counts.exit > 100 && energy.rotational > 0.0 && spin.norm() > 0.0, "{counts:?}");
    assert!(brought.norm() < 1e-9, "each impulse is the momentum that leaves: {brought}");
    assert_eq!(simulation.unsound_index(), None);
}

#[test]
fn bath_acts_on_the_particles_that_are_there() {
    let toml = "
        space = { size = [20.0, 20.0, 20.0], x = 'walls', y = 'walls', z = 'walls' }
        species = [{ name = 'atom', mass = 1.3, diameter = 0.2 }]
        interaction = [{ species = ['atom', 'atom'], potential = 'hard-sphere' }]
        surface = [{ shape = 'sphere', centre = [10.0, 10.0, 10.0], radius = 3.0, outlet = true }]
        inlet = [{ species = 'atom', region = { lower = [0.0, 0.0, 0.0], upper = [4.0, 20.0, 20.0] }, rate = 40.0, keep = 100 }]
        run = { until_time = 400, thermostat = { kind = 'andersen', temperature = 1.0, rate = 0.5 } }";
    let scene = Scene::from_toml(toml, "sink.toml").unwrap();
    let mut simulation = Simulation::new(scene).unwrap();
    simulation.advance(Until::time(40.0)).unwrap();
    let before = simulation.event_counts().thermostat;
    let mut present = 0.0;
    for k in 0..360 {
        simulation.advance(Until::time(40.0 + f64::from(k))).unwrap();
        present += simulation.snapshot().ids.len() as f64 / 360.0;
    }
    let counts = simulation.event_counts();
    // Collisions form a Poisson process. In a time of 359, their mean number is 0.5 N t.
    let (found, expected) = ((counts.thermostat - before) as f64, 0.5 * present * 359.0);
    assert!((found - expected).abs() < 5.0 * expected.sqrt(), "{found} {expected}");
    assert!(counts.exit > 100 && present > 90.0, "{} {present}", counts.exit);
}

#[test]
fn last_particles_enter_after_all_are_due_at_any_rate() {
    // At these rates, times of attempts are rounded in all ways.
    for rate in [0.1, 0.3, 0.7, 1.1, 3.0, 7.0, 49.0, 1e3 / 3.0] {
        let toml = format!(
            "
            space = {{ size = [3.0, 3.0, 20.0], x = 'walls', y = 'walls', z = 'open' }}
            species = [{{ name = 'grain', mass = 1.0, diameter = 1.0 }}]
            interaction = [{{ species = ['grain', 'grain'], potential = 'hard-sphere' }}]
            surface = [{{ shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }}]
            inlet = [{{ species = 'grain', region = {{ lower = [1.0, 1.0, 18.0], upper = [2.0, 2.0, 19.0] }}, velocity = [0.0, 0.0, -0.37], rate = {rate}, count = 30 }}]
            run = {{ until_time = 40 }}"
        );
        let mut simulation = Simulation::new(Scene::from_toml(&toml, "pipe.toml").unwrap()).unwrap();
        let until = 400.0 + 30.0 / rate;
        while simulation.time() < until {
            let before = simulation.inlets()[0].blocked;
            assert!(simulation.advance_for(1_000, Until::time(until)).is_ok());
            let most = 1_000.0 + rate * 4.0;
            assert!(simulation.inlets()[0].blocked as f64 - before as f64 <= most, "{rate}");
        }
        assert_eq!((simulation.inlets()[0].entered, simulation.event_counts().exit), (30, 30), "{rate}");
    }
}

#[test]
fn composition_does_not_depend_on_who_finds_a_place() {
    // Small grains find a place more often than large ones.
    let toml = "
        seed = 11
        space = { size = [6.0, 6.0, 30.0], x = 'walls', y = 'walls', z = 'open' }
        species = [{ name = 'large', mass = 8.0, diameter = 2.0 }, { name = 'small', mass = 1.0, diameter = 0.5 }]
        interaction = [
            { species = ['large', 'large'], potential = 'hard-sphere' },
            { species = ['large', 'small'], potential = 'hard-sphere' },
            { species = ['small', 'small'], potential = 'hard-sphere' },
        ]
        surface = [{ shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }]
        inlet = [{ composition = { large = 1, small = 3 }, region = { lower = [0.0, 0.0, 25.0], upper = [6.0, 6.0, 27.5] }, velocity = [0.0, 0.0, -1.0], rate = 500.0 }]
        run = { until_time = 400 }";
    let mut simulation = Simulation::new(Scene::from_toml(toml, "crowd.toml").unwrap()).unwrap();
    let (mut large, mut all) = (0.0, 0.0);
    let mut see = |event: &Event| {
        if event.kind == EventKind::Entry {
            all += 1.0;
            large += f64::from(u8::from((event.impulse.z / event.after[0].z - 8.0).abs() < 1e-9));
        }
    };
    simulation.advance_with(Until::time(80.0), &mut see).unwrap();
    let counts = simulation.inlets()[0];
    assert!(counts.blocked > 4_000 && counts.waiting > 20_000 && all > 400.0, "{counts:?}");
    let (found, expected) = (large / all, 0.25);
    let error = (expected * (1.0 - expected) / all).sqrt();
    assert!((found - expected).abs() < 5.0 * error, "{found} +- {error} of {all}");
}

#[test]
fn diameters_of_new_grains_have_the_distribution_of_their_species() {
    // Small grains find a place more often than large ones.
    let toml = |distribution: &str| {
        format!(
            "
            seed = 12
            space = {{ size = [6.0, 6.0, 30.0], x = 'walls', y = 'walls', z = 'open' }}
            species = [{{ name = 'grain', mass = 1.3, diameter = {{ {distribution} }}, diameters = 'individual' }}]
            interaction = [{{ species = ['grain', 'grain'], potential = 'hard-sphere' }}]
            surface = [{{ shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }}]
            inlet = [{{ species = 'grain', region = {{ lower = [0.0, 0.0, 25.0], upper = [6.0, 6.0, 27.5] }}, velocity = [0.0, 0.0, -1.0], rate = 500.0 }}]
            run = {{ until_time = 400 }}"
        )
    };
    for distribution in [
        "distribution = 'power-law', exponent = 3.0, lower = 0.5, upper = 2.0",
        "distribution = 'list', diameters = [1.7, 0.6, 1.1], shares = [1.0, 2.0, 0.5]",
    ] {
        let scene = Scene::from_toml(toml(distribution), "crowd.toml").unwrap();
        let species = scene.species[0].clone();
        let mut simulation = Simulation::new(scene).unwrap();
        let mut diameters = Vec::new();
        let mut see = |event: &Event| {
            if event.kind == EventKind::Entry {
                diameters.push(species.diameter * libm::cbrt(newcomer(event).1 / species.mass));
            }
        };
        simulation.advance_with(Until::time(40.0), &mut see).unwrap();
        assert!(simulation.inlets()[0].blocked > 2_000 && diameters.len() > 200, "{:?}", simulation.inlets());
        assert_eq!(simulation.real_overlaps(), []);
        let own = species.individual.unwrap().distribution.unwrap();
        let count = diameters.len() as f64;
        for power in 1..=3_i32 {
            let expected = own.mean_of(|diameter| libm::pow(diameter, f64::from(power)));
            let square = own.mean_of(|diameter| libm::pow(diameter, f64::from(2 * power)));
            let found = diameters.iter().map(|diameter| libm::pow(*diameter, f64::from(power))).sum::<f64>() / count;
            let error = ((square - expected * expected) / count).sqrt();
            assert!((found - expected).abs() < 4.0 * error, "{distribution} {power}: {found} {expected} +- {error}");
        }
    }
}

#[test]
fn queue_and_search_follow_the_number_of_particles() {
    let mut simulation = Simulation::new(rain("", "rate = 60.0, keep = 300")).unwrap();
    let mut sizes = Vec::new();
    for time in [1.0, 20.0, 40.0] {
        simulation.advance(Until::time(time)).unwrap();
        let particles = simulation.snapshot().ids.len();
        with_engine!(&simulation.engine, engine => {
            assert!(time < 10.0 || engine.schedule.queue.fits(engine.state.moving), "{particles} at {time}");
            assert!(time < 10.0 || engine.state.count_when_sorted > particles / 3, "{} of {particles} at {time}", engine.state.count_when_sorted);
            sizes.push(engine.schedule.queue.target());
        });
    }
    assert!(sizes[2] >= 8 * sizes[0], "{sizes:?}");
}

const FILL: &str = "fill = [{ composition = { grain = 1, small = 2 }, count = 60, arrangement = 'random', \
    temperature = 1.0, region = { lower = [1.0, 1.0, 12.0], upper = [8.0, 6.0, 23.0] } }]";

/// Grains fall from a fill, and return at an inlet with the region and settings in `inlet`.
fn mill(inlet: &str) -> Scene {
    flow(2, inlet, FILL)
}

/// At this inlet, few grains have to wait.
const WIDE: &str =
    "region = { lower = [1.0, 1.0, 24.0], upper = [8.0, 6.0, 29.0] }, temperature = 0.2, recirculate = ['drain']";

/// At this inlet, many grains wait for a free place.
const NARROW: &str = "region = { lower = [2.0, 2.0, 24.0], upper = [4.0, 4.0, 25.2] }, velocity = [0.0, 0.0, -0.5], recirculate = ['drain']";

#[test]
fn circulating_flow_is_the_flow_of_the_reference_engine() {
    for (seed, inlet, until) in [(1, WIDE, 9.0), (2, WIDE, 9.0), (3, NARROW, 9.0), (4, NARROW, 9.0)] {
        for mut scene in [mill(inlet), flow_of_sizes(2, inlet, FILL)] {
            scene.seed = seed;
            let (simulation, exits) = compared_with_reference(&scene, until);
            let counts = simulation.inlets()[0];
            assert!(exits > 40 && counts.returned >= 20, "{exits} {counts:?}");
            assert_eq!(counts.waiting > 10, inlet == NARROW, "{counts:?}");
            assert_eq!(simulation.unsound_index(), None);
        }
    }
}

#[test]
fn circulation_conserves_the_composition() {
    for inlet in [WIDE, NARROW] {
        let mut simulation = Simulation::new(mill(inlet)).unwrap();
        let species = |simulation: &Simulation| -> [usize; 2] {
            let snapshot = simulation.snapshot();
            [0, 1].map(|kind| snapshot.species.iter().filter(|id| id.0 == kind).count())
        };
        let at_start = species(&simulation);
        assert_eq!(at_start, [20, 40]);
        let (mut returned, mut least) = (0, 60);
        for part in 1..=40_u32 {
            simulation.advance(Until::time(f64::from(part))).unwrap();
            let counts = simulation.inlets()[0];
            let present = simulation.snapshot().ids.len();
            assert_eq!(present as u64 + counts.waiting, 60, "{part}: {counts:?}");
            let lacking: Vec<usize> = at_start.iter().zip(species(&simulation)).map(|(all, here)| all - here).collect();
            with_engine!(&simulation.engine, engine => {
                let waiting = &engine.sources.inlets.as_ref().unwrap().list[0].returning;
                assert_eq!(lacking, [0, 1].map(|kind| waiting.iter().filter(|it| it.species.0 == kind).count()));
            });
            assert!(counts.returned >= returned && counts.returned == counts.entered);
            (returned, least) = (counts.returned, least.min(present));
            assert_eq!(simulation.unsound_index(), None);
        }
        let (energy, counts) = (simulation.energy(), simulation.event_counts());
        let balance = energy.total() + counts.dissipated.total() - counts.supplied.total();
        let initial = Simulation::new(mill(inlet)).unwrap().energy().total();
        // Round-off of a sum of some hundred energies.
        let scale = counts.supplied.total().abs() + energy.kinetic + energy.potential.abs();
        assert!((balance - initial).abs() < 1e-12 * scale, "{balance} {initial}");
        assert!(returned > 100 && (least < 50) == (inlet == NARROW), "{returned} {least}");
    }
}

#[test]
fn new_grains_and_grains_that_return_enter_at_the_same_inlet() {
    let more = "rate = 2.0, count = 30, composition = { grain = 1, small = 1 }";
    let mut simulation = Simulation::new(mill(&format!("{WIDE}, {more}"))).unwrap();
    for time in [1.1, 12.2, 40.0] {
        simulation.advance(Until::time(time)).unwrap();
        let counts = simulation.inlets()[0];
        let new = counts.entered - counts.returned;
        assert_eq!(simulation.snapshot().ids.len() as u64 + simulation.event_counts().exit, 60 + counts.entered);
        // One grain is due at time 0, and then two in a unit of time. Grains return from 4 on.
        let expected = (2.0 * time).floor() + 1.0;
        assert_eq!((new as f64, counts.waiting), (expected.min(30.0), 0), "{time}: {counts:?}");
    }
    assert!(simulation.inlets()[0].returned > 300, "{:?}", simulation.inlets());
}

#[test]
fn grain_that_leaves_returns_at_once_with_a_new_id() {
    let toml = "
        space = { size = [8.0, 8.0, 30.0], x = 'walls', y = 'walls', z = 'open' }
        dynamics = { gravity = [0.0, 0.0, -0.7] }
        species = [{ name = 'grain', mass = 1.3, diameter = 1.0 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere' }]
        surface = [
            { name = 'left', shape = 'disc', centre = [2.0, 4.0, 1.0], axis = [0.0, 0.0, 1.0], radius = 1.0, outlet = true },
            { name = 'right', shape = 'disc', centre = [6.0, 4.0, 1.0], axis = [0.0, 0.0, 1.0], radius = 1.0, outlet = true },
        ]
        inlet = [{ region = { shape = 'sphere', centre = [2.0, 4.0, 21.0], radius = 0.5 }, velocity = [0.0, 0.0, -0.5], recirculate = ['left'] }]
        particle = [{ species = 'grain', position = [2.0, 4.0, 9.0] }, { species = 'grain', position = [6.0, 4.0, 9.0] }]
        run = { until_time = 40 }";
    let (simulation, all) = events(&Scene::from_toml(toml, "fall.toml").unwrap(), 40.0);
    // From rest to a contact at a height of 1.5, and from the inlet with a speed of 0.5.
    let first = (2.0 * 7.5 / 0.7_f64).sqrt();
    let next = ((0.25 + 2.0 * 0.7 * 19.5_f64).sqrt() - 0.5) / 0.7;
    let round_off = 40.0 * 16.0 * f64::EPSILON;
    let exits: Vec<&Event> = all.iter().filter(|event| event.kind == EventKind::Exit).collect();
    let entries: Vec<&Event> = all.iter().filter(|event| event.kind == EventKind::Entry).collect();
    // Both grains leave at the same time. The grain on the right does not return.
    assert_eq!((exits.len(), entries.len()), (7, 6));
    assert!(exits[..2].iter().all(|event| (event.time - first).abs() < round_off), "{exits:?}");
    let of_left: Vec<&&Event> = exits.iter().filter(|event| event.particle.0 != 1).collect();
    for (number, (exit, entry)) in (0..).zip(of_left.iter().zip(&entries)) {
        assert_eq!((entry.time, entry.particle.0), (exit.time, 2 + number));
        assert!((exit.time - (first + f64::from(number) * next)).abs() < round_off, "{exit:?}");
        assert_eq!((entry.after[0], entry.positions[0]), (Vector::new(0.0, 0.0, -0.5), Vector::new(2.0, 4.0, 21.0)));
        assert_eq!(entry.other, Other::Inlet { inlet: 0, species: SpeciesId(0) });
    }
    assert_eq!((simulation.inlets()[0].returned, simulation.inlets()[0].waiting), (6, 0));
}

#[test]
fn grain_waits_until_the_previous_one_has_made_room() {
    // The region has room for one grain, which needs a time of 1 to leave it. Grains leave at 2.0 and 2.6.
    let toml = "
        space = { size = [3.0, 3.0, 20.0], x = 'walls', y = 'walls', z = 'open' }
        species = [{ name = 'grain', mass = 1.0, diameter = 1.0 }]
        interaction = [{ species = ['grain', 'grain'], potential = 'hard-sphere' }]
        surface = [{ name = 'drain', shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }]
        inlet = [{ region = { lower = [1.0, 1.0, 18.0], upper = [2.0, 2.0, 19.0] }, velocity = [0.0, 0.0, -1.0], recirculate = ['drain'] }]
        particle = [
            { species = 'grain', position = [2.4, 2.4, 3.5], velocity = [0.0, 0.0, -1.0] },
            { species = 'grain', position = [0.6, 0.6, 4.1], velocity = [0.0, 0.0, -1.0] },
        ]
        run = { until_time = 400 }";
    let (mut simulation, all) = events(&Scene::from_toml(toml, "pipe.toml").unwrap(), 2.95);
    assert_eq!(all.iter().filter(|event| event.kind == EventKind::Entry).count(), 1);
    // The grain is tried ten times while the previous one travels its diameter: at 2.6, 2.7, 2.8 and 2.9.
    let counts = simulation.inlets()[0];
    assert_eq!((counts.returned, counts.waiting, counts.blocked), (1, 1, 4));
    assert_eq!(simulation.snapshot().ids.len(), 1);
    let mut entries = Vec::new();
    let mut see = |event: &Event| entries.extend((event.kind == EventKind::Entry).then_some(event.time));
    simulation.advance_with(Until::time(400.0), &mut see).unwrap();
    assert!((3.0..3.1 + 1e-12).contains(&entries[0]), "{entries:?}");
    // From then on, the grains are so far apart that they return at once. A turn takes a time of 17.
    assert!(simulation.inlets()[0].blocked <= 5, "{:?}", simulation.inlets());
    assert!(entries.windows(3).all(|three| (three[2] - three[0] - 17.0).abs() < 1e-9), "{entries:?}");
    assert_eq!((simulation.inlets()[0].returned, simulation.inlets()[0].waiting), (1 + entries.len() as u64, 0));
}

#[test]
fn run_ends_if_nothing_can_leave() {
    let toml = "
        space = { size = [9.0, 9.0, 9.0], x = 'open', y = 'open', z = 'open' }
        species = [{ name = 'atom', mass = 1.0, diameter = 1.0 }]
        interaction = [{ species = ['atom', 'atom'], potential = 'hard-sphere' }]
        surface = [{ name = 'drain', shape = 'plane', point = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], outlet = true }]
        inlet = [{ region = { lower = [1.0, 1.0, 6.0], upper = [8.0, 8.0, 8.0] }, velocity = [0.0, 0.0, 1.0], recirculate = ['drain'] }]
        particle = [{ species = 'atom', position = [4.0, 4.0, 4.0], velocity = [0.0, 0.0, -1.0] }]
        run = { until_time = 400 }";
    let mut simulation = Simulation::new(Scene::from_toml(toml, "up.toml").unwrap()).unwrap();
    assert_eq!(simulation.advance(Until::default()), Ok(Reason::Idle));
    assert_eq!((simulation.event_counts().exit, simulation.inlets()[0].returned), (1, 1));
}
