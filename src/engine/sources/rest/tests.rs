use crate::Vector;
use crate::engine::columns::Order;
use crate::engine::neighbours::Search;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::parts::Engine;
use crate::engine::sources::list_rebuild::tests::are_complete;
use crate::engine::{Chosen, Reason, Simulation, Until};
use crate::model::{Particle, ParticleId, Scene, SpeciesId};

/// Grains of two sizes that fall into a box, fall asleep, and are woken by a large grain. With few grains, the engine
/// uses neighbour lists.
fn falling(grains: u32, side: f64) -> Scene {
    let toml = format!(
        "
        seed = 3
        space = {{ size = [{side}, {side}, 40.0], x = 'walls', y = 'walls', z = {{ lower = {{ restitution = 0.4, friction = 0.5 }}, upper = 'open' }} }}
        dynamics = {{ gravity = [0.0, 0.0, -1.0], contact_time = 0.005, sleep = {{ interval = 0.3, distance = 0.03, wake_speed = 0.3 }} }}
        species = [{{ name = 'A', mass = 1.3, diameter = 1.0 }}, {{ name = 'B', mass = 0.7, diameter = 0.8 }}]
        interaction = [
            {{ species = ['A', 'A'], potential = 'hard-sphere', restitution = 0.4, friction = 0.5 }},
            {{ species = ['A', 'B'], potential = 'hard-sphere', restitution = 0.4, friction = 0.5 }},
            {{ species = ['B', 'B'], potential = 'hard-sphere', restitution = 0.4, friction = 0.5 }},
        ]
        fill = [{{ composition = {{ A = 1, B = 1 }}, arrangement = 'random', count = {grains}, region = {{ lower = [0.0, 0.0, 0.0], upper = [{side}, {side}, 8.0] }}, temperature = 0.1 }}]
        particle = [{{ species = 'A', position = [1.4, 1.3, 39.0], velocity = [0.0, 0.0, 0.0] }}]
        run = {{ until_time = 20 }}"
    );
    Scene::from_toml(toml.as_str(), "falling.toml").unwrap()
}

/// Checks the neighbours of all particles against a test of all pairs.
fn finds_all_neighbours<const FALLING: bool, const TABLE: bool>(engine: &Engine<FALLING, TABLE>) {
    let distance = engine.sources.sleepers.as_ref().unwrap().plan.distance;
    let mut near = Candidates::default();
    for particle in engine.particles() {
        let place = engine.state_at(particle, engine.clock.now).0;
        engine.find_touching(particle, &place, distance, &mut near);
        let mut found = near.found().to_vec();
        found.sort_unstable();
        let touches = |&other: &u32| {
            let range = engine.ranges.at(usize::from(engine.row(particle)), usize::from(engine.row(other)));
            (engine.state_at(other, engine.clock.now).0 - place).norm() <= range + distance
        };
        let expected: Vec<u32> = engine.particles().filter(|&other| other != particle).filter(touches).collect();
        assert_eq!(found, expected, "{particle}");
    }
}

/// Checks that sleeping grains keep their places when the order in memory changes.
fn keeps_places(simulation: &mut Simulation) {
    with_engine!(&mut simulation.engine, engine => {
        let reversed: Vec<u32> = engine.particles().rev().collect();
        engine.permute(&Order::of(reversed.clone(), reversed.len()));
        let watched = &engine.sources.sleepers.as_ref().unwrap().watched;
        for particle in engine.particles().filter(|&particle| engine.is_asleep(particle)) {
            assert_eq!(watched[particle as usize].place, engine.state.bodies[particle as usize].position);
        }
    });
}

#[test]
fn lists_cells_and_indices_stay_complete_while_grains_sleep_and_wake() {
    for (grains, side) in [(25, 3.0), (90, 5.0)] {
        let mut simulation = Simulation::without_plan(falling(grains, side));
        let mut most = 0;
        for part in 1..=60 {
            simulation.advance(Until::time(f64::from(part) * 0.31)).unwrap();
            assert_eq!(simulation.unsound_index(), None, "{grains} {part}");
            most = most.max(simulation.sleeping().len());
            with_engine!(&simulation.engine, engine => {
                if let Some(verlet) = engine.neighbours.verlet() {
                    are_complete(engine, verlet);
                }
                finds_all_neighbours(engine);
            });
        }
        keeps_places(&mut simulation);
        assert!(most > grains as usize * 4 / 5, "{most} of {grains} slept");
        let counts = simulation.event_counts();
        assert!(counts.wake > 3, "the large grain wakes others: {}", counts.wake);
        assert_eq!(counts.rest - counts.wake, simulation.sleeping().len() as u64);
        assert_eq!(simulation.real_overlaps(), []);
    }
}

#[test]
fn neighbours_in_small_cells_are_found() {
    // Pairs of grains that almost touch, with a whole cell between them if the sides of cells are 6.05 / 6.
    let mut particles = String::new();
    for (row, layer) in (0..4).flat_map(|row| (0..5).map(move |layer| (row, layer))) {
        for x in [1.0, 2.02, 4.03, 5.05] {
            let (y, z) = (0.7 + 1.4 * f64::from(row), 0.6 + 1.1 * f64::from(layer));
            particles += &format!("{{ species = 'A', position = [{x}, {y}, {z}] }},");
        }
    }
    let toml = format!(
        "
        space = {{ size = [6.05, 6.05, 6.05], x = 'walls', y = 'walls', z = 'walls' }}
        dynamics = {{ gravity = [0.0, 0.0, -1.0], contact_time = 0.005, sleep = {{ interval = 0.3, distance = 0.03, wake_speed = 0.3 }} }}
        species = [{{ name = 'A', mass = 1.3, diameter = 1.0 }}]
        interaction = [{{ species = ['A', 'A'], potential = 'hard-sphere', restitution = 0.4 }}]
        particle = [{particles}]
        run = {{ until_time = 20 }}"
    );
    let simulation = Simulation::without_plan(Scene::from_toml(toml.as_str(), "pairs.toml").unwrap());
    assert_eq!(simulation.engine().search, Search::Cells);
    with_engine!(&simulation.engine, engine => finds_all_neighbours(engine));
}

/// Two grains that sleep side by side on a table. With many stones far away, the engine uses cells.
fn table(stones: u32) -> Simulation {
    let stones: String = (0..stones)
        .map(|k| format!("{{ species = 'stone', position = [{}, 1.0, 18.0] }},", 1.0 + 0.4 * f64::from(k)))
        .collect();
    let toml = format!(
        "
        space = {{ size = [20.0, 20.0, 20.0], x = 'open', y = 'open', z = 'open' }}
        dynamics = {{ gravity = [0.0, 0.0, -1.0], contact_time = 0.01, sleep = {{ interval = 5.0, distance = 0.01, wake_speed = 0.2 }} }}
        species = [{{ name = 'grain', mass = 1.3, diameter = 1.0 }}, {{ name = 'bullet', mass = 9.0, diameter = 1.0 }}, {{ name = 'stone', diameter = 1.0, static = true }}]
        interaction = [
            {{ species = ['grain', 'grain'], potential = 'hard-sphere', restitution = 0.6 }},
            {{ species = ['grain', 'bullet'], potential = 'hard-sphere', restitution = 0.6 }},
            {{ species = ['bullet', 'bullet'], potential = 'hard-sphere' }},
            {{ species = ['grain', 'stone'], potential = 'hard-sphere' }},
            {{ species = ['bullet', 'stone'], potential = 'hard-sphere' }},
        ]
        surface = [{{ name = 'table', shape = 'disc', centre = [10.0, 10.0, 5.0], axis = [0.0, 0.0, 1.0], radius = 3.0, restitution = 0.5 }}]
        particle = [{{ species = 'grain', position = [9.0, 10.0, 5.5] }}, {{ species = 'grain', position = [10.004, 10.0, 5.5] }}, {stones}]
        run = {{ until_events = 1000000 }}"
    );
    let mut simulation = Simulation::without_plan(Scene::from_toml(toml.as_str(), "table.toml").unwrap());
    simulation.advance(Until::time(15.1)).unwrap();
    assert_eq!(simulation.sleeping().len(), 2);
    simulation
}

#[test]
fn run_is_not_over_while_a_grain_has_to_wake_and_over_when_the_others_have_gone() {
    for (stones, search) in [(0, "lists"), (40, "cells")] {
        let mut simulation = table(stones);
        assert!(simulation.engine().search.to_string().contains(search));
        let height = simulation.snapshot().positions[0].z;
        let bullet = Particle::new(SpeciesId(1), Vector::new(9.0, 8.0, height), Vector::new(0.0, 8.0, 0.0));
        simulation.insert(&[bullet]).unwrap();
        simulation.advance(Until::time(19.0)).unwrap();
        let lowest = simulation.snapshot().positions.iter().map(|position| position.z).fold(0.0, f64::min);
        assert!(lowest < 0.0 && simulation.sleeping().len() == 1, "{lowest}");
        assert!(!simulation.is_over(), "the grain that remains has lost its neighbour");
        assert_eq!(simulation.advance_for(1_000_000, Until::default()), Ok(Some(Reason::Idle)), "{search}");
        assert_eq!((simulation.event_counts().wake, simulation.sleeping().len()), (2, 1));
        assert!(simulation.is_over());
    }
}

#[test]
fn grain_that_will_pass_near_a_sleeping_one_may_wake_it() {
    for (gap, expected) in [(0.005, false), (0.02, true)] {
        let mut simulation = table(0);
        let passing = Vector::new(10.004, 10.0 + 1.0 + gap, 7.0);
        simulation.insert(&[Particle::new(SpeciesId(0), passing, Vector::zeros())]).unwrap();
        let never = with_engine!(&simulation.engine, engine => {
            let number = |id: u32| engine.number(ParticleId(id));
            engine.never_meet(&engine.streamed(number(2), engine.clock.now), number(1))
        });
        assert_eq!(never, expected, "{gap}");
    }
}
