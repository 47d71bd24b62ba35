//! Compares the intersection test with a search for separating planes in integer arithmetic.

use super::super::crossing::meet;
use super::super::pairs::self_intersections;
use super::super::tree::Tree;
use super::*;

type Whole = [i128; 3];

fn difference(a: Whole, b: Whole) -> Whole {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn cross(a: Whole, b: Whole) -> Whole {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn dot(a: Whole, b: Whole) -> i128 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn sides(corners: &[Whole]) -> Vec<Whole> {
    (0..corners.len()).map(|k| difference(corners[(k + 1) % corners.len()], corners[k])).collect()
}

/// Whether a plane separates a triangle from another triangle or a segment.
fn are_separate(one: &[Whole], triangle: &[Whole; 3]) -> bool {
    let normal = |corners: &[Whole]| {
        corners.get(2).map(|c| cross(difference(corners[1], corners[0]), difference(*c, corners[0])))
    };
    let mut axes: Vec<Whole> = [normal(one), normal(triangle)].into_iter().flatten().collect();
    for side in sides(one).into_iter().chain(sides(triangle)) {
        axes.extend([normal(one), normal(triangle)].into_iter().flatten().map(|normal| cross(normal, side)));
    }
    for side in sides(one) {
        axes.extend(sides(triangle).into_iter().map(|other| cross(side, other)));
    }
    let range = |corners: &[Whole], axis: Whole| {
        let places: Vec<i128> = corners.iter().map(|corner| dot(*corner, axis)).collect();
        (*places.iter().min().unwrap(), *places.iter().max().unwrap())
    };
    axes.iter().any(|axis| {
        let ((lower, upper), (other_lower, other_upper)) = (range(one, *axis), range(triangle, *axis));
        upper < other_lower || other_upper < lower
    })
}

/// Tests with integers whether two triangles intersect outside their shared corners. If one corner is shared, the
/// second triangle is enlarged about this corner, and tested against the opposite edge of the first triangle.
fn meet_in_whole_numbers(one: &[Whole; 3], two: &[Whole; 3]) -> bool {
    let not_in = |corners: &[Whole; 3], other: &[Whole; 3]| -> Vec<Whole> {
        corners.iter().copied().filter(|corner| !other.contains(corner)).collect()
    };
    let (a, b) = (not_in(one, two), not_in(two, one));
    let Some(shared) = one.iter().find(|corner| two.contains(corner)) else { return !are_separate(one, two) };
    match a.len() {
        2 => {
            let far = |corner: Whole| [0, 1, 2].map(|k| shared[k] + 100_000 * (corner[k] - shared[k]));
            !are_separate(&a, &[*shared, far(b[0]), far(b[1])])
        }
        1 => {
            let edge: Vec<Whole> = one.iter().copied().filter(|corner| two.contains(corner)).collect();
            let along = difference(edge[1], edge[0]);
            let [n, m] = [a[0], b[0]].map(|corner| cross(along, difference(corner, edge[0])));
            cross(n, m) == [0; 3] && dot(n, m) > 0
        }
        _ => false,
    }
}

#[test]
fn triangle_intersection_test_is_exact_on_integer_coordinates() {
    let mut random = ChaCha8Rng::seed_from_u64(4);
    let mut counts = [[0_usize; 2]; 4];
    for case in 0..400_000 {
        let range = 2 + case % 4;
        let mut corner = || [0; 3].map(|_: i128| i128::from(random.next_u32() % range));
        let mut one = [corner(), corner(), corner()];
        let mut two = [corner(), corner(), corner()];
        if case % 3 == 1 {
            two[1] = one[2];
        }
        if case % 9 == 2 {
            (two[2], two[0]) = (one[0], one[1]);
        }
        if case % 11 == 3 {
            // Moves all corners into one oblique plane.
            for corner in one.iter_mut().chain(&mut two) {
                corner[2] = corner[0] + 2 * corner[1];
            }
        }
        let is_flat = |[a, b, c]: [Whole; 3]| cross(difference(b, a), difference(c, a)) == [0; 3];
        if is_flat(one) || is_flat(two) {
            continue;
        }
        let expected = meet_in_whole_numbers(&one, &two);
        let real = |corners: [Whole; 3]| corners.map(|corner| Vector::from(corner.map(|x| x as f64)));
        // Neither the position of the triangles nor the order of corners changes the result.
        let shift = Vector::repeat(f64::from(random.next_u32() % 1000));
        let (r1, r2) = (real(one).map(|c| c + shift), real(two).map(|c| c + shift));
        let turn = (random.next_u32() % 3) as usize;
        let turned = [r1[turn], r1[(turn + 1) % 3], r1[(turn + 2) % 3]];
        assert_eq!(meet(&turned, &r2), expected, "{one:?} {two:?}");
        assert_eq!(meet(&[r2[1], r2[0], r2[2]], &r1), expected, "{one:?} {two:?}");
        let shared = one.iter().filter(|corner| two.contains(corner)).count();
        counts[shared][usize::from(expected)] += 1;
    }
    assert_eq!(counts[3][1], 0);
    assert!(counts[..3].iter().flatten().all(|count| *count > 500), "{counts:?}");
}

#[test]
fn intersection_test_resolves_one_float_around_a_face() {
    let face = [Vector::new(0.1, 0.2, 0.7), Vector::new(1.3, 0.1, 0.3), Vector::new(0.4, 1.7, 0.9)];
    // At step 0, the tip of the spike is the centroid of the face, up to round-off.
    let middle = face.iter().sum::<Vector>() / 3.0;
    let mut counts = [0; 2];
    for step in -3_i32..=3 {
        let mut tip = middle;
        for _ in 0..step.abs() {
            tip.z = if step > 0 { tip.z.next_up() } else { tip.z.next_down() };
        }
        let spike = [tip, Vector::new(0.5, 0.6, 5.0), Vector::new(0.7, 0.4, 5.0)];
        counts[usize::from(meet(&face, &spike))] += 1;
    }
    assert!(counts[0] >= 3 && counts[1] >= 3 && counts[0] + counts[1] == 7, "{counts:?}");
}

#[test]
fn tree_finds_the_same_intersections_as_brute_force() {
    let mut random = ChaCha8Rng::seed_from_u64(5);
    for case in 0..30 {
        let soup = (0..1 + case * 7).map(|k| {
            let at = vector(&mut random, 1.0);
            let thin = if k % 3 == 0 { 1e-9 } else { 0.3 };
            let along = vector(&mut random, 1.0);
            [at, at + along, at + along * 0.5 + vector(&mut random, thin)]
        });
        let mesh = TriangleMesh::welded(soup);
        let n = mesh.triangles.len();
        let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| [i, j]));
        let found: Vec<_> = pairs.filter(|&[i, j]| meet(&mesh.corners(i), &mesh.corners(j))).collect();
        let fault = self_intersections(&mesh, &Tree::of(&mesh));
        assert_eq!(fault, (PairFault { count: found.len(), first: found.first().copied() }, true));
    }
}
