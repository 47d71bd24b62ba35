use std::cell::Cell;

use super::crossing::meet;
use super::tree::{Bounds, Tree};
use super::{MOST_INTERSECTIONS, MOST_PAIRS, PairFault};
use crate::model::triangle_mesh::TriangleMesh;

/// Finds pairs of triangles that intersect outside a common vertex or edge. Also returns whether all pairs were tested.
pub(super) fn self_intersections(mesh: &TriangleMesh, tree: &Tree) -> (PairFault, bool) {
    let mut fault = PairFault::default();
    let left = Cell::new(MOST_PAIRS);
    for (number, corners) in mesh.all_corners().enumerate() {
        let own = Bounds::around(&corners);
        let meets = |other: &usize| {
            let other = mesh.corners(*other);
            let is_near = Bounds::around(&other).meets(&own);
            left.set(left.get().saturating_sub(usize::from(is_near)));
            is_near && meet(&corners, &other)
        };
        let mut partners: Vec<usize> = tree
            .entered(|bounds| left.get() > 0 && bounds.meets(&own))
            .map(|other| other as usize)
            .filter(|other| *other > number && left.get() > 0)
            .filter(meets)
            .take(MOST_INTERSECTIONS - fault.count)
            .collect();
        partners.sort_unstable();
        fault.count += partners.len();
        if let Some(partner) = partners.first() {
            fault.first.get_or_insert([number, *partner]);
        }
        if fault.count == MOST_INTERSECTIONS || left.get() == 0 {
            return (fault, false);
        }
    }
    (fault, true)
}
