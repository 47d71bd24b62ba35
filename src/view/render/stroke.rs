//! Thin lines over an image: the edges of the box and the letters of the scale.

use super::camera::{Camera, NEAREST, Point};
use super::colour::Colour;
use super::raster::{Layer, SAMPLES};
use crate::base::numbers::trunc_to_usize;

/// A line in pixels, with depths at its two ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub ends: [[f32; 2]; 2],
    pub width: f32,
    pub colour: Colour,
    pub opacity: f32,
}

impl Stroke {
    /// Draws over pixels of an image `width` wide; `shown` gives how much of the stroke is in sight at a pixel, given
    /// how far along the stroke that is, 0 to 1.
    pub fn draw(&self, pixels: &mut [Colour], width: usize, shown: impl Fn(usize, usize, f32) -> f32) {
        self.cover([width, pixels.len() / width.max(1)], shown, |place, opacity| {
            let pixel = &mut pixels[place];
            *pixel = *pixel * (1.0 - opacity) + self.colour * opacity;
        });
    }

    /// Calls `visit` with each pixel of an image of some columns and rows that the stroke covers, and with its opacity there.
    fn cover(&self, size: [usize; 2], shown: impl Fn(usize, usize, f32) -> f32, mut visit: impl FnMut(usize, f32)) {
        let [a, b] = self.ends;
        let width = size[0];
        if width == 0 || !a.iter().chain(&b).all(|x| x.is_finite()) {
            return;
        }
        let reach = 0.5 * self.width + 1.0;
        let [columns, rows] = [0, 1].map(|k| {
            let (low, high) = (a[k].min(b[k]) - reach, a[k].max(b[k]) + reach);
            trunc_to_usize(low)..trunc_to_usize(high).saturating_add(1).min(size[k])
        });
        let along = [b[0] - a[0], b[1] - a[1]];
        let square = along[0] * along[0] + along[1] * along[1];
        for row in rows {
            for column in columns.clone() {
                let arm = [column as f32 + 0.5 - a[0], row as f32 + 0.5 - a[1]];
                let part = (arm[0] * along[0] + arm[1] * along[1]) / square;
                let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 };
                let distance = (arm[0] - part * along[0]).hypot(arm[1] - part * along[1]);
                let coverage = (0.5 * self.width + 0.5 - distance).clamp(0.0, 1.0);
                if coverage > 0.0 {
                    visit(row * width + column, coverage * self.opacity * shown(column, row, part));
                }
            }
        }
    }
}

/// How edges are drawn.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pen {
    /// In pixels.
    pub width: f32,
    pub colour: Colour,
    pub opacity: f32,
}

/// Draws edges in space over an image, each hidden by what is nearer.
pub(super) fn draw_edges(pixels: &mut [Colour], (camera, solid): (&Camera, &Layer), edges: &[[Point; 2]], pen: Pen) {
    for ends in edges {
        cover_edge(camera, solid, *ends, pen, |place, opacity| {
            let pixel = &mut pixels[place];
            *pixel = *pixel * (1.0 - opacity) + pen.colour * opacity;
        });
    }
}

/// Draws edges in space over an image, hidden by what is nearer, as one line: it is not darker where they meet.
pub(super) fn draw_outline(pixels: &mut [Colour], (camera, solid): (&Camera, &Layer), edges: &[[Point; 2]], pen: Pen) {
    let mut most = vec![0.0_f32; pixels.len()];
    for ends in edges {
        cover_edge(camera, solid, *ends, pen, |place, opacity| most[place] = most[place].max(opacity));
    }
    for (pixel, opacity) in pixels.iter_mut().zip(most) {
        *pixel = *pixel * (1.0 - opacity) + pen.colour * opacity;
    }
}

/// Calls `visit` with each pixel that an edge covers, and with its opacity there.
fn cover_edge(camera: &Camera, solid: &Layer, ends: [Point; 2], pen: Pen, visit: impl FnMut(usize, f32)) {
    let Some([a, b]) = in_front(ends) else { return };
    let ends = [a, b].map(|end| camera.pixel(&end));
    let stroke = Stroke { ends, width: pen.width, colour: pen.colour, opacity: pen.opacity };
    let depth = |part: f32| {
        if camera.is_perspective {
            // What is even in space is even in 1/z in the image.
            (((1.0 - part) / a.z) + part / b.z).recip()
        } else {
            a.z + part * (b.z - a.z)
        }
    };
    let shown = |column: usize, row: usize, part: f32| {
        let depth = depth(part);
        let is_free = |sample: usize| {
            let (row, column) = (row * SAMPLES + sample / SAMPLES, column * SAMPLES + sample % SAMPLES);
            solid.depth[row * solid.width + column] > depth
        };
        (0..SAMPLES * SAMPLES).filter(|&sample| is_free(sample)).count() as f32 / (SAMPLES * SAMPLES) as f32
    };
    stroke.cover([camera.width as usize, camera.height as usize], shown, visit);
}

/// The part of a line that lies in front of the camera.
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
