//! Surfaces of revolution as triangles: discs, cones, tubes, funnels.

use std::f64::consts::{PI, TAU};

use crate::Vector;
use crate::base::numbers::{id, trunc_to_usize};
use crate::model::TriangleMesh;

const MOST_SIDES: f64 = 4096.0;

/// Returns a surface of revolution as triangles. A point of `profile` is a distance `r` from the axis and a height
/// above `base`. Each point becomes a polygon with `n` corners. The polygon deviates from a circle by at most `r (1 -
/// cos(pi / n))`, which does not exceed `tolerance`. Returns `None` if `n` is too large or `axis` is zero.
///
/// A closed profile yields a ring. Where the profile goes up, triangles face away from the axis.
pub(crate) fn revolution(base: &Vector, axis: &Vector, profile: &[[f64; 2]], tolerance: f64) -> Option<TriangleMesh> {
    let up = axis.try_normalize(0.0)?;
    let largest = profile.iter().map(|[radius, _]| *radius).fold(0.0, f64::max);
    let sides = (PI / libm::acos((1.0 - tolerance / largest).max(0.0))).ceil().max(8.0);
    if sides.is_nan() || sides > MOST_SIDES {
        return None;
    }
    let sides = trunc_to_usize(sides);
    // The coordinate axis with the largest angle to `up`.
    let mut least = Vector::zeros();
    least[up.iamin()] = 1.0;
    let x = up.cross(&least).normalize();
    let y = up.cross(&x);
    let mut mesh = TriangleMesh::default();
    let mut circles: Vec<Vec<u32>> = Vec::with_capacity(profile.len());
    let is_ring = profile.len() > 2 && profile.first() == profile.last();
    for &[radius, height] in profile.get(..profile.len() - usize::from(is_ring)).unwrap_or_default() {
        let centre = base + up * height;
        let count = if radius == 0.0 { 1 } else { sides };
        let first = mesh.vertices.len();
        mesh.vertices.extend((0..count).map(|k| {
            let angle = TAU * k as f64 / sides as f64;
            if radius == 0.0 { centre } else { centre + (x * libm::cos(angle) + y * libm::sin(angle)) * radius }
        }));
        circles.push((0..sides).map(|k| id(first + k % count)).collect());
    }
    circles.extend(circles.first().cloned().filter(|_| is_ring));
    for pair in circles.windows(2) {
        let [lower, upper] = pair else { continue };
        for k in 0..sides {
            let next = (k + 1) % sides;
            let two = [[lower[k], lower[next], upper[next]], [lower[k], upper[next], upper[k]]];
            mesh.triangles.extend(two.into_iter().filter(|[a, b, c]| a != b && b != c && c != a));
        }
    }
    Some(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::triangle_mesh::EdgeUse;

    #[test]
    fn cones_and_discs_have_exact_area_within_tolerance() {
        let axis = Vector::new(1.0, -2.0, 0.5);
        let base = Vector::new(3.0, 1.0, -2.0);
        // A truncated cone with radii 1 and 4 and slant height `l = 5` has the lateral area `pi (r1 + r2) l = 25 pi`.
        let cone = revolution(&base, &axis, &[[1.0, 0.0], [4.0, 4.0]], 1e-4).unwrap();
        assert!((cone.area() / (PI * 25.0) - 1.0).abs() < 1e-3);
        let disc = revolution(&base, &axis, &[[0.0, 0.0], [2.0, 0.0]], 1e-4).unwrap();
        assert!((disc.area() / (PI * 4.0) - 1.0).abs() < 1e-3);
        for tolerance in [0.3, 0.01, 1e-4] {
            let mesh = revolution(&base, &axis, &[[1.0, 0.0], [4.0, 4.0]], tolerance).unwrap();
            let up = axis.normalize();
            let distance = |point: &Vector| {
                let apart = point - base;
                (apart - up * up.dot(&apart)).norm()
            };
            let edge = mesh.all_corners().map(|[a, b, c]| {
                [(a, b), (b, c), (c, a)].map(|(a, b)| {
                    let radius = distance(&a);
                    if (radius - distance(&b)).abs() < 1e-9 { radius - distance(&(0.5 * (a + b))) } else { 0.0 }
                })
            });
            let deepest = edge.flatten().fold(0.0, f64::max);
            assert!(deepest <= tolerance * (1.0 + 1e-9), "{tolerance} {deepest}");
        }
        assert!(revolution(&base, &axis, &[[1.0, 0.0], [1.0, 1.0]], 1e-9).is_none());
        assert!(revolution(&base, &Vector::zeros(), &[[1.0, 0.0], [1.0, 1.0]], 0.1).is_none());
    }

    #[test]
    fn a_profile_between_two_points_of_the_axis_is_closed() {
        let profile = [[0.0, 0.0], [1.0, 1.0], [0.5, 2.0], [0.0, 2.0]];
        let mesh = revolution(&Vector::zeros(), &Vector::z(), &profile, 0.01).unwrap();
        let is_closed = |uses: &[EdgeUse]| uses.len() == 2 && uses[0].is_forward != uses[1].is_forward;
        assert!(mesh.edges().iter().all(is_closed));
        // The mesh faces outwards, so its volume is positive.
        let volume = mesh.enclosed_volume();
        let exact = PI / 3.0 * (1.0 + 1.0 + 0.5 + 0.25);
        assert!((volume / exact - 1.0).abs() < 0.02, "{volume} {exact}");
    }
}
