//! Particles of very different sizes, which the fast engine sorts into several levels of cells.

use crate::population::{Change, Tally, change, run_scene, same_events};
use crate::{LONGEST, compare_events};
use carom::Vector;
use carom::check::reference::Reference;
use carom::engine::{Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, Particle, Scene, SpeciesId};
use carom::scene::{Arrangement, Fill, InteractionDraft, SceneBuilder, SpeciesDraft};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;

/// Number of scenes. `CAROM_UNLIKE_SCENES` replaces it.
fn cases() -> u32 {
    std::env::var("CAROM_UNLIKE_SCENES").map_or(60, |cases| cases.parse().expect("a number of scenes"))
}

fn runner() -> TestRunner {
    TestRunner::new(ProptestConfig { cases: cases(), max_global_rejects: 40 * cases(), ..ProptestConfig::default() })
}

#[derive(Debug, Clone)]
struct Recipe {
    seed: u64,
    /// Diameter of the large particles.
    diameter: f64,
    large: u64,
    /// Fraction of the box that the small particles fill.
    small: f64,
    dimensions: usize,
    boundary: [usize; 3],
    has_gravity: bool,
    restitution: f64,
    has_wells: bool,
    statics: u32,
    /// Length of the box beyond two large diameters, in units of the large diameter.
    room: f64,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    (
        (0..1_000_000_u64, 1.6..5.0_f64, (0..3_u64, 0.02..0.2_f64), 1..4_usize),
        (prop::array::uniform3(0..3_usize), any::<bool>(), prop::sample::select(vec![1.0, 0.8])),
        (any::<bool>(), 0..4_u32, 0.4..0.8_f64),
    )
        .prop_map(
            |(
                (seed, diameter, (large, small), dimensions),
                (boundary, has_gravity, restitution),
                (has_wells, statics, room),
            )| Recipe {
                seed,
                diameter,
                large,
                small,
                dimensions,
                boundary,
                has_gravity,
                restitution,
                has_wells,
                statics,
                room,
            },
        )
}

impl Recipe {
    fn scene(&self) -> Option<Scene> {
        let length = (2.0 + self.room) * self.diameter + if self.dimensions == 1 { 60.0 } else { 0.0 };
        let mut space = Space::periodic_cube(length);
        let wall = Face::Wall(ContactLaw::smooth(self.restitution));
        for axis in 0..3 {
            space.boundary[axis] = match self.boundary[axis] {
                _ if axis >= self.dimensions => Boundary::Flat,
                0 => Boundary::Periodic,
                1 => Boundary::Bounded { lower: wall, upper: wall },
                _ => Boundary::Bounded { lower: wall, upper: Face::Open },
            };
            if space.boundary[axis] == Boundary::Flat {
                space.size[axis] = 0.0;
            }
        }
        let gravity = Vector::from_fn(|axis, _| if axis + 1 == self.dimensions { -0.7 } else { 0.0 });
        let hard = |diameter: f64| Potential::hard_sphere(diameter).ok();
        let own = if self.has_wells { Potential::square_well(0.7, 1.4, 0.6).ok()? } else { hard(0.7)? };
        let mean = |other: f64| 0.5 * (self.diameter + other);
        let contact = |potential| InteractionDraft::new(potential).restitution(self.restitution);
        let fill = |species: &str, count| Fill::new(Arrangement::Random, species).count(count);
        let mut builder = SceneBuilder::new("unlike")
            .seed(self.seed)
            .space(space)
            .gravity(if self.has_gravity { gravity } else { Vector::zeros() })
            .species(SpeciesDraft::new("S").mass(0.3).diameter(0.7))
            .species(SpeciesDraft::new("L").mass(7.1).diameter(self.diameter))
            .species(SpeciesDraft::new("T").diameter(0.2).fixed())
            .interaction(contact(own).between("S", "S"))
            .interaction(contact(hard(mean(0.7))?).between("S", "L"))
            .interaction(contact(hard(self.diameter)?).between("L", "L"))
            .interaction(contact(hard(0.45)?).between("S", "T"))
            .interaction(contact(hard(mean(0.2))?).between("L", "T"));
        for k in 0..self.statics {
            let at = |axis: usize| if axis < self.dimensions { 0.11 + 0.3 * f64::from(k) } else { 0.0 };
            builder = builder.particle("T", Vector::new(at(0), at(1), at(2)), Vector::zeros());
        }
        if self.large > 0 {
            builder = builder.fill(fill("L", self.large));
        }
        let each = [0.7, 0.385, 0.18][self.dimensions - 1];
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "some hundred particles")]
        let small = (self.small / each * length.powi(self.dimensions as i32)) as u64;
        builder.fill(fill("S", small.clamp(40, 300))).temperature(1.0).build().ok()
    }
}

fn has_levels(scene: &Scene) -> bool {
    Simulation::without_plan(scene.clone()).engine().to_string().contains("levels")
}

#[test]
fn both_engines_agree_on_particles_of_very_different_sizes() {
    let mut runner = runner();
    let (compared, cut_short, levels) = (Cell::new(0), Cell::new(0), Cell::new(0));
    let result = runner.run(&recipe(), |recipe| {
        let Some(scene) = recipe.scene() else { return Err(TestCaseError::reject("no such scene")) };
        // Each particle has one collision on average, so that rounding errors stay small.
        let found = compare_events(&scene, scene.particles().len() / 2)?;
        compared.set(compared.get() + found.events);
        cut_short.set(cut_short.get() + usize::from(found.is_cut_short));
        levels.set(levels.get() + usize::from(has_levels(&scene)));
        Ok(())
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    let counts = (compared.get(), cut_short.get(), levels.get());
    println!("{counts:?} events compared, scenes cut short, scenes with levels, up to t = {LONGEST}");
    assert!(
        counts.0 > 15 * cases() as usize && counts.1 < cases() as usize / 2 && counts.2 > cases() as usize / 20,
        "{counts:?}"
    );
}

/// The scenes with no large particle declare one. When the first of them enters, the engine has to find it.
#[test]
fn both_engines_agree_while_particles_of_very_different_sizes_enter_and_leave() {
    let mut runner = runner();
    let tally = Cell::new(Tally::default());
    let strategy = (recipe(), prop::collection::vec(change(), 2..8));
    let result = runner.run(&strategy, |(recipe, changes): (Recipe, Vec<Change>)| {
        let Some(scene) = recipe.scene() else { return Err(TestCaseError::reject("no such scene")) };
        run_scene(&scene, false, &changes, &tally)
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    let tally = tally.get();
    println!("{tally:?}");
    assert!(tally.events > 5 * cases() as usize && 10 * tally.entered > cases() as usize, "{tally:?}");
}

/// A gas of small particles around an empty place, and a species of large particles that has none.
fn gas_around_a_gap() -> Scene {
    let hard = |diameter| InteractionDraft::new(Potential::hard_sphere(diameter).unwrap());
    let wall = Face::Wall(ContactLaw::smooth(1.0));
    let mut builder = SceneBuilder::new("gap")
        .space(Space { boundary: [Boundary::Bounded { lower: wall, upper: wall }; 3], ..Space::periodic_cube(25.0) })
        .species(SpeciesDraft::new("S").mass(0.3).diameter(0.7))
        .species(SpeciesDraft::new("L").mass(7.1).diameter(9.0))
        .interaction(hard(0.7).between("S", "S"))
        .interaction(hard(4.85).between("S", "L"))
        .interaction(hard(9.0).between("L", "L"));
    let at = |k: u32| 1.25 + 2.5 * f64::from(k);
    for k in 0..1_000_u32 {
        let position = Vector::new(at(k % 10), at(k / 10 % 10), at(k / 100));
        if (position - Vector::repeat(12.5)).norm() > 6.0 {
            let slow = |k: u32| 0.02 * f64::from(k * 7_919 % 101) - 1.0;
            builder = builder.particle("S", position, Vector::new(slow(k), slow(k + 31), slow(k + 57)) * 0.1);
        }
    }
    builder.build().unwrap()
}

/// The cells of a thin gas are smaller than the first large particle, which enters later.
#[test]
fn the_first_large_particle_meets_the_small_ones() {
    const END: f64 = 1.5;
    let scene = gas_around_a_gap();
    let mut simulation = Simulation::without_plan(scene.clone());
    assert!(simulation.engine().to_string().contains("cells"));
    let mut reference = Reference::new(&scene).expect("a reference engine");
    simulation.advance(Until::time(0.3)).expect("no arrest");
    while reference.step_before(0.3).is_some() {}
    let large = |at: [f64; 3]| Particle::new(SpeciesId(1), at.into(), Vector::new(3.0, -2.7, 3.3));
    // Small particles in contact with this one are several cells away from its centre.
    assert!(simulation.insert(&[large([12.5, 12.5, 14.5])]).is_err());
    let new = large([12.5, 12.4, 12.6]);
    let id = simulation.insert(&[new]).expect("a free place")[0];
    assert_eq!(reference.insert(new), id);
    let mut ours = Vec::new();
    simulation.advance_with(Until::time(END), |event| ours.push(*event)).expect("no arrest");
    let theirs: Vec<_> = std::iter::from_fn(|| reference.step_before(END)).collect();
    let found = same_events(&ours, &theirs, END).expect("the same events");
    let met = ours.iter().filter(|event| event.particle == id || event.partner() == Some(id)).count();
    assert!(found.is_some() && met > 10, "{found:?} {met}");
}
