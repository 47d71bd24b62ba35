mod crossing;
mod inside;
mod thickness;

use nalgebra::Rotation3;
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};

use super::*;
use crate::mesh::shapes::{cuboid, disc, icosphere, torus};

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    f64::from(random.next_u32()) / 4_294_967_296.0
}

fn vector(random: &mut ChaCha8Rng, scale: f64) -> Vector {
    Vector::from_fn(|_, _| scale * (2.0 * uniform(random) - 1.0))
}

fn sphere() -> TriangleMesh {
    icosphere(&Vector::new(0.3, -0.2, 0.1), 1.5, 3).unwrap()
}

fn moved(mesh: &TriangleMesh, by: Vector) -> TriangleMesh {
    mesh.transformed(1.0, &Rotation3::identity(), &by)
}

fn both(one: &TriangleMesh, other: &TriangleMesh) -> TriangleMesh {
    let shift = u32::try_from(one.vertices.len()).unwrap();
    let mut mesh = one.clone();
    mesh.vertices.extend(&other.vertices);
    mesh.triangles.extend(other.triangles.iter().map(|numbers| numbers.map(|number| number + shift)));
    mesh
}

fn inside_out(mesh: &TriangleMesh) -> TriangleMesh {
    TriangleMesh { triangles: mesh.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect(), ..mesh.clone() }
}

#[track_caller]
fn assert_clean(mesh: &TriangleMesh) -> MeshReport {
    let report = MeshReport::of(mesh);
    assert_eq!(report.findings(), [], "{report:?}");
    assert!(report.is_closed() && report.is_oriented() && report.volume.is_some());
    report
}

#[test]
fn closed_surfaces_have_no_findings() {
    let report = assert_clean(&sphere());
    assert_eq!((report.vertices, report.triangles, report.parts), (642, 1280, 1));
    assert_eq!(report.orientation(), Some(Orientation::Outwards));
    assert_eq!((report.area, report.bounds), (sphere().area(), sphere().bounds()));
    assert!((report.volume.unwrap() / 14.137_166_941_154_07 - 1.0).abs() < 0.02);
    assert_eq!(assert_clean(&inside_out(&sphere())).orientation(), Some(Orientation::Inwards));
    let axis = Vector::new(1.0, 2.0, 3.0);
    for scale in [1.0, 1e6, 1e-6, 1e30, 1e-30] {
        let turned = Rotation3::new(Vector::new(0.3, 0.2, 0.1));
        let transformed = |mesh: &TriangleMesh| mesh.transformed(scale, &turned, &(scale * axis));
        let report = assert_clean(&transformed(&sphere()));
        assert!((report.volume.unwrap() / (scale * scale * scale) / sphere().enclosed_volume() - 1.0).abs() < 1e-12);
        assert_clean(&transformed(&torus(&axis, &axis, 2.0, 0.5, 0.01).unwrap()));
        assert_clean(&transformed(&cuboid(&-axis, &axis).unwrap()));
    }
}

#[test]
fn rough_and_flattened_spheres_have_no_findings() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    for case in 0..20 {
        // Vertices that move along rays from the centre produce spikes but no self-intersections.
        let mut mesh = icosphere(&Vector::zeros(), 1.0, 3).unwrap();
        mesh.vertices.iter_mut().for_each(|vertex| *vertex *= 0.05 + uniform(&mut random));
        assert_clean(&mesh);
        let flat = 10.0_f64.powi(-case % 7);
        mesh.vertices.iter_mut().for_each(|vertex| vertex.z *= flat);
        assert_clean(&mesh);
    }
}

#[test]
fn a_missing_triangle_leaves_three_open_edges() {
    let mut mesh = sphere();
    let [a, b, c] = mesh.corners(700);
    mesh.triangles.remove(700);
    let report = MeshReport::of(&mesh);
    assert_eq!(
        (report.open_edges.count, report.volume, report.is_closed(), report.is_oriented()),
        (3, None, false, true)
    );
    let ends = report.open_edges.first.unwrap();
    assert!(ends.iter().all(|end| [a, b, c].contains(end)) && ends[0] != ends[1]);
    assert!(matches!(report.findings()[..], [Finding::Open(_)]));
    assert_eq!(report.orientation(), None);
}

#[test]
fn flipped_triangle_makes_the_surface_unoriented() {
    let mut mesh = sphere();
    mesh.triangles[5].swap(0, 1);
    let report = MeshReport::of(&mesh);
    assert_eq!((report.turned_edges.count, report.volume, report.is_closed()), (3, None, true));
    assert!(matches!(report.findings()[..], [Finding::NotOriented(_)]));
}

#[test]
fn duplicate_triangle_is_reported_with_crowded_edges() {
    let mut mesh = sphere();
    let [a, b, c] = mesh.triangles[7];
    mesh.triangles.extend([[b, c, a], [b, a, c], mesh.triangles[3]]);
    let report = MeshReport::of(&mesh);
    assert_eq!(report.duplicates, PairFault { count: 3, first: Some([3, 1282]) });
    assert_eq!((report.crowded_edges.count, report.self_intersections.count, report.volume), (6, 0, None));
    assert!(matches!(report.findings()[..], [Finding::Crowded(_), Finding::Duplicates(_)]));
}

#[test]
fn spheres_meet_where_they_overlap_only() {
    let one = sphere();
    let apart = both(&one, &moved(&one, Vector::new(3.1, 0.0, 0.0)));
    let report = assert_clean(&apart);
    assert_eq!(report.parts, 2);
    let overlapping = both(&one, &moved(&one, Vector::new(1.0, 0.3, 0.2)));
    let report = MeshReport::of(&overlapping);
    assert!(report.self_intersections.count > 50);
    assert!(matches!(report.findings()[..], [Finding::SelfIntersections(_)]));
    let [first, second] = report.self_intersections.first.unwrap();
    assert!(first < 1280 && second >= 1280);
    let nested = both(&one, &one.transformed(0.5, &Rotation3::identity(), &Vector::zeros()));
    assert_eq!(assert_clean(&nested).parts, 2);
}

#[test]
fn degenerate_triangles_are_reported_and_surface_stays_closed() {
    let mut mesh = sphere();
    let [a, b, _] = mesh.triangles[9];
    mesh.triangles.push([a, a, b]);
    let report = MeshReport::of(&mesh);
    assert_eq!(report.degenerate, TriangleFault { count: 1, first: Some(1280) });
    assert!(report.is_closed() && matches!(report.findings()[..], [Finding::Degenerate(_)]));
    mesh.triangles.push([7, 7, 7]);
    assert_eq!(MeshReport::of(&mesh).degenerate.count, 2);
    // A triangle with a base of 8 is degenerate if its height is below 1.6e-11.
    let triangle = |height: f64| {
        let corners = [Vector::zeros(), Vector::new(8.0, 0.0, 0.0), Vector::new(4.0, 0.0, height)];
        MeshReport::of(&TriangleMesh::welded([corners].into_iter())).degenerate.count
    };
    assert_eq!([1.5e-11, 1.7e-11].map(triangle), [1, 0]);
    assert_eq!(triangle(0.0), 1);
}

#[test]
fn edges_with_three_triangles_and_separate_parts_are_counted() {
    let fin = |angle: f64| [Vector::zeros(), Vector::z(), Vector::new(angle.cos(), angle.sin(), 0.0)];
    let report = MeshReport::of(&TriangleMesh::welded([0.0, 1.0, 2.0].map(fin).into_iter()));
    assert_eq!((report.crowded_edges.count, report.open_edges.count, report.parts), (1, 6, 1));
    assert_eq!(report.crowded_edges.first, Some([Vector::zeros(), Vector::z()]));
    // The number of parts does not depend on the order of triangles, or on vertices without triangles.
    let mut random = ChaCha8Rng::seed_from_u64(3);
    for _ in 0..200 {
        let mut mesh = TriangleMesh { vertices: vec![Vector::zeros(); 30], triangles: Vec::new() };
        mesh.triangles = (0..random.next_u32() % 14).map(|_| [0; 3].map(|_: u32| random.next_u32() % 30)).collect();
        let mut labels: Vec<usize> = (0..30).collect();
        for _ in 0..30 {
            for numbers in &mesh.triangles {
                let least = numbers.iter().map(|number| labels[*number as usize]).min().unwrap();
                numbers.iter().for_each(|number| labels[*number as usize] = least);
            }
        }
        let mut used: Vec<usize> = mesh.triangles.iter().flatten().map(|number| labels[*number as usize]).collect();
        used.sort_unstable();
        used.dedup();
        assert_eq!(topology::parts(&mesh), used.len());
    }
}

#[test]
fn unusable_meshes_are_reported_without_further_checks() {
    let mut mesh = sphere();
    mesh.triangles[40][2] = 9_999;
    mesh.vertices[0].y = f64::NAN;
    let report = MeshReport::of(&mesh);
    let first = mesh.first_unusable();
    assert_eq!((report.vertices, report.triangles, report.unusable.first), (642, 1280, first));
    assert!(matches!(report.findings()[..], [Finding::Unusable(_)]) && !report.is_closed());
    assert!(!contains(&mesh, &Vector::zeros()));
    let _ = Inside::of(&mesh).contains(&Vector::zeros());
    assert!(matches!(MeshReport::of(&TriangleMesh::default()).findings()[..], [Finding::NoTriangle]));
    assert!(!Inside::of(&TriangleMesh::default()).contains(&Vector::zeros()));
}

#[test]
fn findings_say_what_is_wrong_where_and_what_to_do() {
    let [a, b] = [Vector::new(0.5, 0.0, -1.0), Vector::x()];
    let pair = PairFault { count: 2, first: Some([3, 8]) };
    let report = MeshReport {
        triangles: 9,
        is_searched: false,
        open_edges: EdgeFault { count: 1, first: Some([a, b]) },
        degenerate: TriangleFault { count: 1, first: Some(4) },
        duplicates: PairFault { count: 1, ..pair },
        self_intersections: PairFault { count: MOST_INTERSECTIONS, ..pair },
        ..MeshReport::default()
    };
    let texts: Vec<String> = report.findings().iter().map(ToString::to_string).collect();
    assert_eq!(
        texts,
        [
            "1 edge is on one triangle only: the surface has a rim, first from (0.5, 0, -1) to (1, 0, 0)",
            "1 triangle is of zero area, first triangle 4 (from 0)",
            "1 triangle with the same vertices as another triangle, first triangles 3 and 8 (from 0)",
            "at least 1000000 pairs of triangles intersect or overlap, first triangles 3 and 8 (from 0)",
        ]
    );
    assert!(report.findings().iter().all(|finding| !finding.cure().is_empty()));
    let report = MeshReport { triangles: 9, ..MeshReport::default() };
    assert!(matches!(report.findings()[..], [Finding::NotSearched]));
}
