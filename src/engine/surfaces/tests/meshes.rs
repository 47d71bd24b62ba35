//! Meshes and round surfaces. A mesh must act like the wall or plane that has the same shape. No particle may leave a
//! closed mesh.

use super::run;
use crate::Vector;
use crate::engine::event::{Event, Other};
use crate::engine::neighbours::Neighbours;
use crate::engine::parts::Engine;
use crate::engine::{Reason, Simulation, Until};
use crate::mesh::revolution::revolution;
use crate::model::potential::Potential;
use crate::model::space::{Boundary, Space};
use crate::model::{Scene, SurfaceShape, TriangleMesh};
use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
use std::ops::ControlFlow;

/// Hard spheres of two sizes and masses on a cubic grid of edge `room` in the middle of an open box.
pub(super) fn gas(count: u32, room: f64, gravity: f64) -> SceneBuilder {
    let hard = |diameter| Potential::hard_sphere(diameter).unwrap();
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    let mut scene = SceneBuilder::new("gas")
        .space(space)
        .gravity(Vector::new(0.1, -0.2, -1.0) * gravity)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.5))
        .species(SpeciesDraft::new("B").mass(3.1).diameter(0.8))
        .interaction(InteractionDraft::new(hard(0.5)).between("A", "A").restitution(0.97))
        .interaction(InteractionDraft::new(hard(0.65)).between("A", "B").restitution(0.97))
        .interaction(InteractionDraft::new(hard(0.8)).between("B", "B").restitution(0.97));
    let side = f64::from(count).cbrt().ceil();
    for k in 0..count {
        let at = |n: f64| 10.0 + room * ((n.rem_euclid(side) + 0.5) / side - 0.5);
        let n = f64::from(k);
        let place = Vector::new(at(n), at((n / side).floor()), at((n / side / side).floor()));
        let velocity = Vector::new(1.3 - f64::from(k % 5), 0.7 * f64::from(k % 3) - 0.6, 0.4 - f64::from(k % 4));
        scene = scene.particle(if k % 3 == 0 { "B" } else { "A" }, place, velocity);
    }
    scene
}

pub(super) fn mesh(name: &str, mesh: TriangleMesh) -> SurfaceDraft {
    SurfaceDraft::new(name, SurfaceShape::Mesh(mesh))
}

pub(super) fn contacts(scene: Scene, events: u64) -> Vec<Event> {
    let mut found = Vec::new();
    let mut simulation = Simulation::without_plan(scene);
    let mut see = |event: &Event| {
        if matches!(event.other, Other::Surface { .. }) {
            found.push(*event);
        }
        ControlFlow::Continue(())
    };
    assert_eq!(simulation.advance_observed(Until::events(events), Some(&mut see)), Ok(Reason::Events));
    found
}

#[test]
fn box_of_triangles_acts_like_box_of_walls() {
    for gravity in [0.0, 0.7] {
        let (lower, upper) = (Vector::new(6.1, 6.3, 6.7), Vector::new(13.9, 14.2, 14.8));
        let walled = Space { lower, size: upper - lower, boundary: [Boundary::walls(0.9); 3] };
        let walls = contacts(gas(4, 4.0, gravity).space(walled).build().unwrap(), 60);
        let triangles = mesh("box", TriangleMesh::cuboid(&lower, &upper)).restitution(0.9);
        let faces = contacts(gas(4, 4.0, gravity).surface(triangles).build().unwrap(), 60);
        assert_eq!(walls.len(), faces.len());
        assert!(walls.len() > 20);
        for (wall, face) in walls.iter().zip(&faces) {
            assert_eq!(wall.particle, face.particle);
            assert!((wall.time - face.time).abs() < 1e-9, "{} {}", wall.time, face.time);
            assert!((wall.after[0] - face.after[0]).norm() < 1e-9);
            assert!(face.wall().is_none() && wall.wall().is_some());
        }
    }
}

/// A square floor of `2 n^2` triangles around the middle of the box.
fn floor(n: u32, size: f64) -> TriangleMesh {
    let at = |k: u32| 10.0 + size * (f64::from(k) / f64::from(n) - 0.5);
    let vertices = (0..=n).flat_map(|y| (0..=n).map(move |x| Vector::new(at(x), at(y), 0.3)));
    let square = |k: u32| {
        let (x, y) = (k % n, k / n);
        let [a, b] = [y * (n + 1) + x, (y + 1) * (n + 1) + x];
        [[a, a + 1, b + 1], [a, b + 1, b]]
    };
    TriangleMesh { vertices: vertices.collect(), triangles: (0..n * n).flat_map(square).collect() }
}

#[test]
fn floor_of_many_triangles_acts_like_a_plane() {
    // The sphere must not come to rest, so the restitution is nearly 1.
    for (velocity, restitution) in [
        (Vector::new(0.021, 0.017, 0.0), 1.0),
        (Vector::new(0.018, 0.018, 0.0), 1.0),
        (Vector::new(0.025, 0.0, -1.0), 0.999),
    ] {
        let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
        let ball = SceneBuilder::new("ball")
            .space(space)
            .gravity(Vector::new(0.0, 0.0, -1.0))
            .species(SpeciesDraft::new("ball").mass(0.7).diameter(0.37))
            .interaction(InteractionDraft::new(Model::HardSphere).between("ball", "ball"))
            .particle("ball", Vector::new(-25.0, -25.0, 1.1), velocity);
        let plane = SurfaceShape::Plane { point: Vector::new(3.0, 1.0, 0.3), normal: Vector::z() };
        let smooth = contacts(
            ball.clone().surface(SurfaceDraft::new("floor", plane).restitution(restitution)).build().unwrap(),
            1_000,
        );
        let faceted =
            contacts(ball.surface(mesh("floor", floor(71, 90.0)).restitution(restitution)).build().unwrap(), 1_000);
        for (one, other) in smooth.iter().zip(&faceted) {
            assert!((one.time - other.time).abs() < 1e-9, "{} {}", one.time, other.time);
            assert!((one.positions[0] - other.positions[0]).norm() < 1e-9);
            let kick = other.after[0] - one.after[0];
            assert!(kick.norm() < 1e-9, "{kick}");
        }
        let seams = faceted.windows(2).filter(|pair| pair[0].other != pair[1].other).count();
        assert!(seams > 20, "{seams}");
    }
}

/// A closed vase with convex and concave parts, and with thin triangles at its ends.
fn vase() -> TriangleMesh {
    let profile = [[0.0, 4.0], [3.0, 4.1], [4.5, 7.0], [2.2, 10.0], [3.9, 13.0], [0.001, 15.5], [0.0, 15.5]];
    revolution(&Vector::new(10.0, 10.0, 0.0), &Vector::z(), &profile, 0.05).unwrap()
}

fn nothing_leaves<const FALLING: bool>(
    gravity: f64,
    restitution: f64,
    count: u32,
    draft: SurfaceDraft,
    inside: impl Fn(&Vector) -> bool,
) {
    let mut scene = gas(count, 2.6, gravity).surface(draft.restitution(restitution));
    if gravity > 0.0 || restitution == 0.0 {
        // Without a contact time, a heap of particles would undergo inelastic collapse.
        scene = scene.contact_time(1e-5);
    }
    let scene = scene.build().unwrap();
    let mut engine = Engine::<FALLING, true>::new(&scene);
    let start = engine.energy();
    let mut besides = 0;
    let found = run(&mut engine, 6_000, |event, surface| {
        let radius = event.distance;
        let gap = super::Surface::gap(&surface.shape, &event.positions[0], radius);
        // Because of round-off, the projection of a particle may be just outside its face.
        besides += u32::from(gap == f64::INFINITY);
        assert!(gap.abs() < 1e-12 || gap == f64::INFINITY, "{gap}");
        // The tolerance allows for the round-off of a velocity change, and of a direction.
        let direction = 2.0 + event.positions[0].amax() / radius;
        let rounding = 4.0 * f64::EPSILON * event.before[0].norm() * 3.1 * direction;
        let across = (event.impulse - event.normal * event.normal_impulse()).norm();
        assert!(across <= rounding, "{across:e} {rounding:e}");
    });
    // Without restitution, particles slide along edges. There, the projection of the centre is often outside the face.
    assert!(found > 500 && (besides < 5 || restitution == 0.0), "{found} {besides}");
    assert_eq!(engine.real_overlaps(), []);
    assert_eq!(engine.counts.totals.in_invalid_state, 0);
    for particle in engine.particles() {
        assert!(inside(&engine.state_at(particle, engine.clock.now).0));
    }
    let (end, counts) = (engine.energy(), engine.counts.totals);
    let change = end.kinetic + end.potential - start.kinetic - start.potential;
    assert!((change + counts.dissipated.total()).abs() < 1e-9 * start.kinetic.max(start.potential.abs()), "{change}");
}

fn in_vase(place: &Vector) -> bool {
    let radius = (place.x - 10.0).hypot(place.y - 10.0);
    let profile = [[4.0, 3.0], [4.1, 3.0], [7.0, 4.5], [10.0, 2.2], [13.0, 3.9], [15.5, 0.0]];
    profile.windows(2).any(|part| {
        let [[z0, r0], [z1, r1]] = [part[0], part[1]];
        (z0..=z1).contains(&place.z) && radius <= r0 + (r1 - r0) * (place.z - z0) / (z1 - z0)
    })
}

#[test]
fn nothing_leaves_a_closed_mesh() {
    for (count, gravity, restitution) in [(3, 0.0, 1.0), (20, 0.0, 0.9), (20, 0.5, 1.0), (3, 0.5, 0.98), (12, 0.0, 0.0)]
    {
        if gravity == 0.0 {
            nothing_leaves::<false>(gravity, restitution, count, mesh("vase", vase()), in_vase);
        } else {
            nothing_leaves::<true>(gravity, restitution, count, mesh("vase", vase()), in_vase);
        }
    }
}

#[test]
fn nothing_leaves_a_sphere_or_a_pipe_with_a_rod_in_it() {
    let middle = Vector::repeat(10.0);
    let sphere = SurfaceDraft::new("sphere", SurfaceShape::Sphere { centre: middle, radius: 3.2, is_inside: true });
    let is_inside = |place: &Vector| (place - middle).norm() < 3.2;
    nothing_leaves::<false>(0.0, 1.0, 20, sphere.clone(), is_inside);
    nothing_leaves::<true>(0.5, 0.95, 20, sphere, is_inside);
    let axis = Vector::new(0.3, 1.0, -0.2);
    let pipe =
        SurfaceDraft::new("pipe", SurfaceShape::Cylinder { point: middle + axis, axis, radius: 2.9, is_inside: true });
    let in_pipe = |place: &Vector| (place - middle).cross(&axis.normalize()).norm() < 2.9;
    nothing_leaves::<false>(0.0, 1.0, 20, pipe.clone(), in_pipe);
    nothing_leaves::<true>(0.5, 0.95, 20, pipe, in_pipe);
}

#[test]
fn rods_balls_and_capsules_act_from_outside_on_chosen_species() {
    let middle = Vector::repeat(10.0);
    let cage = mesh("cage", TriangleMesh::cuboid(&Vector::repeat(7.0), &Vector::repeat(13.0)));
    let at = |x: f64, y: f64, z: f64| middle + Vector::new(x, y, z);
    let rod = SurfaceShape::Cylinder { point: at(-2.0, -2.0, 0.0), axis: Vector::z(), radius: 0.3, is_inside: false };
    let ball = SurfaceShape::Sphere { centre: at(2.0, 1.6, 0.2), radius: 0.4, is_inside: false };
    let capsule = SurfaceShape::Capsule { ends: [at(-1.9, 1.9, -2.0), at(-1.6, 2.0, 1.0)], radius: 0.2 };
    let line = SurfaceShape::Capsule { ends: [at(2.0, -2.0, -2.0), at(1.9, -1.9, 2.0)], radius: 0.0 };
    let scene = gas(18, 2.4, 0.0)
        .surface(cage)
        .surface(SurfaceDraft::new("rod", rod).only("A"))
        .surface(SurfaceDraft::new("ball", ball).restitution(0.9))
        .surface(SurfaceDraft::new("capsule", capsule))
        .surface(SurfaceDraft::new("line", line).only("B").restitution(0.5))
        .build()
        .unwrap();
    let radii = [0.25, 0.4];
    let mut met = [[0; 2]; 5];
    let mut simulation = Simulation::without_plan(scene.clone());
    let mut see = |event: &Event| {
        if let Other::Surface { surface, .. } = event.other {
            let kind = scene.particles()[event.particle.0 as usize].species.0 as usize;
            assert_eq!(event.distance, radii[kind]);
            met[surface as usize - 6][kind] += 1;
        }
        ControlFlow::Continue(())
    };
    simulation.advance_observed(Until::events(40_000), Some(&mut see)).unwrap();
    assert!(met[0].iter().all(|count| *count > 1_000), "{met:?}");
    assert!(met[1][0] > 100 && met[1][1] == 0, "{met:?}");
    assert!(met[2].iter().all(|count| *count > 50), "{met:?}");
    assert!(met[3].iter().all(|count| *count > 50), "{met:?}");
    assert!(met[4][0] == 0 && met[4][1] > 10, "{met:?}");
}

#[test]
fn surface_across_periodic_side_acts_on_the_other_side() {
    // A gas around a box of triangles, which lies across the corner of a periodic box.
    let hard = Potential::hard_sphere(0.5).unwrap();
    let mut scene = SceneBuilder::new("corner")
        .space(Space::periodic_cube(6.0))
        .species(SpeciesDraft::new("A").mass(1.0).diameter(0.5))
        .interaction(InteractionDraft::new(hard).between("A", "A"))
        .surface(mesh("block", TriangleMesh::cuboid(&Vector::repeat(-1.0), &Vector::repeat(1.2))));
    for k in 0..64 {
        let at = |n: u32| 1.6 + 0.9 * f64::from(n % 4);
        scene = scene.particle(
            "A",
            Vector::new(at(k), at(k / 4), at(k / 16)),
            Vector::new(1.0, 0.3, -0.7) * (f64::from(k % 7) - 3.0),
        );
    }
    let scene = scene.build().unwrap();
    let mut engine = Engine::<false, true>::new(&scene);
    let found = run(&mut engine, 20_000, |_, _| {});
    assert!(found > 500, "{found}");
    assert_eq!(engine.real_overlaps(), []);
    for particle in engine.particles() {
        let place = engine.state_at(particle, engine.clock.now).0;
        let is_in = |x: f64| x.rem_euclid(6.0) < 1.2 || x.rem_euclid(6.0) > 5.0;
        assert!(!place.iter().all(|x| is_in(*x)), "{place}");
    }
    assert_eq!(engine.counts.totals.in_invalid_state, 0);
}

#[test]
fn cells_and_lists_find_the_same_contacts() {
    let mut taken = [false; 2];
    for count in [3, 27, 125] {
        let scene = gas(count, 4.0, 0.0)
            .surface(mesh("box", TriangleMesh::cuboid(&Vector::repeat(6.5), &Vector::repeat(13.5))))
            .build()
            .unwrap();
        let mut engine = Engine::<false, true>::new(&scene);
        taken[usize::from(matches!(engine.neighbours, Neighbours::Lists(_)))] = true;
        run(&mut engine, 5_000, |_, _| {});
        assert_eq!(engine.real_overlaps(), []);
        assert!(engine.particles().all(|particle| {
            let place = engine.state_at(particle, engine.clock.now).0;
            place.iter().all(|x| (6.5..13.5).contains(x))
        }));
    }
    assert_eq!(taken, [true; 2]);
}
