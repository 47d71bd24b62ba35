use proptest::prelude::*;

use super::super::tests::{frame, is_background, is_red, level, pixel};
use super::super::{Framing, Image, draw, draw_with, of_trajectory};
use super::*;
use crate::Vector;
use crate::model::TriangleMesh;
use crate::trajectory::Frame;
use crate::trajectory::extended_xyz::write_frame;
use crate::view::ViewError;

/// A square normal to the y axis, with `columns` columns of two triangles each.
fn square(y: f64, columns: u32) -> TriangleMesh {
    let at = |x: u32, z: f64| Vector::new(10.0 * f64::from(x) / f64::from(columns), y, z);
    let quads = (0..columns).map(|k| [at(k, 0.0), at(k + 1, 0.0), at(k + 1, 10.0), at(k, 10.0)]);
    TriangleMesh::welded(quads.flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]))
}

fn ball() -> Frame {
    frame([10.0; 3], &[(0, [5.0, 5.0, 5.0], 1.0)])
}

fn style(opacity: f64) -> Style {
    Style { surface_opacity: opacity, ..level() }
}

fn image(mesh: &TriangleMesh, opacity: f64) -> Image {
    draw_with(&ball(), &Surfaces::of([mesh]), &style(opacity)).unwrap()
}

#[test]
fn opacity_decides_how_much_shows_through_a_surface() {
    let none = draw(&ball(), &level()).unwrap();
    let is_reddish = |pixel: [u8; 4]| pixel[0] > pixel[1] + 40;
    let middle = |image: &Image| pixel(image, 0.5, 0.5);
    let front = image(&square(0.0, 1), 0.35);
    assert!(is_reddish(middle(&front)) && middle(&front) != middle(&none));
    assert!(!is_reddish(middle(&image(&square(0.0, 1), 1.0))));
    assert_eq!(image(&square(0.0, 1), 0.0), none);
    let behind = image(&square(10.0, 1), 1.0);
    assert!(is_red(middle(&behind)) && !is_background(pixel(&behind, 0.5, 0.2)));
    let mut turned = square(0.0, 1);
    turned.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
    assert_eq!(image(&turned, 0.35), front);
}

#[test]
fn adjacent_triangles_join_without_gap_or_overlap() {
    let whole = image(&square(0.0, 1), 0.5);
    for columns in [2, 3, 7, 64] {
        let parts = image(&square(0.0, columns), 0.5);
        let is_same = |(a, b): (&[u8; 4], &[u8; 4])| (0..3).all(|k| a[k].abs_diff(b[k]) <= 1);
        // In the rows at the rim, the lines of two edges overlap.
        let inner = 12 * 240..228 * 240;
        assert!(inner.clone().all(|k| is_same((&whole.pixels()[k], &parts.pixels()[k]))), "{columns}");
    }
}

#[test]
fn surface_extending_behind_the_camera_is_drawn_in_front() {
    let corner = |x: f64, y: f64| Vector::new(x, y, 2.0);
    let floor = |reach: f64| {
        let [a, b, c, d] = [corner(-reach, -reach), corner(reach, -reach), corner(reach, reach), corner(-reach, reach)];
        TriangleMesh::welded([[a, b, c], [a, c, d]].into_iter())
    };
    let near = image(&floor(4e3), 1.0);
    assert!(is_background(pixel(&near, 0.1, 0.2)) && !is_background(pixel(&near, 0.1, 0.95)));
    let far = image(&floor(1e30), 1.0);
    assert_eq!((far.width(), far.height()), (near.width(), near.height()));
}

#[test]
fn image_makes_room_for_a_funnel_but_not_for_a_large_plane() {
    let style = Style { framing: Framing::Particles, ..style(1.0) };
    let balls = [(0, [5.0, 5.0, 5.0], 1.0), (0, [8.0, 8.0, 8.0], 1.0)];
    let scene = frame([10.0; 3], &balls);
    let drawn = |mesh: TriangleMesh| draw_with(&scene, &Surfaces::of([&mesh]), &style).unwrap();
    let reds = |image: &Image| image.pixels().iter().filter(|pixel| is_red(**pixel)).count();
    let none = reds(&draw(&scene, &style).unwrap());
    // Both surfaces are behind the balls.
    let funnel = reds(&drawn(TriangleMesh::cuboid(&Vector::new(2.0, 9.5, 2.0), &Vector::repeat(10.0))));
    let plain = reds(&drawn(square(1e3, 1).transformed(100.0, &nalgebra::Rotation3::identity(), &Vector::zeros())));
    assert!(funnel < none * 9 / 10 && funnel > none / 3, "{funnel} {none}");
    assert_eq!(plain, none);
}

#[test]
fn surfaces_are_found_beside_the_trajectory() {
    let folder = tempfile::tempdir().unwrap();
    let trajectory = folder.path().join("trajectory.xyz");
    write_frame(std::fs::File::create(&trajectory).unwrap(), &ball()).unwrap();
    let without = of_trajectory(&trajectory, None, &level()).unwrap();
    assert_eq!(without, draw(&ball(), &level()).unwrap());
    let surfaces = folder.path().join("surfaces");
    std::fs::create_dir(&surfaces).unwrap();
    std::fs::write(surfaces.join("notes.txt"), "none").unwrap();
    assert_eq!(of_trajectory(&trajectory, None, &level()).unwrap(), without);
    let file = surfaces.join("wall.stl");
    crate::mesh::write_stl(&square(0.0, 3), &mut std::fs::File::create(&file).unwrap()).unwrap();
    assert_eq!(of_trajectory(&trajectory, None, &level()).unwrap(), image(&square(0.0, 3), 0.35));
    std::fs::write(&file, "solid\nfacet").unwrap();
    assert!(matches!(of_trajectory(&trajectory, None, &level()), Err(ViewError::Surface(_))));
}

#[test]
fn moving_surface_is_drawn_at_its_position_if_its_file_exists() {
    let folder = tempfile::tempdir().unwrap();
    let (trajectory, surfaces) = (folder.path().join("trajectory.xyz"), folder.path().join("surfaces"));
    std::fs::create_dir(&surfaces).unwrap();
    let write = |name: &str, mesh: &TriangleMesh| {
        crate::mesh::write_stl(mesh, &mut std::fs::File::create(surfaces.join(name)).unwrap()).unwrap();
    };
    // The list is not sorted, and the first file is missing.
    write("gate.stl", &square(7.0, 1));
    write("a.stl", &square(1.0, 1));
    let motion = r#"{"from": 0.0, "until": null, "kind": {"Translation": {"velocity": [0.0, -1.0, 0.0], "acceleration": [0.0, 0.0, 0.0]}}}"#;
    let list = format!(
        r#"[{{"file": "out_of_sight.stl", "motions": []}}, {{"file": "gate.stl", "motions": [{motion}]}}, {{"file": "a.stl", "motions": []}}]"#
    );
    std::fs::write(surfaces.join("surfaces.json"), list).unwrap();
    let drawn = |time: f64, present: &[bool]| {
        let frame = Frame { time, surfaces: present.to_vec(), ..ball() };
        write_frame(std::fs::File::create(&trajectory).unwrap(), &frame).unwrap();
        of_trajectory(&trajectory, None, &level()).unwrap()
    };
    let both = |place: f64| draw_with(&ball(), &Surfaces::of([&square(1.0, 1), &square(place, 1)]), &level()).unwrap();
    for place in [7.0, 5.5] {
        assert_eq!(drawn(7.0 - place, &[]), both(place));
        assert_eq!(drawn(7.0 - place, &[true; 3]), both(place));
        assert_eq!(drawn(7.0 - place, &[true, false, true]), image(&square(1.0, 1), 0.35));
        assert_eq!(drawn(7.0 - place, &[true, true, false]), image(&square(place, 1), 0.35));
    }
}

#[test]
fn movie_bounds_cover_every_position_of_a_moving_surface() {
    use crate::model::{MotionKind, SurfaceMotion};
    let mut surfaces = Surfaces::of([&square(7.0, 1)]);
    let kind = MotionKind::Rotation { point: Vector::zeros(), axis: Vector::z(), frequency: 0.25 };
    let [lower, upper] = surfaces.skins[0].bounds;
    surfaces.skins[0].timeline =
        Some(crate::model::surface_motion::Timeline::of(&[SurfaceMotion { from: 0.0, until: 9.0, kind }]));
    // A quarter turn takes `(x, y)` to `(-y, x)`.
    let [low, high] = surfaces.around([0.0, 1.0].into_iter()).skins[0].bounds;
    assert_eq!((low.x, high.x), (-upper.y, upper.x));
    assert_eq!((low.y, high.y), (lower.x.min(lower.y), upper.x.max(upper.y)));
    assert_eq!((low.z, high.z), (lower.z, upper.z));
}

#[test]
fn static_spheres_and_surfaces_are_drawn_in_the_order_of_their_depth() {
    let veiled = |y: f64| {
        let balls = [(0, [5.0, 8.0, 5.0], 1.0), (2, [5.0, 5.0, 5.0], 1.0)];
        let style = Style { static_opacity: 1.0 - 1e-9, ..style(0.9) };
        let image = draw_with(&frame([10.0; 3], &balls), &Surfaces::of([&square(y, 1)]), &style).unwrap();
        pixel(&image, 0.5, 0.5)
    };
    // The sphere is nearly opaque, and hides only surfaces behind it.
    let alone = veiled(1e4);
    assert_eq!(veiled(7.0), alone);
    assert_ne!(veiled(2.0), alone);
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![6 => -5.0..15.0, 2 => Just(0.0), 1 => Just(5.0), 1 => Just(1e300), 1 => Just(-1e30), 1 => Just(1e-300)]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_triangles_are_drawn(
        corners in prop::collection::vec([coordinate(), coordinate(), coordinate()], 3..24),
        is_flat in any::<bool>(),
        opacity in 0.0..1.0,
    ) {
        let vertices: Vec<Vector> = corners.into_iter().map(Vector::from).collect();
        let count = u32::try_from(vertices.len()).unwrap();
        let triangles = (0..40).map(|k| [k % count, (3 * k + 1) % count, (7 * k + 2) % count]).collect();
        let mesh = TriangleMesh { vertices, triangles };
        let size = if is_flat { [10.0, 10.0, 0.0] } else { [10.0; 3] };
        let balls = [(0, size.map(|edge| 0.5 * edge), 1.0), (2, size.map(|edge| 0.3 * edge), 1.0)];
        let style = Style { width: 48, height: 32, has_box: true, ..style(opacity) };
        prop_assert!(draw_with(&frame(size, &balls), &Surfaces::of([&mesh]), &style).is_ok());
    }
}
