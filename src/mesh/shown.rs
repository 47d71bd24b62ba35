//! Surfaces of a scene as triangles, for pictures.
//!
//! | surface | its triangles |
//! |---|---|
//! | mesh | the triangles of the mesh |
//! | sphere, capsule | a surface of revolution with 23 to 100 sides, depending on its size; a capsule of radius 0 is a thin rod |
//! | cylinder | the part inside the region; at open sides it ends perpendicular to its axis |
//! | plane | the polygon in which the plane cuts the region |
//!
//! The region is the box. At open sides it is extended to all particles, and to planes just outside. In a periodic box,
//! parts outside the box are shown at their images inside. Normals point to the side with particles.
//!
//! In two dimensions, a surface is a narrow strip on the side away from the particles.

mod section;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::f64::consts::PI;

use super::clip::{HalfSpace, clipped, cut, fan};
use super::revolution::revolution;
use crate::Vector;
use crate::base::numbers::{trunc_to_i32, trunc_to_u32};
use crate::model::space::Boundary;
use crate::model::{Scene, SceneSurface, SurfaceShape, TriangleMesh};

/// Deviation of triangles from a round surface, divided by the diagonal of the region.
const TOLERANCE: f64 = 2e-4;

/// Limits of the deviation from a round surface, divided by its radius. A circle has at most 100 and at least 23 sides.
const RELATIVE: [f64; 2] = [5e-4, 1e-2];

/// Displayed radius of a capsule of radius 0, relative to the diagonal of the region.
const THIN: f64 = 1.5e-3;

/// Relative tolerance of coordinates, so that a plane in a side of the box is shown.
const ROUNDING: f64 = 1e-9;

/// Returns the name and the triangles of each surface of a scene. A surface outside the region has no triangles.
pub fn shown(scene: &Scene) -> impl Iterator<Item = (&str, Cow<'_, TriangleMesh>)> {
    let region = Region::of(scene);
    scene.surfaces().iter().map(move |surface| (surface.name.as_str(), region.triangles(surface)))
}

#[derive(Debug, Clone)]
struct Region {
    lower: Vector,
    upper: Vector,
    boundary: [Boundary; 3],
}

impl Region {
    fn of(scene: &Scene) -> Self {
        let space = scene.space();
        let mut region = Self { lower: space.lower, upper: space.upper(), boundary: space.boundary };
        for particle in scene.particles() {
            region.hold(&particle.position, 0.5 * scene.diameter(particle));
        }
        region
    }

    /// Extends the region beyond open sides to contain a sphere.
    fn hold(&mut self, centre: &Vector, radius: f64) {
        for k in 0..3 {
            let Boundary::Bounded { .. } = self.boundary[k] else { continue };
            let [lower, upper] = self.boundary[k].contact_laws().map(|wall| wall.is_none());
            if lower {
                self.lower[k] = self.lower[k].min(centre[k] - radius);
            }
            if upper {
                self.upper[k] = self.upper[k].max(centre[k] + radius);
            }
        }
    }

    fn tolerance(&self, radius: f64) -> f64 {
        let [least, most] = RELATIVE;
        (TOLERANCE * self.diagonal()).clamp(least * radius, most * radius)
    }

    fn centre(&self) -> Vector {
        0.5 * (self.lower + self.upper)
    }

    fn diagonal(&self) -> f64 {
        (self.upper - self.lower).norm()
    }

    fn rounding(&self) -> f64 {
        ROUNDING * (self.diagonal() + self.lower.amax().max(self.upper.amax()))
    }

    /// Returns the sides of the region that `is_wanted(axis, side)` selects. Side 0 is lower and side 1 is upper.
    fn sides(&self, is_wanted: impl Fn(usize, usize) -> bool) -> Vec<HalfSpace> {
        let all = (0..3).flat_map(|k| [(k, 0), (k, 1)]).filter(|&(k, side)| is_wanted(k, side));
        all.map(|(k, side)| {
            let sign = if side == 0 { 1.0 } else { -1.0 };
            let face = if side == 0 { self.lower[k] } else { self.upper[k] };
            HalfSpace { normal: Vector::from_fn(|i, _| if i == k { sign } else { 0.0 }), offset: sign * face }
        })
        .collect()
    }

    fn is_open(&self, axis: usize, side: usize) -> bool {
        match &self.boundary[axis] {
            Boundary::Bounded { .. } => self.boundary[axis].contact_laws()[side].is_none(),
            Boundary::Periodic | Boundary::Flat => false,
        }
    }

    fn triangles<'s>(&self, surface: &'s SceneSurface) -> Cow<'s, TriangleMesh> {
        let flat: Vec<usize> = (0..3).filter(|&k| self.boundary[k] == Boundary::Flat).collect();
        let whole = match (&flat[..], &surface.shape) {
            (&[axis], shape) => return Cow::Owned(section::strip(shape, self, axis)),
            (&[_, ..], _) => return Cow::Owned(TriangleMesh::default()),
            (_, SurfaceShape::Mesh(mesh)) => Cow::Borrowed(mesh),
            (_, SurfaceShape::Plane { point, normal }) => return Cow::Owned(self.plane(point, normal)),
            (_, SurfaceShape::Cylinder { point, axis, radius, is_inside }) => {
                Cow::Owned(facing(self.cylinder(point, axis, *radius), *is_inside))
            }
            (_, SurfaceShape::Sphere { centre, radius, is_inside }) => {
                Cow::Owned(facing(self.capsule(&[*centre; 2], *radius), *is_inside))
            }
            (_, SurfaceShape::Capsule { ends, radius }) => {
                let radius = if *radius > 0.0 { *radius } else { THIN * self.diagonal() };
                Cow::Owned(self.capsule(ends, radius))
            }
        };
        self.within_periods(whole)
    }

    fn plane(&self, point: &Vector, normal: &Vector) -> TriangleMesh {
        let Some(up) = normal.try_normalize(0.0) else { return TriangleMesh::default() };
        let foot = |centre: &Vector| centre - up * up.dot(&(centre - point));
        let (x, y) = across(&up);
        let polygon = |region: &Self| {
            let (foot, reach) = (foot(&region.centre()), region.diagonal());
            let square = [(-reach, -reach), (reach, -reach), (reach, reach), (-reach, reach)];
            let square = square.map(|(a, b)| foot + x * a + y * b).to_vec();
            cut(square, &region.sides(|_, _| true), region.rounding())
        };
        let mut found = polygon(self);
        if found.is_empty() {
            let nearest = foot(&self.centre());
            let mut larger = self.clone();
            if (nearest - self.centre()).norm() <= self.diagonal() {
                larger.hold(&nearest, 0.0);
            }
            found = polygon(&larger);
        }
        TriangleMesh::welded(fan(&found))
    }

    fn cylinder(&self, point: &Vector, axis: &Vector, radius: f64) -> TriangleMesh {
        let Some(along) = axis.try_normalize(0.0) else { return TriangleMesh::default() };
        // The tube extends to all corners of the region.
        let middle = along.dot(&(self.centre() - point));
        let half = 0.5 * (0..3).map(|k| along[k].abs() * (self.upper[k] - self.lower[k])).sum::<f64>();
        let profile = [[radius, middle - half], [radius, middle + half]];
        let tube = revolution(point, &along, &profile, self.tolerance(radius)).unwrap_or_default();
        clipped(&tube, &self.sides(|k, side| !self.is_open(k, side)), self.rounding())
    }

    fn capsule(&self, ends: &[Vector; 2], radius: f64) -> TriangleMesh {
        let span = ends[1] - ends[0];
        let length = span.norm();
        let axis = if length > 0.0 { span } else { Vector::z() };
        let tolerance = self.tolerance(radius);
        // Points on a meridian are about as far apart as the corners on the equator.
        let half = trunc_to_u32((0.25 * PI / (2.0 * tolerance / radius).sqrt()).ceil()).clamp(4, 100);
        let arc = |step: u32| {
            // The poles lie exactly on the axis.
            let angle = 0.5 * PI * f64::from(step) / f64::from(half);
            let out = if step == 0 || step == 2 * half { 0.0 } else { radius * libm::sin(angle) };
            (out, -radius * libm::cos(angle))
        };
        let first = if length > 0.0 { half } else { half + 1 };
        let lower = (0..=half).map(|step| arc(step).into());
        let upper = (first..=2 * half).map(arc).map(|(out, height)| [out, height + length]);
        let profile: Vec<[f64; 2]> = lower.chain(upper).collect();
        revolution(&ends[0], &axis, &profile, tolerance).unwrap_or_default()
    }

    fn within_periods<'s>(&self, mesh: Cow<'s, TriangleMesh>) -> Cow<'s, TriangleMesh> {
        let (size, bounds, rounding) = (self.upper - self.lower, mesh.bounds(), self.rounding());
        let is_periodic = |k: usize| self.boundary[k] == Boundary::Periodic;
        // Shifts that move an image of the mesh into the box `[periods]`. Images that only touch the box are ignored.
        let shifts = [0, 1, 2].map(|k| {
            let first = (self.lower[k] + rounding - bounds[1][k]) / size[k];
            let last = (self.upper[k] - rounding - bounds[0][k]) / size[k];
            if is_periodic(k) { trunc_to_i32(first.ceil())..=trunc_to_i32(last.floor()) } else { 0..=0 }
        });
        let is_whole = shifts.iter().all(|shifts| *shifts == (0..=0));
        // A mesh longer than two periods is not cut.
        if is_whole || shifts.iter().any(|shifts| shifts.end() - shifts.start() > 2) {
            return mesh;
        }
        let sides = self.sides(|k, _| is_periodic(k));
        let [x, y, z] = shifts;
        let moves = x.flat_map(|i| y.clone().map(move |j| (i, j))).flat_map(|(i, j)| z.clone().map(move |k| [i, j, k]));
        let images = moves.map(|periods| {
            let shift = Vector::from(periods.map(f64::from)).component_mul(&size);
            let vertices = mesh.vertices.iter().map(|vertex| vertex + shift).collect();
            clipped(&TriangleMesh { vertices, triangles: mesh.triangles.clone() }, &sides, rounding)
        });
        let images: Vec<TriangleMesh> = images.collect();
        Cow::Owned(TriangleMesh::welded(images.iter().flat_map(TriangleMesh::all_corners)))
    }
}

/// Returns two unit vectors that form a right-handed system with the unit vector `up`.
fn across(up: &Vector) -> (Vector, Vector) {
    let mut least = Vector::zeros();
    least[up.iamin()] = 1.0;
    let x = up.cross(&least).normalize();
    (x, up.cross(&x))
}

fn facing(mut mesh: TriangleMesh, is_inside: bool) -> TriangleMesh {
    if is_inside {
        mesh.triangles.iter_mut().for_each(|[_, b, c]| std::mem::swap(b, c));
    }
    mesh
}
