//! Translucent triangles of surfaces.

#[cfg(test)]
mod tests;

use super::Style;
use super::camera::{Camera, NEAREST, Point};
use super::colour::{self, Colour};
use super::raster::{Layer, Rays, SAMPLES};
use crate::base::numbers::{single, trunc_to_usize};
use crate::view::Surfaces;

/// Largest number of triangles per sample. At the default opacity, 16 triangles transmit a thousandth of the light.
const MOST_SHEETS: usize = 16;

/// A triangle, with half-open ranges of the rows and columns around it.
#[derive(Debug, Clone)]
struct Triangle {
    corners: [u32; 3],
    rows: [usize; 2],
    columns: [usize; 2],
}

#[derive(Debug, Clone, Default)]
pub(super) struct Sheets {
    points: Vec<Point>,
    normals: Vec<Point>,
    triangles: Vec<Triangle>,
    /// Opacity of a surface seen straight on.
    pub opacity: f32,
    pub colour: Colour,
    is_perspective: bool,
}

/// Point at which the ray of a sample hits a translucent triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fragment {
    pub depth: f32,
    pub triangle: u32,
}

/// A triangle, prepared for intersections with rays. A ray with window coordinates `w = (x, y, 1)` hits the triangle if
/// the three products `edges[k] . w` are not negative. These products are the weights of the corners. The depth of the
/// hit is `(depth . w) / (total . w)`.
///
/// In perspective, the ray `t w` meets the plane of a triangle with corners `a, b, c` where
/// `t = a . (b x c) / (e_a + e_b + e_c)`. Here `e_a = w . (b x c)`, and `e_b` and `e_c` follow by cyclic permutation
/// (Olano and Greer, Triangle scan conversion using 2D homogeneous coordinates, 1997).
struct Plane {
    edges: [[f64; 3]; 3],
    depth: [f64; 3],
    total: [f64; 3],
}

impl Sheets {
    pub fn of(surfaces: &Surfaces, camera: &Camera, style: &Style) -> Self {
        let mut sheets = Self {
            opacity: single(style.surface_opacity),
            colour: colour::linear(colour::SURFACE),
            is_perspective: camera.is_perspective,
            ..Self::default()
        };
        if style.surface_opacity == 0.0 {
            return sheets;
        }
        let size = [camera.width, camera.height].map(|pixels| pixels as usize * SAMPLES);
        for skin in &surfaces.skins {
            let first = u32::try_from(sheets.points.len()).unwrap_or(u32::MAX);
            sheets.points.extend(skin.vertices.iter().map(|vertex| camera.place(vertex)));
            sheets.normals.extend(skin.normals.iter().map(|normal| camera.turn(normal)));
            for corners in &skin.triangles {
                let corners = corners.map(|corner| corner.saturating_add(first));
                let Some(points) = sheets.points_of(&corners) else { continue };
                if let Some([rows, columns]) = surroundings(&points, camera, size) {
                    sheets.triangles.push(Triangle { corners, rows, columns });
                }
            }
        }
        sheets
    }

    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    fn points_of(&self, corners: &[u32; 3]) -> Option<[Point; 3]> {
        let [a, b, c] = corners.map(|corner| self.points.get(corner as usize).copied());
        Some([a?, b?, c?])
    }

    /// Returns the normal at a point of a triangle, on the side that faces the camera.
    pub fn normal(&self, fragment: &Fragment, [x, y]: [f32; 2], view: &Point) -> Point {
        let found = self.triangles.get(fragment.triangle as usize).and_then(|triangle| {
            let plane = Plane::of(&self.points_of(&triangle.corners)?, self.is_perspective)?;
            let mut sum = Point::zeros();
            for (corner, edge) in triangle.corners.iter().zip(&plane.edges) {
                let weight = value(edge, f64::from(x), f64::from(y)) / value(&plane.total, f64::from(x), f64::from(y));
                sum += self.normals.get(*corner as usize)? * single(weight);
            }
            sum.try_normalize(0.0)
        });
        let normal = found.unwrap_or(*view);
        if normal.dot(view) < 0.0 { -normal } else { normal }
    }
}

/// Returns the ranges of rows and columns around a triangle, if the triangle may be visible.
fn surroundings(points: &[Point; 3], camera: &Camera, size: [usize; 2]) -> Option<[[usize; 2]; 2]> {
    if points.iter().all(|point| point.z <= NEAREST) || !points.iter().all(|point| point.iter().all(|x| x.is_finite()))
    {
        return None;
    }
    let [columns, rows] = [0, 1].map(|k| {
        if points.iter().any(|point| point.z <= NEAREST) {
            return [0, size[k]];
        }
        let places = points.map(|point| camera.pixel(&point)[k] * SAMPLES as f32);
        let (low, high) = places.iter().fold((f32::MAX, f32::MIN), |(low, high), x| (low.min(*x), high.max(*x)));
        [trunc_to_usize(low - 1.0).min(size[k]), trunc_to_usize(high + 2.0).min(size[k])]
    });
    (rows[0] < rows[1] && columns[0] < columns[1]).then_some([rows, columns])
}

fn value(form: &[f64; 3], x: f64, y: f64) -> f64 {
    form[0] * x + form[1] * y + form[2]
}

impl Plane {
    /// Prepares a triangle; `None` if it is seen edge-on.
    fn of(points: &[Point; 3], is_perspective: bool) -> Option<Self> {
        let points = points.map(|point| point.cast::<f64>());
        let flat =
            points.map(|point| if is_perspective { point } else { nalgebra::Vector3::new(point.x, point.y, 1.0) });
        let [a, b, c] = flat;
        // Adjacent triangles compute the same numbers for a common edge, up to the sign, so no ray passes between them.
        let edges = [b.cross(&c), c.cross(&a), a.cross(&b)];
        let volume = a.dot(&edges[0]);
        let edges = edges.map(|edge| edge * volume.signum());
        let total = edges[0] + edges[1] + edges[2];
        let depth = if is_perspective {
            nalgebra::Vector3::new(0.0, 0.0, volume.abs())
        } else {
            edges[0] * points[0].z + edges[1] * points[1].z + edges[2] * points[2].z
        };
        let is_seen = volume != 0.0 && volume.is_finite();
        is_seen.then(|| Self { edges: edges.map(Into::into), depth: depth.into(), total: total.into() })
    }

    /// Returns the depth at which the ray through a window position hits the triangle in front of the camera.
    fn depth(&self, x: f64, y: f64) -> Option<f32> {
        let is_within = |edge: &[f64; 3]| {
            let side = value(edge, x, y);
            // A ray through a common edge of two triangles hits exactly one of them.
            side > 0.0 || side == 0.0 && (edge[0] > 0.0 || edge[0] == 0.0 && edge[1] > 0.0)
        };
        if !self.edges.iter().all(is_within) {
            return None;
        }
        let total = value(&self.total, x, y);
        let depth = single(value(&self.depth, x, y) / total);
        (total > 0.0 && depth > NEAREST && depth.is_finite()).then_some(depth)
    }

    /// Returns the window coordinates x at which the row at `y` may hit the triangle.
    fn range(&self, y: f64) -> [f64; 2] {
        let mut range = [f64::NEG_INFINITY, f64::INFINITY];
        for [a, b, c] in self.edges {
            let border = -(b * y + c) / a;
            if a > 0.0 {
                range[0] = range[0].max(border);
            } else if a < 0.0 {
                range[1] = range[1].min(border);
            } else if b * y + c < 0.0 {
                return [f64::INFINITY, f64::NEG_INFINITY];
            }
        }
        range
    }
}

/// The triangles that the ray of each sample hits, from farthest to nearest.
pub(super) struct Fragments {
    /// Index of the first fragment of each sample, then the number of all fragments.
    starts: Vec<usize>,
    all: Vec<Fragment>,
}

impl Fragments {
    pub fn of(sheets: &Sheets, rays: &Rays, solid: &Layer, rows: [usize; 2]) -> Self {
        let count = (rows[1] - rows[0]) * solid.width;
        let mut starts = vec![0; count + 1];
        for_each_hit(sheets, rays, solid, rows, |place, _| {
            if let Some(number) = starts.get_mut(place + 1).filter(|number| **number < MOST_SHEETS) {
                *number += 1;
            }
        });
        let mut sum = 0;
        for start in &mut starts {
            sum += *start;
            *start = sum;
        }
        let mut all = vec![Fragment { depth: f32::INFINITY, triangle: u32::MAX }; sum];
        for_each_hit(sheets, rays, solid, rows, |place, fragment| {
            let ends = (starts.get(place), starts.get(place + 1));
            let (Some(start), Some(end)) = ends else { return };
            // The fragments stay sorted by depth. If there are too many, the farthest fragment is dropped.
            let Some(own) = all.get_mut(*start..*end) else { return };
            let nearer = own.partition_point(|other| other.depth > fragment.depth);
            if nearer > 0 {
                own.copy_within(1..nearer, 0);
                own[nearer - 1] = fragment;
            }
        });
        Self { starts, all }
    }

    pub fn at(&self, place: usize) -> &[Fragment] {
        let ends = (self.starts.get(place), self.starts.get(place + 1));
        let (Some(start), Some(end)) = ends else { return &[] };
        self.all.get(*start..*end).unwrap_or_default()
    }
}

/// Calls `visit` for each hit of a triangle in front of the opaque bodies, with the index of the sample.
fn for_each_hit(sheets: &Sheets, rays: &Rays, solid: &Layer, rows: [usize; 2], mut visit: impl FnMut(usize, Fragment)) {
    for (number, triangle) in (0..u32::MAX).zip(&sheets.triangles) {
        if triangle.rows[0] >= rows[1] || triangle.rows[1] <= rows[0] {
            continue;
        }
        let Some(points) = sheets.points_of(&triangle.corners) else { continue };
        let Some(plane) = Plane::of(&points, sheets.is_perspective) else { continue };
        for row in triangle.rows[0].max(rows[0])..triangle.rows[1].min(rows[1]) {
            let y = f64::from(rays.window(row, 0)[1]);
            let columns = rays.columns_between(plane.range(y));
            for column in columns[0].max(triangle.columns[0])..columns[1].min(triangle.columns[1]) {
                let x = f64::from(rays.window(row, column)[0]);
                let place = solid.place(row, column);
                if let Some(depth) = plane.depth(x, y).filter(|depth| *depth < solid.depth[place]) {
                    visit(place, Fragment { depth, triangle: number });
                }
            }
        }
    }
}
