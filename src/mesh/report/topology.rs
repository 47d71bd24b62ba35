//! Degenerate and duplicate triangles, and the number of connected parts.

use super::{PairFault, TriangleFault};
use crate::model::triangle_mesh::{TriangleMesh, twice_area};

/// Largest area of a degenerate triangle, divided by the square of its longest side. The height of such a triangle is
/// less than the round-off of `f32`.
const SMALLEST_AREA: f64 = 1e-12;

pub(super) fn degenerate(mesh: &TriangleMesh) -> TriangleFault {
    let mut fault = TriangleFault::default();
    for (number, corners) in mesh.all_corners().enumerate() {
        let [a, b, c] = corners;
        let longest = (b - a).norm_squared().max((c - b).norm_squared()).max((a - c).norm_squared());
        let area = 0.5 * twice_area(&corners).norm();
        if area == 0.0 || area < SMALLEST_AREA * longest {
            fault.count += 1;
            fault.first.get_or_insert(number);
        }
    }
    fault
}

pub(super) fn duplicates(mesh: &TriangleMesh) -> PairFault {
    let key = |(numbers, triangle): (&[u32; 3], u32)| {
        let mut sorted = *numbers;
        sorted.sort_unstable();
        (sorted, triangle)
    };
    let mut sorted: Vec<([u32; 3], u32)> = mesh.triangles.iter().zip(0..).map(key).collect();
    sorted.sort_unstable();
    let mut fault = PairFault::default();
    for same in sorted.chunk_by(|one, other| one.0 == other.0) {
        fault.count += same.len() - 1;
        if let [(_, first), (_, second), ..] = same {
            let pair = [*first as usize, *second as usize];
            fault.first = Some(fault.first.map_or(pair, |before| before.min(pair)));
        }
    }
    fault
}

pub(super) fn parts(mesh: &TriangleMesh) -> usize {
    let mut parents: Vec<u32> = (0..).take(mesh.vertices.len()).collect();
    let mut is_used = vec![false; mesh.vertices.len()];
    let mut parts = 0;
    for numbers in &mesh.triangles {
        for number in numbers {
            if let Some(is_used) = is_used.get_mut(*number as usize)
                && !*is_used
            {
                *is_used = true;
                parts += 1;
            }
        }
        let [a, b, c] = numbers.map(|number| root(&mut parents, number));
        for (one, other) in [(a, b), (a, c)] {
            let (one, other) = (root(&mut parents, one), root(&mut parents, other));
            if one != other {
                parts -= 1;
                if let Some(parent) = parents.get_mut(one.max(other) as usize) {
                    *parent = one.min(other);
                }
            }
        }
    }
    parts
}

/// Returns the root vertex of a connected part (union-find with path halving).
fn root(parents: &mut [u32], mut number: u32) -> u32 {
    loop {
        let parent = parents.get(number as usize).copied().unwrap_or(number);
        if parent == number {
            return number;
        }
        let next = parents.get(parent as usize).copied().unwrap_or(parent);
        if let Some(entry) = parents.get_mut(number as usize) {
            *entry = next;
        }
        number = next;
    }
}
