//! Faults of a mesh, and its measures: volume, wall thickness, gaps, points inside.

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

/// Edges with the same fault.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EdgeFault {
    /// Their number.
    pub count: usize,
    /// Ends of the first one `[length]`.
    pub first: Option<[Vector; 2]>,
}

/// Triangles with the same fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TriangleFault {
    /// Their number.
    pub count: usize,
    /// Number of the first one, from 0.
    pub first: Option<usize>,
}

/// Pairs of triangles with the same fault.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PairFault {
    /// Their number.
    pub count: usize,
    /// Indices of the first two, from 0, the smaller one first.
    pub first: Option<[usize; 2]>,
}

/// Report of a mesh. All decisions are exact; areas, volumes and distances are rounded. Coordinates below
/// `1e-90` count as zero.
///
/// For a mesh with [`unusable`](Self::unusable) triangles, only vertices and triangles are counted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeshReport {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Triangles whose vertices are missing, not finite or beyond [`LARGEST_COORDINATE`](crate::model::triangle_mesh::LARGEST_COORDINATE); only
    /// the first one is counted.
    pub unusable: TriangleFault,
    /// Lower and upper corner of the smallest box around the mesh `[length]`.
    pub bounds: [Vector; 2],
    /// Area of all triangles `[length^2]`.
    pub area: f64,
    /// Enclosed volume `[length^3]`, negative if the normals point inwards; only for closed and consistently
    /// oriented meshes.
    pub volume: Option<f64>,
    /// Edges with a single triangle.
    pub open_edges: EdgeFault,
    /// Edges with more than two triangles.
    pub crowded_edges: EdgeFault,
    /// Edges between two triangles with opposite orientations.
    pub turned_edges: EdgeFault,
    /// Number of parts without a common vertex.
    pub parts: usize,
    /// Triangles of zero area, or of less than `1e-12` of the square of their longest side.
    pub degenerate: TriangleFault,
    /// Triangles with the same three vertices as an earlier triangle, in any order.
    pub duplicates: PairFault,
    /// Triangles that meet outside a common vertex or edge. Triangles whose corners are on a line are
    /// ignored.
    pub self_intersections: PairFault,
    /// Whether all pairs were tested, for self-intersections and for distances. The search ends at
    /// [`MOST_INTERSECTIONS`] and at [`MOST_PAIRS`].
    pub is_searched: bool,
    /// Smallest distance between triangles that face each other, across the solid or across the outside.
    pub thinnest: Option<Thinnest>,
    /// Smallest thickness of the enclosed solid; only for closed and consistently oriented meshes.
    pub wall: Option<Thinnest>,
    /// Smallest gap between surfaces outside the enclosed solid; only for closed and consistently oriented
    /// meshes.
    pub gap: Option<Thinnest>,
}

/// Largest number of self-intersections that are counted. A mesh with more is not a surface, and finding all
/// of them takes a time quadratic in the number of triangles.
pub const MOST_INTERSECTIONS: usize = 1_000_000;

/// Largest number of pairs of triangles with overlapping boxes that are tested for self-intersections. It
/// also limits the triangles tested against rays. A mesh of a million triangles needs a tenth of this number.
/// Tens of thousands of needles may need more if they are not parallel to an axis and all their boxes
/// overlap.
pub const MOST_PAIRS: usize = 100_000_000;

/// Direction of the normals of a closed mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Orientation {
    /// The enclosed volume is positive.
    Outwards,
    /// The enclosed volume is negative.
    Inwards,
}

impl MeshReport {
    /// Examines a mesh. The time grows as `n log n` with the number of triangles, and with the number of
    /// pairs whose boxes overlap.
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

    /// Whether each edge is on two triangles, so that the mesh encloses a volume.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.triangles > 0 && self.unusable.count == 0 && self.open_edges.count == 0 && self.crowded_edges.count == 0
    }

    /// Whether neighbours have their normals on the same side.
    #[must_use]
    pub fn is_oriented(&self) -> bool {
        self.unusable.count == 0 && self.turned_edges.count == 0
    }

    /// Direction of the normals, if the mesh is closed and consistently oriented and encloses a volume.
    #[must_use]
    pub fn orientation(&self) -> Option<Orientation> {
        match self.volume {
            Some(volume) if volume > 0.0 => Some(Orientation::Outwards),
            Some(volume) if volume < 0.0 => Some(Orientation::Inwards),
            _ => None,
        }
    }

    /// Faults of the mesh, the worst first; empty if it can be used as a closed surface.
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
