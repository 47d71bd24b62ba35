//! Surfaces of triangles that share vertices.

mod edges;
mod merge;
#[cfg(test)]
mod tests;
mod weld;

pub use edges::{EdgeUse, Edges};
pub(crate) use weld::Welder;

use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};

use super::limits::LARGEST;
use crate::Vector;

/// Largest number of triangles. Indices of three vertices per triangle then fit in 32 bits.
pub const MOST_TRIANGLES: usize = 1 << 28;

/// Largest magnitude of a coordinate `[length]`. Squares of areas and products of volumes stay far from overflow.
pub const LARGEST_COORDINATE: f64 = LARGEST;

/// Surface of triangles that share vertices. Corners are counterclockwise as seen from the tip of the normal.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Positions `[length]`.
    pub vertices: Vec<Vector>,
    /// Indices of the three vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// Creates a mesh from the corners of triangles. Corners with equal coordinates become one vertex. Triangles and
    /// vertices keep their order. Triangles beyond [`MOST_TRIANGLES`] are dropped.
    #[must_use]
    pub fn welded(corners: impl Iterator<Item = [Vector; 3]>) -> Self {
        let mut welder = Welder::default();
        corners.take(MOST_TRIANGLES).for_each(|corners| welder.push(&corners));
        welder.finish()
    }

    /// A box of twelve triangles with outward normals.
    #[must_use]
    pub fn cuboid(lower: &Vector, upper: &Vector) -> Self {
        let at = |k: u32| Vector::from_fn(|axis, _| if k >> axis & 1 == 1 { upper[axis] } else { lower[axis] });
        // Corners of the two sides across x, then y, then z, counterclockwise as seen from outside.
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self { vertices: (0..8).map(at).collect(), triangles }
    }

    /// Whether all corners refer to existing vertices, and all coordinates are at most [`LARGEST_COORDINATE`].
    #[must_use]
    pub(crate) fn is_sound(&self) -> bool {
        let is_vertex = |&number: &u32| (number as usize) < self.vertices.len();
        self.triangles.iter().flatten().all(is_vertex)
            && self.vertices.iter().all(|vertex| vertex.amax() <= LARGEST_COORDINATE)
    }

    /// Corners of a triangle; NaN if the triangle or a vertex does not exist.
    #[must_use]
    pub fn corners(&self, triangle: usize) -> [Vector; 3] {
        self.triangles.get(triangle).map_or([Vector::repeat(f64::NAN); 3], |numbers| self.at(numbers))
    }

    /// Iterates over the corners of all triangles, in order.
    pub fn all_corners(&self) -> impl Iterator<Item = [Vector; 3]> + '_ {
        self.triangles.iter().map(|numbers| self.at(numbers))
    }

    fn at(&self, numbers: &[u32; 3]) -> [Vector; 3] {
        numbers.map(|number| self.vertices.get(number as usize).copied().unwrap_or(Vector::repeat(f64::NAN)))
    }

    /// The first triangle whose vertices are missing, not finite, or beyond [`LARGEST_COORDINATE`].
    #[must_use]
    pub fn first_unusable(&self) -> Option<usize> {
        let is_usable = |corner: &Vector| corner.iter().all(|x| x.abs() <= LARGEST_COORDINATE);
        self.all_corners().position(|corners| !corners.iter().all(is_usable))
    }

    /// Lower and upper corner of the smallest box that contains all triangles `[length]`; zeros without triangles.
    #[must_use]
    pub fn bounds(&self) -> [Vector; 2] {
        let mut corners = self.all_corners().flatten();
        let Some(first) = corners.next() else { return [Vector::zeros(); 2] };
        corners.fold([first; 2], |[lower, upper], corner| [lower.inf(&corner), upper.sup(&corner)])
    }

    /// The mesh scaled about the origin, then rotated, then translated. A negative scale mirrors the mesh and reverses
    /// the order of corners, so that outward normals stay outward.
    #[must_use]
    pub fn transformed(&self, scale: f64, rotation: &Rotation3<f64>, translation: &Vector) -> Self {
        let moved = |vertex: &Vector| rotation * (vertex * scale) + translation;
        let turned = |&[a, b, c]: &[u32; 3]| if scale < 0.0 { [a, c, b] } else { [a, b, c] };
        Self {
            vertices: self.vertices.iter().map(moved).collect(),
            triangles: self.triangles.iter().map(turned).collect(),
        }
    }

    /// Volume that a closed mesh encloses `[length^3]`, positive if its normals point outwards.
    ///
    /// By the divergence theorem, `V = sum (a - o) . ((b - o) x (c - o)) / 6` for any point `o`. Here `o` is a vertex,
    /// because a distant point would make the volume less precise.
    #[must_use]
    pub fn enclosed_volume(&self) -> f64 {
        let [origin, ..] = self.corners(0);
        let six_times = |[a, b, c]: [Vector; 3]| (a - origin).dot(&(b - origin).cross(&(c - origin)));
        self.all_corners().map(six_times).sum::<f64>() / 6.0
    }

    /// Area of all triangles `[length^2]`.
    #[must_use]
    pub fn area(&self) -> f64 {
        self.all_corners().map(|corners| 0.5 * twice_area(&corners).norm()).sum()
    }

    /// Returns the edges in the order of their vertex indices, with the triangles at each edge.
    #[must_use]
    pub fn edges(&self) -> Edges {
        Edges::of(&self.triangles)
    }
}

/// Vector along the normal of a triangle; its length is twice the area `[length^2]`.
#[must_use]
pub fn twice_area([a, b, c]: &[Vector; 3]) -> Vector {
    (b - a).cross(&(c - a))
}
