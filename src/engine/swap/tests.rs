use super::*;
use crate::engine::event::{Event, Other};
use crate::engine::{Search, Snapshot, Until};
use crate::model::random::Purpose;
use crate::model::space::{Boundary, Space};
use crate::model::{MassRule, ParticleId, SpeciesId, Thermostat, Threads};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use proptest::prelude::*;

fn every(interval: f64, attempts: u64) -> Swap {
    Swap { interval, attempts: Some(attempts), largest_ratio: None }
}

/// Additive hard spheres. Species are named by their number.
fn mixture(space: Space, species: &[(f64, f64)]) -> SceneBuilder {
    let named =
        species.iter().enumerate().fold(SceneBuilder::new("mixture").space(space), |scene, (k, (diameter, mass))| {
            scene.species(SpeciesDraft::new(&k.to_string()).mass(*mass).diameter(*diameter))
        });
    let pairs = (0..species.len()).flat_map(|a| (0..=a).map(move |b| [a, b]));
    pairs.fold(named, |scene, [a, b]| {
        scene.interaction(InteractionDraft::new(Model::HardSphere).between(&a.to_string(), &b.to_string()))
    })
}

fn species_of(simulation: &Simulation) -> Vec<u32> {
    simulation.snapshot().species.iter().map(|species| species.0).collect()
}

fn line(length: f64) -> Space {
    let boundary = [Boundary::walls(1.0), Boundary::Flat, Boundary::Flat];
    Space { lower: Vector::zeros(), size: Vector::new(length, 0.0, 0.0), boundary }
}

const SAMPLES: u32 = 400;

/// Simulates with swap moves in a heat bath. Returns the cases of [`SAMPLES`] samples for each of several blocks.
fn cases_of(scene: SceneBuilder, mut random: Random, case: impl Fn(&Snapshot) -> usize) -> Vec<Vec<usize>> {
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 0.3, axes: [true; 3] };
    simulation.set_thermostat(Some(&bath), 0).unwrap();
    let (mut time, mut accepted) = (0.0, 0);
    let mut sample = |_| {
        time += 0.7;
        simulation.advance(Until::time(time)).unwrap();
        accepted += simulation.swap(&every(0.7, 2), &mut random).accepted;
        case(&simulation.snapshot())
    };
    let blocks = (0..64).map(|_| (0..SAMPLES).map(&mut sample).collect()).collect();
    assert!(accepted > 5_000, "{accepted}");
    blocks
}

/// Mean share of each case, with the standard error from the scatter of the blocks.
fn mean_and_error<const CASES: usize>(blocks: &[Vec<usize>]) -> [[f64; 2]; CASES] {
    let count = blocks.len() as f64;
    std::array::from_fn(|case| {
        let share = |block: &Vec<usize>| block.iter().filter(|it| **it == case).count() as f64 / f64::from(SAMPLES);
        let mean = blocks.iter().map(share).sum::<f64>() / count;
        let squares: f64 = blocks.iter().map(|block| (share(block) - mean) * (share(block) - mean)).sum();
        [mean, (squares / (count * (count - 1.0))).sqrt()]
    })
}

/// In one dimension, the configurational integral of hard rods between walls does not depend on their order.
#[test]
fn all_orders_of_unlike_rods_are_equally_likely() {
    let rods = [(0.3, 1.3), (0.7, 0.9), (1.6, 2.1)];
    let mut scene = mixture(line(5.0), &rods);
    for (k, x) in [0.5, 1.5, 3.5].into_iter().enumerate() {
        scene = scene.particle(&k.to_string(), Vector::new(x, 0.0, 0.0), Vector::zeros());
    }
    let cases = cases_of(scene, Random::new(7, Purpose::Swap, 0), |snapshot| {
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        orders.iter().position(|order| snapshot.species == order.map(SpeciesId)).unwrap()
    });
    for (order, [mean, error]) in mean_and_error::<6>(&cases).into_iter().enumerate() {
        assert!((mean - 1.0 / 6.0).abs() < 5.0 * error, "{order}: {mean} {error}");
        assert!(error < 0.006, "{error}");
    }
}

/// Three disks with different individual diameters between four walls. The free space depends on which disk is in the
/// middle, so the probabilities of the three cases differ. They are found by random placement.
#[test]
fn unlike_disks_are_in_the_middle_as_often_as_their_room_allows() {
    const EDGE: f64 = 2.4;
    let diameters = [1.0, 0.7, 0.4];
    let middle_of = |at: [f64; 3]| (0..3).find(|&k| at.iter().filter(|x| **x < at[k]).count() == 1).unwrap();
    let mut random = Random::new(11, Purpose::Placement, 0);
    let (mut expected, mut placed) = ([0.0; 3], 0.0);
    for _ in 0..400_000 {
        let at: [[f64; 2]; 3] = std::array::from_fn(|k| {
            std::array::from_fn(|_| 0.5 * diameters[k] + (EDGE - diameters[k]) * random.uniform())
        });
        // The room of a disk between the walls is the same in all placements, so no weight is needed.
        let apart = |a: usize, b: usize| libm::hypot(at[a][0] - at[b][0], at[a][1] - at[b][1]);
        if [(0, 1), (0, 2), (1, 2)].into_iter().all(|(a, b)| apart(a, b) >= 0.5 * (diameters[a] + diameters[b])) {
            expected[middle_of(at.map(|[x, _]| x))] += 1.0;
            placed += 1.0;
        }
    }
    let expected = expected.map(|count| count / placed);
    assert!(expected[0] > 0.36 && expected[2] < 0.31, "{expected:?}");

    let boundary = [Boundary::walls(1.0), Boundary::walls(1.0), Boundary::Flat];
    let mut scene = SceneBuilder::new("disks")
        .space(Space { lower: Vector::zeros(), size: Vector::new(EDGE, EDGE, 0.0), boundary })
        .species(SpeciesDraft::new("A").mass(1.3).diameter(0.7).individual_diameters(MassRule::Volume))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"));
    for (diameter, [x, y]) in diameters.into_iter().zip([[0.6, 0.6], [1.7, 1.7], [1.7, 0.5]]) {
        let velocity = Vector::new(0.3 + y, x - 0.9, 0.0);
        scene = scene.sized_particle("A", diameter, Vector::new(x, y, 0.0), velocity);
    }
    let cases = cases_of(scene, random, |snapshot| {
        let middle = middle_of(std::array::from_fn(|k| snapshot.positions[k].x));
        diameters.iter().position(|diameter| *diameter == snapshot.diameters[middle]).unwrap()
    });
    for (k, (expected, [mean, error])) in expected.into_iter().zip(mean_and_error::<3>(&cases)).enumerate() {
        let error = (error * error + expected * (1.0 - expected) / placed).sqrt();
        assert!((mean - expected).abs() < 4.0 * error, "{k}: {mean} {expected} {error}");
        assert!(error < 0.005, "{error}");
    }
}

/// Two rods in two compartments of different length. The probability of an order is proportional to the product of the
/// free lengths.
#[test]
fn orders_in_two_compartments_have_the_ratio_of_their_free_lengths() {
    let (lengths, diameters) = ([1.5, 2.4], [0.4, 1.2]);
    let wall = 0.6;
    let mut scene = mixture(line(lengths[0] + wall + lengths[1]), &[(diameters[0], 1.3), (diameters[1], 0.7)]);
    scene.insert_species(SpeciesDraft::new("wall").diameter(wall).fixed());
    for name in ["0", "1"] {
        scene = scene.interaction(InteractionDraft::new(Model::HardSphere).between(name, "wall"));
    }
    scene.insert_particle("0", Vector::new(0.75, 0.0, 0.0), Vector::zeros());
    scene.insert_particle("1", Vector::new(3.1, 0.0, 0.0), Vector::zeros());
    scene.insert_particle("wall", Vector::new(lengths[0] + 0.5 * wall, 0.0, 0.0), Vector::zeros());
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    let bath = Thermostat::Andersen { temperature: 1.0, rate: 0.5, axes: [true; 3] };
    simulation.set_thermostat(Some(&bath), 0).unwrap();
    let mut random = Random::new(3, Purpose::Swap, 0);
    let blocks = 50;
    let mut shares = Vec::new();
    let mut time = 0.0;
    for _ in 0..blocks {
        let mut share = 0.0;
        for _ in 0..400 {
            time += 0.9;
            simulation.advance(Until::time(time)).unwrap();
            simulation.swap(&every(0.9, 1), &mut random);
            share += f64::from(u8::from(species_of(&simulation)[..2] == [0, 1])) / 400.0;
        }
        shares.push(share);
    }
    let mean = shares.iter().sum::<f64>() / blocks as f64;
    let error = (shares.iter().map(|share| (share - mean) * (share - mean)).sum::<f64>()
        / (blocks * (blocks - 1)) as f64)
        .sqrt();
    let weight = |order: [usize; 2]| (lengths[0] - diameters[order[0]]) * (lengths[1] - diameters[order[1]]);
    let expected = weight([0, 1]) / (weight([0, 1]) + weight([1, 0]));
    assert!((mean - expected).abs() < 5.0 * error, "{mean} {error} {expected}");
    assert!(error < 0.01 && (expected - 0.5).abs() > 0.15, "{error} {expected}");
}

#[derive(Debug, Clone)]
struct Recipe {
    species: Vec<(f64, f64)>,
    kinds: Vec<usize>,
    velocities: Vec<[f64; 3]>,
    dimensions: usize,
    has_walls: [bool; 3],
    seed: u64,
    /// Half of the skin of lists; cells if not given.
    half_skin: Option<f64>,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let species = prop::collection::vec((0.3..2.5_f64, 0.6..2.7_f64), 2..5);
    let velocity = prop::array::uniform3(-1.0..1.0_f64);
    (species, 1..4_usize, prop::array::uniform3(any::<bool>()), 0..1_000_u64, prop::option::of(0.02..0.15_f64))
        .prop_flat_map(move |(species, dimensions, has_walls, seed, half_skin)| {
            let count = [7, 36, 64][dimensions - 1];
            let kinds = prop::collection::vec(0..species.len(), count);
            (
                Just((species, dimensions, has_walls, seed, half_skin)),
                kinds,
                prop::collection::vec(velocity.clone(), count),
            )
        })
        .prop_map(|((species, dimensions, has_walls, seed, half_skin), kinds, velocities)| Recipe {
            species,
            kinds,
            velocities,
            dimensions,
            has_walls,
            seed,
            half_skin,
        })
}

impl Recipe {
    fn simulation(&self) -> Simulation {
        let spacing = 1.05 * self.species.iter().map(|(diameter, _)| *diameter).fold(0.0, f64::max);
        let side = [7, 6, 4][self.dimensions - 1];
        let mut space = Space::periodic_cube(spacing * f64::from(side));
        for axis in 0..3 {
            if axis >= self.dimensions {
                (space.boundary[axis], space.size[axis]) = (Boundary::Flat, 0.0);
            } else if self.has_walls[axis] {
                space.boundary[axis] = Boundary::walls(1.0);
            }
        }
        let mut scene = mixture(space, &self.species);
        for ((kind, velocity), number) in self.kinds.iter().zip(&self.velocities).zip(0..) {
            let place = [number % side, number / side % side, number / (side * side)];
            let at = |axis: usize| if axis < self.dimensions { spacing * (f64::from(place[axis]) + 0.5) } else { 0.0 };
            let along = |axis: usize| if axis < self.dimensions { velocity[axis] } else { 0.0 };
            scene.insert_particle(&kind.to_string(), Vector::from_fn(|k, _| at(k)), Vector::from_fn(|k, _| along(k)));
        }
        let mut simulation = Simulation::without_plan(scene.build().unwrap());
        if let Some(half_skin) = self.half_skin {
            let scale = self.species.iter().map(|(diameter, _)| *diameter).fold(f64::INFINITY, f64::min);
            with_engine!(&mut simulation.engine, engine => {
                let space = engine.state.space.clone();
                let widest = super::super::neighbours::verlet::VerletLists::widest_half_skin(&space, engine.ranges.longest);
                if widest > 0.0 {
                    engine.sort_in(Search::Lists { half_skin: (half_skin * scale).min(0.9 * widest) });
                    engine.fill_lists();
                    engine.start_anew();
                }
            });
        }
        simulation
    }
}

fn pair(event: &Event) -> [Option<ParticleId>; 2] {
    let Other::Particle(partner) = event.other else { return [Some(event.particle), None] };
    [Some(event.particle.min(partner)), Some(event.particle.max(partner))]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]
    #[test]
    fn events_after_swaps_are_those_of_a_new_search(recipe in recipe()) {
        let mut simulation = recipe.simulation();
        let mut random = Random::new(recipe.seed, Purpose::Swap, 0);
        let before = simulation.energy();
        let momentum = |simulation: &Simulation| -> Vector {
            let snapshot = simulation.snapshot();
            let mass = |species: &crate::model::SpeciesId| simulation.scene().species()[species.0 as usize].mass;
            snapshot.species.iter().zip(&snapshot.velocities).map(|(species, velocity)| velocity * mass(species)).sum()
        };
        for _ in 0..6 {
            let events = simulation.event_counts().physical();
            simulation.advance(Until::events(events + 20)).unwrap();
            let (population, at_first) = (simulation.population(), momentum(&simulation));
            let species = species_of(&simulation);
            let moves = simulation.swap(&every(1.0, 60), &mut random);
            prop_assert_eq!(moves.attempted, 60);
            prop_assert_eq!(simulation.population(), population);
            prop_assert!((momentum(&simulation) - at_first).norm() < 1e-12);
            prop_assert_eq!(simulation.unsound_index(), None);
            // Lists have centres inside of the box.
            let space = simulation.scene().space().clone();
            let changed = species_of(&simulation).into_iter().zip(species).zip(0..).filter(|((now, before), _)| now != before);
            for (_, id) in changed.filter(|_| recipe.half_skin.is_some()) {
                let position = with_engine!(&simulation.engine, engine => {
                    engine.state.bodies[engine.number(ParticleId(id)) as usize].position
                });
                prop_assert!((0..3).all(|k| space.lower[k] <= position[k] && position[k] <= space.upper()[k]), "{}", position);
            }
            prop_assert!(simulation.real_overlaps().is_empty());
            let mut anew = simulation.clone();
            with_engine!(&mut anew.engine, engine => {
                engine.sort_anew();
                engine.start_anew();
            });
            let next = |simulation: &mut Simulation| {
                let (mut events, done) = (Vec::new(), simulation.event_counts().physical());
                simulation.advance_with(Until::events(done + 25), |event| events.push((event.time, pair(event)))).unwrap();
                events
            };
            let (here, there) = (next(&mut simulation.clone()), next(&mut anew));
            prop_assert_eq!(here.len(), there.len());
            for (one, other) in here.iter().zip(&there) {
                prop_assert_eq!(one.1, other.1);
                // Rounding errors grow with each collision.
                prop_assert!((one.0 - other.0).abs() < 1e-6, "{} {}", one.0, other.0);
            }
        }
        let after = simulation.energy();
        prop_assert!((after.kinetic / before.kinetic - 1.0).abs() < 1e-12);
        prop_assert!(simulation.event_counts().supplied.total().abs() < 1e-12 * before.kinetic);
    }
}

#[test]
fn particles_of_equal_mass_keep_their_velocities() {
    for (mass, is_exchanged) in [(1.3, false), (2.6, true)] {
        let scene = mixture(Space::periodic_cube(10.0), &[(1.0, 1.3), (1.5, mass)])
            .particle("0", Vector::new(2.0, 2.0, 2.0), Vector::new(0.3, -0.2, 0.1))
            .particle("1", Vector::new(6.0, 6.0, 6.0), Vector::new(-0.1, 0.5, 0.7));
        let mut simulation = Simulation::without_plan(scene.build().unwrap());
        simulation.advance(Until::time(0.25)).unwrap();
        let before = simulation.snapshot();
        let moves = simulation.swap(&every(1.0, 1), &mut Random::new(1, Purpose::Swap, 0));
        assert_eq!((moves.attempted, moves.accepted), (1, 1));
        let after = simulation.snapshot();
        assert_eq!((after.positions, species_of(&simulation)), (before.positions, vec![1, 0]));
        let mut velocities = before.velocities;
        if is_exchanged {
            velocities.reverse();
        }
        assert_eq!(after.velocities, velocities);
        assert_eq!(simulation.event_counts().supplied.total(), 0.0);
    }
}

/// The contact distance of the two particles is the same after the exchange.
#[test]
fn particles_in_contact_can_exchange_their_species() {
    let scene = mixture(Space::periodic_cube(10.0), &[(1.0, 1.3), (1.5, 1.3)])
        .particle("0", Vector::new(2.0, 2.0, 2.0), Vector::zeros())
        .particle("1", Vector::new(3.26, 2.0, 2.0), Vector::zeros());
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    let moves = simulation.swap(&every(1.0, 3), &mut Random::new(1, Purpose::Swap, 0));
    assert_eq!((moves.attempted, moves.accepted), (3, 3));
}

#[test]
fn moves_are_counted_by_their_reason() {
    let scene = mixture(Space::periodic_cube(12.0), &[(1.0, 1.0), (2.0, 1.0), (3.0, 1.0)]);
    let at = |x: f64, y: f64| Vector::new(x, y, 3.0);
    let scene = scene
        .particle("0", at(2.0, 2.0), Vector::zeros())
        .particle("0", at(3.2, 2.0), Vector::zeros())
        .particle("1", at(7.0, 2.0), Vector::zeros())
        .particle("2", at(7.0, 7.0), Vector::zeros());
    let mut simulation = Simulation::without_plan(scene.build().unwrap());
    let mut random = Random::new(1, Purpose::Swap, 0);
    let limited = Swap { largest_ratio: Some(2.0), ..every(1.0, 600) };
    let moves = simulation.swap(&limited, &mut random);
    // One of six pairs is alike. The other two small spheres are too close for a sphere of diameter 2.
    assert_eq!(moves.attempted, 600);
    assert!((60..150).contains(&moves.alike), "{moves:?}");
    assert!(moves.too_unlike > 50 && moves.accepted > 20, "{moves:?}");
    assert_eq!(simulation.population(), [2, 1, 1]);
    assert!(simulation.real_overlaps().is_empty());
    let alone = mixture(Space::periodic_cube(12.0), &[(1.0, 1.0), (2.0, 1.0)]).particle("0", at(2.0, 2.0), Vector::x());
    let mut simulation = Simulation::without_plan(alone.build().unwrap());
    assert_eq!(simulation.swap(&every(1.0, 5), &mut random), SwapMoves::default());
}

#[test]
fn swaps_have_the_same_bits_on_several_threads() {
    let of = |threads: usize| {
        let recipe = Recipe {
            species: vec![(1.0, 1.3), (1.4, 1.3), (0.6, 0.9)],
            kinds: (0..64).map(|k| k * 7 % 3).collect(),
            velocities: (0..64).map(|k| [f64::from(k * 37 % 64) - 31.5, f64::from(k * 11 % 64) - 31.5, 3.0]).collect(),
            dimensions: 3,
            has_walls: [false, true, false],
            seed: 5,
            half_skin: None,
        };
        let mut simulation = recipe.simulation();
        simulation.set_threads(Threads::Number(threads));
        let mut random = Random::new(9, Purpose::Swap, 0);
        for k in 1..=20 {
            simulation.advance(Until::time(0.01 * f64::from(k))).unwrap();
            simulation.swap(&every(0.01, 30), &mut random);
        }
        simulation.advance(Until::time(0.25)).unwrap();
        (simulation.snapshot(), *simulation.event_counts())
    };
    let one = of(1);
    assert!(one.1.physical() > 200);
    assert_eq!(of(2), one);
    assert_eq!(of(3), one);
}
