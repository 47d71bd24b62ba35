//! Which surface each sample of the image sees: a depth buffer, filled body by body.

use super::bodies::{Ball, Rod};
use super::camera::{Camera, Point};
use super::parallel::{self, Team};
use crate::base::numbers::trunc_to_usize;

/// Samples per pixel along each axis: each pixel is the mean of the square of this.
pub(super) const SAMPLES: usize = 3;

/// Stands for no surface.
pub(super) const NOTHING: u32 = u32::MAX;

/// Depth and body of the surface that each sample sees, row by row.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    pub width: usize,
    pub depth: Vec<f32>,
    /// Index of a ball, or the number of balls plus the index of a rod, or [`NOTHING`].
    pub body: Vec<u32>,
}

/// Which of the surfaces along a ray a layer keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Keep {
    Nearest,
    /// The farthest, and of each body its near side.
    Farthest,
}

/// The balls' shape along a ray, or the rods'.
#[derive(Debug, Clone, Copy)]
enum Shape<'a> {
    Ball(&'a Ball),
    Rod(&'a Rod),
}

/// A shape with the rectangle of samples around it.
struct Stamp<'a> {
    shape: Shape<'a>,
    body: u32,
    columns: [usize; 2],
    rows: [usize; 2],
}

impl Layer {
    /// Draws bodies; where `before` is given, only what lies in front of it.
    pub fn of(balls: &[Ball], rods: &[Rod], camera: &Camera, keep: Keep, before: Option<&Layer>, team: &Team) -> Self {
        let width = camera.width as usize * SAMPLES;
        let height = camera.height as usize * SAMPLES;
        let shapes = balls.iter().map(Shape::Ball).chain(rods.iter().map(Shape::Rod));
        let stamps: Vec<Stamp> = (0..NOTHING)
            .zip(shapes)
            .filter_map(|(body, shape)| Stamp::of(shape, body, camera, [width, height]))
            .collect();
        let start = if keep == Keep::Nearest { f32::INFINITY } else { 0.0 };
        let mut layer = Self { width, depth: vec![start; width * height], body: vec![NOTHING; width * height] };
        let limit = before.map(|before| before.depth.as_slice());
        let rows = parallel::rows_per_band(height);
        let bands = layer.depth.chunks_mut(rows * width).zip(layer.body.chunks_mut(rows * width)).enumerate();
        parallel::for_each(team, bands, |(band, (depth, body))| {
            let first = band * rows;
            let limit = limit.map(|limit| &limit[first * width..][..depth.len()]);
            Band { first, width, depth, body, limit, keep }.draw(&stamps, camera);
        });
        layer
    }
}

impl<'a> Stamp<'a> {
    /// `None` if nothing of the shape can be seen.
    fn of(shape: Shape<'a>, body: u32, camera: &Camera, size: [usize; 2]) -> Option<Self> {
        let bounds = match shape {
            Shape::Ball(ball) => camera.rectangle(&ball.centre, ball.radius)?,
            Shape::Rod(rod) => {
                let (a, b) = (camera.rectangle(&rod.start, rod.radius)?, camera.rectangle(&rod.end, rod.radius)?);
                [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
            }
        };
        // Numbers saturate, so what is far outside ends in an empty range.
        let range = |low: f32, high: f32, size: usize| {
            let (low, high) = (low * SAMPLES as f32 - 1.0, high * SAMPLES as f32 + 2.0);
            [trunc_to_usize(low).min(size), trunc_to_usize(high).min(size)]
        };
        let (columns, rows) = (range(bounds[0], bounds[1], size[0]), range(bounds[2], bounds[3], size[1]));
        (columns[0] < columns[1] && rows[0] < rows[1]).then_some(Self { shape, body, columns, rows })
    }
}

/// Some rows of a layer.
struct Band<'a> {
    first: usize,
    width: usize,
    depth: &'a mut [f32],
    body: &'a mut [u32],
    limit: Option<&'a [f32]>,
    keep: Keep,
}

impl Band<'_> {
    fn draw(&mut self, stamps: &[Stamp], camera: &Camera) {
        let last = self.first + self.depth.len() / self.width;
        for stamp in stamps {
            for row in stamp.rows[0].max(self.first)..stamp.rows[1].min(last) {
                for column in stamp.columns[0]..stamp.columns[1] {
                    self.draw_sample(stamp, camera, row, column);
                }
            }
        }
    }

    fn draw_sample(&mut self, stamp: &Stamp, camera: &Camera, row: usize, column: usize) {
        let place = (row - self.first) * self.width + column;
        if let (Shape::Ball(ball), Keep::Nearest) = (stamp.shape, self.keep)
            && self.depth[place] < ball.centre.z - ball.radius
        {
            return;
        }
        let (origin, direction) = sample_ray(camera, row, column);
        let depth = match stamp.shape {
            Shape::Ball(ball) => ball_depth(ball, &origin, &direction),
            Shape::Rod(rod) => rod_depth(rod, &origin, &direction),
        };
        let Some(depth) = depth else { return };
        let is_kept = match self.keep {
            Keep::Nearest => depth < self.depth[place],
            Keep::Farthest => depth > self.depth[place],
        };
        if is_kept && self.limit.is_none_or(|limit| depth < limit[place]) {
            self.depth[place] = depth;
            self.body[place] = stamp.body;
        }
    }
}

/// The ray through the middle of a sample.
pub(super) fn sample_ray(camera: &Camera, row: usize, column: usize) -> (Point, Point) {
    let middle = |index: usize| (index as f32 + 0.5) / SAMPLES as f32;
    camera.ray(middle(column), middle(row))
}

/// How far along a ray it enters a sphere. Measured from the point nearest to the centre, where nothing cancels.
fn ball_depth(ball: &Ball, origin: &Point, direction: &Point) -> Option<f32> {
    let centre = ball.centre - origin;
    let square = direction.norm_squared();
    let nearest = direction.dot(&centre) / square;
    let half_chord = ball.radius * ball.radius - (centre - direction * nearest).norm_squared();
    (half_chord >= 0.0).then(|| nearest - (half_chord / square).sqrt())
}

/// How far along a ray it enters the round side of a cylinder; the flat ends are inside of spheres.
fn rod_depth(rod: &Rod, origin: &Point, direction: &Point) -> Option<f32> {
    let axis = rod.end - rod.start;
    let length = axis.norm();
    let axis = axis / length;
    let start = origin - rod.start;
    let across = direction - axis * direction.dot(&axis);
    let away = start - axis * start.dot(&axis);
    let square = across.norm_squared();
    let nearest = -away.dot(&across) / square;
    let half_chord = rod.radius * rod.radius - (away + across * nearest).norm_squared();
    if !(half_chord >= 0.0 && square > 0.0) {
        return None;
    }
    let depth = nearest - (half_chord / square).sqrt();
    let along = (start + direction * depth).dot(&axis);
    (0.0..=length).contains(&along).then_some(depth)
}
