//! Pairs with an interaction of their own, which separate and meet again through any side of a periodic box.

use carom::Vector;
use carom::engine::{Reason, Simulation, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

const RANGE: f64 = 1.5;

/// Returns the first time before `until` at which two free particles, in any images, come within `range`.
fn first_meeting(range: f64, size: &Vector, rate: f64, apart: &Vector, velocity: &Vector, until: f64) -> Option<f64> {
    let mut first = None;
    #[expect(clippy::cast_possible_truncation, reason = "some periods")]
    let periods = |travelled: f64| travelled.ceil() as i32 + 2;
    let most = |axis: usize| periods(velocity[axis].abs() * until / size[axis]);
    let ups = if size.y > 0.0 { -most(1)..=most(1) } else { 0..=0 };
    for up in ups {
        // In a sheared box, images farther up move faster.
        let faster = rate * size.y * f64::from(up);
        let most_beside = periods(((velocity.x - faster).abs() * until) / size.x);
        for beside in -most_beside..=most_beside {
            for deep in if size.z > 0.0 { -most(2)..=most(2) } else { 0..=0 } {
                let image = Vector::from([beside, up, deep].map(f64::from)).component_mul(size);
                let (r, v) = (apart - image, velocity - Vector::new(faster, 0.0, 0.0));
                let (b, v2) = (r.dot(&v), v.norm_squared());
                let root = b * b - v2 * (r.norm_squared() - range * range);
                if b < 0.0 && root > 0.0 {
                    let time = (-b - root.sqrt()) / v2;
                    first = if time < first.unwrap_or(until) { Some(time) } else { first };
                }
            }
        }
    }
    first
}

/// Two particles with their own interaction. The other particles are at rest and interact with nothing.
fn scene(space: &Space, rate: Option<f64>, own: Potential, states: [(Vector, Vector); 2], others: u32) -> Scene {
    let mut builder = SceneBuilder::new("apart")
        .space(space.clone())
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .species(SpeciesDraft::new("B").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .interaction(InteractionDraft::new(Model::None).between("A", "B"))
        .interaction(InteractionDraft::new(Model::None).between("B", "B"))
        .interaction(InteractionDraft::new(own).named("own"))
        .bond([0, 1], "own");
    for (position, velocity) in states {
        builder = builder.particle("A", position, velocity);
    }
    for other in 0..others {
        let part = |factor: f64| (f64::from(other) * factor).fract();
        let place = Vector::new(part(0.618), part(0.414), part(0.732)).component_mul(&space.size);
        builder = builder.particle("B", space.lower + place, Vector::zeros());
    }
    if let Some(rate) = rate {
        builder = builder.shear(rate);
    }
    builder.build().unwrap()
}

fn well(range: f64) -> Potential {
    Potential::square_well(1.0, range, 1.0).unwrap()
}

fn first_event(scene: Scene, until: f64) -> Option<f64> {
    let mut found = None;
    let until = Until::time(until).or_events(1);
    Simulation::without_plan(scene).advance_with(until, |event| found = found.or(Some(event.time))).unwrap();
    found
}

#[test]
fn pair_meets_in_the_first_image_within_range() {
    let flat = [Boundary::Periodic, Boundary::Periodic, Boundary::Flat];
    let boxes = [
        (Vector::new(10.0, 10.0, 10.0), [Boundary::Periodic; 3], None),
        (Vector::new(3.5, 5.0, 6.5), [Boundary::Periodic; 3], None),
        (Vector::new(9.0, 13.0, 0.0), flat, None),
        (Vector::new(9.0, 7.0, 8.0), [Boundary::Periodic; 3], Some(0.7)),
        (Vector::new(7.0, 9.0, 0.0), flat, Some(-2.0)),
    ];
    let mut random = ChaCha8Rng::seed_from_u64(11);
    let mut next = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let (mut met, mut far) = (0, 0);
    for (size, boundary, rate) in boxes {
        let space = Space { lower: Vector::new(-1.0, 2.0, 0.5), size, boundary };
        for case in 0..60 {
            let mut random_vector = |scale: f64| {
                let vector = Vector::new(next() - 0.5, next() - 0.5, next() - 0.5) * scale;
                if size.z == 0.0 { Vector::new(vector.x, vector.y, 0.0) } else { vector }
            };
            let (velocity, half) = (random_vector(4.0), random_vector(0.2));
            let direction = Vector::new(0.8, 0.55, 0.0);
            let middle = space.lower + 0.5 * size;
            let (a, b) = (middle + direction + half, middle - direction);
            let until = 6.0;
            let expected = first_meeting(RANGE, &size, rate.unwrap_or(0.0), &(a - b), &(2.0 * velocity), until);
            // With few particles, the engine uses neighbour lists. With many particles, it uses cells.
            let others = if case % 2 == 0 { 0 } else { 60 };
            let found = first_event(scene(&space, rate, well(RANGE), [(a, velocity), (b, -velocity)], others), until);
            match (found, expected) {
                (Some(found), Some(expected)) => {
                    assert!((found - expected).abs() < 1e-9, "{size} {rate:?} {case}: {found} {expected}");
                }
                _ => assert_eq!(found, expected, "{size} {rate:?} {case}: {velocity}"),
            }
            met += u32::from(expected.is_some());
            far += u32::from(expected.is_some_and(|time| time * 2.0 * velocity.amax() > size.max()));
        }
    }
    assert!(met > 100 && far > 10, "{met} {far}");
}

#[test]
fn pair_meets_across_cell_rows_after_many_image_passages() {
    // The particles do not move along y. One particle drifts slowly along z, into the range of a passing image.
    let (size, range) = (Vector::repeat(10.0), 4.6);
    let states =
        [(Vector::new(1.0, 2.1, 2.9), Vector::new(0.0, 0.0, -0.0025)), (Vector::new(6.0, 7.9, 1.0), Vector::zeros())];
    let apart = states[0].0 - states[1].0;
    for rate in [0.5, -0.5] {
        let expected = first_meeting(range, &size, rate, &apart, &states[0].1, 30.0).unwrap();
        assert!(expected > 10.0, "{expected}");
        let found = first_event(scene(&Space::periodic_cube(10.0), Some(rate), well(range), states, 60), 30.0);
        assert!((found.unwrap() - expected).abs() < 1e-9, "{found:?} {expected}");
    }
}

#[test]
fn bond_longer_than_a_cell_ends_correctly_across_sliding_sides() {
    let bond = [0.9, 4.3];
    let mut random = ChaCha8Rng::seed_from_u64(5);
    let mut next = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut across = [0; 2];
    for case in 0..800 {
        let rate = if case % 2 == 0 { 0.5 } else { -1.3 };
        let size = Vector::new(10.0, 11.0, 9.0);
        let space = Space { lower: Vector::new(-1.0, 2.0, 0.5), size, boundary: [Boundary::Periodic; 3] };
        let mut random_vector = |scale: f64| Vector::new(next() - 0.5, next() - 0.5, next() - 0.5) * scale;
        let place = space.lower + (random_vector(1.0).add_scalar(0.5)).component_mul(&size);
        let apart = random_vector(1.0).normalize() * (1.0 + 1.5 * f64::from(case % 3));
        let velocities = [random_vector(4.0), random_vector(4.0)];
        let v = velocities[0] - velocities[1];
        let (r2, b, v2) = (apart.norm_squared(), apart.dot(&v), v.norm_squared());
        let root = |distance: f64| (b * b - v2 * (r2 - distance * distance)).sqrt();
        // `inner` is NaN if the particles do not reach the inner end of the bond.
        let (inner, outer) = ((-b - root(bond[0])) / v2, (root(bond[1]) - b) / v2);
        let expected = if b < 0.0 && inner > 0.0 { inner } else { outer };
        // The second particle is wrapped into the box. In a sheared box, wrapping along y changes the velocity along x.
        let mut other = (place - apart, velocities[1]);
        for axis in 0..3 {
            let periods = ((other.0[axis] - space.lower[axis]) / size[axis]).floor();
            other.0[axis] -= periods * size[axis];
            if axis == 1 && periods != 0.0 {
                other.1.x -= periods * rate * size.y;
                let rows = [place, other.0].map(|at| ((at.y - space.lower.y) / 2.2).floor());
                across[usize::from(rows.iter().any(|row| (1.0..=3.0).contains(row)))] += 1;
            }
        }
        let own = Potential::bond(bond[0], bond[1]).unwrap();
        let found = first_event(scene(&space, Some(rate), own, [(place, velocities[0]), other], 60), 100.0).unwrap();
        assert!((found - expected).abs() < 1e-9 * (1.0 + expected), "{case}: {found} {expected}");
    }
    assert!(across.iter().all(|count| *count > 15), "{across:?}");
}

#[test]
fn an_overstretched_bond_that_closes_across_a_side_is_left_alone() {
    // The neighbour list does not contain the bonded particle, which is 8 away across a periodic side.
    let at = |x: f64, speed: f64| (Vector::new(x, 10.0, 10.0), Vector::new(speed, 0.0, 0.0));
    for others in [0, 30, 200] {
        let mut builder = SceneBuilder::new("overstretched")
            .space(Space::periodic_cube(20.0))
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .species(SpeciesDraft::new("B").mass(1.0).diameter(0.1))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .interaction(InteractionDraft::new(Model::None).between("A", "B"))
            .interaction(InteractionDraft::new(Model::None).between("B", "B"))
            .interaction(InteractionDraft::new(Potential::bond(0.9, 1.3).unwrap()).named("link"))
            .bond([0, 1], "link")
            .allow_invalid_start(true);
        for (position, velocity) in [at(7.0, -1.0), at(19.0, 1.0)] {
            builder = builder.particle("A", position, velocity);
        }
        for other in 0..others {
            let at = Vector::new(0.618, 0.414, 0.732) * f64::from(other);
            builder = builder.particle("B", at.map(f64::fract) * 20.0, Vector::zeros());
        }
        let found = first_event(builder.build().unwrap(), 10.0).unwrap();
        assert!((found - 0.5 * (8.0 - 0.9)).abs() < 1e-9, "{others}: {found}");
    }
}

#[test]
fn advancing_to_a_past_time_does_nothing() {
    let states =
        [(Vector::new(1.0, 2.0, 3.0), Vector::new(1.0, 0.5, 0.0)), (Vector::new(6.0, 7.0, 1.0), Vector::zeros())];
    let mut simulation = Simulation::without_plan(scene(&Space::periodic_cube(10.0), None, well(RANGE), states, 60));
    simulation.advance(Until::time(3.0)).unwrap();
    let before = simulation.snapshot();
    assert_eq!(simulation.advance(Until::time(1.0)).unwrap(), Reason::Time);
    assert_eq!((simulation.time(), &simulation.snapshot().positions), (3.0, &before.positions));
    assert!(simulation.events(Until::time(2.0)).next().is_none());
    assert_eq!(simulation.time(), 3.0);
}
