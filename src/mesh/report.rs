//! Reports on meshes: faults, volume, thickness of walls and gaps. Tests whether points are inside a mesh.

mod crossing;
mod finding;
mod inside;
mod pairs;
mod predicates;
#[cfg(test)]
mod tests;
mod thickness;
mod topology;
mod tree;

pub use finding::Finding;
pub use inside::{Inside, contains};
pub use thickness::Thinnest;

use crate::Vector;
use crate::model::triangle_mesh::TriangleMesh;

/// Number of edges with a fault, and the first such edge.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EdgeFault {
    /// Number of edges with the fault.
    pub count: usize,
    /// Ends of the first edge with the fault `[length]`.
    pub first: Option<[Vector; 2]>,
}

/// Number of triangles with a fault, and the first such triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TriangleFault {
    /// Number of triangles with the fault.
    pub count: usize,
    /// Index of the first triangle with the fault, from 0.
    pub first: Option<usize>,
}

/// Number of pairs of triangles with a fault, and the first such pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PairFault {
    /// Number of pairs with the fault.
    pub count: usize,
    /// Indices of the two triangles of the first pair, from 0, in ascending order.
    pub first: Option<[usize; 2]>,
}

/// Report on a mesh. Intersections are decided exactly, other numbers are rounded. Coordinates with a magnitude below
/// `1e-90` are treated as zero.
///
/// If a triangle is [`unusable`](Self::unusable), the report contains only the numbers of vertices and triangles.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Triangles with vertices that are missing, not finite, or beyond
    /// [`LARGEST_COORDINATE`](crate::model::triangle_mesh::LARGEST_COORDINATE). The count is at most one.
    pub unusable: TriangleFault,
    /// Lower and upper corner of the bounding box `[length]`.
    pub bounds: [Vector; 2],
    /// Total area of all triangles `[length^2]`.
    pub area: f64,
    /// Enclosed volume, negative for inward normals `[length^3]`; `None` unless the mesh is closed and consistently
    /// oriented.
    pub volume: Option<f64>,
    /// Edges that belong to a single triangle.
    pub open_edges: EdgeFault,
    /// Edges that belong to more than two triangles.
    pub crowded_edges: EdgeFault,
    /// Edges between two triangles of opposite orientation.
    pub turned_edges: EdgeFault,
    /// Number of parts without common vertices.
    pub parts: usize,
    /// Triangles of zero area, or with an area below `1e-12` times the square of their longest side.
    pub degenerate: TriangleFault,
    /// Triangles with the same three vertices as an earlier triangle, in any order.
    pub duplicates: PairFault,
    /// Pairs of triangles that intersect outside a common vertex or edge. Triangles without area are ignored.
    pub self_intersections: PairFault,
    /// Whether all pairs of triangles were tested. The search ends early at [`MOST_INTERSECTIONS`] or [`MOST_PAIRS`].
    pub is_searched: bool,
    /// Smallest distance between triangles that face each other, inside or outside the solid.
    pub thinnest: Option<Thinnest>,
    /// Smallest thickness of the enclosed solid; `None` unless the mesh is closed and consistently oriented.
    pub wall: Option<Thinnest>,
    /// Smallest gap outside the enclosed solid; `None` unless the mesh is closed and consistently oriented.
    pub gap: Option<Thinnest>,
}

/// Maximum number of counted self-intersections. It limits the time for meshes that are not surfaces.
pub const MOST_INTERSECTIONS: usize = 1_000_000;

/// Maximum number of intersection tests between two triangles, and of tests between a ray and a triangle. A mesh of a
/// million triangles needs about 10 million tests. Long, thin, oblique triangles need more.
pub const MOST_PAIRS: usize = 100_000_000;

/// Direction of the normals of a closed mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// Normals point outwards. The enclosed volume is positive.
    Outwards,
    /// Normals point inwards. The enclosed volume is negative.
    Inwards,
}

impl MeshReport {
    /// Examines a mesh of `n` triangles. The time is of order `n log n + p`, with `p` pairs of overlapping bounding
    /// boxes.
    #[must_use]
    pub fn of(mesh: &TriangleMesh) -> Self {
        let (vertices, triangles) = (mesh.vertices.len(), mesh.triangles.len());
        if let Some(first) = mesh.first_unusable() {
            let unusable = TriangleFault { count: 1, first: Some(first) };
            return Self { vertices, triangles, unusable, ..Self::default() };
        }
        let mut report = Self { vertices, triangles, bounds: mesh.bounds(), area: mesh.area(), ..Self::default() };
        report.look_at_edges(mesh);
        report.volume = (report.is_closed() && report.is_oriented()).then(|| mesh.enclosed_volume());
        report.parts = topology::parts(mesh);
        report.degenerate = topology::degenerate(mesh);
        report.duplicates = topology::duplicates(mesh);
        let tree = tree::Tree::of(mesh);
        (report.self_intersections, report.is_searched) = pairs::self_intersections(mesh, &tree);
        let ([ahead, behind], are_followed) = thickness::thinnest(mesh, &tree, report.volume.is_some());
        report.is_searched &= are_followed;
        report.thinnest = [ahead, behind].into_iter().flatten().min_by(|a, b| a.distance.total_cmp(&b.distance));
        if let Some(volume) = report.volume {
            (report.gap, report.wall) = if volume < 0.0 { (behind, ahead) } else { (ahead, behind) };
        }
        report
    }

    /// Whether each edge belongs to exactly two triangles, as in a mesh that encloses a volume.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.triangles > 0 && self.unusable.count == 0 && self.open_edges.count == 0 && self.crowded_edges.count == 0
    }

    /// Whether adjacent triangles have their normals on the same side of the mesh.
    #[must_use]
    pub fn is_oriented(&self) -> bool {
        self.unusable.count == 0 && self.turned_edges.count == 0
    }

    /// Direction of the normals; `None` unless the mesh is closed and consistently oriented, and encloses a volume.
    #[must_use]
    pub fn orientation(&self) -> Option<Orientation> {
        match self.volume {
            Some(volume) if volume > 0.0 => Some(Orientation::Outwards),
            Some(volume) if volume < 0.0 => Some(Orientation::Inwards),
            _ => None,
        }
    }

    /// Faults of the mesh, the worst first. A closed surface without faults has none.
    #[must_use]
    pub fn findings(&self) -> Vec<Finding> {
        finding::of(self)
    }

    fn look_at_edges(&mut self, mesh: &TriangleMesh) {
        for uses in mesh.edges().iter() {
            let (fault, ends) = match uses {
                [side] => (&mut self.open_edges, side.ends),
                [one, other] if one.is_forward == other.is_forward => (&mut self.turned_edges, one.ends),
                [_, _] | [] => continue,
                [side, ..] => (&mut self.crowded_edges, side.ends),
            };
            fault.count += 1;
            let place = |end: u32| mesh.vertices.get(end as usize).copied().unwrap_or_default();
            fault.first.get_or_insert_with(|| ends.map(place));
        }
    }
}
