//! Meshes of triangles.

use nalgebra::Rotation3;
use serde::{Deserialize, Serialize};

use crate::Vector;

/// A mesh of triangles: vertices, and for each triangle the numbers of its three, counterclockwise seen from outside.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct TriangleMesh {
    /// Positions `[length]`.
    pub vertices: Vec<Vector>,
    /// Numbers of vertices.
    pub triangles: Vec<[u32; 3]>,
}

impl TriangleMesh {
    /// A box of twelve triangles that look outwards.
    #[must_use]
    pub fn cuboid(lower: &Vector, upper: &Vector) -> Self {
        let at = |k: u32| Vector::from_fn(|axis, _| if k >> axis & 1 == 1 { upper[axis] } else { lower[axis] });
        // Counterclockwise seen from outside: across x, y, z, below and above.
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self { vertices: (0..8).map(at).collect(), triangles }
    }

    /// The mesh made larger, turned about the origin, and moved, in this order.
    #[must_use]
    pub fn transformed(&self, scale: f64, rotation: &Rotation3<f64>, translation: &Vector) -> Self {
        let vertices = self.vertices.iter().map(|vertex| rotation * (vertex * scale) + translation).collect();
        Self { vertices, triangles: self.triangles.clone() }
    }

    /// The corners of a triangle `[length]`.
    #[must_use]
    pub fn corners(&self, triangle: &[u32; 3]) -> [Vector; 3] {
        triangle.map(|vertex| self.vertices[vertex as usize])
    }
}
