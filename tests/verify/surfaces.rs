mod kinds;
mod moving;
mod moving_wrong;
mod wrong;

use std::ops::ControlFlow;

use carom::Vector;
use carom::check::verify::{Certificate, End, EventRange, RunEnd, verify_run};
use carom::model::potential::Potential;
use carom::model::space::{Boundary, Space};
use carom::model::{Scene, SurfaceMotion, SurfaceShape, TriangleMesh};
use carom::nalgebra::Rotation3;
use carom::scene::{Arrangement, Fill, InteractionDraft, SceneBuilder, SpeciesDraft, SurfaceDraft};

use crate::scenes::assert_proven;
use crate::{config, prove, scene};

const MIDDLE: Vector = Vector::new(10.0, 10.0, 10.0);

/// Grains of two sizes and masses on a lattice in an open region, with irregular velocities.
pub fn grains(seed: u32, count: u32) -> SceneBuilder {
    let hard = |diameter| Potential::hard_sphere(diameter).unwrap();
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    let mut scene = SceneBuilder::new("grains")
        .space(space)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.5))
        .species(SpeciesDraft::new("B").mass(3.1).diameter(0.8))
        .interaction(InteractionDraft::new(hard(0.5)).between("A", "A").restitution(0.97))
        .interaction(InteractionDraft::new(hard(0.65)).between("A", "B").restitution(0.97))
        .interaction(InteractionDraft::new(hard(0.8)).between("B", "B").restitution(0.97));
    for k in 0..count {
        let at = |n: u32| 1.1 * (f64::from(n % 3) - 1.0);
        let place = MIDDLE + Vector::new(at(k), at(k / 3), at(k / 9));
        let part = |step: f64| 4.0 * (f64::from(k + 1) * step + f64::from(seed) * 0.618_034).fract() - 2.0;
        let velocity = Vector::new(part(0.754_877), part(0.569_840), part(0.430_159));
        scene = scene.particle(if k % 3 == 0 { "B" } else { "A" }, place, velocity);
    }
    scene
}

/// Turns a mesh so that no face is perpendicular to an axis.
pub fn turned(mesh: &TriangleMesh) -> SurfaceShape {
    let rotation = Rotation3::from_euler_angles(0.3, -0.2, 0.5);
    SurfaceShape::Mesh(mesh.transformed(1.0, &rotation, &(MIDDLE - rotation * MIDDLE)))
}

pub fn cuboid(half: f64) -> TriangleMesh {
    TriangleMesh::cuboid(&MIDDLE.add_scalar(-half), &MIDDLE.add_scalar(1.1 * half))
}

/// A prism with a star as its base. Every second long edge points inwards.
fn star(points: u32, radii: [f64; 2], height: f64) -> TriangleMesh {
    let count = 2 * points;
    let corner = |k: u32, z: f64| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(count);
        let radius = radii[k as usize % 2];
        MIDDLE + Vector::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
    };
    let ends = [-0.5 * height, 0.5 * height];
    let vertices =
        ends.iter().flat_map(|z| (0..count).map(|k| corner(k, *z))).chain(ends.map(|z| MIDDLE + Vector::z() * z));
    let [low, high] = [2 * count, 2 * count + 1];
    let around = |k: u32| {
        let next = (k + 1) % count;
        [[k, next, count + next], [k, count + next, count + k], [low, next, k], [high, count + k, count + next]]
    };
    TriangleMesh { vertices: vertices.collect(), triangles: (0..count).flat_map(around).collect() }
}

pub fn without(mut mesh: TriangleMesh, triangle: usize) -> TriangleMesh {
    mesh.triangles.remove(triangle);
    mesh
}

pub fn around(kind: usize) -> Vec<SurfaceShape> {
    let at = |x: f64, y: f64, z: f64| MIDDLE + Vector::new(x, y, z);
    let plane = |k: u32| {
        let sign = |bit: u32| if k >> bit & 1 == 0 { 1.0 } else { -1.1 };
        let normal = Vector::new(sign(0), 1.2 * sign(1), 0.9 * sign(2));
        SurfaceShape::Plane { point: MIDDLE - 3.0 * normal.normalize(), normal }
    };
    let axis = Vector::new(0.2, 1.0, -0.3);
    let end = |sign: f64| SurfaceShape::Plane { point: MIDDLE - 3.5 * sign * axis.normalize(), normal: sign * axis };
    let ball = |radius: f64, is_inside| SurfaceShape::Sphere { centre: MIDDLE, radius, is_inside };
    match kind {
        0 => (0..8).map(plane).collect(),
        1 => vec![ball(3.2, true)],
        2 => {
            let pipe = SurfaceShape::Cylinder { point: MIDDLE, axis, radius: 2.9, is_inside: true };
            vec![pipe, end(1.0), end(-1.0)]
        }
        3 => vec![turned(&cuboid(2.4))],
        4 => vec![
            ball(6.0, true),
            SurfaceShape::Capsule { ends: [at(-4.0, -2.5, 0.0), at(3.0, -2.6, 1.0)], radius: 0.3 },
            SurfaceShape::Capsule { ends: [at(2.6, -1.0, -3.0), at(2.7, 2.0, 3.0)], radius: 0.0 },
            SurfaceShape::Sphere { centre: at(0.0, 3.0, 0.5), radius: 0.9, is_inside: false },
            SurfaceShape::Cylinder {
                point: at(-2.8, 0.0, 0.0),
                axis: Vector::new(0.1, 0.3, 1.0),
                radius: 0.4,
                is_inside: false,
            },
            turned(&TriangleMesh::cuboid(&at(-1.0, -1.5, -4.2), &at(1.5, 1.0, -2.6))),
        ],
        5 => vec![turned(&star(5, [4.0, 2.8], 5.0))],
        // A box with one open side and a single triangle, in a hollow sphere.
        6 => vec![
            ball(6.0, true),
            turned(&without(without(cuboid(2.4), 11), 10)),
            SurfaceShape::Mesh(TriangleMesh {
                vertices: vec![at(-4.0, -4.0, 4.0), at(4.0, -4.0, 3.5), at(0.0, 4.0, 3.0)],
                triangles: vec![[0, 1, 2]],
            }),
        ],
        _ => vec![turned(&cuboid(3.4)), turned(&star(3, [4.8, 2.9], 5.0))],
    }
}

pub const KINDS: usize = 8;

pub fn moving(scene: SceneBuilder, shapes: Vec<SurfaceShape>, motions: &[SurfaceMotion], restitution: f64) -> Scene {
    let draft = |(k, shape)| {
        let draft = SurfaceDraft::new(&format!("surface {k}"), shape).restitution(restitution);
        motions.iter().fold(draft, |draft, motion| draft.motion(*motion))
    };
    shapes.into_iter().enumerate().map(draft).fold(scene, SceneBuilder::surface).build().unwrap()
}

pub fn with(scene: SceneBuilder, shapes: Vec<SurfaceShape>, restitution: f64) -> Scene {
    moving(scene, shapes, &[], restitution)
}

/// Asserts that the verifier proves `events` events of a scene, or all events if there are fewer. An arrested run is
/// accepted.
fn assert_surfaces(name: &str, scene: Scene, events: u64) -> Certificate {
    let certificate = prove(scene, 0, events);
    match certificate.end {
        End::Arrested(_) => {}
        End::Idle => assert_proven(name, &certificate, certificate.counts.events()),
        _ => assert_proven(name, &certificate, events),
    }
    certificate
}

#[test]
fn scenes_of_configs_with_surfaces_are_proven() {
    for (name, events) in [("funnel", 3000), ("silo", 600), ("hopper_smooth", 600)] {
        let certificate = prove(config(name), 0, events);
        assert_proven(name, &certificate, events);
    }
    // The grains must first reach the surfaces.
    for (name, from) in [("funnel", 30_000), ("silo", 30_000)] {
        let certificate = prove(config(name), from, 1000);
        assert_proven(name, &certificate, 1000);
        println!("{name}: {:?}", certificate);
        assert!(certificate.counts.surface > 50, "{name}: {:?}", certificate.counts);
    }
}

const ALL: EventRange = EventRange { from: 0, events: 1_000 };

/// Ball A bounces on a gate, which is present in the stage `shut`. Ball B falls through the gate to the floor.
const GATE: &str = r#"
[space]
size = [10.0, 10.0, 10.0]
x = "open"
y = "open"
z = "open"
[dynamics]
gravity = [0.0, 0.0, -1.0]
contact_time = 1e-3
[[species]]
name = "A"
mass = 1.0
diameter = 1.0
[[species]]
name = "B"
mass = 1.0
diameter = 0.5
[[interaction]]
species = ["A", "A"]
potential = "hard-sphere"
[[interaction]]
species = ["A", "B"]
potential = "hard-sphere"
[[interaction]]
species = ["B", "B"]
potential = "hard-sphere"
[[surface]]
name = "gate"
shape = "parallelogram"
corner = [2.0, 2.0, 4.0]
edge_1 = [6.0, 0.0, 0.0]
edge_2 = [0.0, 6.0, 0.1]
restitution = 0.9
species = ["A"]
stages = ["shut"]
[[surface]]
name = "floor"
shape = "plane"
point = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
restitution = 1.0
[[particle]]
species = "A"
position = [5.0, 5.0, 6.0]
[[particle]]
species = "B"
position = [3.0, 3.0, 7.0]
velocity = [0.1, 0.1, 0.0]
[[stage]]
name = "shut"
until_time = 12.0
[run]
until_time = 30.0
"#;

#[test]
fn gate_acts_only_in_its_stage_and_on_its_species() {
    let certificate = prove(scene(GATE), 0, 1_000);
    assert_proven("gate", &certificate, 1_000);
    assert_eq!(certificate.end, End::RunEnded);
    assert!((certificate.duration - 42.0).abs() < 1e-9 && certificate.counts.surface > 10, "{certificate:?}");
    for from in 6..12 {
        assert_proven("later", &prove(scene(GATE), from, 10), 10);
    }
    let by_events = GATE.replace("until_time = 12.0", "until_events = 7");
    assert_proven("by events", &prove(scene(&by_events), 0, 30), 30);
    // A run may end at a recorded time in any stage. The number of events is checked if it is known.
    let run = |events, time| verify_run(scene(GATE), RunEnd { events, time }, ALL, &mut |_| ControlFlow::Continue(()));
    for time in [11.0, 12.1, 25.0, 42.0] {
        let found = run(None, time);
        assert_eq!(found.end, End::RunEnded, "{found:?}");
        assert!((found.duration - time).abs() < 1e-9, "{found:?}");
        let events = found.counts.events();
        let again = run(Some(events), time);
        assert_eq!((again.end, again.counts), (found.end, found.counts));
        assert!(matches!(run(Some(events + 1), time).end, End::Departed { .. }));
        assert!(matches!(run(Some(events - 1), time).end, End::Departed { .. }));
    }
    // The verifier cannot predict when an automatic equilibration ends.
    let open = GATE.replace("until_time = 12.0", "measure = true\nequilibration = \"auto\"\nuntil_time = 12.0");
    let found = prove(scene(&open), 0, 10);
    assert!(found.end == End::OpenStages && !found.is_proven(), "{found:?}");
    assert_eq!(prove(scene(&GATE.replace("restitution = 1.0", "temperature = 1.0")), 0, 10).end, End::Driven);
}

#[test]
fn surfaces_in_periodic_boxes_are_proven_in_all_images() {
    // A block across a corner of the box, and a rod along the x-axis.
    let block = TriangleMesh::cuboid(&Vector::new(-1.3, 4.9, -0.9), &Vector::new(1.1, 7.4, 1.2));
    let rotation = Rotation3::from_euler_angles(0.3, -0.2, 0.5);
    let block = SurfaceShape::Mesh(block.transformed(1.0, &rotation, &Vector::zeros()));
    let rod =
        SurfaceShape::Cylinder { point: Vector::new(0.1, 0.3, 5.0), axis: Vector::x(), radius: 0.5, is_inside: false };
    let ball = SurfaceShape::Sphere { centre: Vector::new(6.9, 3.0, 3.0), radius: 0.8, is_inside: false };
    let other = SurfaceShape::Sphere { centre: Vector::new(3.0, 0.2, 6.8), radius: 0.8, is_inside: false };
    // With 3 particles, the engine uses neighbour lists. With 40 particles, it uses cells.
    for (count, gravity) in [(3, 0.0), (3, 0.3), (40, 0.0), (40, 0.3)] {
        let gas = grains(0, 0).space(Space::periodic_cube(7.0)).gravity(Vector::new(0.1, 0.2, -1.0) * gravity);
        let gas = gas.fill(Fill::new(Arrangement::Random, "A").count(count)).temperature(1.0);
        let shapes = if count == 3 { [&rod, &ball, &other] } else { [&rod, &ball, &block] };
        let scene = with(gas, shapes.map(SurfaceShape::clone).to_vec(), 1.0);
        let met = assert_surfaces("periodic", scene, 2000).counts.surface;
        assert!(met > 300, "{count}: {met}");
    }
}
