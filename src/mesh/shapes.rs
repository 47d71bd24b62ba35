//! Meshes for tests: spheres, boxes, discs, rings.

use std::collections::HashMap;

use super::revolution::revolution;
use crate::Vector;
use crate::model::TriangleMesh;

const GOLDEN: f64 = 1.618_033_988_749_895;

const FACES: [[u32; 3]; 20] = [
    [0, 11, 5],
    [0, 5, 1],
    [0, 1, 7],
    [0, 7, 10],
    [0, 10, 11],
    [1, 5, 9],
    [5, 11, 4],
    [11, 10, 2],
    [10, 7, 6],
    [7, 1, 8],
    [3, 9, 4],
    [3, 4, 2],
    [3, 2, 6],
    [3, 6, 8],
    [3, 8, 9],
    [4, 9, 5],
    [2, 4, 11],
    [6, 2, 10],
    [8, 6, 7],
    [9, 8, 1],
];

/// Sphere of `20 x 4^subdivisions` triangles with outward normals.
pub fn icosphere(centre: &Vector, radius: f64, subdivisions: u32) -> Option<TriangleMesh> {
    let (a, b) = (1.0, GOLDEN);
    let corners = [
        [-a, b, 0.0],
        [a, b, 0.0],
        [-a, -b, 0.0],
        [a, -b, 0.0],
        [0.0, -a, b],
        [0.0, a, b],
        [0.0, -a, -b],
        [0.0, a, -b],
        [b, 0.0, -a],
        [b, 0.0, a],
        [-b, 0.0, -a],
        [-b, 0.0, a],
    ];
    let mut directions: Vec<Vector> = corners.iter().map(|corner| Vector::from(*corner).normalize()).collect();
    let mut triangles = FACES.to_vec();
    for _ in 0..subdivisions {
        let mut middles = HashMap::new();
        let mut middle = |from: u32, to: u32| {
            *middles.entry((from.min(to), from.max(to))).or_insert_with(|| {
                let at = |number: u32| directions.get(number as usize).copied().unwrap_or_default();
                directions.push((at(from) + at(to)).normalize());
                u32::try_from(directions.len() - 1).unwrap_or(u32::MAX)
            })
        };
        let quarter = |[a, b, c]: [u32; 3]| {
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(quarter).collect();
    }
    Some(TriangleMesh { vertices: directions.iter().map(|direction| centre + direction * radius).collect(), triangles })
}

pub fn cuboid(lower: &Vector, upper: &Vector) -> Option<TriangleMesh> {
    Some(TriangleMesh::cuboid(lower, upper))
}

pub fn disc(centre: &Vector, axis: &Vector, radius: f64, tolerance: f64) -> Option<TriangleMesh> {
    revolution(centre, axis, &[[0.0, 0.0], [radius, 0.0]], tolerance)
}

pub fn torus(centre: &Vector, axis: &Vector, major: f64, minor: f64, tolerance: f64) -> Option<TriangleMesh> {
    let sides = 64;
    let point = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k % sides) / f64::from(sides);
        [major + minor * libm::cos(angle), minor * libm::sin(angle)]
    };
    let profile: Vec<[f64; 2]> = (0..=sides).map(point).collect();
    revolution(centre, axis, &profile, tolerance)
}
