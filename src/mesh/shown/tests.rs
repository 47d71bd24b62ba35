use super::*;
use crate::model::space::{Face, Space};
use crate::model::{ContactLaw, SceneSurface, SurfaceLaw};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};

fn region(lower: [f64; 3], upper: [f64; 3], boundary: Boundary) -> Region {
    Region { lower: lower.into(), upper: upper.into(), boundary: [boundary; 3] }
}

fn triangles(region: &Region, shape: SurfaceShape) -> TriangleMesh {
    let surface = SceneSurface::new("it", shape, SurfaceLaw::Reflecting(ContactLaw::smooth(1.0)));
    region.triangles(&surface).into_owned()
}

fn plane(region: &Region, point: [f64; 3], normal: [f64; 3]) -> TriangleMesh {
    triangles(region, SurfaceShape::Plane { point: point.into(), normal: normal.into() })
}

#[test]
fn plane_is_drawn_as_its_cross_section_with_the_box() {
    let cube = region([0.0; 3], [2.0; 3], Boundary::walls(1.0));
    assert!((plane(&cube, [9.0, 9.0, 1.0], [0.0, 0.0, 3.0]).area() - 4.0).abs() < 1e-12);
    // A plane through the centre, perpendicular to a diagonal, cuts the cube in a regular hexagon of side sqrt(2).
    let hexagon = plane(&cube, [1.0; 3], [1.0; 3]);
    assert!((hexagon.area() - 1.5 * 3.0_f64.sqrt() * 2.0).abs() < 1e-9);
    assert_eq!(hexagon.triangles.len(), 4);
    let up = crate::model::triangle_mesh::twice_area(&hexagon.corners(0));
    assert!(up.dot(&Vector::repeat(1.0)) > 0.0, "it looks along its normal");
    // If the plane contains a side of the box, this side is shown.
    assert!((plane(&cube, [0.3, 0.1, 0.0], [0.0, 0.0, 1.0]).area() - 4.0).abs() < 1e-9);
    assert!(plane(&cube, [0.0, 0.0, -0.1], [0.0, 0.0, 1.0]).triangles.is_empty());
    assert!(plane(&cube, [0.0, 0.0, 1e40], [0.0, 0.0, 1.0]).triangles.is_empty());
}

#[test]
fn a_floor_below_an_open_side_is_shown() {
    let open = region([0.0; 3], [2.0; 3], Boundary::OPEN);
    let floor = plane(&open, [0.0, 0.0, -1.5], [0.0, 0.0, 1.0]);
    assert!((floor.area() - 4.0).abs() < 1e-9);
    assert!(floor.vertices.iter().all(|vertex| (vertex.z + 1.5).abs() < 1e-9));
    assert!(plane(&open, [0.0, 0.0, -1e3], [0.0, 0.0, 1.0]).triangles.is_empty(), "far away");
}

#[test]
fn spheres_and_capsules_are_round_and_look_to_the_particles() {
    let cube = region([-10.0; 3], [10.0; 3], Boundary::OPEN);
    let centre = Vector::new(1.0, -2.0, 3.0);
    for is_inside in [false, true] {
        let sphere = triangles(&cube, SurfaceShape::Sphere { centre, radius: 2.0, is_inside });
        assert!(sphere.vertices.iter().all(|vertex| ((vertex - centre).norm() - 2.0).abs() < 1e-12));
        let volume = sphere.enclosed_volume() * if is_inside { -1.0 } else { 1.0 };
        assert!((volume / (32.0 / 3.0 * PI) - 1.0).abs() < 0.02, "{volume}");
        assert!(sphere.edges().iter().all(|uses| uses.len() == 2), "it is closed");
    }
    let ends = [centre, centre + Vector::new(0.0, 3.0, 4.0)];
    let capsule = triangles(&cube, SurfaceShape::Capsule { ends, radius: 1.0 });
    assert!((capsule.enclosed_volume() / (PI * 5.0 + 4.0 / 3.0 * PI) - 1.0).abs() < 0.03);
    assert!(capsule.edges().iter().all(|uses| uses.len() == 2));
    let rod = triangles(&cube, SurfaceShape::Capsule { ends, radius: 0.0 });
    assert!(!rod.triangles.is_empty() && rod.area() < 10.0);
}

#[test]
fn a_cylinder_ends_at_the_box() {
    let shape = |axis: [f64; 3]| SurfaceShape::Cylinder {
        point: Vector::new(1.0, 1.0, 70.0),
        axis: axis.into(),
        radius: 0.5,
        is_inside: false,
    };
    for boundary in [Boundary::walls(1.0), Boundary::Periodic, Boundary::OPEN] {
        let cube = region([0.0; 3], [2.0; 3], boundary);
        let tube = triangles(&cube, shape([0.0, 0.0, -4.0]));
        assert!((tube.area() / (PI * 2.0) - 1.0).abs() < 2e-3, "{boundary:?}");
        assert!(tube.vertices.iter().all(|vertex| (-1e-9..=2.0 + 1e-9).contains(&vertex.z)));
    }
    let walled = region([0.0; 3], [2.0; 3], Boundary::walls(1.0));
    let oblique =
        SurfaceShape::Cylinder { point: Vector::repeat(1.0), axis: Vector::repeat(1.0), radius: 0.2, is_inside: true };
    let oblique = triangles(&walled, oblique);
    assert!(!oblique.triangles.is_empty());
    assert!(oblique.vertices.iter().flatten().all(|x| (-1e-6..=2.0 + 1e-6).contains(x)));
}

#[test]
fn shape_across_a_periodic_side_continues_on_the_opposite_side() {
    let cube = region([0.0; 3], [10.0; 3], Boundary::Periodic);
    let sphere = |x: f64| SurfaceShape::Sphere { centre: Vector::new(x, 5.0, 0.0), radius: 2.0, is_inside: false };
    let (whole, parts) =
        (triangles(&region([0.0; 3], [10.0; 3], Boundary::OPEN), sphere(5.0)), triangles(&cube, sphere(0.5)));
    assert!((whole.area() - parts.area()).abs() < 1e-9 * whole.area());
    assert!(parts.vertices.iter().flatten().all(|x| (-1e-6..=10.0 + 1e-6).contains(x)));
    // A mesh with faces in the sides of the box is not wrapped.
    let mesh = TriangleMesh::cuboid(&Vector::zeros(), &Vector::repeat(10.0));
    let surface = SceneSurface::new("box", SurfaceShape::Mesh(mesh), SurfaceLaw::Reflecting(ContactLaw::smooth(1.0)));
    assert!(matches!(cube.triangles(&surface), Cow::Borrowed(_)));
    let huge = TriangleMesh::cuboid(&Vector::repeat(-1e9), &Vector::repeat(1e9));
    assert_eq!(triangles(&cube, SurfaceShape::Mesh(huge.clone())), huge);
}

#[test]
fn surfaces_of_flat_scenes_are_strips_facing_away_from_particles() {
    let mut square = region([0.0; 3], [10.0, 10.0, 0.0], Boundary::walls(1.0));
    square.boundary[2] = Boundary::Flat;
    let centre = Vector::new(5.0, 5.0, 0.0);
    let width = 4e-3 * 200.0_f64.sqrt();
    for is_inside in [false, true] {
        let disc = triangles(&square, SurfaceShape::Sphere { centre, radius: 2.0, is_inside });
        let sign = if is_inside { 1.0 } else { -1.0 };
        let area = PI * ((2.0 + sign * width).powi(2) - 4.0) * sign;
        assert!((disc.area() / area - 1.0).abs() < 1e-3);
        assert!(disc.vertices.iter().all(|vertex| vertex.z == 0.0));
    }
    let line = plane(&square, [0.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    assert!((line.area() / (width * (10.0 + 2.0 * width)) - 1.0).abs() < 1e-6);
    assert!(line.vertices.iter().all(|vertex| vertex.y <= 1e-9));
    let ends = [centre, centre + Vector::new(0.0, 3.0, 0.0)];
    let capsule = triangles(&square, SurfaceShape::Capsule { ends, radius: 1.0 });
    assert!((capsule.area() / (width * (2.0 * PI + 6.0)) - 1.0).abs() < 0.05);
    square.boundary[1] = Boundary::Flat;
    assert!(plane(&square, [5.0, 0.0, 0.0], [1.0, 0.0, 0.0]).triangles.is_empty(), "on a line");
}

#[test]
fn surfaces_extend_past_open_sides_to_the_particles() {
    let mut space = Space::periodic_cube(10.0);
    space.boundary[0] = Boundary::walls(1.0);
    space.boundary[2] = Boundary::Bounded { lower: Face::Wall(ContactLaw::smooth(1.0)), upper: Face::Open };
    let wall = SurfaceShape::Plane { point: Vector::new(2.0, 0.0, 0.0), normal: Vector::x() };
    let scene = SceneBuilder::new("tower")
        .space(space)
        .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
        .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
        .surface(SurfaceDraft::new("a wall", wall))
        .particle("A", Vector::new(5.0, 5.0, 19.5), Vector::zeros())
        .build()
        .unwrap();
    let all: Vec<_> = shown(&scene).collect();
    assert_eq!(all[0].0, "a wall");
    assert!((all[0].1.area() - 200.0).abs() < 1e-9);
}
