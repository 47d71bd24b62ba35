//! Sections of surfaces in a two-dimensional scene.

use std::f64::consts::TAU;

use super::super::clip::{cut, fan};
use super::Region;
use crate::Vector;
use crate::model::{SurfaceShape, TriangleMesh};

const CORNERS: u32 = 144;

/// Width of a strip, relative to the diagonal of the region.
const WIDTH: f64 = 4e-3;

/// Strip along the section of a surface with the plane of the scene, on the side away from the particles.
pub(super) fn strip(shape: &SurfaceShape, region: &Region, flat: usize) -> TriangleMesh {
    let width = WIDTH * region.diagonal();
    match shape {
        SurfaceShape::Plane { point, normal } => line(point, normal, region, flat),
        SurfaceShape::Sphere { centre, radius, is_inside }
        | SurfaceShape::Cylinder { point: centre, radius, is_inside, .. } => {
            let mut centre = *centre;
            centre[flat] = region.lower[flat];
            let inner = if *is_inside { *radius } else { (radius - width).max(0.0) };
            ring(&[centre; 2], [inner, if *is_inside { radius + width } else { *radius }], flat)
        }
        SurfaceShape::Capsule { ends, radius } => {
            ring(ends, [(radius - width).max(0.0), radius.max(0.5 * width)], flat)
        }
        SurfaceShape::Mesh(_) => TriangleMesh::default(),
    }
}

/// Strip along a line, on the side opposite to the normal.
fn line(point: &Vector, normal: &Vector, region: &Region, flat: usize) -> TriangleMesh {
    let Some(up) = normal.try_normalize(0.0) else { return TriangleMesh::default() };
    let along = Vector::from_fn(|k, _| if k == flat { 1.0 } else { 0.0 }).cross(&up);
    let mut foot = region.centre() - up * up.dot(&(region.centre() - point));
    foot[flat] = region.lower[flat];
    let width = WIDTH * region.diagonal();
    let mut larger = region.clone();
    if (foot - region.centre()).norm() <= region.diagonal() {
        larger.hold(&foot, 0.0);
    }
    // Extends the region, so that a strip behind a side of the box is not cut off.
    (larger.lower, larger.upper) = (larger.lower.add_scalar(-width), larger.upper.add_scalar(width));
    let reach = larger.diagonal();
    let corners = [(-reach, 0.0), (reach, 0.0), (reach, -width), (-reach, -width)];
    let square = corners.map(|(a, b)| foot + along * a + up * b).to_vec();
    let polygon = cut(square, &larger.sides(|k, _| k != flat), region.rounding());
    TriangleMesh::welded(fan(&polygon))
}

/// Strip around a segment. The edges of the strip have the given distances from the segment.
fn ring(ends: &[Vector; 2], distances: [f64; 2], flat: usize) -> TriangleMesh {
    let [x, y] = [(flat + 1) % 3, (flat + 2) % 3];
    let direction = |angle: f64| {
        let mut direction = Vector::zeros();
        (direction[x], direction[y]) = (libm::cos(angle), libm::sin(angle));
        direction
    };
    let span = ends[1] - ends[0];
    let start = libm::atan2(span[y], span[x]);
    // The outline consists of half circles around the two ends, connected by straight sides.
    let half = CORNERS / 2;
    let corners = (0..2_u32).flat_map(|end| (0..=half).map(move |k| (end, end * half + k)));
    let outline: Vec<[Vector; 2]> = corners
        .map(|(end, k)| {
            let out = direction(start + TAU * (f64::from(k) / f64::from(CORNERS) - 0.25));
            let centre = if end == 0 { ends[1] } else { ends[0] };
            distances.map(|distance| centre + out * distance)
        })
        .collect();
    let next = outline.iter().cycle().skip(1);
    let quads = outline.iter().zip(next).flat_map(|([a, b], [d, c])| {
        let quad = [*a, *b, *c, *d];
        fan(&quad).collect::<Vec<_>>()
    });
    TriangleMesh::welded(quads)
}
