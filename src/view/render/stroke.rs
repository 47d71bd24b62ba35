use std::ops::Range;

use super::camera::{Camera, NEAREST, Point};
use super::colour::Colour;
use super::raster::{Layer, SAMPLES};
use crate::base::numbers::trunc_to_usize;

/// A straight line in an image, in pixels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub ends: [[f32; 2]; 2],
    pub width: f32,
    pub colour: Colour,
    pub opacity: f32,
}

impl Stroke {
    pub fn draw(&self, pixels: &mut [Colour], width: usize) {
        let rows = 0..pixels.len() / width.max(1);
        self.cover(width, rows, |column, row, _, opacity| {
            let pixel = &mut pixels[row * width + column];
            *pixel = *pixel * (1.0 - opacity) + self.colour * opacity;
        });
    }

    /// Calls `visit` for each pixel of the line: column, row, position along the line from 0 to 1, and opacity.
    fn cover(&self, width: usize, rows: Range<usize>, mut visit: impl FnMut(usize, usize, f32, f32)) {
        let [a, b] = self.ends;
        if width == 0 || !a.iter().chain(&b).all(|x| x.is_finite()) {
            return;
        }
        let [columns, own] = [0, 1].map(|k| self.reach(k));
        let columns = columns[0]..columns[1].min(width);
        let along = [b[0] - a[0], b[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        for row in own[0].max(rows.start)..own[1].min(rows.end) {
            for column in columns.clone() {
                let arm = [column as f32 + 0.5 - a[0], row as f32 + 0.5 - a[1]];
                let part = (arm[0] * along[0] + arm[1] * along[1]) / square;
                let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
                let (x, y) = (arm[0] - part * along[0], arm[1] - part * along[1]);
                let coverage = (0.5 * self.width + 0.5 - (x * x + y * y).sqrt()).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    visit(column, row, part, coverage * self.opacity);
                }
            }
        }
    }

    /// Returns the half-open range of columns (axis 0) or rows (axis 1) around the line.
    fn reach(&self, axis: usize) -> [usize; 2] {
        let ([a, b], reach) = (self.ends, 0.5 * self.width + 1.0);
        let (low, high) = (a[axis].min(b[axis]) - reach, a[axis].max(b[axis]) + reach);
        [trunc_to_usize(low), trunc_to_usize(high).saturating_add(1)]
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    pub width: f32,
    pub colour: Colour,
    pub opacity: f32,
    /// Whether the edge is drawn behind all bodies, even if it is in front of them.
    pub is_behind: bool,
}

#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    stroke: Stroke,
    depths: [f32; 2],
    is_behind: bool,
}

impl Edge {
    /// Returns `None` if the edge is behind the camera.
    pub fn of(camera: &Camera, ends: [Point; 2], pen: Pen) -> Option<Self> {
        let [a, b] = in_front(ends)?;
        let Pen { width, colour, opacity, is_behind } = pen;
        let stroke = Stroke { ends: [a, b].map(|end| camera.pixel(&end)), width, colour, opacity };
        Some(Self { stroke, depths: [a.z, b.z], is_behind })
    }

    fn cover(&self, solid: &Layer, rows: &Range<usize>, is_perspective: bool, mut visit: impl FnMut(usize, f32)) {
        let width = solid.width / SAMPLES;
        let [near, far] = self.depths;
        self.stroke.cover(width, rows.clone(), |column, row, part, opacity| {
            let depth = match is_perspective {
                _ if self.is_behind => f32::INFINITY,
                // In perspective, `1 / z` is linear along a line in the image.
                true => ((1.0 - part) / near + part / far).recip(),
                false => near + part * (far - near),
            };
            let is_free = |sample: usize| {
                let (row, column) = (row * SAMPLES + sample / SAMPLES, column * SAMPLES + sample % SAMPLES);
                solid.depth[solid.place(row, column)] >= depth
            };
            let free = (0..SAMPLES * SAMPLES).filter(|&sample| is_free(sample)).count();
            visit((row - rows.start) * width + column, opacity * free as f32 / (SAMPLES * SAMPLES) as f32);
        });
    }
}

pub(super) fn draw_edges(
    pixels: &mut [Colour],
    solid: &Layer,
    rows: &Range<usize>,
    edges: &[Edge],
    is_perspective: bool,
) {
    for edge in edges {
        edge.cover(solid, rows, is_perspective, |place, opacity| {
            let pixel = &mut pixels[place];
            *pixel = *pixel * (1.0 - opacity) + edge.stroke.colour * opacity;
        });
    }
}

/// Draws edges such that the image is not darker where edges meet.
pub(super) fn draw_outline(
    pixels: &mut [Colour],
    solid: &Layer,
    rows: &Range<usize>,
    edges: &[Edge],
    is_perspective: bool,
) {
    let Some(colour) = edges.first().map(|edge| edge.stroke.colour) else { return };
    let mut most = vec![0.0_f32; pixels.len()];
    for edge in edges {
        edge.cover(solid, rows, is_perspective, |place, opacity| most[place] = most[place].max(opacity));
    }
    for (pixel, opacity) in pixels.iter_mut().zip(most) {
        *pixel = *pixel * (1.0 - opacity) + colour * opacity;
    }
}

fn in_front(ends: [Point; 2]) -> Option<[Point; 2]> {
    let [a, b] = ends;
    let cut = |from: Point, to: Point| from + (to - from) * ((NEAREST - from.z) / (to.z - from.z));
    match [a.z >= NEAREST, b.z >= NEAREST] {
        [true, true] => Some([a, b]),
        [true, false] => Some([a, cut(b, a)]),
        [false, true] => Some([cut(a, b), b]),
        [false, false] => None,
    }
}
