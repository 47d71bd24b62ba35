//! Tree of boxes around triangles (a bounding volume hierarchy).
//!
//! Each triangle is in one leaf, so that the memory does not depend on shapes. It does with a grid of cells, in which a long thin
//! triangle is in many.

use std::ops::Range;

use crate::Vector;
use crate::model::triangle_mesh::TriangleMesh;

/// Box around a triangle or several `[length]`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    pub lower: Vector,
    pub upper: Vector,
}

impl Bounds {
    /// Box around points.
    pub fn around(corners: &[Vector; 3]) -> Self {
        let [a, b, c] = corners;
        Self { lower: a.inf(b).inf(c), upper: a.sup(b).sup(c) }
    }

    /// Whether two boxes meet.
    pub fn meets(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.lower[axis] <= other.upper[axis] && other.lower[axis] <= self.upper[axis])
    }
}

#[derive(Debug, Clone)]
struct Node {
    bounds: Bounds,
    /// The node that comes after all below this one.
    next: usize,
    /// Places of its triangles in the order of the tree; none but in leaves.
    triangles: Range<usize>,
}

/// The tree: nodes before those below them, in one list.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    order: Vec<u32>,
}

/// Triangles of a leaf.
const LEAF: usize = 4;

impl Tree {
    /// Builds the tree by halving: triangles are ordered by the centres of their boxes along the longest edge, ties by number.
    pub fn of(mesh: &TriangleMesh) -> Self {
        let boxes: Vec<Bounds> = mesh.all_corners().map(|corners| Bounds::around(&corners)).collect();
        let mut order: Vec<u32> = (0..).take(boxes.len()).collect();
        let mut nodes = Vec::with_capacity(boxes.len());
        if !order.is_empty() {
            grow(&mut nodes, &boxes, &mut order, 0);
        }
        Self { nodes, order }
    }

    /// Numbers of the triangles in leaves whose boxes, and all boxes above them, are entered.
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

/// Adds the node of a range of triangles in the order, and all nodes below it. Halving keeps the depth at the
/// logarithm.
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
