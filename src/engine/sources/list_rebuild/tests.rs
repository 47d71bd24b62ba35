use super::*;
use crate::engine::Until;
use crate::engine::predict::Scratch;
use crate::engine::predict::reach::tests::box_of_spheres;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Face, Space, minimum_image};
use crate::model::{ContactLaw, Scene};
use crate::physics::overlap::Side;
use crate::scene::{Arrangement, Fill, InteractionDraft, Lattice, SceneBuilder, SpeciesDraft};

/// Checks that each particle is within its skin, and that lists contain exactly the uncaptured pairs within reach.
pub(in crate::engine) fn are_complete<const FALLING: bool, const TABLE: bool>(
    engine: &Engine<FALLING, TABLE>,
    verlet: &VerletLists,
) {
    for particle in engine.particles().filter(|&p| !engine.is_static(p)) {
        let (position, _) = engine.state_at(particle, engine.clock.now);
        let gone = (position - verlet.centres[particle as usize]).norm();
        assert!(gone < verlet.half_skin * (1.0 + 1e-9), "{particle} left its half_skin: {gone}");
        let list = verlet.lists.of(particle);
        let is_moving = |other: &&u32| !engine.is_static(**other);
        assert!(list.iter().filter(is_moving).all(|other| verlet.lists.of(*other).contains(&particle)));
        for other in engine.particles() {
            let [a, b] = [particle, other].map(|id| verlet.centres[id as usize]);
            let apart = minimum_image(a - b, &engine.state.periods).norm();
            let species = [particle, other].map(|id| usize::from(engine.row(id)));
            let range = engine.ranges.at(species[0], species[1]);
            let is_captured = TABLE && engine.pairs.states.get(particle, other).is_some();
            // The reach may include a margin of one millionth of the skin. The factor `1 + 1e-14` allows for round-off.
            let is_near = |margin| apart < (range + 2.0 * verlet.half_skin * (1.0 + margin)) * (1.0 + 1e-14);
            let may_meet = other != particle && range > 0.0 && !is_captured;
            let times = list.iter().filter(|entry| **entry == other).count();
            assert!(times <= usize::from(may_meet && is_near(1e-6)), "{particle} {other} {times}");
            assert!(times >= usize::from(may_meet && is_near(0.0)), "{particle} misses {other}");
        }
    }
}

fn check<const FALLING: bool, const TABLE: bool>(scene: &Scene, events: u64) {
    let mut engine = Engine::<FALLING, TABLE>::new(scene);
    for part in 1..=10 {
        engine.advance(Until::events(events * part / 10), &mut None).unwrap();
        let Some(verlet) = engine.neighbours.verlet() else { continue };
        are_complete(&engine, verlet);
    }
    assert!(engine.neighbours.verlet().is_some(), "dense enough for lists in the end");
    assert!(engine.counts.totals.transition > 100, "only {} lists were made anew", engine.counts.totals.transition);
}

fn spheres() -> SceneBuilder {
    let hard = Potential::hard_sphere(1.0).unwrap();
    SceneBuilder::new("fluid")
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(hard).between("A", "A"))
}

fn fluid() -> Scene {
    let spheres = spheres().fill(Fill::new(Lattice::FaceCentredCubic, "A").count(500).packing_fraction(0.45));
    spheres.temperature(1.0).build().unwrap()
}

#[test]
fn lists_are_complete_in_a_fluid() {
    check::<false, false>(&fluid(), 20_000);
}

#[test]
fn rebuilt_lists_are_complete_for_particles_that_left_the_box() {
    let scene = fluid();
    let mut engine = Engine::<false, false>::new(&scene);
    engine.advance(Until::events(20_000), &mut None).unwrap();
    let now = engine.clock.now;
    let upper = scene.space().upper();
    let are_outside = |engine: &Engine<false, false>| {
        let is_outside =
            |at: &Vector| (0..3).any(|axis| at[axis] < scene.space().lower[axis] || at[axis] >= upper[axis]);
        engine.particles().filter(|&particle| is_outside(&engine.state_at(particle, now).0)).count()
    };
    assert!(are_outside(&engine) > 5);
    let search = engine.neighbours.search();
    engine.stream_all(now);
    engine.sort_in(search);
    engine.fill_lists();
    assert_eq!(are_outside(&engine), 0);
    are_complete(&engine, engine.neighbours.verlet().unwrap());
}

#[test]
fn lists_stay_complete_in_a_small_box_far_from_the_origin() {
    for lower in [1e4, -1e6, 1e8] {
        let space = Space { lower: Vector::repeat(lower), ..Space::periodic_cube(3.9) };
        let fill = Fill::new(Arrangement::Random, "A").count(32);
        check::<false, false>(&spheres().space(space).fill(fill).temperature(1.0).build().unwrap(), 3_000);
    }
}

/// `own` is the potential of species A, `mixed` the potential between A and B. Species B consists of hard spheres.
fn mixture(size: f64, (mass, diameter): (f64, f64), [own, mixed]: [Potential; 2], [first, second]: [u64; 2]) -> Scene {
    SceneBuilder::new("mixture")
        .space(Space::periodic_cube(size))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(mass).diameter(diameter))
        .interaction(InteractionDraft::new(own).between("A", "A"))
        .interaction(InteractionDraft::new(mixed).between("A", "B"))
        .interaction(InteractionDraft::new(Potential::hard_sphere(diameter).unwrap()).between("B", "B"))
        .fill(Fill::new(Arrangement::Random, "A").count(first))
        .fill(Fill::new(Arrangement::Random, "B").count(second))
        .temperature(1.0)
        .build()
        .unwrap()
}

#[test]
fn lists_are_complete_among_wells_of_two_sizes() {
    let wells = [1.0, 0.8].map(|diameter| Potential::square_well(diameter, 1.5, 1.0).unwrap());
    check::<false, true>(&mixture(12.0, (0.5, 0.6), wells, [500, 500]), 20_000);
}

#[test]
fn lists_are_complete_in_a_small_box_of_wells() {
    let well = Potential::square_well(1.0, 1.5, 0.8).unwrap();
    let shoulder = Potential::square_shoulder(0.9, 1.4, 0.4).unwrap();
    check::<false, true>(&mixture(4.1, (0.7, 0.8), [well, shoulder], [18, 17]), 20_000);
}

#[test]
fn lists_are_complete_for_grains_that_fall_on_static_ones() {
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(0.9)), upper: Face::Open };
    let hard = || Potential::hard_sphere(1.0).unwrap();
    let space = Space {
        lower: Vector::zeros(),
        size: Vector::new(12.0, 12.0, 12.0),
        boundary: [Boundary::Periodic, Boundary::walls(0.9), floor],
    };
    let mut builder = SceneBuilder::new("grains")
        .space(space)
        .gravity(Vector::new(0.0, 0.0, -1.0))
        .contact_time(1e-3)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("S").diameter(1.0).fixed())
        .interaction(InteractionDraft::new(hard()).between("A", "A").restitution(0.5))
        .interaction(InteractionDraft::new(hard()).between("A", "S").restitution(0.5));
    for k in 0..36 {
        let at = Vector::new(2.0 * f64::from(k % 6) + 1.0, 2.0 * f64::from(k / 6) + 1.0, 1.0);
        builder = builder.particle("S", at, Vector::zeros());
    }
    let region = (Vector::new(0.0, 0.5, 2.1), Vector::new(12.0, 11.5, 8.5));
    let fill = Fill::new(Arrangement::Random, "A").count(500).region(region.0, region.1);
    check::<true, true>(&builder.fill(fill).temperature(1.0).build().unwrap(), 200_000);
}

/// A few large spheres among many small ones.
fn unlike(space: Space, diameter: f64, [large, small]: [u64; 2]) -> SceneBuilder {
    let hard = |diameter| InteractionDraft::new(Potential::hard_sphere(diameter).unwrap()).restitution(0.8);
    SceneBuilder::new("unlike")
        .space(space)
        .species(SpeciesDraft::new("S").mass(0.3).diameter(1.0))
        .species(SpeciesDraft::new("L").mass(17.0).diameter(diameter))
        .interaction(hard(1.0).between("S", "S"))
        .interaction(hard(0.5 * (1.0 + diameter)).between("S", "L"))
        .interaction(hard(diameter).between("L", "L"))
        .fill(Fill::new(Arrangement::Random, "L").count(large))
        .fill(Fill::new(Arrangement::Random, "S").count(small))
        .temperature(1.0)
}

#[test]
fn lists_are_complete_among_spheres_of_very_different_sizes() {
    check::<false, true>(&unlike(Space::periodic_cube(24.0), 6.0, [8, 3_000]).build().unwrap(), 15_000);
    // The large spheres are almost as large as the box permits.
    check::<false, true>(&unlike(Space::periodic_cube(24.0), 10.0, [2, 1_500]).build().unwrap(), 10_000);
    let floor = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(0.9)), upper: Face::Open };
    let space = Space {
        lower: Vector::repeat(-10.0),
        size: Vector::repeat(20.0),
        boundary: [Boundary::Periodic, Boundary::walls(0.9), floor],
    };
    let grains = unlike(space, 4.5, [12, 1_500]).gravity(Vector::new(0.0, 0.0, -1.0)).contact_time(1e-3);
    check::<true, true>(&grains.build().unwrap(), 75_000);
}

/// Compares the predicted contact of each particle with the first contact among 125 images of every other particle.
/// Contacts after either particle has left its skin are ignored.
fn lists_hold_all_images<const TABLE: bool>(scene: &Scene) {
    let mut engine = Engine::<false, TABLE>::new(scene);
    assert!(engine.neighbours.verlet().is_some());
    let mut scratch = Scratch::new(scene.particles().len());
    let mut met = 0;
    for part in 1..=30 {
        engine.advance(Until::events(100 * part), &mut None).unwrap();
        let now = engine.clock.now;
        let period = engine.state.periods;
        for particle in engine.particles() {
            let me = engine.streamed(particle, now);
            let mut first = (f64::INFINITY, particle);
            for other in engine.particles().filter(|&other| other != particle) {
                let meeting = engine.pairs.rules.meeting(engine.row(particle), engine.row(other));
                let (nearest, _) = engine.relative(&me, other);
                for image in 0..125 {
                    let along = |k: i32| f64::from(image / 5_i32.pow(k as u32) % 5 - 2);
                    let mut state = nearest;
                    state.position += Vector::new(along(0), along(1), along(2)).component_mul(&period);
                    if let Some(dt) =
                        engine.detect(&me, other, &state, (meeting.squared, Side::Positive), f64::INFINITY)
                        && now + dt < first.0
                    {
                        first = (now + dt, other);
                    }
                }
            }
            let prediction = engine.predict(particle, now, &mut scratch);
            let leaves = engine.schedule.predictions[first.1 as usize].transition_time;
            if first.0 < prediction.transition_time.min(leaves) {
                assert_eq!((prediction.contact_time, prediction.partner), first, "{particle}");
                met += 1;
            }
        }
    }
    assert!(met > 30, "{met}");
}

#[test]
fn small_box_lists_cover_all_images() {
    for (count, packing_fraction) in [(16, 0.2), (32, 0.3), (32, 0.45), (108, 0.4)] {
        for is_mixture in [false, true] {
            let scene = box_of_spheres(count, packing_fraction, is_mixture, 0.0);
            if is_mixture { lists_hold_all_images::<true>(&scene) } else { lists_hold_all_images::<false>(&scene) }
        }
    }
}
