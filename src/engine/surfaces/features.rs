//! Converts the surfaces of a scene to features, such as the faces, edges and corners of a mesh, and periodic images.
//!
//! An edge between coplanar faces is not a feature, because a sphere touches a face first. The two faces evaluate the
//! same expression, with opposite signs, to decide on which side of the edge a projection lies. Each projection is
//! therefore on at least one of the faces.

use super::Shape;
use super::face::Face;
use super::plane::Plane;
use super::round::Round;
use crate::Vector;
use crate::model::space::Space;
use crate::model::triangle_mesh::EdgeUse;
use crate::model::{SurfaceShape, TriangleMesh};

/// An edge is flat if the sine of the angle between its faces is at most this value. When a sphere rolls across the
/// edge, the gap changes by less than a billionth of the radius.
const FLAT: f64 = 1e-9;

/// Calls `visit` with each feature of a shape, and with its periodic images. An image has the number of its feature.
/// Particles may be up to half a period outside the box, so images in this region are included.
pub(super) fn for_each_within(space: &Space, shape: &SurfaceShape, mut visit: impl FnMut(Shape, u32)) {
    let is_periodic = space.periods().iter().any(|period| period.is_finite());
    let mut all = Vec::new();
    let mut number = 0;
    for_each(shape, &mut |feature| {
        if is_periodic {
            all.push((feature, number))
        } else {
            visit(feature, number)
        }
        number += 1;
    });
    for axis in 0..3 {
        let period = space.periods()[axis];
        if period == f64::INFINITY {
            continue;
        }
        let (lower, upper) = (space.lower[axis] - 0.5 * period, space.lower[axis] + 1.5 * period);
        let mut images = Vec::new();
        for (shape, number) in &all {
            let moved = |periods: f64| {
                let mut by = Vector::zeros();
                by[axis] = periods * period;
                shape.moved(&by)
            };
            let Some([start, end]) = shape.span(axis) else { continue };
            let first = ((lower - end) / period).ceil();
            let last = ((upper - start) / period).floor();
            let mut periods = first;
            while periods <= last {
                if periods != 0.0 {
                    images.push((moved(periods), *number));
                }
                periods += 1.0;
            }
        }
        all.append(&mut images);
    }
    all.into_iter().for_each(|(shape, number)| visit(shape, number));
}

impl Shape {
    fn moved(&self, by: &Vector) -> Self {
        match *self {
            Self::Wall(wall) => Self::Wall(wall),
            Self::Plane(plane) => Self::Plane(plane),
            Self::Round(round) => Self::Round(Round { centre: round.centre + by, ..round }),
            Self::Face(face) => Self::Face(Face { corners: face.corners.map(|corner| corner + by), ..face }),
        }
    }

    /// Returns the lower and the upper end of the shape along an axis. `None` if the shape encloses particles or is
    /// unbounded, because it has no images then.
    fn span(&self, axis: usize) -> Option<[f64; 2]> {
        let corners = match self {
            Self::Round(round) if !round.is_inside => round.around(),
            Self::Face(face) => super::Surface::extent(face)?,
            Self::Round(_) | Self::Wall(_) | Self::Plane(_) => return None,
        };
        Some(corners.map(|corner| corner[axis])).filter(|ends| ends.iter().all(|end| end.is_finite()))
    }
}

fn for_each(shape: &SurfaceShape, visit: &mut dyn FnMut(Shape)) {
    let round = |centre: Vector, axis: Option<Vector>, length: f64, radius: f64, is_inside: bool| {
        Shape::Round(Round { centre, axis, length, radius, is_inside })
    };
    match shape {
        SurfaceShape::Plane { point, normal } => {
            Plane::through(point, normal).map(Shape::Plane).into_iter().for_each(visit)
        }
        &SurfaceShape::Sphere { centre, radius, is_inside } => visit(round(centre, None, 0.0, radius, is_inside)),
        &SurfaceShape::Cylinder { point, axis, radius, is_inside } => {
            let axis = axis.try_normalize(0.0);
            axis.map(|_| round(point, axis, f64::INFINITY, radius, is_inside)).into_iter().for_each(visit);
        }
        &SurfaceShape::Capsule { ends, radius } => {
            let line = segment(&ends, radius).into_iter();
            line.chain(ends.map(|end| round(end, None, 0.0, radius, false))).for_each(visit);
        }
        SurfaceShape::Mesh(mesh) => for_each_of_mesh(mesh, visit),
    }
}

/// Returns a cylinder around a line segment, without the ends. `None` if the segment has no length.
fn segment([start, end]: &[Vector; 2], radius: f64) -> Option<Shape> {
    let along = end - start;
    let axis = along.try_normalize(0.0)?;
    Some(Shape::Round(Round { centre: *start, axis: Some(axis), length: along.norm(), radius, is_inside: false }))
}

/// Calls `visit` with the features of a mesh: faces first, then edges, then corners.
fn for_each_of_mesh(mesh: &TriangleMesh, visit: &mut dyn FnMut(Shape)) {
    let mut faces: Vec<Option<Face>> = mesh.triangles.iter().zip(mesh.all_corners()).map(face).collect();
    let all = mesh.edges();
    let mut edges = Vec::new();
    let mut is_corner = vec![false; mesh.vertices.len()];
    for uses in all.iter().filter(|uses| !make_flat(uses, mesh, &mut faces)) {
        edges.push(uses[0].ends);
        uses[0].ends.iter().for_each(|vertex| is_corner[*vertex as usize] = true);
    }
    faces.into_iter().flatten().map(Shape::Face).for_each(&mut *visit);
    // A triangle with equal corners collapses to a line or a point. It is a separate feature unless another triangle
    // has this edge or corner.
    let mut needles: Vec<[u32; 2]> = mesh.triangles.iter().filter_map(needle).collect();
    if !needles.is_empty() {
        let mut is_used = vec![false; mesh.vertices.len()];
        let used: Vec<[u32; 2]> = all.iter().map(|uses| uses[0].ends).collect();
        used.iter().flatten().for_each(|vertex| is_used[*vertex as usize] = true);
        needles.sort_unstable();
        needles.dedup();
        for ends in needles.into_iter().filter(|ends| used.binary_search(ends).is_err()) {
            edges.push(ends);
            let alone = ends.into_iter().map(|vertex| vertex as usize).filter(|vertex| !is_used[*vertex]);
            alone.for_each(|vertex| is_corner[vertex] = true);
        }
    }
    drop(all);
    let place = |vertex: u32| mesh.vertices[vertex as usize];
    edges.iter().filter_map(|ends| segment(&ends.map(place), 0.0)).for_each(&mut *visit);
    let corners = mesh.vertices.iter().zip(is_corner).filter(|(_, is_corner)| *is_corner);
    corners
        .map(|(vertex, _)| {
            Shape::Round(Round { centre: *vertex, axis: None, length: 0.0, radius: 0.0, is_inside: false })
        })
        .for_each(visit);
}

/// If a triangle has collapsed to a line or a point, returns the numbers of the two end vertices in ascending order.
fn needle(&[a, b, c]: &[u32; 3]) -> Option<[u32; 2]> {
    let is_one = a == b || b == c || c == a;
    is_one.then(|| [a.min(b).min(c), a.max(b).max(c)])
}

/// Returns true if the faces at an edge are coplanar, and makes their inward directions exactly opposite.
fn make_flat(uses: &[EdgeUse], mesh: &TriangleMesh, faces: &mut [Option<Face>]) -> bool {
    let &[one, other] = uses else { return false };
    let [(one, side), (other, other_side)] = [one, other].map(|of| {
        let triangle = of.triangle as usize;
        let numbers = mesh.triangles[triangle];
        let is_side = |side: &usize| of.ends.contains(&numbers[*side]) && of.ends.contains(&numbers[(side + 1) % 3]);
        (triangle, [0, 1, 2].into_iter().find(is_side).unwrap_or_default())
    });
    let [Some(a), Some(b)] = [faces[one], faces[other]] else { return false };
    let are_opposite = a.inwards[side].dot(&b.inwards[other_side]) < 0.0;
    if !are_opposite || a.normal.cross(&b.normal).norm() > FLAT {
        return false;
    }
    if let Some(face) = &mut faces[other] {
        face.inwards[other_side] = -a.inwards[side];
    }
    true
}

/// Returns the face of a triangle, or `None` if the triangle has no area.
///
/// Directions are perpendicular to the longest edge, so round-off can turn a thin triangle only about this edge.
fn face((triangle, corners): (&[u32; 3], [Vector; 3])) -> Option<Face> {
    let along = |side: usize| corners[(side + 1) % 3] - corners[side];
    let longest = (0..3).max_by(|a, b| along(*a).norm_squared().total_cmp(&along(*b).norm_squared()))?;
    let u = along(longest).try_normalize(0.0)?;
    let third = corners[(longest + 2) % 3] - corners[longest];
    let across = third - u * u.dot(&third);
    let rounding = 4.0 * f64::EPSILON * (along(longest).norm() + third.norm());
    let across = if across.norm() > rounding { across.try_normalize(0.0)? } else { return None };
    let w = (across - u * u.dot(&across)).normalize();
    let normal = u.cross(&w);
    let mut inwards = [Vector::zeros(); 3];
    for (side, inwards) in inwards.iter_mut().enumerate() {
        *inwards = if side == longest { w } else { normal.cross(&along(side)).try_normalize(0.0)? };
    }
    // Two faces at an edge use the same corner: the corner with the smaller number.
    let from_second = [0, 1, 2].map(|side: usize| triangle[side] > triangle[(side + 1) % 3]);
    Some(Face { corners, normal, inwards, from_second })
}
