//! Merges vertices that are nearly equal.

use std::collections::HashMap;

use super::TriangleMesh;
use crate::Vector;

/// Largest cell index along an axis. A float represents all smaller integers exactly.
const MOST_CELLS: f64 = 9e15;

impl TriangleMesh {
    /// Merges vertices that are at most `tolerance` apart `[length]`. A vertex is merged into the nearest earlier
    /// vertex. Returns the new mesh and the number of removed vertices. Triangles stay, but may have no area.
    #[must_use]
    pub fn merged(&self, tolerance: f64) -> (Self, usize) {
        let Some(origin) = self.vertices.first().filter(|_| tolerance > 0.0) else { return (self.clone(), 0) };
        let cell = |place: &Vector| {
            let at = (place - origin) / tolerance;
            #[expect(clippy::cast_possible_truncation, reason = "within the bounds")]
            [at.x, at.y, at.z].map(|x| x.floor().clamp(-MOST_CELLS, MOST_CELLS) as i64)
        };
        let mut cells: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
        let mut vertices: Vec<Vector> = Vec::with_capacity(self.vertices.len());
        let mut numbers = Vec::with_capacity(self.vertices.len());
        for vertex in &self.vertices {
            let at = cell(vertex);
            let mut nearest: Option<(f64, u32)> = None;
            for k in 0..27 {
                let beside = [at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1];
                for &other in cells.get(&beside).into_iter().flatten() {
                    let distance = (vertices[other as usize] - vertex).norm();
                    if distance <= tolerance && nearest.is_none_or(|found| (distance, other) < found) {
                        nearest = Some((distance, other));
                    }
                }
            }
            numbers.push(nearest.map_or_else(
                || {
                    // The index fits in 32 bits, because there are at most as many vertices as before.
                    let number = u32::try_from(vertices.len()).unwrap_or(u32::MAX);
                    vertices.push(*vertex);
                    cells.entry(at).or_default().push(number);
                    number
                },
                |(_, other)| other,
            ));
        }
        let merged = self.vertices.len() - vertices.len();
        let triangles = self.triangles.iter().map(|corners| corners.map(|it| numbers[it as usize])).collect();
        (Self { vertices, triangles }, merged)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The triangles of a box. Each triangle has its own slightly displaced vertices.
    fn soup(off: f64) -> TriangleMesh {
        let cuboid = TriangleMesh::cuboid(&Vector::new(-1.0, 2.0, 0.5), &Vector::new(3.0, 4.0, 1.5));
        let mut mesh = TriangleMesh::default();
        for (k, corners) in (0_u32..).zip(cuboid.all_corners()) {
            let shift = |n: u32| off * (f64::from((7 * k + 3 * n) % 5) / 2.0 - 1.0);
            mesh.triangles.push([3 * k, 3 * k + 1, 3 * k + 2]);
            mesh.vertices.extend((0..).zip(corners).map(|(n, corner)| corner.add_scalar(shift(n))));
        }
        mesh
    }

    #[test]
    fn merging_close_vertices_closes_a_box_of_loose_triangles() {
        let (mesh, merged) = soup(1e-7).merged(1e-6);
        assert_eq!((mesh.vertices.len(), merged, mesh.triangles.len()), (8, 28, 12));
        assert!(mesh.edges().iter().all(|uses| uses.len() == 2));
        assert!((mesh.enclosed_volume() / 8.0 - 1.0).abs() < 1e-6);
        assert_eq!(mesh.vertices[0], soup(1e-7).vertices[0]);
    }

    #[test]
    fn only_vertices_within_the_tolerance_are_merged() {
        // Displacements are multiples of 5e-8, so only vertices with equal displacements are merged.
        let alike = soup(1e-7).merged(1e-12).1;
        assert!(alike < 28 && soup(1e-7).merged(1e-9).1 == alike, "{alike}");
        assert_eq!(soup(0.0).merged(0.0), (soup(0.0), 0));
        assert_eq!(TriangleMesh::default().merged(1.0), (TriangleMesh::default(), 0));
        // Vertices on both sides of the first vertex are merged with it, even if they are in adjacent cells.
        let line = |places: &[f64]| TriangleMesh {
            vertices: places.iter().map(|x| Vector::new(*x, 0.0, 0.0)).collect(),
            triangles: Vec::new(),
        };
        let (mesh, merged) = line(&[0.0, -0.9, 0.95, 2.0, 2.9]).merged(1.0);
        assert_eq!((mesh, merged), (line(&[0.0, 2.0]), 3));
    }
}
