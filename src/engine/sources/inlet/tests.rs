use crate::Vector;
use crate::check::reference::{EventKind as ReferenceKind, Reference};
use crate::engine::event::{Event, EventKind, Other};
use crate::engine::neighbours::Search;
use crate::engine::{Chosen, Simulation, Until};
use crate::model::{FillRegion, Particle, Region, Scene, SpeciesId};

/// A box with a floor that is an outlet, and a rain of two kinds of grains.
fn rain(more: &str, inlet: &str) -> Scene {
    let toml = format!(
        "
        seed = 7
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
        inlet = [{{ composition = {{ grain = 1, small = 2 }}, region = {{ lower = [1.0, 1.0, 24.0], upper = [8.0, 6.0, 29.0] }}, temperature = 0.2, {inlet} }}]
        run = {{ until_time = 40 }}
        {more}"
    );
    Scene::from_toml(&toml, "rain.toml").unwrap()
}

fn events(scene: &Scene, until: f64) -> (Simulation, Vec<Event>) {
    let mut simulation = Simulation::new(scene.clone()).unwrap();
    let mut events = Vec::new();
    simulation.advance_with(Until::time(until), |event| events.push(*event)).unwrap();
    (simulation, events)
}

#[test]
fn energy_and_momentum_of_a_flow_are_in_the_ledger() {
    let scene = rain("", "rate = 6.0");
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

/// Runs a scene in both engines, and asserts that their events agree. Returns the simulation at the end of the run, and
/// the number of exits.
fn compared_with_reference(scene: &Scene, until: f64) -> (Simulation, usize) {
    let (simulation, found) = events(scene, until);
    let mut alone = scene.clone();
    alone.inlets.clear();
    let mut reference = Reference::new(&alone).unwrap();
    let mut exits = 0;
    for event in &found {
        if let EventKind::Entry = event.kind {
            assert!(reference.step_before(event.time).is_none(), "{event:?}");
            let has_mass = |mass: f64| (event.impulse - event.after[0] * mass).norm() < 1e-12;
            let species = (0..).zip(&scene.species).find(|(_, species)| has_mass(species.mass)).unwrap().0;
            let id = reference.insert(Particle::new(SpeciesId(species), event.positions[0], event.after[0]));
            assert_eq!(id, event.particle);
            assert!(matches!(event.other, Other::Inlet(0)));
            continue;
        }
        let expected = reference.step_before(until + 1.0).expect("an event");
        let who = [Some(event.particle), event.partner()];
        let same = [who, [who[1], who[0]]].contains(&[Some(expected.particle), expected.partner]);
        assert!(same && (event.time - expected.time).abs() < 1e-6, "{event:?} {expected:?}");
        if let EventKind::Exit = event.kind {
            exits += 1;
            assert!(matches!(expected.kind, ReferenceKind::Exit { number: 0 }), "{expected:?}");
            assert!((event.before[0] - expected.before[0]).norm() < 1e-5);
            assert_eq!(event.after[0], Vector::zeros());
        }
    }
    (simulation, exits)
}

#[test]
fn flow_is_the_flow_of_the_reference_engine() {
    for (seed, inlet) in
        [(1, "rate = 3.0"), (2, "rate = 9.0"), (3, "rate = 5.0, keep = 20"), (4, "rate = 8.0, count = 60")]
    {
        let mut scene = rain("", inlet);
        scene.seed = seed;
        let (_, exits) = compared_with_reference(&scene, 14.0);
        assert!(exits > 10, "{exits}");
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
            inlet = [{{ species = 'atom', region = {{ lower = [0.0, 0.0, 11.0], upper = [6.0, 6.0, 18.0] }}, velocity = [0.0, 0.0, -12.0], temperature = 0.1, rate = 40.0 }}]
            run = {{ until_time = 9 }}"
        );
        let (simulation, exits) = compared_with_reference(&Scene::from_toml(&toml, "dense.toml").unwrap(), 0.6);
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
    let scene = rain("", "rate = 7.0, keep = 40");
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
    simulation.advance_with(Until::time(200.0), &mut see).unwrap();
    let counts = simulation.inlets()[0];
    assert!(counts.blocked > 10_000 && counts.waiting > 50_000 && all > 1_000.0, "{counts:?}");
    let (found, expected) = (large / all, 0.25);
    let error = (expected * (1.0 - expected) / all).sqrt();
    assert!((found - expected).abs() < 5.0 * error, "{found} +- {error} of {all}");
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
            assert!(time < 10.0 || engine.state.sorted > particles / 3, "{} of {particles} at {time}", engine.state.sorted);
            sizes.push(engine.schedule.queue.target());
        });
    }
    assert!(sizes[2] >= 8 * sizes[0], "{sizes:?}");
}
