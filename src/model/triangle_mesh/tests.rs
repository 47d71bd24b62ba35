use nalgebra::Rotation3;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::*;

fn tetrahedron() -> TriangleMesh {
    let [o, x, y, z] = [Vector::zeros(), Vector::x(), Vector::y(), Vector::z()];
    TriangleMesh::welded([[o, y, x], [o, x, z], [o, z, y], [x, y, z]].into_iter())
}

#[test]
fn vertices_are_numbered_as_they_appear_and_zeros_have_no_sign() {
    let mesh = tetrahedron();
    assert_eq!(mesh.vertices, [Vector::zeros(), Vector::y(), Vector::x(), Vector::z()]);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]]);
    let [a, b] = [Vector::new(-0.0, 1.0, 0.0), Vector::new(0.0, 1.0, -0.0)];
    let mesh = TriangleMesh::welded([[a, b, Vector::x()]].into_iter());
    assert_eq!(mesh.triangles, [[0, 0, 1]]);
    assert!(mesh.vertices[0].iter().all(|x| x.is_sign_positive()));
    let c = Vector::new(0.0, 1.0_f64.next_up(), 0.0);
    assert_eq!(TriangleMesh::welded([[a, c, b]].into_iter()).triangles, [[0, 1, 0]]);
}

#[test]
fn welding_agrees_with_a_search_through_all_vertices() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for points in [1, 5, 40, 3_000] {
        let mut point = || Vector::from_fn(|_, _| f64::from(random.next_u32() % points) - 7.0);
        let corners: Vec<[Vector; 3]> = (0..500).map(|_| [point(), point(), point()]).collect();
        let mesh = TriangleMesh::welded(corners.iter().copied());
        let mut vertices: Vec<Vector> = Vec::new();
        for (triangle, corners) in corners.iter().enumerate() {
            for (place, corner) in corners.iter().enumerate() {
                let number = vertices.iter().position(|vertex| vertex == corner).unwrap_or_else(|| {
                    vertices.push(*corner);
                    vertices.len() - 1
                });
                assert_eq!(mesh.triangles[triangle][place] as usize, number);
            }
        }
        assert_eq!(mesh.vertices, vertices);
    }
}

#[test]
fn measures_of_a_tetrahedron_are_exact() {
    let mesh = tetrahedron();
    assert_eq!(mesh.enclosed_volume(), 1.0 / 6.0);
    assert_eq!(mesh.area(), 1.5 + 3.0_f64.sqrt() / 2.0);
    assert_eq!(mesh.bounds(), [Vector::zeros(), Vector::repeat(1.0)]);
    // Products of coordinates far from the origin have errors much larger than the volume.
    let far = mesh.transformed(1.0, &Rotation3::identity(), &Vector::repeat(1e9));
    assert_eq!(far.enclosed_volume(), 1.0 / 6.0);
    assert_eq!(far.bounds(), [Vector::repeat(1e9), Vector::repeat(1e9 + 1.0)]);
}

#[test]
fn transform_scales_rotates_then_moves_and_keeps_normals_outward() {
    let quarter = Rotation3::from_matrix_unchecked(nalgebra::Matrix3::new(0., -1., 0., 1., 0., 0., 0., 0., 1.));
    let mesh = tetrahedron().transformed(2.0, &quarter, &Vector::new(10.0, 0.0, 0.0));
    assert_eq!(mesh.vertices[2], Vector::new(10.0, 2.0, 0.0));
    assert_eq!(mesh.enclosed_volume(), 8.0 / 6.0);
    let mirrored = tetrahedron().transformed(-2.0, &quarter, &Vector::zeros());
    assert_eq!(mirrored.enclosed_volume(), 8.0 / 6.0);
}

#[test]
fn edges_list_the_triangles_on_them() {
    let mesh = tetrahedron();
    let edges = mesh.edges();
    let found: Vec<[u32; 2]> = edges.iter().map(|uses| uses[0].ends).collect();
    assert_eq!(found, [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]]);
    for uses in edges.iter() {
        assert_eq!(uses.len(), 2);
        assert!(uses[0].triangle < uses[1].triangle);
        assert_ne!(uses[0].is_forward, uses[1].is_forward);
        for side in uses {
            let corners = mesh.triangles[side.triangle as usize];
            let [from, to] = if side.is_forward { side.ends } else { [side.ends[1], side.ends[0]] };
            assert!((0..3).any(|k| corners[k] == from && corners[(k + 1) % 3] == to));
        }
    }
    let mut collapsed = mesh.clone();
    collapsed.triangles.push([0, 0, 1]);
    assert_eq!(collapsed.edges(), mesh.edges());
}

#[test]
fn invalid_vertex_indices_give_nan_without_panic() {
    let mut mesh = tetrahedron();
    assert!(mesh.corners(4)[0].x.is_nan());
    assert_eq!(mesh.first_unusable(), None);
    mesh.triangles.push([0, 1, 9]);
    assert!(mesh.corners(4)[2].x.is_nan() && mesh.enclosed_volume().is_nan());
    assert_eq!(mesh.first_unusable(), Some(4));
    mesh.triangles.pop();
    mesh.vertices[3].z = 1e61;
    assert_eq!(mesh.first_unusable(), Some(1));
    let none = TriangleMesh::default();
    assert_eq!((none.area(), none.bounds(), none.first_unusable()), (0.0, [Vector::zeros(); 2], None));
    assert_eq!(none.edges().iter().count(), 0);
}

#[test]
fn mesh_survives_json_round_trip() {
    let text = serde_json::to_string(&tetrahedron()).unwrap();
    assert_eq!(serde_json::from_str::<TriangleMesh>(&text).unwrap(), tetrahedron());
}
