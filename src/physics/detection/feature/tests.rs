//! Contacts with triangles feature by feature, against the distance from the whole triangle, followed by conservative advancement.

use super::*;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

/// A number of `[0, 1)`.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    f64::from(random.next_u32()) / 4_294_967_296.0
}

/// The distance of a point from a triangle, from the nearest of its closed features, found by clamping.
fn distance(corners: &[Vector; 3], at: &Vector) -> f64 {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(&(c - a)).normalize();
    let to_segment = |a: Vector, b: Vector| {
        let along = ((at - a).dot(&(b - a)) / (b - a).norm_squared()).clamp(0.0, 1.0);
        (at - a - (b - a) * along).norm()
    };
    let is_over = [(a, b), (b, c), (c, a)].iter().all(|(p, q)| normal.cross(&(q - p)).dot(&(at - p)) >= 0.0);
    let edges = to_segment(a, b).min(to_segment(b, c)).min(to_segment(c, a));
    if is_over { normal.dot(&(at - a)).abs().min(edges) } else { edges }
}

/// The first time at which the distance is that of contact, by steps that cannot pass it; none before `end`.
fn by_advancement(corners: &[Vector; 3], state: &RelativeState, g: &Vector, contact: f64, end: f64) -> Option<f64> {
    let fastest = state.velocity.norm() + g.norm() * end;
    let mut t = 0.0;
    while t < end {
        let at = state.position + state.velocity * t + g * (0.5 * t * t);
        let gap = distance(corners, &at) - contact;
        if gap < 1e-11 {
            return Some(t);
        }
        t += gap / fastest;
    }
    None
}

/// The first contact with any of the features of a triangle.
fn by_features(corners: &[Vector; 3], state: &RelativeState, g: &Vector, contact: f64) -> Option<f64> {
    let from = |p: &Vector| RelativeState { position: state.position - p, velocity: state.velocity };
    let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0])).normalize();
    let sides = [0, 1, 2].map(|k| {
        let along = corners[(k + 1) % 3] - corners[k];
        Parabola::along(&normal.cross(&along).normalize(), &from(&corners[k]), g)
    });
    let mut found = vec![face(&Parabola::along(&normal, &from(&corners[0]), g), contact, &sides)];
    for k in 0..3 {
        let along = corners[(k + 1) % 3] - corners[k];
        found.push(segment(&along.normalize(), along.norm(), &from(&corners[k]), g, contact * contact));
        found.push(point(&from(&corners[k]), g, contact * contact, Side::Positive));
    }
    found.into_iter().flatten().reduce(f64::min)
}

#[test]
fn a_triangle_is_met_where_its_distance_says_in_straight_flight_and_in_a_fall() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut counts = [0_u32; 2];
    for case in 0..6_000 {
        let mut vector = |scale: f64| Vector::from_fn(|_, _| scale * (2.0 * uniform(&mut random) - 1.0));
        let mut corners = [vector(1.0), vector(1.0), vector(1.0)];
        if case % 5 == 0 {
            // Slivers.
            corners[2] = corners[0] * 0.3 + corners[1] * 0.7 + vector(1e-4);
        }
        let aim = corners.iter().sum::<Vector>() / 3.0 + vector(0.8);
        let position = vector(4.0);
        let g = if case % 2 == 0 { Vector::zeros() } else { vector(0.7) };
        let duration = 2.0;
        let velocity = (aim - position) / duration - g * (0.5 * duration);
        let state = RelativeState { position, velocity };
        let contact = 0.05 + 0.4 * uniform(&mut random);
        if distance(&corners, &position) < contact + 1e-3 {
            continue;
        }
        let end = 6.0;
        let expected = by_advancement(&corners, &state, &g, contact, end);
        let found = by_features(&corners, &state, &g, contact).filter(|t| *t < end);
        match (expected, found) {
            (Some(expected), Some(found)) => {
                // Advancement stops at a gap of 1e-11, reached at a grazing angle: the square root of it.
                let at = state.position + velocity * found + g * (0.5 * found * found);
                assert!((distance(&corners, &at) - contact).abs() < 1e-12, "{case}");
                assert!((found - expected).abs() < 1e-5, "{case}: {found} {expected}");
                counts[0] += 1;
            }
            (None, None) => counts[1] += 1,
            // A miss by less than advancement resolves.
            (Some(t), None) => {
                let at = |t: f64| state.position + velocity * t + g * (0.5 * t * t);
                let nearest = (0..2_000).map(|k| distance(&corners, &at(t + 1e-8 * f64::from(k)))).fold(9.0, f64::min);
                assert!(nearest > contact - 1e-12, "{case}: {nearest} {contact}");
            }
            (None, Some(found)) => panic!("{case}: {found} is none"),
        }
    }
    assert!(counts[0] > 2_000 && counts[1] > 500, "{counts:?}");
}

#[test]
fn a_foot_that_comes_onto_a_face_within_its_thickness_is_an_event_there() {
    // Half a unit above the face, falling, one unit beside it: over its edge at t = 1.
    let height = Parabola([0.5, -0.01, 0.0]);
    let extent = Parabola([-1.0, 1.0, 0.0]);
    assert_eq!(face(&height, 1.0, &[extent]), Some(1.0));
    // It rises: left alone.
    assert_eq!(face(&Parabola([0.5, 0.01, 0.0]), 1.0, &[extent]), None);
    // Beside it for ever, or on it only after it has passed to the other side.
    assert_eq!(face(&height, 1.0, &[Parabola([-1.0, 0.0, 0.0])]), None);
    assert_eq!(face(&Parabola([0.5, -1.0, 0.0]), 1.0, &[extent]), None);
    // From below.
    assert_eq!(face(&Parabola([-3.0, 2.0, 0.0]), 1.0, &[Parabola([0.0, 0.0, 0.0])]), Some(1.0));
}

#[test]
fn two_faces_with_a_common_edge_never_both_miss_a_foot() {
    // Along and across the edge, within rounding of it, at heights that differ by rounding.
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for case in 0..20_000 {
        let mut small = || f64::EPSILON * (f64::from(random.next_u32() % 9) - 4.0);
        let speed = if case % 3 == 0 { 0.0 } else { small() + if case % 3 == 1 { 0.3 } else { -0.3 } };
        let at = small() - speed;
        let side = Parabola([at, speed, 0.0]);
        let other = side.from_end(0.0);
        let first = face(&Parabola([2.0 + small(), -1.0, 0.0]), 1.0, &[side]);
        let second = face(&Parabola([2.0 + small(), -1.0, 0.0]), 1.0, &[other]);
        let met = [first, second].into_iter().flatten().reduce(f64::min);
        assert!(met.is_some_and(|t| (t - 1.0).abs() < 1e-14), "{case}: {first:?} {second:?}");
    }
}
