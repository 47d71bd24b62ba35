//! Runs that start with overlaps. The overlaps vanish, and no new overlaps appear.

use crate::listed::{hard_sphere, open_box};
use carom::Vector;
use carom::engine::{Reason, Simulation, Snapshot, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Space, minimum_image};
use carom::scene::{InteractionDraft, SceneBuilder, SpeciesDraft};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

const COUNT: usize = 500;

struct Recipe {
    name: &'static str,
    potential: fn(f64) -> Potential,
    /// Diameters of the two species. With `has_static`, the second species is static.
    diameters: [f64; 2],
    restitution: f64,
    gravity: f64,
    contact_time: Option<f64>,
    has_static: bool,
    /// Fraction of particles of the second species.
    second: f64,
}

impl Recipe {
    /// In a common well, three inelastic particles with overlapping cores may collide without end. About a fifth of all
    /// seeds end in such a collapse, even with the TC model.
    fn may_arrest(&self) -> bool {
        self.restitution < 1.0 && self.name.contains("wells")
    }
}

const PLAIN: Recipe = Recipe {
    name: "hard spheres",
    potential: |diameter| Potential::hard_sphere(diameter).unwrap(),
    diameters: [1.0, 1.0],
    restitution: 1.0,
    gravity: 0.0,
    contact_time: None,
    has_static: false,
    second: 0.5,
};

/// The TC model is needed if gravity presses overlapping particles onto static particles.
fn recipes() -> [Recipe; 10] {
    let well = |diameter| Potential::square_well(diameter, 1.5, 1.0).unwrap();
    [
        PLAIN,
        Recipe { name: "inelastic spheres", restitution: 0.9, ..PLAIN },
        Recipe { name: "square wells", potential: well, ..PLAIN },
        Recipe { name: "inelastic wells", contact_time: Some(1e-3), potential: well, restitution: 0.9, ..PLAIN },
        Recipe { name: "a mixture", diameters: [1.2, 0.6], ..PLAIN },
        Recipe { name: "a mixture of wells", diameters: [1.2, 0.6], potential: well, restitution: 0.95, ..PLAIN },
        Recipe { name: "falling spheres", gravity: -1.0, ..PLAIN },
        Recipe { name: "spheres among static ones", has_static: true, second: 0.1, ..PLAIN },
        Recipe {
            name: "spheres falling on static ones",
            gravity: -1.0,
            contact_time: Some(1e-3),
            has_static: true,
            second: 0.1,
            ..PLAIN
        },
        Recipe {
            name: "grains falling on static ones",
            gravity: -1.0,
            contact_time: Some(1e-3),
            has_static: true,
            second: 0.1,
            restitution: 0.9,
            ..PLAIN
        },
    ]
}

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 * 0.5 * f64::EPSILON
}

fn random_start(recipe: &Recipe, seed: u64) -> Scene {
    let volume: f64 = recipe
        .diameters
        .iter()
        .zip([1.0 - recipe.second, recipe.second])
        .map(|(d, part)| part * std::f64::consts::FRAC_PI_6 * d * d * d)
        .sum();
    let length = (COUNT as f64 * volume / 0.2).cbrt();
    let mean = 0.5 * (recipe.diameters[0] + recipe.diameters[1]);
    let mut builder = SceneBuilder::new("random")
        .space(Space::periodic_cube(length))
        .allow_invalid_start(true)
        .gravity(Vector::new(0.0, 0.0, recipe.gravity))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(recipe.diameters[0]))
        .interaction(
            InteractionDraft::new((recipe.potential)(recipe.diameters[0]))
                .between("A", "A")
                .restitution(recipe.restitution),
        )
        .interaction(InteractionDraft::new((recipe.potential)(mean)).between("A", "B").restitution(recipe.restitution));
    if recipe.has_static {
        builder = builder.species(SpeciesDraft::new("B").diameter(recipe.diameters[1]).fixed());
    } else {
        builder = builder.species(SpeciesDraft::new("B").mass(1.0).diameter(recipe.diameters[1])).interaction(
            InteractionDraft::new((recipe.potential)(recipe.diameters[1]))
                .between("B", "B")
                .restitution(recipe.restitution),
        );
    }
    if let Some(time) = recipe.contact_time {
        builder = builder.contact_time(time);
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for k in 0..COUNT {
        let position = Vector::from_fn(|_, _| length * uniform(&mut random));
        let velocity = Vector::from_fn(|_, _| 2.0 * uniform(&mut random) - 1.0);
        let is_second = k as f64 >= (1.0 - recipe.second) * COUNT as f64;
        let velocity = if is_second && recipe.has_static { Vector::zeros() } else { velocity };
        builder = builder.particle(if is_second { "B" } else { "A" }, position, velocity);
    }
    builder.build().unwrap()
}

struct Cores {
    periods: Vector,
    pairs: Vec<([usize; 2], f64)>,
    /// `|r|^2 - s^2` of each pair at the last check, with the core diameter `s`. Zero for pairs without overlap.
    last: Vec<f64>,
}

impl Cores {
    fn new(scene: &Scene) -> Self {
        let mut pairs = Vec::new();
        for (j, i) in (0..COUNT).flat_map(|j| (0..j).map(move |i| (j, i))) {
            let species = |k: usize| scene.particles()[k].species;
            if let Some(id) = scene.interaction_of(species(i), species(j)) {
                pairs.push(([i, j], scene.interactions()[id.0 as usize].potential.core().unwrap()));
            }
        }
        let last = vec![f64::NEG_INFINITY; pairs.len()];
        Self { periods: scene.space().periods(), pairs, last }
    }

    /// Returns the number of overlaps, and the largest increase of an overlap since the last check.
    fn look(&mut self, now: &Snapshot) -> (usize, f64) {
        let (mut overlapping, mut worse) = (0, f64::NEG_INFINITY);
        for (([i, j], core), last) in self.pairs.iter().zip(&mut self.last) {
            let apart = minimum_image(now.positions[*i] - now.positions[*j], &self.periods);
            let f = (apart.norm_squared() - core * core).min(0.0);
            worse = worse.max(*last - f);
            overlapping += usize::from(f < 0.0);
            *last = f;
        }
        (overlapping, worse)
    }
}

/// Largest increase of an overlap by rounding. A coordinate error `e` changes `|r|^2` by `2 |r| e`, and `|r| = 1.2`.
fn deepening(length: f64) -> f64 {
    2.0 * 1.2 * 16.0 * f64::EPSILON * length
}

fn resolve(recipe: &Recipe) {
    let scene = random_start(recipe, 7);
    let (length, mut cores) = (scene.space().size.x, Cores::new(&scene));
    let mut simulation = Simulation::without_plan(scene);
    let (start, _) = cores.look(&simulation.snapshot());
    assert!(start > 100, "{start} overlaps are no test");
    let (mut worst, mut gone) = (0.0_f64, None);
    for look in 1..=3000 {
        let time = 0.01 * f64::from(look);
        match simulation.advance(Until::time(time)) {
            Err(arrest) if recipe.may_arrest() => {
                println!("{}: {arrest}; worst step back {worst:.1e}", recipe.name);
                assert!(worst < deepening(length), "{}: an overlap got deeper by {worst:e}", recipe.name);
                return;
            }
            reached => assert_eq!(reached, Ok(Reason::Time), "{}", recipe.name),
        }
        worst = worst.max(cores.look(&simulation.snapshot()).1);
        if simulation.real_overlaps().is_empty() {
            gone = Some(time);
            break;
        }
    }
    let event_counts = simulation.event_counts();
    println!(
        "{}: {start} overlaps, the last gone after {gone:?} and {} events; worst step back {worst:.1e}; {} events in \
         invalid states, {} turning points",
        recipe.name,
        event_counts.physical(),
        event_counts.in_invalid_state,
        event_counts.turning_point
    );
    assert!(worst < deepening(length), "{}: an overlap got deeper by {worst:e}", recipe.name);
    assert!(gone.is_some(), "{}: {} overlaps are left", recipe.name, simulation.real_overlaps().len());
}

#[test]
fn overlaps_of_a_random_start_only_improve_until_all_are_gone() {
    for recipe in recipes() {
        resolve(&recipe);
    }
}

#[test]
fn overlaps_held_by_gravity_arrest_without_the_tc_model() {
    // Gravity pulls a ball back before it leaves a static ball. At the turning point, the normal velocity is zero, so
    // no contact separates the balls.
    let recipe = Recipe { name: "held down", gravity: -1.0, has_static: true, second: 0.1, ..PLAIN };
    let mut simulation = Simulation::without_plan(random_start(&recipe, 7));
    let arrest = simulation.advance(Until::time(30.0)).unwrap_err().arrest().unwrap();
    println!("{} events, {arrest}", simulation.event_counts().physical());
    assert!(simulation.event_counts().physical() < 1_000_000);
    assert!(arrest.particle.0.max(arrest.partner.unwrap().0) >= 450, "{arrest}");
}

#[test]
fn two_particles_at_the_same_point_part_if_they_move_and_stay_if_not() {
    for velocity in [0.0, 1e-3, 1.0] {
        let scene = SceneBuilder::new("same")
            .space(open_box(8.0))
            .allow_invalid_start(true)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(hard_sphere()).between("A", "A"))
            .particle("A", Vector::zeros(), Vector::zeros())
            .particle("A", Vector::zeros(), Vector::new(velocity, 0.0, 0.0));
        let mut simulation = Simulation::without_plan(scene.build().unwrap());
        assert_eq!(simulation.advance(Until::time(2000.0)), Ok(Reason::Time));
        // Overlapping particles have no event while they separate or are at relative rest.
        assert_eq!(simulation.event_counts().physical(), 0);
        assert_eq!(simulation.real_overlaps().len(), usize::from(velocity == 0.0));
    }
}
