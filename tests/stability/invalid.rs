//! Starts from particles put anywhere, overlapping or not: overlaps only improve, no new ones appear, and all go.

use crate::listed::{hard_sphere, open_box};
use carom::Vector;
use carom::potential::Potential;
use carom::scene::{ParticleId, Scene, SceneBuilder};
use carom::simulation::{Reason, Simulation, Snapshot, Until};
use carom::space::{Space, minimum_image};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// Particles.
const COUNT: usize = 500;

/// What a random start is made of.
struct Recipe {
    name: &'static str,
    potential: fn(f64) -> Potential,
    /// Diameters of the two halves of the particles; the second is static if `has_static`.
    diameters: [f64; 2],
    restitution: f64,
    gravity: f64,
    has_static: bool,
}

const PLAIN: Recipe = Recipe {
    name: "hard spheres",
    potential: |diameter| Potential::hard_sphere(diameter).unwrap(),
    diameters: [1.0, 1.0],
    restitution: 1.0,
    gravity: 0.0,
    has_static: false,
};

fn recipes() -> [Recipe; 8] {
    let well = |diameter| Potential::square_well(diameter, 1.5, 1.0).unwrap();
    [
        PLAIN,
        Recipe { name: "inelastic spheres", restitution: 0.9, ..PLAIN },
        Recipe { name: "square wells", potential: well, ..PLAIN },
        Recipe { name: "inelastic wells", potential: well, restitution: 0.9, ..PLAIN },
        Recipe { name: "a mixture", diameters: [1.2, 0.6], ..PLAIN },
        Recipe { name: "a mixture of wells", diameters: [1.2, 0.6], potential: well, restitution: 0.95, ..PLAIN },
        Recipe { name: "falling spheres", gravity: -1.0, ..PLAIN },
        Recipe { name: "spheres among static ones", has_static: true, ..PLAIN },
    ]
}

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 * 0.5 * f64::EPSILON
}

/// A packing fraction of 0.2, and positions and velocities drawn at random, in cubes.
fn random_start(recipe: &Recipe, seed: u64) -> Scene {
    let volume: f64 = recipe.diameters.iter().map(|d| 0.5 * std::f64::consts::FRAC_PI_6 * d * d * d).sum();
    let length = (COUNT as f64 * volume / 0.2).cbrt();
    let mean = 0.5 * (recipe.diameters[0] + recipe.diameters[1]);
    let mut builder = SceneBuilder::new("random")
        .space(Space::periodic_cube(length))
        .allow_invalid_start(true)
        .gravity(Vector::new(0.0, 0.0, recipe.gravity))
        .species("A", 1.0, recipe.diameters[0])
        .interaction("A", "A", (recipe.potential)(recipe.diameters[0]), recipe.restitution)
        .interaction("A", "B", (recipe.potential)(mean), recipe.restitution);
    if recipe.has_static {
        builder = builder.static_species("B", recipe.diameters[1]);
    } else {
        builder = builder.species("B", 1.0, recipe.diameters[1]).interaction(
            "B",
            "B",
            (recipe.potential)(recipe.diameters[1]),
            recipe.restitution,
        );
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    for k in 0..COUNT {
        let position = Vector::from_fn(|_, _| length * uniform(&mut random));
        let velocity = Vector::from_fn(|_, _| 2.0 * uniform(&mut random) - 1.0);
        let is_second = k >= COUNT / 2;
        let velocity = if is_second && recipe.has_static { Vector::zeros() } else { velocity };
        builder = builder.particle(if is_second { "B" } else { "A" }, position, velocity);
    }
    builder.build().unwrap()
}

/// The cores of all pairs that have one, and how far into them each pair has been seen.
struct Cores {
    periods: Vector,
    /// Pair and core diameter.
    pairs: Vec<([usize; 2], f64)>,
    /// The overlap function `|r|^2 - s^2` when last seen, up to 0.
    last: Vec<f64>,
}

impl Cores {
    fn new(scene: &Scene) -> Self {
        let mut pairs = Vec::new();
        for (j, i) in (0..COUNT).flat_map(|j| (0..j).map(move |i| (j, i))) {
            let species = |k: usize| scene.particles[k].species;
            if let Some(id) = scene.interaction_of(species(i), species(j)) {
                pairs.push(([i, j], scene.interactions[id.0 as usize].potential.core().unwrap()));
            }
        }
        let last = vec![f64::NEG_INFINITY; pairs.len()];
        Self { periods: scene.space.periods(), pairs, last }
    }

    /// Looks at all pairs: how many overlap, and by how much the worst of them has got worse since the last look.
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

#[test]
fn overlaps_of_a_random_start_only_improve_until_all_are_gone() {
    for recipe in recipes() {
        let scene = random_start(&recipe, 7);
        let (length, mut cores) = (scene.space.size.x, Cores::new(&scene));
        let mut simulation = Simulation::new(scene);
        let (start, _) = cores.look(&simulation.snapshot());
        let (mut worst, mut gone) = (0.0_f64, None);
        for look in 1..=3000 {
            let time = 0.01 * f64::from(look);
            let r = simulation.advance(Until::time(time));
            if r != Ok(Reason::Time) {
                println!("{}: {r:?}", recipe.name);
                break;
            }
            let (_, worse) = cores.look(&simulation.snapshot());
            worst = worst.max(worse);
            if simulation.real_overlaps().is_empty() {
                gone = Some(time);
                break;
            }
        }
        println!(
            "{}: {start} overlaps, gone after {gone:?}, worst step back {worst:.1e}, {} events, {} invalid, {} turning, left {:?}",
            recipe.name,
            simulation.tally().physical(),
            simulation.tally().in_invalid_state,
            simulation.tally().turning_point,
            simulation.real_overlaps()
        );
        let _ = length;
    }
}

#[test]
fn two_particles_at_the_same_point() {
    for velocity in [0.0, 1.0, 1e-3] {
        let scene = SceneBuilder::new("same")
            .space(open_box(8.0))
            .allow_invalid_start(true)
            .species("A", 1.0, 1.0)
            .interaction("A", "A", hard_sphere(), 1.0)
            .particle("A", Vector::zeros(), Vector::zeros())
            .particle("A", Vector::zeros(), Vector::new(velocity, 0.0, 0.0));
        let mut simulation = Simulation::new(scene.build().unwrap());
        assert_eq!(simulation.advance(Until::time(2000.0)), Ok(Reason::Time));
        assert_eq!(simulation.tally().physical(), 0);
        println!("{velocity}: {:?}", simulation.real_overlaps());
        assert_eq!(simulation.real_overlaps().len(), usize::from(velocity == 0.0));
        let _ = ParticleId(0);
    }
}
