//! Tree of bounding boxes around triangles (bounding volume hierarchy). Each triangle is in exactly one leaf, so long
//! thin triangles need no more memory than others.

use std::ops::Range;

use crate::Vector;
use crate::model::triangle_mesh::TriangleMesh;

#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub lower: Vector,
    pub upper: Vector,
}

impl Bounds {
    pub fn around(corners: &[Vector; 3]) -> Self {
        let [a, b, c] = corners;
        Self { lower: a.inf(b).inf(c), upper: a.sup(b).sup(c) }
    }

    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.lower[axis] <= other.upper[axis] && other.lower[axis] <= self.upper[axis])
    }
}

#[derive(Debug, Clone)]
struct Node {
    bounds: Bounds,
    /// Index of the next node that is not below this node.
    next: usize,
    /// Range of the triangles of a leaf in `Tree::order`; empty for other nodes.
    triangles: Range<usize>,
}

/// List of nodes. Each node comes before all nodes below it.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

const LEAF: usize = 4;

impl Tree {
    /// Builds the tree by repeated halving along the longest edge.
    pub fn of(mesh: &TriangleMesh) -> Self {
        let boxes: Vec<Bounds> = mesh.all_corners().map(|corners| Bounds::around(&corners)).collect();
        let mut order: Vec<u32> = (0..).take(boxes.len()).collect();
        let mut nodes = Vec::with_capacity(boxes.len());
        if !order.is_empty() {
            grow(&mut nodes, &boxes, &mut order, 0);
        }
        Self { nodes, order }
    }

    /// Returns the triangles in all leaves that a search enters.
    pub fn entered(&self, mut enters: impl FnMut(&Bounds) -> bool) -> impl Iterator<Item = u32> {
        let mut node = 0;
        let leaves = std::iter::from_fn(move || {
            loop {
                let Node { bounds, next, triangles } = self.nodes.get(node)?;
                if !enters(bounds) {
                    node = *next;
                    continue;
                }
                node += 1;
                if !triangles.is_empty() {
                    return self.order.get(triangles.clone());
                }
            }
        });
        leaves.flatten().copied()
    }
}

/// Adds a node for a range of triangles, and all nodes below it. The depth of the recursion is logarithmic.
fn grow(nodes: &mut Vec<Node>, boxes: &[Bounds], order: &mut [u32], place: usize) {
    let of = |number: &u32| boxes.get(*number as usize).copied();
    let mut all = order.iter().filter_map(of);
    let Some(first) = all.next() else { return };
    let join = |a: Bounds, b: Bounds| Bounds { lower: a.lower.inf(&b.lower), upper: a.upper.sup(&b.upper) };
    let bounds = all.fold(first, join);
    let node = nodes.len();
    let is_leaf = order.len() <= LEAF;
    let triangles = if is_leaf { place..place + order.len() } else { 0..0 };
    nodes.push(Node { bounds, next: 0, triangles });
    if !is_leaf {
        let axis = (bounds.upper - bounds.lower).imax();
        let middle = |number: &u32| of(number).map_or(0.0, |bounds| bounds.lower[axis] + bounds.upper[axis]);
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |a, b| middle(a).total_cmp(&middle(b)).then(a.cmp(b)));
        let (lower, upper) = order.split_at_mut(half);
        grow(nodes, boxes, lower, place);
        grow(nodes, boxes, upper, place + half);
    }
    let next = nodes.len();
    if let Some(node) = nodes.get_mut(node) {
        node.next = next;
    }
}
