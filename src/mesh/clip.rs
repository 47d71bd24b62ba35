use crate::Vector;
use crate::model::TriangleMesh;

/// Half space of all points `x` with `normal . x >= offset`. The normal is a unit vector.
#[derive(Debug, Clone, Copy)]
pub(crate) struct HalfSpace {
    pub normal: Vector,
    pub offset: f64,
}

impl HalfSpace {
    /// Depth of a point inside the half space `[length]`; negative outside.
    fn depth(&self, point: &Vector) -> f64 {
        self.normal.dot(point) - self.offset
    }
}

/// Returns the part of a mesh inside all half spaces. The tolerance keeps surfaces in a boundary plane.
pub(crate) fn clipped(mesh: &TriangleMesh, spaces: &[HalfSpace], tolerance: f64) -> TriangleMesh {
    let is_inside = |point: &Vector| spaces.iter().all(|space| space.depth(point) >= -tolerance);
    if mesh.vertices.iter().all(is_inside) {
        return mesh.clone();
    }
    let pieces = mesh.all_corners().flat_map(|corners| {
        let polygon = cut(corners.to_vec(), spaces, tolerance);
        fan(&polygon).collect::<Vec<_>>()
    });
    TriangleMesh::welded(pieces)
}

/// Returns the part of a convex polygon inside all half spaces (Sutherland-Hodgman algorithm).
pub(crate) fn cut(mut polygon: Vec<Vector>, spaces: &[HalfSpace], tolerance: f64) -> Vec<Vector> {
    for space in spaces {
        let mut kept = Vec::with_capacity(polygon.len() + 1);
        let next = polygon.iter().cycle().skip(1);
        for (a, b) in polygon.iter().zip(next) {
            let (depth_a, depth_b) = (space.depth(a), space.depth(b));
            let is_inside = [depth_a, depth_b].map(|depth| depth >= -tolerance);
            if is_inside[0] {
                kept.push(*a);
            }
            if is_inside[0] != is_inside[1] {
                // Intersections are computed from inside to outside, so both triangles at an edge get the same point.
                let (from, to, inner, outer) =
                    if is_inside[0] { (a, b, depth_a, depth_b) } else { (b, a, depth_b, depth_a) };
                kept.push(from + (to - from) * (inner / (inner - outer)).clamp(0.0, 1.0));
            }
        }
        polygon = kept;
    }
    polygon
}

/// Returns a fan of triangles around the first corner of a convex polygon. Omits triangles with two equal corners.
pub(crate) fn fan(polygon: &[Vector]) -> impl Iterator<Item = [Vector; 3]> + '_ {
    let rest = polygon.get(1..).unwrap_or_default();
    let triangles = rest.windows(2).filter_map(|pair| Some([*polygon.first()?, *pair.first()?, *pair.get(1)?]));
    triangles.filter(|[a, b, c]| a != b && b != c && c != a)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clipping_a_box_keeps_only_the_part_above_the_plane() {
        let cube = TriangleMesh::cuboid(&Vector::zeros(), &Vector::repeat(2.0));
        let above = HalfSpace { normal: Vector::z(), offset: 0.5 };
        let upper = clipped(&cube, &[above], 1e-12);
        // The top has area 4. Each of the four sides has area 2 x 1.5. The cut itself stays open.
        assert!((upper.area() - (4.0 + 4.0 * 3.0)).abs() < 1e-12);
        assert!(upper.all_corners().flatten().all(|corner| corner.z >= 0.5 - 1e-12));
        let oblique = HalfSpace { normal: Vector::new(1.0, 1.0, 0.0).normalize(), offset: 2.0_f64.sqrt() };
        assert!((clipped(&cube, &[oblique], 1e-12).area() - 12.0).abs() < 1e-9);
        assert_eq!(clipped(&cube, &[HalfSpace { normal: Vector::z(), offset: 0.0 }], 1e-12), cube);
        assert!(clipped(&cube, &[HalfSpace { normal: Vector::z(), offset: 3.0 }], 1e-12).triangles.is_empty());
    }

    #[test]
    fn triangles_stay_joined_where_they_are_cut() {
        let cube = TriangleMesh::cuboid(&Vector::zeros(), &Vector::new(1.0, 1.3, 0.7));
        let normal = Vector::new(0.3, -0.5, 0.8).normalize();
        let part = clipped(&cube, &[HalfSpace { normal, offset: 0.1 }], 1e-12);
        let rim = part.edges().iter().filter(|uses| uses.len() == 1).flatten().copied().collect::<Vec<_>>();
        let on_face = |vertex: u32| (normal.dot(&part.vertices[vertex as usize]) - 0.1).abs() < 1e-9;
        assert!(!rim.is_empty() && rim.iter().all(|side| side.ends.into_iter().all(on_face)));
    }
}
