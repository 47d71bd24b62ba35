//! Thickness of walls and gaps, measured along rays from the middle of each triangle, parallel to its normal.

use std::cell::Cell;

use super::MOST_PAIRS;
use super::tree::{Bounds, Tree};
use crate::Vector;
use crate::model::triangle_mesh::{TriangleMesh, twice_area};

/// Shortest distance between two triangles that face each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thinnest {
    /// Distance from the middle of `triangle` to `other`, along the normal of `triangle` `[length]`.
    pub distance: f64,
    /// Index of the triangle where the distance begins, from 0.
    pub triangle: usize,
    /// Index of the triangle where the distance ends, from 0.
    pub other: usize,
}

/// Cosine of 60 degrees, the largest angle between a ray and the normal of the triangle at which it ends.
const FACING: f64 = 0.5;

/// Tolerance of barycentric coordinates, so that no ray passes between adjacent triangles.
const SLACK: f64 = 1e-9;

#[derive(Debug, Clone, Copy)]
struct Ray<'a> {
    origin: Vector,
    direction: Vector,
    /// Number of triangles that may still be tested.
    left: &'a Cell<usize>,
}

/// Follows two rays from the middle of each triangle, along the normal and in the opposite direction. Returns the
/// shortest ray in each of the two directions, and whether all rays were followed.
///
/// A ray ends at the first triangle whose normal is within 60 degrees of the ray. In an oriented mesh, the normals at
/// the two ends must also be roughly opposite. Triangles that share a vertex with the starting triangle are skipped.
pub(super) fn thinnest(mesh: &TriangleMesh, tree: &Tree, is_oriented: bool) -> ([Option<Thinnest>; 2], bool) {
    let mut shortest = [None; 2];
    let left = Cell::new(MOST_PAIRS);
    for (triangle, corners) in mesh.all_corners().enumerate() {
        let area = twice_area(&corners);
        let size = area.norm();
        if size == 0.0 {
            continue;
        }
        let normal = area / size;
        let origin = corners.iter().sum::<Vector>() / 3.0;
        for (shortest, way) in shortest.iter_mut().zip([1.0, -1.0]) {
            let ray = Ray { origin, direction: normal * way, left: &left };
            let limit = shortest.map_or(f64::INFINITY, |found: Thinnest| found.distance);
            let faces = |other: &Vector| {
                let cosine = normal.dot(other);
                if is_oriented { cosine <= -FACING } else { cosine.abs() >= FACING }
            };
            if let Some((distance, other)) = ray.first(mesh, tree, triangle, limit, faces) {
                *shortest = Some(Thinnest { distance, triangle, other });
            }
        }
    }
    (shortest, left.get() > 0)
}

impl Ray<'_> {
    /// Returns the distance and the index of the nearest triangle on the ray, up to the distance `limit`. Skips
    /// triangles whose unit normal does not satisfy `faces`, and triangles that share a vertex with `from`.
    fn first(
        &self,
        mesh: &TriangleMesh,
        tree: &Tree,
        from: usize,
        limit: f64,
        faces: impl Fn(&Vector) -> bool,
    ) -> Option<(f64, usize)> {
        let own = mesh.corners(from);
        let nearest = Cell::new(limit);
        let mut found = None;
        for other in tree.entered(|bounds| self.left.get() > 0 && self.reaches(bounds, nearest.get())) {
            self.left.set(self.left.get().saturating_sub(1));
            let corners = mesh.corners(other as usize);
            if own.iter().any(|corner| corners.contains(corner)) {
                continue;
            }
            let area = twice_area(&corners);
            let size = area.norm();
            if let Some(distance) = self.distance(&corners)
                && distance < nearest.get()
                && size > 0.0
                && faces(&(area / size))
            {
                nearest.set(distance);
                found = Some((distance, other as usize));
            }
        }
        found
    }

    fn reaches(&self, bounds: &Bounds, limit: f64) -> bool {
        let (mut enter, mut leave) = (0.0_f64, limit);
        for axis in 0..3 {
            let (origin, direction) = (self.origin[axis], self.direction[axis]);
            let (lower, upper) = (bounds.lower[axis], bounds.upper[axis]);
            if direction == 0.0 {
                if origin < lower || origin > upper {
                    return false;
                }
                continue;
            }
            let (one, other) = ((lower - origin) / direction, (upper - origin) / direction);
            enter = enter.max(one.min(other));
            leave = leave.min(one.max(other));
        }
        enter <= leave * (1.0 + SLACK)
    }

    /// Distance to a triangle (Möller and Trumbore, J. Graph. Tools 2, 21, 1997).
    fn distance(&self, [a, b, c]: &[Vector; 3]) -> Option<f64> {
        let (along, across, from) = (b - a, c - a, self.origin - a);
        let p = self.direction.cross(&across);
        let determinant = along.dot(&p);
        if determinant == 0.0 {
            return None;
        }
        let q = from.cross(&along);
        let [u, v] = [from.dot(&p), self.direction.dot(&q)].map(|x| x / determinant);
        let distance = across.dot(&q) / determinant;
        (u >= -SLACK && v >= -SLACK && u + v <= 1.0 + SLACK && distance >= 0.0).then_some(distance.abs())
    }
}
