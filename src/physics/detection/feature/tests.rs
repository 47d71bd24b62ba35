//! Compares contacts with triangles with conservative advancement, and lets balls bounce inside closed meshes.

mod mesh;

use super::face;
use crate::Vector;
use crate::physics::detection::stretch::Parabola;
use crate::physics::motion::RelativeState;
use mesh::{Mesh, sphere};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    f64::from(random.next_u32()) / 4_294_967_296.0
}

fn vector(random: &mut ChaCha8Rng, scale: f64) -> Vector {
    Vector::from_fn(|_, _| scale * (2.0 * uniform(random) - 1.0))
}

/// Conservative advancement by the distance from the whole triangle. No step can pass the first contact.
fn by_advancement(mesh: &Mesh, state: &RelativeState, g: &Vector, contact: f64, end: f64) -> Option<f64> {
    let fastest = state.velocity.norm() + g.norm() * end;
    let mut t = 0.0;
    while t < end {
        let at = state.position + state.velocity * t + g * (0.5 * t * t);
        let gap = mesh.distance(&at) - contact;
        if gap < 1e-11 {
            return Some(t);
        }
        t += gap / fastest;
    }
    None
}

#[test]
fn triangle_contact_time_matches_distance_with_and_without_gravity() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut counts = [0_u32; 2];
    for case in 0..6_000 {
        let mut vector = |scale: f64| vector(&mut random, scale);
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
        let mesh = Mesh::new(corners.to_vec(), &[[0, 1, 2]]);
        let contact = 0.05 + 0.4 * uniform(&mut random);
        if mesh.distance(&position) < contact + 1e-3 {
            continue;
        }
        let end = 6.0;
        let expected = by_advancement(&mesh, &state, &g, contact, end);
        let found = mesh.next(&state, &g, contact).map(|(t, _)| t).filter(|t| *t < end);
        match (expected, found) {
            (Some(expected), Some(found)) => {
                // Advancement stops at a gap of 1e-11. At a grazing angle, the error of the time is about the root of
                // the gap.
                let at = state.position + velocity * found + g * (0.5 * found * found);
                assert!((mesh.distance(&at) - contact).abs() < 1e-12, "{case}");
                assert!((found - expected).abs() < 1e-5, "{case}: {found} {expected}");
                counts[0] += 1;
            }
            (None, None) => counts[1] += 1,
            // The ball misses the triangle by less than the resolution of the conservative advancement.
            (Some(t), None) => {
                let at = |t: f64| state.position + velocity * t + g * (0.5 * t * t);
                let nearest = (0..2_000).map(|k| mesh.distance(&at(t + 1e-8 * f64::from(k)))).fold(9.0, f64::min);
                assert!(nearest > contact - 1e-12, "{case}: {nearest} {contact}");
            }
            (None, Some(found)) => panic!("{case}: {found} is none"),
        }
    }
    assert!(counts[0] > 2_000 && counts[1] > 500, "{counts:?}");
}

#[test]
fn foot_entering_a_face_within_contact_height_is_an_event() {
    // The sphere is half a unit above the face and falls. It is over the edge of the face at t = 1.
    let height = Parabola([0.5, -0.01, 0.0]);
    let extent = Parabola([-1.0, 1.0, 0.0]);
    assert_eq!(face(&height, 1.0, &[extent]), Some(1.0));
    assert_eq!(face(&Parabola([0.5, 0.01, 0.0]), 1.0, &[extent]), None);
    // The foot is never on the face, or reaches it only after the sphere has passed to the other side.
    assert_eq!(face(&height, 1.0, &[Parabola([-1.0, 0.0, 0.0])]), None);
    assert_eq!(face(&Parabola([0.5, -1.0, 0.0]), 1.0, &[extent]), None);
    assert_eq!(face(&Parabola([-3.0, 2.0, 0.0]), 1.0, &[Parabola([0.0, 0.0, 0.0])]), Some(1.0));
}

#[test]
fn foot_entering_at_a_corner_hits_the_face() {
    // Two extents become positive almost together. At the computed root of one, rounding may make the other negative.
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for case in 0..20_000 {
        let at = 1.0 + uniform(&mut random);
        let mut rising = || {
            let (speed, bend) = (0.1 + uniform(&mut random), 0.1 * uniform(&mut random));
            Parabola([-at * (speed + bend * at), speed, bend])
        };
        let sides = [rising(), rising(), Parabola([1.0, 0.0, 0.0])];
        let met = face(&Parabola([2.0, -0.5, 0.0]), 1.5, &sides);
        assert!(met.is_some_and(|t| (t - at).abs() < 1e-13), "{case}: {met:?} {at}");
    }
    // The first extent becomes positive at t = 1.5. The second becomes negative at 1.5, one float earlier, or later.
    for (leaves, expected) in [(1.5, Some(1.5)), (1.5_f64.next_down(), None), (1.75, Some(1.5))] {
        let sides = [Parabola([-1.5, 1.0, 0.0]), Parabola([leaves, -1.0, 0.0])];
        assert_eq!(face(&Parabola([2.0, -0.5, 0.0]), 1.5, &sides), expected);
    }
    // In the first case, the first extent in the list becomes positive last. `dips` is negative from t = 1.5 to t = 2.
    let rising = |at: f64| Parabola([-at, 1.0, 0.0]);
    let dips = Parabola([1.5 * 2.0, -3.5, 1.0]);
    let height = Parabola([2.0, -0.5, 0.0]);
    assert_eq!(face(&height, 1.5, &[rising(1.75), rising(1.5), rising(1.25)]), Some(1.75));
    assert_eq!(face(&height, 1.5, &[dips, rising(1.25)]), Some(1.25));
    assert_eq!(face(&height, 1.5, &[dips, rising(1.625)]), Some(2.0));
}

#[test]
fn two_faces_with_a_common_edge_never_both_miss_a_foot() {
    // The sphere touches both faces while its foot crosses their common edge or stays on it, within rounding errors.
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

/// Lets a ball bounce inside a closed mesh and returns its deepest overlap.
fn bounce(mesh: &Mesh, radius: f64, g: Vector, restitution: f64, impacts: usize, random: &mut ChaCha8Rng) -> f64 {
    let mut ball = RelativeState { position: Vector::zeros(), velocity: vector(random, 1.0) };
    let mut deepest = 0.0_f64;
    for impact in 0..impacts {
        let (t, normal) = mesh.next(&ball, &g, radius).unwrap_or_else(|| panic!("{impact}: escapes"));
        ball.position += ball.velocity * t + g * (0.5 * t * t);
        ball.velocity += g * t;
        deepest = deepest.max(radius - mesh.distance(&ball.position));
        let vn = normal.dot(&ball.velocity);
        assert!(vn < 1e-7, "{impact}: it comes, {vn}");
        ball.velocity -= normal * ((1.0 + restitution) * vn.min(0.0));
        if ball.velocity.norm() < 0.3 {
            let push = vector(random, 1.0);
            ball.velocity += if push.dot(&normal) > 0.0 { push } else { -push };
        }
        assert!(mesh.is_inside(&ball.position), "{impact}");
    }
    deepest
}

fn impacts() -> usize {
    std::env::var("CAROM_IMPACTS").map_or(300, |impacts| impacts.parse().unwrap())
}

#[test]
fn a_ball_in_a_closed_mesh_never_leaves_it() {
    let mut random = ChaCha8Rng::seed_from_u64(17);
    let mut deepest = 0.0_f64;
    for case in 0..30 {
        let (mut points, triangles) = sphere(1 + case % 2);
        let rough = [0.0, 0.2, 0.5][case % 3];
        points.iter_mut().for_each(|point| *point *= 1.0 - rough * uniform(&mut random));
        if case % 5 == 0 {
            for [a, b, _] in triangles.iter().step_by(7) {
                points[*a] = points[*b] + vector(&mut random, 1.0) * 1e-6;
            }
        }
        let mesh = Mesh::new(points, &triangles);
        let room = mesh.distance(&Vector::zeros());
        for (k, restitution) in [1.0, 0.5].into_iter().enumerate() {
            let radius = room * (0.1 + 0.6 * uniform(&mut random));
            let g = if (case / 2 + k) % 2 == 0 { Vector::zeros() } else { vector(&mut random, 1.0) };
            deepest = deepest.max(bounce(&mesh, radius, g, restitution, impacts(), &mut random));
        }
    }
    assert!(deepest < 1e-13, "{deepest}");
}
