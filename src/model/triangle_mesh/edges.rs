//! Edges of a mesh.

/// One side of a triangle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct EdgeUse {
    /// Indices of the two vertices of the side, the smaller one first.
    pub ends: [u32; 2],
    /// Index of the triangle.
    pub triangle: u32,
    /// Whether the second end follows the first in the cyclic order of the triangle's corners.
    pub is_forward: bool,
}

/// The sides of all triangles, sorted by vertices and then by triangle. Sides of the same edge are adjacent.
///
/// Triangles with two identical vertices are left out. A surface can be closed without them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Edges {
    uses: Vec<EdgeUse>,
}

impl Edges {
    pub(super) fn of(triangles: &[[u32; 3]]) -> Self {
        let mut uses = Vec::with_capacity(3 * triangles.len());
        for (&[a, b, c], triangle) in triangles.iter().zip(0..) {
            if a == b || b == c || c == a {
                continue;
            }
            uses.extend([[a, b], [b, c], [c, a]].map(|[from, to]| {
                let ends = [from.min(to), from.max(to)];
                EdgeUse { ends, triangle, is_forward: from < to }
            }));
        }
        uses.sort_unstable();
        Self { uses }
    }

    /// Iterates over the edges. Each item lists the triangle sides on an edge: one side at the rim of a surface, two
    /// sides elsewhere. A surface is consistently oriented if exactly one of the two sides runs forward at each edge.
    pub fn iter(&self) -> impl Iterator<Item = &[EdgeUse]> {
        self.uses.chunk_by(|one, other| one.ends == other.ends)
    }
}
