//! Pairs with an interaction of their own that does not hold them: they meet again through any side of a periodic box.

use carom::Vector;
use carom::engine::{Simulation, Until};
use carom::model::Scene;
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::scene::SceneBuilder;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

const RANGE: f64 = 1.5;

/// When two that fly freely are first at their range, over all images that come by, up to a time.
fn first_meeting(size: &Vector, rate: f64, apart: &Vector, velocity: &Vector, until: f64) -> Option<f64> {
    let mut first = None;
    #[expect(clippy::cast_possible_truncation, reason = "some periods")]
    let periods = |travelled: f64| travelled.ceil() as i32 + 2;
    let most = |axis: usize| periods(velocity[axis].abs() * until / size[axis]);
    let ups = if size.y > 0.0 { -most(1)..=most(1) } else { 0..=0 };
    for up in ups {
        // The image further up is faster.
        let faster = rate * size.y * f64::from(up);
        let most_beside = periods(((velocity.x - faster).abs() * until) / size.x);
        for beside in -most_beside..=most_beside {
            for deep in if size.z > 0.0 { -most(2)..=most(2) } else { 0..=0 } {
                let image = Vector::from([beside, up, deep].map(f64::from)).component_mul(size);
                let (r, v) = (apart - image, velocity - Vector::new(faster, 0.0, 0.0));
                let (b, v2) = (r.dot(&v), v.norm_squared());
                let root = b * b - v2 * (r.norm_squared() - RANGE * RANGE);
                if b < 0.0 && root > 0.0 {
                    let time = (-b - root.sqrt()) / v2;
                    first = if time < first.unwrap_or(until) { Some(time) } else { first };
                }
            }
        }
    }
    first
}

/// The two, among so many others that rest and meet no other.
fn scene(space: &Space, rate: Option<f64>, states: [(Vector, Vector); 2], others: u32) -> Scene {
    let mut builder = SceneBuilder::new("apart")
        .space(space.clone())
        .species("A", 1.0, 1.0)
        .species("B", 1.0, 1.0)
        .interaction("A", "A", Potential::hard_sphere(1.0).unwrap(), 1.0)
        .no_interaction("A", "B")
        .no_interaction("B", "B")
        .bond_interaction("own", Potential::square_well(1.0, RANGE, 1.0).unwrap(), 1.0)
        .bond(0, 1, "own");
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

#[test]
fn they_meet_in_the_first_image_that_comes_by() {
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
            // Far apart in the middle of the box, and fast enough to go round it.
            let (velocity, half) = (random_vector(4.0), random_vector(0.2));
            let direction = Vector::new(0.8, 0.55, 0.0);
            let middle = space.lower + 0.5 * size;
            let (a, b) = (middle + direction + half, middle - direction);
            let until = 6.0;
            let expected = first_meeting(&size, rate.unwrap_or(0.0), &(a - b), &(2.0 * velocity), until);
            // Few have lists, many have cells.
            let others = if case % 2 == 0 { 0 } else { 60 };
            let mut simulation = Simulation::without_plan(scene(&space, rate, [(a, velocity), (b, -velocity)], others));
            let mut found = None;
            simulation
                .advance_with(Until { time: until, events: 1 }, |event| found = found.or(Some(event.time)))
                .unwrap();
            match (found, expected) {
                // Grazing within rounding may be missed.
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
