//! Tree of bounding boxes. It finds the features near the region that a particle sweeps before its predicted event.
//! Unlike cells, the tree needs no more memory for long or thin features than for compact features.

use super::{Placed, Surface};
use crate::Vector;
use crate::base::numbers::id;

const LEAF: usize = 4;

/// A node of the tree. Its box contains all features in the node and below it.
#[derive(Debug, Clone, Copy)]
struct Node {
    lower: Vector,
    upper: Vector,
    /// Index of the next node if the query does not reach this node. Nodes below this node are then skipped.
    next: u32,
    /// Index of the first feature in this node or below it.
    first: u32,
    count: u32,
}

/// Each node is stored before the nodes below it.
#[derive(Debug, Clone)]
pub(super) struct Tree {
    nodes: Vec<Node>,
    boxes: Vec<[Vector; 2]>,
    /// While the tree is built, the index of the first feature of the next leaf.
    first: u32,
}

impl Tree {
    /// Builds a tree, and sorts the features. The first feature gets the index `first`.
    pub fn of(features: &mut [Placed], first: usize) -> Self {
        let mut tree = Self { nodes: Vec::new(), boxes: Vec::new(), first: number(first) };
        tree.add(features);
        tree.boxes = features.iter().map(bounds).collect();
        tree
    }

    fn add(&mut self, features: &mut [Placed]) {
        let Some((first, rest)) = features.split_first() else { return };
        let [lower, upper] =
            rest.iter().map(bounds).fold(bounds(first), |all, one| [all[0].inf(&one[0]), all[1].sup(&one[1])]);
        let at = self.nodes.len();
        let is_leaf = features.len() <= LEAF;
        let count = if is_leaf { features.len() } else { 0 };
        self.nodes.push(Node { lower, upper, next: 0, first: self.first, count: number(count) });
        if is_leaf {
            self.first += number(count);
        } else {
            // The features are split into halves along the axis on which their centres are farthest apart.
            let middle = |placed: &Placed| bounds(placed)[0] + bounds(placed)[1];
            let [least, most] = features
                .iter()
                .map(middle)
                .fold([Vector::repeat(f64::INFINITY), Vector::repeat(f64::NEG_INFINITY)], |[least, most], m| {
                    [least.inf(&m), most.sup(&m)]
                });
            let axis = (most - least).imax();
            let name = |placed: &Placed| (placed.number, placed.feature);
            let half = features.len() / 2;
            features.select_nth_unstable_by(half, |a, b| {
                middle(a)[axis].total_cmp(&middle(b)[axis]).then(name(a).cmp(&name(b)))
            });
            let (one, other) = features.split_at_mut(half);
            self.add(one);
            self.add(other);
        }
        self.nodes[at].next = number(self.nodes.len());
    }

    /// Diagonal of the bounding box of all features `[length]`.
    pub fn size(&self) -> f64 {
        self.nodes.first().map_or(0.0, |root| (root.upper - root.lower).norm())
    }

    #[inline]
    pub fn for_each(&self, [lower, upper]: &[Vector; 2], mut visit: impl FnMut(u32)) {
        let meets = |start: &Vector, end: &Vector| (0..3).all(|k| start[k] <= upper[k] && end[k] >= lower[k]);
        let base = self.nodes.first().map_or(0, |root| root.first);
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !meets(&node.lower, &node.upper) {
                at = node.next as usize;
                continue;
            }
            for index in node.first..node.first + node.count {
                let [start, end] = &self.boxes[(index - base) as usize];
                if meets(start, end) {
                    visit(index);
                }
            }
            at += 1;
        }
    }
}

fn bounds(placed: &Placed) -> [Vector; 2] {
    placed.shape.extent().unwrap_or([Vector::repeat(f64::NEG_INFINITY), Vector::repeat(f64::INFINITY)])
}

fn number(of: usize) -> u32 {
    id(of)
}
