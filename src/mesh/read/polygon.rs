//! Triangulation of a face, which must be a plane polygon that does not cross itself.
//!
//! If the whole polygon is visible from its first corner, a fan of triangles around this corner is correct. Other
//! polygons are projected along a coordinate axis and cut by ear clipping, with the crate `earcut`. Every corner
//! belongs to a triangle, so neighbouring faces keep their common edges.

use thiserror::Error;

use crate::Vector;

/// Largest accepted distance from the plane of a face, divided by the extent of the face.
const FLATNESS: f64 = 1e-3;

/// Round-off of an area, divided by the square of the extent.
const ROUNDING: f64 = 1e-13;

/// Reason why a face cannot be cut into triangles.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PolygonProblem {
    /// The corners do not lie in a plane.
    #[error("is not flat: a corner is {distance:.3e} away from its plane, expected at most {allowed:.3e}")]
    NotFlat {
        /// Largest distance of a corner from the plane `[length]`.
        distance: f64,
        /// Largest accepted distance `[length]`.
        allowed: f64,
    },
    /// The outline of the face crosses or touches itself.
    #[error("has an outline that crosses itself, expected a simple polygon")]
    CrossesItself,
}

/// Cuts a polygon of `n` corners into `n - 2` triangles with the orientation of the polygon. Returns the corners of the
/// triangles, or `None` if the fan around the first corner is correct.
pub(super) fn triangulate(polygon: &[Vector]) -> Result<Option<Vec<[usize; 3]>>, PolygonProblem> {
    let Some((&origin, rest)) = polygon.split_first() else { return Ok(None) };
    let extent = rest.iter().map(|corner| (corner - origin).amax()).fold(0.0, f64::max);
    let rounding = ROUNDING * extent * extent;
    // Newell's method: the length of the normal is twice the enclosed area.
    let fan: Vec<Vector> = rest.windows(2).map(|pair| (pair[0] - origin).cross(&(pair[1] - origin))).collect();
    let normal: Vector = fan.iter().sum();
    if normal.norm() <= rounding {
        // If all corners are on a line, all triangles of the fan have zero area.
        let is_line = fan.iter().all(|twice_area| twice_area.norm() <= rounding);
        return if is_line { Ok(None) } else { Err(PolygonProblem::CrossesItself) };
    }
    let unit = normal.normalize();
    let middle: Vector = polygon.iter().sum::<Vector>() / polygon.len() as f64;
    let distance = polygon.iter().map(|corner| unit.dot(&(corner - middle)).abs()).fold(0.0, f64::max);
    if distance > FLATNESS * extent {
        return Err(PolygonProblem::NotFlat { distance, allowed: FLATNESS * extent });
    }
    if is_seen_from_first(&unit, rest, &origin, &fan, rounding) {
        return Ok(None);
    }
    clip_ears(polygon, &normal).map(Some)
}

/// Whether the fan turns in one direction by less than a full turn. The first corner then has a view of the whole face.
fn is_seen_from_first(unit: &Vector, rest: &[Vector], origin: &Vector, fan: &[Vector], rounding: f64) -> bool {
    let sines = || fan.iter().map(|twice_area| unit.dot(twice_area));
    let cosines = rest.windows(2).map(|pair| (pair[0] - origin).dot(&(pair[1] - origin)));
    let turned: f64 = sines().zip(cosines).map(|(sine, cosine)| libm::atan2(sine, cosine)).sum();
    sines().all(|sine| sine >= -rounding) && turned < std::f64::consts::TAU
}

fn clip_ears(polygon: &[Vector], normal: &Vector) -> Result<Vec<[usize; 3]>, PolygonProblem> {
    // Projects the polygon onto a coordinate plane. The projected corners run counterclockwise.
    let across = normal.iamax();
    let (mut u, mut v) = ((across + 1) % 3, (across + 2) % 3);
    if normal[across] < 0.0 {
        (u, v) = (v, u);
    }
    let flat: Vec<[f64; 2]> = polygon.iter().map(|corner| [corner[u], corner[v]]).collect();
    let mut found: Vec<usize> = Vec::new();
    earcut::Earcut::new().earcut(flat.iter().copied(), &[] as &[usize], &mut found);
    let twice_area = |[a, b, c]: [usize; 3]| {
        let [[ax, ay], [bx, by], [cx, cy]] = [flat[a], flat[b], flat[c]];
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    };
    let (triples, _) = found.as_chunks::<3>();
    let mut triangles: Vec<[usize; 3]> =
        triples.iter().map(|&[a, b, c]| if twice_area([a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] }).collect();
    keep_corners(&mut triangles, polygon.len());
    let covered: f64 = triangles.iter().map(|&triangle| twice_area(triangle).abs()).sum();
    let enclosed = normal[across].abs();
    let is_whole = triangles.len() == polygon.len() - 2 && (covered - enclosed).abs() <= 1e-9 * enclosed;
    if is_whole { Ok(triangles) } else { Err(PolygonProblem::CrossesItself) }
}

/// Ear clipping omits corners that lie on an edge of a triangle. Divides the triangle at these corners.
fn keep_corners(triangles: &mut Vec<[usize; 3]>, corners: usize) {
    let mut is_used = vec![false; corners];
    triangles.iter().flatten().for_each(|&corner| is_used[corner] = true);
    let Some(start) = is_used.iter().position(|&is_used| is_used) else { return };
    let mut before = start;
    for k in 1..=corners {
        let corner = (start + k) % corners;
        if !is_used[corner] {
            continue;
        }
        let has_edge =
            |triangle: &[usize; 3]| (0..3).find(|&at| triangle[at] == before && triangle[(at + 1) % 3] == corner);
        let found =
            triangles.iter().enumerate().find_map(|(number, triangle)| has_edge(triangle).map(|at| (number, at)));
        if let Some((number, at)) = found
            && (before + 1) % corners != corner
        {
            let opposite = triangles[number][(at + 2) % 3];
            let mut along = before;
            while along != corner {
                let next = (along + 1) % corners;
                let triangle = [along, next, opposite];
                if along == before {
                    triangles[number] = triangle
                } else {
                    triangles.push(triangle)
                }
                along = next;
            }
        }
        before = corner;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const L: [[f64; 2]; 6] = [[10.0, 0.0], [10.0, 4.0], [4.0, 4.0], [4.0, 10.0], [0.0, 10.0], [0.0, 0.0]];

    fn tilted(corners: &[[f64; 2]]) -> Vec<Vector> {
        let along = Vector::new(0.48, 0.6, -0.64);
        let up = Vector::new(0.8, 0.0, 0.6);
        corners.iter().map(|[x, y]| Vector::new(3.0, -7.0, 11.0) + along * *x + up * *y).collect()
    }

    fn areas(polygon: &[Vector]) -> Result<Vec<Vector>, PolygonProblem> {
        let fan = || (2..polygon.len()).map(|k| [0, k - 1, k]).collect();
        let triangles = triangulate(polygon)?.unwrap_or_else(fan);
        assert_eq!(triangles.len(), polygon.len() - 2);
        let area = |[a, b, c]: [usize; 3]| (polygon[b] - polygon[a]).cross(&(polygon[c] - polygon[a]));
        Ok(triangles.into_iter().map(area).collect())
    }

    #[test]
    fn concave_face_area_is_independent_of_first_corner_and_orientation() {
        for first in 0..L.len() {
            let mut corners = L;
            corners.rotate_left(first);
            for turn in 0..2 {
                if turn == 1 {
                    corners.reverse();
                }
                let areas = areas(&tilted(&corners)).unwrap();
                let sum: Vector = areas.iter().sum();
                let covered: f64 = areas.iter().map(Vector::norm).sum();
                assert!((covered - 2.0 * 64.0).abs() < 1e-11, "{covered}");
                assert!((sum.norm() - covered).abs() < 1e-11, "all triangles have the same orientation");
                let normal = Vector::new(0.48, 0.6, -0.64).cross(&Vector::new(0.8, 0.0, 0.6));
                assert_eq!(sum.dot(&normal) > 0.0, turn == 0);
            }
        }
    }

    #[test]
    fn a_face_that_is_seen_from_its_first_corner_stays_a_fan() {
        let square = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        assert_eq!(triangulate(&tilted(&square)), Ok(None));
        let dart = [[0.0, 0.0], [2.0, -1.0], [0.0, 3.0], [-2.0, -1.0]];
        assert_eq!(triangulate(&tilted(&dart)), Ok(None));
        // Two corners may be equal. All corners may be on a line.
        assert_eq!(triangulate(&tilted(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0, 1.0]])), Ok(None));
        assert_eq!(triangulate(&tilted(&[[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]])), Ok(None));
    }

    #[test]
    fn corners_on_an_edge_stay_corners() {
        let mut corners = L.to_vec();
        corners.insert(1, [10.0, 2.0]);
        corners.insert(5, [2.0, 10.0]);
        let polygon = tilted(&corners);
        let triangles = triangulate(&polygon).unwrap().unwrap();
        let covered: f64 = areas(&polygon).unwrap().iter().map(Vector::norm).sum();
        assert!((covered - 2.0 * 64.0).abs() < 1e-11, "{covered}");
        for corner in 0..corners.len() {
            let next = (corner + 1) % corners.len();
            let has_edge = |t: &[usize; 3]| (0..3).any(|k| (t[k], t[(k + 1) % 3]) == (corner, next));
            assert_eq!(triangles.iter().filter(|triangle| has_edge(triangle)).count(), 1, "edge {corner}");
        }
    }

    #[test]
    fn outlines_that_cross_and_faces_that_are_not_flat_are_refused() {
        let bow_tie = [[0.0, 0.0], [2.0, 2.0], [2.0, 0.0], [0.0, 2.0]];
        let uneven = [[0.0, 0.0], [3.0, 3.0], [3.0, 0.0], [0.0, 2.0]];
        let star: Vec<[f64; 2]> =
            (0..5).map(|k| f64::from(k) * 0.8 * std::f64::consts::PI).map(|a| [a.cos(), a.sin()]).collect();
        for corners in [&bow_tie[..], &uneven, &star] {
            assert_eq!(triangulate(&tilted(corners)), Err(PolygonProblem::CrossesItself), "{corners:?}");
        }
        let mut square = tilted(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        let normal = (square[1] - square[0]).cross(&(square[2] - square[0])).normalize();
        square[3] += 1e-3 * normal;
        assert_eq!(triangulate(&square), Ok(None));
        square[3] += 1e-1 * normal;
        assert!(matches!(triangulate(&square), Err(PolygonProblem::NotFlat { .. })));
    }

    proptest! {
        #[test]
        fn star_shaped_polygons_have_the_area_of_their_outline(
            radii in prop::collection::vec(0.2..5.0_f64, 4..30),
            first in 0..30_usize,
        ) {
            let n = radii.len();
            let at = |k: usize| (k % n) as f64 / n as f64 * std::f64::consts::TAU;
            let corners: Vec<[f64; 2]> = (first..first + n).map(|k| [radii[k % n] * at(k).cos(), radii[k % n] * at(k).sin()]).collect();
            let outline: f64 = (0..n).map(|k| {
                let ([a, b], [c, d]) = (corners[k], corners[(k + 1) % n]);
                a * d - b * c
            }).sum();
            let areas = areas(&tilted(&corners)).unwrap();
            let covered: f64 = areas.iter().map(Vector::norm).sum();
            prop_assert!((covered - outline).abs() <= 1e-9 * outline, "{} {}", covered, outline);
        }
    }
}
