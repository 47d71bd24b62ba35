use crate::engine::neighbours::candidates::Candidates;
use crate::engine::parts::Engine;
use crate::engine::sources::list_rebuild::tests::are_complete;
use crate::engine::{Chosen, Simulation, Until};
use crate::model::Scene;

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
        let rows = engine.pairs.rules.rows.species().len();
        let touches = |&other: &u32| {
            let range =
                engine.ranges.between[usize::from(engine.row(particle)) * rows + usize::from(engine.row(other))];
            (engine.state_at(other, engine.clock.now).0 - place).norm() <= range + distance
        };
        let expected: Vec<u32> = engine.particles().filter(|&other| other != particle).filter(touches).collect();
        assert_eq!(found, expected, "{particle}");
    }
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
        assert!(most > grains as usize * 4 / 5, "{most} of {grains} slept");
        let counts = simulation.event_counts();
        assert!(counts.wake > 3, "the large grain wakes others: {}", counts.wake);
        assert_eq!(counts.rest - counts.wake, simulation.sleeping().len() as u64);
        assert_eq!(simulation.real_overlaps(), []);
    }
}
