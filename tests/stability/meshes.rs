//! Balls never escape from random closed meshes: convex, rough, and with slivers.
//!
//! ```text
//! CAROM_MESH_EVENTS=1000000 cargo test --release --test stability meshes -- --nocapture  # 10^6 contacts in each of 30
//! meshes
//! ```

use carom::engine::{Simulation, Until};
use carom::model::space::{Boundary, Space};
use carom::model::{SurfaceShape, TriangleMesh};
use carom::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft, SurfaceDraft};
use carom::{Scene, Vector};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use std::collections::HashMap;
use std::f64::consts::PI;

const MESHES: u64 = 30;

const BALLS: usize = 12;

fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// A unit sphere around the origin with 512 triangles that face outwards.
fn sphere() -> TriangleMesh {
    let mut vertices: Vec<Vector> =
        [Vector::x(), Vector::y(), Vector::z()].into_iter().flat_map(|axis| [axis, -axis]).collect();
    let mut triangles: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..3 {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                vertices.push((vertices[a as usize] + vertices[b as usize]).normalize());
                u32::try_from(vertices.len() - 1).unwrap()
            })
        };
        let parts = triangles.iter().flat_map(|&[a, b, c]| {
            let [d, e, f] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, d, f], [d, b, e], [f, e, c], [d, e, f]]
        });
        triangles = parts.collect();
    }
    TriangleMesh { vertices, triangles }
}

/// A sphere with vertices moved inwards by up to `0.2 (kind % 4)` of the radius. If `kind` is odd, there are slivers.
fn cavity(random: &mut ChaCha8Rng, kind: u64, middle: &Vector) -> TriangleMesh {
    let mut mesh = sphere();
    if kind > 0 {
        let roughness = 0.2 * (kind % 4) as f64;
        for vertex in &mut mesh.vertices {
            *vertex *= 1.0 - roughness * uniform(random);
        }
    }
    if kind % 2 == 1 {
        // Moves some vertices towards a neighbour, by all but a millionth of the edge. Moved vertices share no
        // neighbours.
        let mut is_taken = vec![false; mesh.vertices.len()];
        for triangle in mesh.triangles.clone().iter().step_by(23) {
            let ring: Vec<[u32; 3]> =
                mesh.triangles.iter().copied().filter(|other| other.contains(&triangle[0])).collect();
            if ring.iter().flatten().any(|vertex| is_taken[*vertex as usize]) {
                continue;
            }
            ring.iter().flatten().for_each(|vertex| is_taken[*vertex as usize] = true);
            let [from, to] = [triangle[0], triangle[1]].map(|vertex| mesh.vertices[vertex as usize]);
            mesh.vertices[triangle[0] as usize] = to + (from - to) * 1e-6;
        }
    }
    for vertex in &mut mesh.vertices {
        *vertex = middle + *vertex * 3.0;
    }
    mesh
}

/// Returns the solid angle of a mesh at a point: `4 pi` inside, 0 outside (Van Oosterom and Strackee, 1983).
fn solid_angle(mesh: &TriangleMesh, place: &Vector) -> f64 {
    let of = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| mesh.vertices[vertex as usize] - place);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        2.0 * libm::atan2(a.dot(&b.cross(&c)), below)
    };
    mesh.triangles.iter().map(of).sum()
}

fn scene(mesh: TriangleMesh, random: &mut ChaCha8Rng, restitution: f64, gravity: f64, middle: &Vector) -> Scene {
    let space = Space { boundary: [Boundary::OPEN; 3], ..Space::periodic_cube(20.0) };
    let draft = SurfaceDraft::new("cavity", SurfaceShape::Mesh(mesh)).restitution(restitution);
    let mut scene = SceneBuilder::new("cavity")
        .space(space)
        .gravity(Vector::new(0.1, 0.2, -1.0) * gravity)
        .species(SpeciesDraft::new("A").mass(0.7).diameter(0.17))
        .interaction(InteractionDraft::new(Model::None).between("A", "A"))
        .surface(draft);
    if restitution < 1.0 {
        scene = scene.contact_time(1e-3);
    }
    for _ in 0..BALLS {
        let mut part = || uniform(random) - 0.5;
        let (place, velocity) = (Vector::new(part(), part(), part()), Vector::new(part(), part(), part()));
        scene = scene.particle("A", middle + place, velocity * 3.0);
    }
    scene.build().unwrap()
}

#[test]
fn nothing_ever_leaves_a_closed_mesh() {
    let events: u64 = std::env::var("CAROM_MESH_EVENTS").map_or(3_000, |events| events.parse().unwrap());
    let middle = Vector::new(10.3, 9.8, 10.1);
    let (mut deepest, mut contacts) = (0.0_f64, 0);
    for seed in 0..MESHES {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mesh = cavity(&mut random, seed % 8, &middle);
        let (restitution, gravity) = ([1.0, 0.98, 0.5, 0.0][(seed / 2 % 4) as usize], [0.0, 0.7][(seed % 2) as usize]);
        let (mut here, mut thrown) = (0, 0);
        while here < events && thrown < (events / 100).max(100) {
            let scene = scene(mesh.clone(), &mut random, restitution, gravity, &middle);
            let mut simulation = Simulation::new(scene).unwrap();
            // An arrest of a ball in a corner is not an escape.
            let _ = simulation.advance(Until::time(1e4).or_events((events - here).min(events.div_ceil(10))));
            thrown += 1;
            let snapshot = simulation.snapshot();
            for place in &snapshot.positions {
                let angle = solid_angle(&mesh, place) / (4.0 * PI);
                assert!((angle - 1.0).abs() < 1e-6, "mesh {seed}: a ball at {place}, {angle}");
            }
            let counts = simulation.event_counts();
            assert_eq!(counts.in_invalid_state, 0, "mesh {seed}");
            assert_eq!(simulation.real_overlaps(), [], "mesh {seed}");
            deepest = deepest.max(counts.deepest_overlap);
            here += counts.wall;
        }
        contacts += here;
        if std::env::var_os("CAROM_MESH_EVENTS").is_some() {
            println!("mesh {seed}, e = {restitution}, g = {gravity}: {here} contacts, thrown {thrown} times");
        }
    }
    println!("{contacts} contacts, {deepest:e} deep");
    assert!(contacts > MESHES * events / 2, "{contacts}");
    assert!(deepest < 1e-11, "{deepest}");
}
