//! Tests whether two triangles intersect outside a common corner. The test uses exact signs of determinants.
//!
//! Two triangles intersect if an edge of one triangle meets the other triangle. If the triangles share a corner, it is
//! enough to test the two opposite edges. Triangles with a common edge intersect elsewhere only if they are folded onto
//! each other.

use super::predicates::{Projection, Sign, side};
use super::tree::Bounds;
use crate::Vector;

/// Position of a corner, and its side of the plane of the other triangle. A shared corner has no side.
type Corner = (Vector, Option<Sign>);

/// Whether two triangles intersect outside shared corners. False for triangles without area and for equal triangles.
pub(super) fn meet(one: &[Vector; 3], two: &[Vector; 3]) -> bool {
    if is_clear(one, two) && is_clear(two, one) {
        return false;
    }
    let Some(first) = sides(one, two) else { return false };
    let Some(second) = sides(two, one) else { return false };
    if Projection::for_triangle(one).is_none() || Projection::for_triangle(two).is_none() {
        return false;
    }
    let ([a, b, c], [d, e, f]) = (&first, &second);
    match first.iter().filter(|(_, sign)| sign.is_none()).count() {
        0 => {
            let crosses = |[a, b, c]: [&Corner; 3], triangle| {
                edge_meets([a, b], triangle) || edge_meets([b, c], triangle) || edge_meets([c, a], triangle)
            };
            crosses([a, b, c], two) || crosses([d, e, f], one)
        }
        1 => edge_meets([a, b], two) || edge_meets([d, e], one),
        // The triangles share an edge and lie in one plane.
        _ => is_folded([a, b, c].map(|(corner, _)| *corner), &d.0),
    }
}

/// Quick test: the triangles share one corner, and the opposite edge of `one` is outside the bounding box of `two`.
fn is_clear(one: &[Vector; 3], two: &[Vector; 3]) -> bool {
    let (p, q) = match one.map(|corner| two.contains(&corner)) {
        [true, false, false] => (one[1], one[2]),
        [false, true, false] => (one[2], one[0]),
        [false, false, true] => (one[0], one[1]),
        _ => return false,
    };
    !Bounds::around(&[p, q, q]).meets(&Bounds::around(two))
}

/// Returns the corners of a triangle, shared corners last; `None` if all unshared corners are on one side of the plane.
fn sides(triangle: &[Vector; 3], other: &[Vector; 3]) -> Option<[Corner; 3]> {
    let [a, b, c] = triangle.map(|corner| (corner, (!other.contains(&corner)).then(|| side(other, &corner))));
    let is_on = |sign: Sign| [a, b, c].iter().all(|(_, found)| found.is_none_or(|found| found == sign));
    if is_on(Sign::Greater) || is_on(Sign::Less) {
        return None;
    }
    Some(match [a, b, c].map(|(_, sign)| sign.is_some()) {
        [false, true, _] => [b, c, a],
        [true, false, true] | [false, false, true] => [c, a, b],
        _ => [a, b, c],
    })
}

/// Whether two coplanar triangles with a common edge lie on the same side of the edge.
fn is_folded(triangle: [Vector; 3], other: &Vector) -> bool {
    let [apex, from, to] = &triangle;
    let turns =
        |(projection, _): (Projection, Sign)| projection.turn(from, to, apex) == projection.turn(from, to, other);
    Projection::for_triangle(&triangle).is_some_and(turns)
}

/// Whether a segment meets a triangle or its edges.
fn edge_meets([(p, at_p), (q, at_q)]: [&Corner; 2], triangle: &[Vector; 3]) -> bool {
    if at_p == at_q {
        return *at_p == Some(Sign::Equal) && flat_edge_meets(p, q, triangle);
    }
    // The line through the segment meets the triangle if it passes all edges on the same side.
    let [a, b, c] = triangle;
    let around = [(a, b), (b, c), (c, a)].map(|(from, to)| side(&[*from, *to, *p], q));
    !around.contains(&Sign::Greater) || !around.contains(&Sign::Less)
}

/// Whether a segment meets a triangle in the same plane. If not, a line along the segment or an edge separates the two.
fn flat_edge_meets(p: &Vector, q: &Vector, triangle: &[Vector; 3]) -> bool {
    let Some((projection, turn)) = Projection::for_triangle(triangle) else { return false };
    let [a, b, c] = triangle;
    let is_outside = |from, to| [p, q].iter().all(|end| projection.turn(from, to, end) == turn.reverse());
    let along = triangle.map(|corner| projection.turn(p, q, &corner));
    !is_outside(a, b) && !is_outside(b, c) && !is_outside(c, a) && along.iter().any(|sign| *sign != along[0])
}
