//! Compares the exact test for points inside with solid angles and with surfaces of known shape.

use super::*;

#[test]
fn rays_and_solid_angles_agree_and_find_what_is_inside() {
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let mut rough = icosphere(&Vector::zeros(), 1.0, 2).unwrap();
    rough.vertices.iter_mut().for_each(|vertex| *vertex *= 0.2 + uniform(&mut random));
    let shell = both(
        &sphere(),
        &inside_out(&moved(&sphere().transformed(0.4, &Rotation3::identity(), &Vector::zeros()), Vector::x() * 0.2)),
    );
    let ring = torus(&Vector::zeros(), &Vector::new(1.0, 1.0, 0.2), 1.0, 0.4, 0.02).unwrap();
    for mesh in [rough.clone(), inside_out(&rough), shell.clone(), ring.clone()] {
        let inside = Inside::of(&mesh);
        let mut counts = [0; 2];
        for _ in 0..1_500 {
            let point = vector(&mut random, 1.4);
            let found = inside.contains(&point);
            assert_eq!(found, contains(&mesh, &point), "{point}");
            counts[usize::from(found)] += 1;
        }
        assert!(counts[0] > 100 && counts[1] > 50, "{counts:?}");
    }
    let inside = Inside::of(&ring);
    let axis = Vector::new(1.0, 1.0, 0.2).normalize();
    for _ in 0..1_500 {
        let point = vector(&mut random, 1.4);
        let height = point.dot(&axis);
        let depth = 0.4 - ((point - axis * height).norm() - 1.0).hypot(height);
        assert!((-0.02..0.02).contains(&depth) || inside.contains(&point) == (depth > 0.0));
    }
    let cavity = Vector::new(0.3, -0.1, 0.05);
    assert!(!Inside::of(&shell).contains(&cavity) && !contains(&shell, &cavity));
    let twice = both(&sphere(), &moved(&sphere(), Vector::x()));
    assert_eq!(Inside::of(&twice).winding_number(&Vector::new(0.8, 0.0, 0.0)), 2);
    assert_eq!(Inside::of(&inside_out(&rough)).winding_number(&Vector::zeros()), -1);
}

#[test]
fn rays_through_edges_vertices_and_upright_faces_are_counted_once() {
    let (lower, upper) = (Vector::zeros(), Vector::new(2.0, 3.0, 4.0));
    let mesh = cuboid(&lower, &upper).unwrap();
    let fine = icosphere(&Vector::zeros(), 2.0, 2).unwrap();
    let (inside, inside_fine) = (Inside::of(&mesh), Inside::of(&fine));
    let steps = || (-4..=10).map(|k| 0.5 * f64::from(k));
    for point in steps().flat_map(|x| steps().flat_map(move |y| steps().map(move |z| Vector::new(x, y, z)))) {
        let is_on = |k: usize| lower[k] <= point[k] && point[k] <= upper[k];
        let is_in = |k: usize| lower[k] < point[k] && point[k] < upper[k];
        if (0..3).all(is_in) || !(0..3).all(is_on) {
            assert_eq!(inside.contains(&point), (0..3).all(is_in), "{point}");
        }
        if point.norm() < 1.8 || point.norm() > 2.0 {
            assert_eq!(inside_fine.contains(&point), point.norm() < 1.9, "{point}");
        }
    }
    for vertex in &fine.vertices {
        let below = Vector::new(vertex.x, vertex.y, -3.0);
        assert_eq!(inside_fine.winding_number(&below), 0);
        let [x, y] = [vertex.x, vertex.y];
        if x.hypot(y) < 1.8 {
            assert_eq!(inside_fine.winding_number(&Vector::new(x, y, 0.0)), 1, "{vertex}");
        }
    }
}

#[test]
fn points_one_float_off_a_face_are_on_their_side() {
    let mesh = cuboid(&Vector::new(0.1, 0.1, 0.1), &Vector::new(0.3, 0.7, 0.9)).unwrap();
    let inside = Inside::of(&mesh);
    let middle = Vector::new(0.2, 0.3, 0.5);
    for (axis, limits) in [[0.1_f64, 0.3], [0.1, 0.7], [0.1, 0.9]].into_iter().enumerate() {
        for (limit, is_upper) in limits.into_iter().zip([false, true]) {
            let mut point = middle;
            point[axis] = limit.next_up();
            assert_ne!(inside.contains(&point), is_upper);
            point[axis] = limit.next_down();
            assert_eq!(inside.contains(&point), is_upper);
        }
    }
}
