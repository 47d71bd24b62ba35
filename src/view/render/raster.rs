//! A depth buffer: the visible body at each sample of an image.

use super::bodies::{Ball, Rod};
use super::camera::{Camera, Point};
use crate::base::numbers::trunc_to_usize;

/// Samples per pixel along each axis.
pub(super) const SAMPLES: usize = 3;

pub(super) const NOTHING: u32 = u32::MAX;

/// Rays through the centres of the samples.
#[derive(Debug)]
pub(super) struct Rays {
    /// Window coordinate x of each column of samples, and y of each row.
    columns: Vec<f32>,
    rows: Vec<f32>,
    /// The ray through window coordinates `(x, y)` begins at `shift * (x, y, 0)`.
    /// The direction is `(slope * x, slope * y, 1)`.
    shift: f32,
    slope: f32,
}

/// The visible body and its depth for each sample in a range of rows, row by row.
#[derive(Debug, Clone)]
pub(super) struct Layer {
    pub first: usize,
    pub width: usize,
    pub depth: Vec<f32>,
    /// Index of a ball, or the number of balls plus the index of a rod, or [`NOTHING`].
    pub body: Vec<u32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Keep {
    Nearest,
    /// The body whose near side is farthest from the camera.
    Farthest,
}

#[derive(Debug, Clone, Copy)]
enum Shape<'a> {
    Ball(&'a Ball),
    Rod(&'a Rod),
}

/// A shape with the range of samples that it may cover.
struct Stamp<'a> {
    shape: Shape<'a>,
    body: u32,
    columns: [usize; 2],
    rows: [usize; 2],
}

pub(super) struct Stamps<'a>(Vec<Stamp<'a>>);

impl<'a> Stamps<'a> {
    pub fn of(balls: &'a [Ball], rods: &'a [Rod], camera: &Camera, rays: &Rays) -> Self {
        let size = [rays.columns.len(), rays.rows.len()];
        let shapes = balls.iter().map(Shape::Ball).chain(rods.iter().map(Shape::Rod));
        Self((0..NOTHING).zip(shapes).filter_map(|(body, shape)| Stamp::of(shape, body, camera, size)).collect())
    }
}

impl Layer {
    /// Draws the shapes. If `before` is given, only parts in front of this layer are drawn.
    pub fn of(stamps: &Stamps, rays: &Rays, rows: [usize; 2], keep: Keep, before: Option<&Layer>) -> Self {
        let (width, first) = (rays.columns.len(), rows[0]);
        let count = width * (rows[1] - rows[0]);
        let start = if keep == Keep::Nearest { f32::INFINITY } else { 0.0 };
        let mut layer = Self { first, width, depth: vec![start; count], body: vec![NOTHING; count] };
        let (depth, body) = (layer.depth.as_mut_slice(), layer.body.as_mut_slice());
        let limit = before.map(|before| before.depth.as_slice());
        Band { first, width, depth, body, limit, keep }.draw(&stamps.0, rays);
        layer
    }

    pub fn place(&self, row: usize, column: usize) -> usize {
        (row - self.first) * self.width + column
    }
}

impl<'a> Stamp<'a> {
    /// Returns `None` if the shape is not visible.
    fn of(shape: Shape<'a>, body: u32, camera: &Camera, size: [usize; 2]) -> Option<Self> {
        let bounds = match shape {
            Shape::Ball(ball) => camera.rectangle(&ball.centre, ball.radius)?,
            Shape::Rod(rod) => {
                let (a, b) = (camera.rectangle(&rod.start, rod.radius)?, camera.rectangle(&rod.end, rod.radius)?);
                [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
            }
        };
        // A shape far outside the image has an empty range, because conversions to integers saturate.
        let range = |low: f32, high: f32, size: usize| {
            let (low, high) = (low * SAMPLES as f32 - 1.0, high * SAMPLES as f32 + 2.0);
            [trunc_to_usize(low).min(size), trunc_to_usize(high).min(size)]
        };
        let (columns, rows) = (range(bounds[0], bounds[1], size[0]), range(bounds[2], bounds[3], size[1]));
        (columns[0] < columns[1] && rows[0] < rows[1]).then_some(Self { shape, body, columns, rows })
    }
}

struct Band<'a> {
    first: usize,
    width: usize,
    depth: &'a mut [f32],
    body: &'a mut [u32],
    limit: Option<&'a [f32]>,
    keep: Keep,
}

impl Band<'_> {
    fn draw(&mut self, stamps: &[Stamp], rays: &Rays) {
        let last = self.first + self.depth.len() / self.width;
        let (mut depths, unlimited) = (vec![0.0; self.width], vec![f32::INFINITY; self.width]);
        for stamp in stamps.iter().filter(|stamp| stamp.rows[0] < last && stamp.rows[1] > self.first) {
            let [left, right] = stamp.columns;
            let depths = &mut depths[left..right];
            for row in stamp.rows[0].max(self.first)..stamp.rows[1].min(last) {
                match stamp.shape {
                    Shape::Ball(ball) => ball_depths(ball, rays, row, left, depths),
                    Shape::Rod(rod) => {
                        for (column, depth) in (left..).zip(&mut *depths) {
                            *depth = rod_depth(rod, rays.through(row, column));
                        }
                    }
                }
                let start = (row - self.first) * self.width;
                let places = start + left..start + right;
                let limits = self.limit.map_or(&unlimited[left..right], |limit| &limit[places.clone()]);
                let kept = self.depth[places.clone()].iter_mut().zip(&mut self.body[places]);
                for (((kept, body), depth), limit) in kept.zip(&*depths).zip(limits) {
                    let is_kept = match self.keep {
                        Keep::Nearest => depth < kept,
                        Keep::Farthest => depth > kept,
                    };
                    if is_kept && depth < limit {
                        (*kept, *body) = (*depth, stamp.body);
                    }
                }
            }
        }
    }
}

impl Rays {
    pub fn of(camera: &Camera) -> Self {
        let middle = |sample: usize| (sample as f32 + 0.5) / SAMPLES as f32;
        let samples = |pixels: u32| 0..pixels as usize * SAMPLES;
        let (shift, slope) = if camera.is_perspective { (0.0, 1.0) } else { (1.0, 0.0) };
        Self {
            columns: samples(camera.width).map(|column| camera.window([middle(column), 0.0])[0]).collect(),
            rows: samples(camera.height).map(|row| camera.window([0.0, middle(row)])[1]).collect(),
            shift,
            slope,
        }
    }

    pub fn window(&self, row: usize, column: usize) -> [f32; 2] {
        [self.columns[column], self.rows[row]]
    }

    /// Returns the columns in a range of window coordinates: the first, and one past the last.
    pub fn columns_between(&self, [low, high]: [f64; 2]) -> [usize; 2] {
        let (Some(first), Some(last)) = (self.columns.first(), self.columns.last()) else { return [0, 0] };
        let (first, last) = (f64::from(*first), f64::from(*last));
        let step = (last - first) / (self.columns.len() - 1).max(1) as f64;
        let place = |x: f64| (x - first) / step;
        [trunc_to_usize(place(low) - 1.0), trunc_to_usize(place(high) + 2.0).min(self.columns.len())]
    }

    /// Returns the origin and direction of the ray through a sample. Distances along the ray are depths, because the
    /// direction has `z = 1`.
    pub fn through(&self, row: usize, column: usize) -> (Point, Point) {
        let (x, y) = (self.columns[column], self.rows[row]);
        (Point::new(self.shift * x, self.shift * y, 0.0), Point::new(self.slope * x, self.slope * y, 1.0))
    }
}

/// Computes the distances at which the rays of a row enter a sphere, or NaN for a miss. The first column is `left`. To
/// avoid cancellation, distances start at the point nearest to the centre. The loop is vectorised.
fn ball_depths(ball: &Ball, rays: &Rays, row: usize, left: usize, depths: &mut [f32]) {
    let Rays { columns, rows, shift, slope } = rays;
    let (centre, radius_square) = (ball.centre, ball.radius * ball.radius);
    let (centre_y, slope_y) = (centre.y - shift * rows[row], slope * rows[row]);
    for (depth, x) in depths.iter_mut().zip(&columns[left..]) {
        let (centre_x, slope_x) = (centre.x - shift * x, slope * x);
        let inverse = 1.0 / (slope_x * slope_x + slope_y * slope_y + 1.0);
        let nearest = (slope_x * centre_x + slope_y * centre_y + centre.z) * inverse;
        let (dx, dy, dz) = (centre_x - slope_x * nearest, centre_y - slope_y * nearest, centre.z - nearest);
        *depth = nearest - ((radius_square - (dx * dx + dy * dy + dz * dz)) * inverse).sqrt();
    }
}

/// Returns the distance at which a ray enters the curved side of a cylinder, or NaN for a miss. The flat ends are
/// hidden in spheres or between the halves of a bond.
fn rod_depth(rod: &Rod, (origin, direction): (Point, Point)) -> f32 {
    let axis = rod.end - rod.start;
    let length = axis.norm();
    let axis = axis / length;
    let start = origin - rod.start;
    let across = direction - axis * direction.dot(&axis);
    let away = start - axis * start.dot(&axis);
    let square = across.norm_squared();
    let nearest = -away.dot(&across) / square;
    let half_chord = rod.radius * rod.radius - (away + across * nearest).norm_squared();
    let depth = nearest - (half_chord / square).sqrt();
    let along = (start + direction * depth).dot(&axis);
    if square > 0.0 && (0.0..=length).contains(&along) { depth } else { f32::NAN }
}
