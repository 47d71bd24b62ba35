//! Tests whether a point is inside a closed mesh.

use std::borrow::Cow;
use std::f64::consts::PI;

use super::predicates::{Projection, Sign, side};
use super::tree::Tree;
use crate::Vector;
use crate::model::triangle_mesh::TriangleMesh;

/// Returns true if a closed mesh contains a point. The solid angles add up to `4 pi` times the winding number.
///
/// The corners of a triangle are `a`, `b` and `c`, relative to the point. The solid angle `omega` follows from
/// `tan(omega / 2) = a . (b x c) / (|a| |b| |c| + (a . b) |c| + (b . c) |a| + (c . a) |b|)` (A. van Oosterom and J.
/// Strackee, *The Solid Angle of a Plane Triangle*, IEEE Trans. Biomed. Eng. 30, 125, 1983). The time is proportional
/// to the number of triangles; for many points, use [`Inside`]. The result for a point on the mesh is arbitrary.
#[must_use]
pub fn contains(mesh: &TriangleMesh, point: &Vector) -> bool {
    let half_angle = |corners: [Vector; 3]| {
        let [a, b, c] = corners.map(|corner| corner - point);
        let [x, y, z] = [a.norm(), b.norm(), c.norm()];
        libm::atan2(a.dot(&b.cross(&c)), x * y * z + a.dot(&b) * z + b.dot(&c) * x + c.dot(&a) * y)
    };
    let winding = mesh.all_corners().map(half_angle).sum::<f64>() / (2.0 * PI);
    // The sum is an integer within round-off, or a half-integer for a point on a face.
    winding.abs() > 0.5
}

/// Test for points inside a closed mesh. Round-off never puts a point on the wrong side.
///
/// A ray runs from the point upwards. The winding number is the number of times that the ray leaves the mesh, minus the
/// number of times that it enters. Infinitesimal shifts move the ray off edges and vertices. The time grows with the
/// number of triangles above the point.
#[derive(Debug, Clone)]
pub struct Inside<'a> {
    mesh: Cow<'a, TriangleMesh>,
    tree: Tree,
}

impl<'a> Inside<'a> {
    /// Prepares the test.
    #[must_use]
    pub fn of(mesh: &'a TriangleMesh) -> Self {
        Self { tree: Tree::of(mesh), mesh: Cow::Borrowed(mesh) }
    }

    /// Prepares the test and takes ownership of the mesh.
    #[must_use]
    pub fn of_own(mesh: TriangleMesh) -> Self {
        Self { tree: Tree::of(&mesh), mesh: Cow::Owned(mesh) }
    }

    /// Returns true if the mesh contains a point. The result for a point on the mesh is arbitrary.
    #[must_use]
    pub fn contains(&self, point: &Vector) -> bool {
        self.winding_number(point) != 0
    }

    /// Winding number around a point: 1 inside, 0 outside, -1 for inward normals, 2 where two parts overlap.
    #[must_use]
    pub fn winding_number(&self, point: &Vector) -> i32 {
        let above = self.tree.entered(|bounds| {
            let is_over = |axis: usize| bounds.lower[axis] <= point[axis] && point[axis] <= bounds.upper[axis];
            is_over(0) && is_over(1) && point.z <= bounds.upper.z
        });
        above.map(|triangle| passes(&self.mesh.corners(triangle as usize), point)).sum()
    }
}

/// Returns 1 if the upward ray from a point leaves the mesh through a triangle, -1 if the ray enters, otherwise 0.
fn passes(triangle: &[Vector; 3], point: &Vector) -> i32 {
    let [a, b, c] = triangle;
    let turn = moved_turn(a, b, point);
    if turn == Sign::Equal || moved_turn(b, c, point) != turn || moved_turn(c, a, point) != turn {
        return 0;
    }
    // If the normal points up, points below the triangle are behind it.
    match (turn, side(triangle, point)) {
        (Sign::Greater, Sign::Less) => 1,
        (Sign::Less, Sign::Greater) => -1,
        _ => 0,
    }
}

/// Returns the side of a directed line on which a point lies, seen from above. `Greater` is the left side. A point on
/// the line is shifted by an infinitesimal distance along x, or along y if the line is parallel to x.
fn moved_turn(from: &Vector, to: &Vector, point: &Vector) -> Sign {
    let [_, _, along_z] = Projection::ALL;
    let ([x, y], [to_x, to_y]) = (along_z.of(from), along_z.of(to));
    let order = |a: f64, b: f64| a.partial_cmp(&b).unwrap_or(Sign::Equal);
    along_z.turn(from, to, point).then(order(y, to_y)).then(order(to_x, x))
}
