//! Random scenes with surfaces of every kind.

use carom::Vector;
use carom::model::{SurfaceShape, TriangleMesh};
use carom::scene::SceneBuilder;

use super::{KINDS, around, assert_surfaces, grains, with};

#[test]
fn surfaces_of_every_kind_are_proven() {
    for kind in 0..KINDS {
        let mut met = 0;
        for seed in 0..8 {
            let gravity = if seed % 2 == 0 { 0.0 } else { 0.8 };
            let gas = grains(seed, 18).gravity(Vector::new(0.1, -0.2, -1.0) * gravity);
            let gas = if seed / 2 % 2 == 0 { gas } else { gas.contact_time(1e-2) };
            let restitution = if seed / 4 == 0 { 1.0 } else { 0.7 };
            let name = format!("kind {kind}, seed {seed}");
            met += assert_surfaces(&name, with(gas, around(kind), restitution), 400).counts.surface;
        }
        println!("{kind}: {met} contacts");
        assert!(met > 300, "kind {kind}: {met}");
    }
}

/// The ball rolls and hops. The TC model changes its contacts.
#[test]
fn a_ball_that_comes_to_rest_on_a_surface_is_proven() {
    for kind in 0..KINDS {
        for contact_time in [1e-3, 0.1] {
            let ball = |scene: SceneBuilder| {
                let scene = scene.gravity(Vector::new(0.1, -0.2, -1.0)).contact_time(contact_time);
                with(scene, around(kind), 0.4)
            };
            let met = assert_surfaces(&format!("kind {kind}, {contact_time}"), ball(grains(3, 1)), 300).counts.surface;
            assert!(met > 20 || kind == 4, "kind {kind}: {met}");
        }
    }
}

#[test]
fn flat_edges_are_no_obstacle_to_a_proof() {
    let floor = |n: u32| {
        let at = |k: u32| 10.0 + 12.0 * (f64::from(k) / f64::from(n) - 0.5);
        let vertices = (0..=n).flat_map(|y| (0..=n).map(move |x| Vector::new(at(x), at(y), 7.0)));
        let square = |k: u32| {
            let [a, b] = [k / n * (n + 1) + k % n, (k / n + 1) * (n + 1) + k % n];
            [[a, a + 1, b + 1], [a, b + 1, b]]
        };
        TriangleMesh { vertices: vertices.collect(), triangles: (0..n * n).flat_map(square).collect() }
    };
    for shape in [SurfaceShape::Mesh(floor(22)), super::turned(&floor(22))] {
        let gas = grains(5, 27).gravity(Vector::new(0.0, 0.0, -1.0)).contact_time(1e-2);
        let met = assert_surfaces("floor", with(gas, vec![shape], 0.5), 3000).counts.surface;
        assert!(met > 500, "{met}");
    }
}

/// A triangle with two equal corners is a segment, and a triangle with three equal corners is a point. A triangle that
/// lies on another triangle has no effect.
#[test]
fn degenerate_triangles_are_met_and_proven() {
    let at = |x: f64, y: f64, z: f64| super::MIDDLE + Vector::new(x, y, z);
    let vertices = vec![at(-1.9, -2.0, 1.4), at(2.0, 1.9, 1.5), at(0.4, -0.3, 2.1)];
    for triangles in [vec![[0, 1, 0]], vec![[2, 2, 2], [1, 0, 0]], vec![[0, 1, 2], [0, 1, 1], [2, 2, 2]]] {
        let needle = SurfaceShape::Mesh(TriangleMesh { vertices: vertices.clone(), triangles });
        let mut met = 0;
        for seed in 0..3 {
            let room = around(1).into_iter().chain([needle.clone()]).collect();
            let scene = with(grains(seed, 18), room, 1.0);
            met += assert_surfaces(&format!("seed {seed}"), scene, 400).counts.surface;
        }
        assert!(met > 100, "{met}");
    }
}
