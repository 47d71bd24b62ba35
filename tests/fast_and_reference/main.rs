//! Compares the fast engine with the reference engine, event by event, on random scenes.

use carom::Vector;
use carom::check::reference::{self, Reference};
use carom::engine::event::{Event, EventKind, Other, Outcome};
use carom::engine::{Simulation, Until};
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Face, Space};
use carom::model::{ContactLaw, Restitution, RestitutionTable, Scene, SurfaceVelocity, TcRule};
use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use std::cell::Cell;

mod population;
mod sleep;
mod surfaces;
mod unlike;

use surfaces::{motions, surfaces};

/// Number of events compared in each scene. Each collision multiplies rounding errors by about ten.
const EVENTS: usize = 40;

/// Tolerance for times and positions. Round-off grows from 1e-15 to about 1e-7 during the compared events.
const TOLERANCE: f64 = 1e-7;

/// Simulated time after which a comparison ends. In an open scene, the particles may disperse and never meet.
const LONGEST: f64 = 20.0;

#[derive(Debug, Clone)]
struct Recipe {
    seed: u64,
    count: u64,
    potential: usize,
    /// Depth of wells and height of shoulders, relative to the values in [`potential`].
    depth: f64,
    masses: [f64; 2],
    boundary: [usize; 3],
    gravity: bool,
    restitution: Restitution,
    /// Tangential restitution and friction of all contacts with cores and walls.
    roughness: Option<[f64; 2]>,
    statics: usize,
    bonds: usize,
    contact_time: Option<f64>,
    box_length: f64,
    /// Selects the surfaces.
    surfaces: usize,
    motion: usize,
}

const PLAIN: Recipe = Recipe {
    seed: 1,
    count: 12,
    potential: 0,
    depth: 1.0,
    masses: [1.0, 3.0],
    boundary: [2; 3],
    gravity: false,
    restitution: Restitution::Constant(1.0),
    roughness: None,
    statics: 0,
    bonds: 0,
    contact_time: None,
    box_length: 8.0,
    surfaces: 0,
    motion: 0,
};

fn recipe() -> impl Strategy<Value = Recipe> {
    (
        (0..1_000_000_u64, 8..24_u64, 0..6_usize, prop::array::uniform3(0..3_usize), any::<bool>()),
        // These numbers are not powers of two, so their products are rounded.
        (0.3..1.6_f64, prop::array::uniform2((-1.5..1.5_f64).prop_map(f64::exp))),
        (
            (restitution(), prop::option::weighted(0.4, roughness())),
            0..4_usize,
            0..4_usize,
            0..6_usize,
            prop::option::weighted(0.3, 1e-3..0.1_f64),
            5.0..8.0_f64,
        ),
    )
        .prop_map(
            |(
                (seed, count, potential, boundary, gravity),
                (depth, masses),
                ((restitution, roughness), statics, bonds, surfaces, contact_time, box_length),
            )| {
                Recipe {
                    seed,
                    count,
                    potential,
                    depth,
                    masses,
                    boundary,
                    gravity,
                    restitution,
                    roughness,
                    statics,
                    bonds,
                    contact_time,
                    box_length,
                    surfaces,
                    motion: (seed % 5) as usize,
                }
            },
        )
}

fn restitution() -> impl Strategy<Value = Restitution> {
    let table = RestitutionTable::new(&[0.2, 1.3, 2.0], &[0.9, 0.4, 0.5]).expect("a valid table");
    let viscoelastic = Restitution::Viscoelastic { viscous_time: 0.1, stiffness: 2.3 };
    let constant = [1.0, 0.9, 0.5].map(Restitution::Constant);
    prop::sample::select([constant.as_slice(), &[viscoelastic, Restitution::Table(table)]].concat())
}

fn roughness() -> impl Strategy<Value = [f64; 2]> {
    let tangential = prop_oneof![Just(1.0), Just(0.0), -1.0..1.0_f64];
    (tangential, prop_oneof![Just(f64::INFINITY), 0.0..1.0_f64]).prop_map(|(b, mu)| [b, mu])
}

fn potential(kind: usize, depth: f64) -> Potential {
    match kind {
        0 => Potential::hard_sphere(1.0),
        1 => Potential::square_well(1.0, 1.5, 0.7 * depth),
        2 => Potential::square_shoulder(1.0, 1.4, 0.8 * depth),
        3 => Potential::penetrable(1.0, 0.6 * depth),
        4 => Potential::stepped_lennard_jones(1.0, depth, 2.0, 5, 20.0),
        _ => Potential::new(vec![1.8, 1.5, 1.2, 1.0], vec![0.0, 0.4 * depth, -0.3 * depth, -depth, f64::INFINITY]),
    }
    .expect("a valid potential")
}

impl Recipe {
    fn scene(&self) -> Option<Scene> {
        let mut space = Space::periodic_cube(self.box_length);
        for axis in 0..3 {
            space.boundary[axis] = match self.boundary[axis] {
                0 => Boundary::Periodic,
                1 => Boundary::Bounded { lower: self.wall(), upper: self.wall() },
                _ => Boundary::OPEN,
            };
        }
        let gravity = if self.gravity { Vector::new(0.25, 0.0, -1.0) } else { Vector::zeros() };
        let mut builder = SceneBuilder::new("random")
            .seed(self.seed)
            .space(space)
            .gravity(gravity)
            .species(SpeciesDraft::new("A").mass(self.masses[0]).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(self.masses[1]).diameter(1.2))
            .species(SpeciesDraft::new("S").diameter(1.0).fixed());
        let interaction = |potential: Potential| {
            let has_core = potential.core().is_some() && !potential.is_bond();
            let draft = InteractionDraft::new(potential).restitution(self.restitution);
            match self.roughness.filter(|_| has_core) {
                Some([tangential, friction]) => draft.tangential_restitution(tangential).friction(friction),
                None => draft,
            }
        };
        let kind = |next: usize| interaction(potential((self.potential + next) % 6, self.depth));
        builder = builder
            .interaction(kind(0).between("A", "A"))
            .interaction(kind(1).between("A", "B"))
            .interaction(interaction(Potential::hard_sphere(1.2).ok()?).between("B", "B"))
            .interaction(kind(2).between("A", "S"))
            .interaction(interaction(Potential::hard_sphere(1.1).ok()?).between("B", "S"))
            .interaction(interaction(Potential::bond(0.3, 3.0).ok()?).named("link"));
        if let Some(time) = self.contact_time {
            let rule = if self.seed % 7 < 2 { TcRule::LudingMcNamara } else { TcRule::Resting };
            builder = builder.contact_time(time).tc_rule(rule);
        }
        // Static particles and bonded pairs come first, so that their ids are known.
        let at = |x: f64, y: f64, z: f64| Vector::new(x, y, z) * (self.box_length / 8.0);
        for k in 0..self.statics {
            builder = builder.particle("S", at(1.0 + 2.0 * k as f64, 1.0, 1.0), Vector::zeros());
        }
        for k in 0..self.bonds {
            // The bonds have different velocities. Otherwise, pairs would collide at the same time.
            let (x, part) = (1.0 + 2.0 * k as f64, 0.07 * (k * k) as f64);
            let first = u32::try_from(self.statics + 2 * k).unwrap();
            builder = builder
                .particle("A", at(x, 4.0, 1.0), Vector::new(0.1 * x, part - 0.7, 0.9 - 0.7 * part))
                .particle("A", at(x, 6.0, 1.0), Vector::new(0.4 * part - 0.3, 0.5 * x, 0.2 + part * part))
                .bond([first, first + 1], "link");
        }
        let mut fill = Fill::new(Lattice::SimpleCubic, "A").count(self.count);
        fill.composition = vec![("A".into(), 0.6), ("B".into(), 0.4)];
        fill.temperature = Some(1.0);
        let region = carom::model::Region { lower: at(0.1, 0.1, 2.6), upper: at(7.9, 7.9, 7.9) };
        fill.region = Some(carom::scene::FillRegion::Box(region));
        if !space_is_periodic(&self.boundary) {
            for surface in surfaces(self.surfaces, self.box_length, self.restitution) {
                let surface = self.roughened(surface);
                builder = builder.surface(motions(self.motion).into_iter().fold(surface, SurfaceDraft::motion));
            }
        }
        builder.fill(fill).build().ok()
    }
}

impl Recipe {
    fn roughened(&self, surface: SurfaceDraft) -> SurfaceDraft {
        let Some([tangential, friction]) = self.roughness else { return surface };
        let rough = surface.tangential_restitution(tangential).friction(friction);
        match self.seed % 3 {
            0 => rough,
            1 => rough.surface_velocity(SurfaceVelocity::Translation { velocity: Vector::new(0.4, -0.3, 0.7) }),
            _ => rough.surface_velocity(SurfaceVelocity::Rotation {
                point: Vector::new(3.0, 4.5, 2.0),
                axis: Vector::new(0.3, -0.2, 1.0),
                frequency: 0.03,
            }),
        }
    }

    fn wall(&self) -> Face {
        let law = ContactLaw { restitution: self.restitution, ..ContactLaw::smooth(1.0) };
        let rough =
            |[tangential, friction]: [f64; 2]| law.with_tangential_restitution(tangential).with_friction(friction);
        Face::Wall(self.roughness.map_or(law, rough))
    }
}

fn space_is_periodic(boundary: &[usize; 3]) -> bool {
    boundary.contains(&0)
}

fn pair(event: &Event) -> (u32, Option<u32>) {
    match event.partner() {
        Some(partner) => (event.particle.0.min(partner.0), Some(event.particle.0.max(partner.0))),
        None => (event.particle.0, None),
    }
}

fn kind(event: &Event) -> Option<reference::EventKind> {
    match event.kind {
        EventKind::Pair(Outcome::Core) => Some(reference::EventKind::Pair(reference::Outcome::Core)),
        EventKind::Pair(Outcome::Capture) => Some(reference::EventKind::Pair(reference::Outcome::Capture)),
        EventKind::Pair(Outcome::Release) => Some(reference::EventKind::Pair(reference::Outcome::Release)),
        EventKind::Pair(Outcome::Bounce) => Some(reference::EventKind::Pair(reference::Outcome::Bounce)),
        EventKind::Surface => match (event.wall(), event.other) {
            (Some((axis, is_upper)), _) => Some(reference::EventKind::Wall { axis, is_upper }),
            (None, Other::Surface { surface, .. }) => {
                Some(reference::EventKind::Surface { number: surface as usize - 6 })
            }
            _ => None,
        },
        _ => None,
    }
}

fn fast_events(scene: &Scene, count: usize) -> Vec<Event> {
    let mut events = Vec::new();
    let mut simulation = Simulation::without_plan(scene.clone());
    let until = Until::time(LONGEST).or_events(count as u64);
    let _ = simulation.advance_with(until, |event| events.push(*event));
    events
}

/// A comparison ends before the first contact with a smaller normal velocity `v`. The contact time may be wrong by
/// [`TOLERANCE`] divided by `v`.
const SLOWEST: f64 = 1e-3;

/// A comparison is cut short if round-off may decide the order of two events, or at a contact slower than [`SLOWEST`].
struct Compared {
    events: usize,
    is_cut_short: bool,
}

fn compare(scene: &Scene) -> Result<Compared, TestCaseError> {
    compare_events(scene, EVENTS)
}

fn compare_events(scene: &Scene, count: usize) -> Result<Compared, TestCaseError> {
    let mut reference = Reference::new(scene).map_err(|error| TestCaseError::fail(error.to_string()))?;
    let fast = fast_events(scene, count);
    let expected: Vec<_> = std::iter::from_fn(|| reference.step_before(LONGEST)).take(count).collect();
    for (k, ours) in fast.iter().enumerate() {
        let Some(theirs) = expected.get(k) else { break };
        let speed = (theirs.before[0] - theirs.before[1]).dot(&theirs.normal).abs();
        if speed < SLOWEST || expected.get(k + 1).is_some_and(|next| next.time - theirs.time < TOLERANCE) {
            return Ok(Compared { events: k, is_cut_short: true });
        }
        let between = (theirs.particle.0, theirs.partner.map(|partner| partner.0));
        prop_assert_eq!((kind(ours), pair(ours)), (Some(theirs.kind), between), "event {}: {:?} {:?}", k, ours, theirs);
        prop_assert!((ours.time - theirs.time).abs() < TOLERANCE, "event {k}: {ours:?} {theirs:?}");
        prop_assert!(
            (ours.normal_impulse().abs() - theirs.impulse.abs()).abs() < 1e3 * TOLERANCE,
            "{ours:?} {theirs:?}"
        );
        let torques =
            if ours.particle == theirs.particle { theirs.torques } else { [theirs.torques[1], theirs.torques[0]] };
        for (one, other) in ours.torques.iter().zip(&torques) {
            prop_assert!((one - other).norm() < 1e3 * TOLERANCE, "event {k}: {ours:?} {theirs:?}");
        }
        let lost = (ours.dissipated - theirs.dissipated).abs();
        prop_assert!(lost < 1e3 * TOLERANCE, "event {k}: {ours:?} {theirs:?}");
        // The work done by a surface is computed from velocities, so it contains rounding errors.
        let rounding = if ours.kind == EventKind::Surface { 1e2 * TOLERANCE } else { 1e-12 };
        prop_assert!((ours.energy_step - theirs.energy_step).abs() < rounding, "{ours:?} {theirs:?}");
    }
    prop_assert_eq!(fast.len(), expected.len());
    Ok(Compared { events: fast.len(), is_cut_short: false })
}

const CASES: u32 = 400;

/// Smallest total number of compared events. It is five standard deviations below the average of twelve runs, 15,480.
const FEWEST: usize = 14_880;

/// Largest number of comparisons that rounding may cut short. It is five Poisson standard deviations above the average
/// of 6. All of these scenes collapse on a wall or at the end of a bond.
const MOST_CUT_SHORT: usize = 18;

#[test]
fn the_fast_engine_executes_the_events_of_the_reference() {
    let mut runner = TestRunner::new(ProptestConfig { cases: CASES, ..ProptestConfig::default() });
    let (compared, cut_short) = (Cell::new(0), Cell::new(0));
    let result = runner.run(&recipe(), |recipe| {
        let Some(scene) = recipe.scene() else { return Err(TestCaseError::reject("no such scene")) };
        let Compared { events, is_cut_short } = compare(&scene)?;
        compared.set(compared.get() + events);
        cut_short.set(cut_short.get() + usize::from(is_cut_short));
        Ok(())
    });
    result.unwrap_or_else(|failure| panic!("{failure}"));
    println!("{} events compared, {} scenes cut short", compared.get(), cut_short.get());
    assert!(compared.get() >= FEWEST, "{} events", compared.get());
    assert!(cut_short.get() <= MOST_CUT_SHORT, "{} scenes cut short", cut_short.get());
}

#[test]
fn engines_agree_on_the_first_events_of_a_hard_sphere_fluid() {
    let scene = SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.45))
        .temperature(1.0)
        .seed(3)
        .build()
        .expect("a valid scene");
    assert_eq!(
        Simulation::without_plan(scene.clone()).engine().to_string().split(',').nth(1),
        Some(" one hard-sphere species")
    );
    let compared = compare(&scene).expect("the engines agree");
    assert_eq!((compared.events, compared.is_cut_short), (EVENTS, false));
}

#[test]
fn both_engines_meet_walls() {
    let count =
        |scene: &Scene| fast_events(scene, EVENTS).iter().filter(|event| event.kind == EventKind::Surface).count();
    let recipe = Recipe {
        seed: 1,
        count: 12,
        potential: 1,
        boundary: [1, 1, 1],
        gravity: true,
        restitution: Restitution::Constant(0.9),
        statics: 2,
        bonds: 2,
        ..PLAIN
    };
    let scene = recipe.scene().expect("a valid scene");
    assert!(count(&scene) > 0);
    assert_eq!(compare(&scene).expect("the engines agree").events, EVENTS);
}

/// `CAROM_MOVING_SCENES` sets the number of scenes for each combination of surfaces and motion.
#[test]
fn both_engines_meet_surfaces_of_every_kind() {
    let moving: usize = std::env::var("CAROM_MOVING_SCENES").map_or(4, |scenes| scenes.parse().unwrap());
    for (surfaces, motion) in (1..6).flat_map(|surfaces| (0..5).map(move |motion| (surfaces, motion))) {
        let (mut met, mut compared, mut cut_short) = (0, 0, 0);
        let scenes = if motion == 0 { 40 } else { moving };
        for seed in 1..=scenes as u64 {
            let recipe = Recipe {
                seed,
                count: 12,
                masses: [0.7, 3.1],
                gravity: seed % 3 == 0,
                restitution: Restitution::Constant(if seed % 2 == 0 { 1.0 } else { 0.8 }),
                statics: 1,
                bonds: (seed % 2) as usize,
                contact_time: (seed % 5 == 0).then_some(1e-3),
                roughness: (seed % 4 < 2).then_some([0.3, 0.4]),
                box_length: 6.0,
                surfaces,
                motion,
                ..PLAIN
            };
            let scene = recipe.scene().expect("a valid scene");
            let is_surface = |event: &&Event| event.kind == EventKind::Surface;
            met += fast_events(&scene, EVENTS).iter().filter(is_surface).count();
            let found = compare(&scene)
                .unwrap_or_else(|error| panic!("surfaces {surfaces}, motion {motion}, seed {seed}: {error}"));
            compared += found.events;
            cut_short += usize::from(found.is_cut_short);
        }
        println!("{surfaces} {motion}: {met} contacts, {compared} events, {cut_short} scenes cut short");
        assert!(met > 10 * scenes && compared > 30 * scenes && cut_short < scenes / 4, "{met} {compared} {cut_short}");
    }
}

#[test]
fn in_a_box_of_three_cells_the_second_nearest_image_is_met_too() {
    let recipe = Recipe { seed: 462_767, count: 10, boundary: [2, 0, 0], box_length: 5.0, ..PLAIN };
    let compared = compare(&recipe.scene().expect("a valid scene")).expect("the engines agree");
    assert!(!compared.is_cut_short && compared.events >= 20, "{}", compared.events);
}
