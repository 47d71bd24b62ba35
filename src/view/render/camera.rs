//! Conversion of positions to image coordinates.
//!
//! Bodies are drawn in camera space, where lengths are in units of half the diagonal of the framed region. The camera
//! is at the origin, `x` points right, `y` up, and `z` into the image. In perspective, the *window* coordinates of a
//! point are `(x/z, y/z)`. Otherwise, they are `(x, y)`.

use nalgebra::{Matrix3, Vector3};

use super::Style;
use super::framing::joined;
use crate::Vector;
use crate::base::numbers::{single, trunc_to_u32};
use crate::trajectory::Frame;

pub(super) type Point = Vector3<f32>;

/// Tangent of half the field of view: 30 degrees along the shorter side of the image.
const HALF_VIEW: f32 = 0.267_949_2;

/// Margin around the framed region, relative to the shorter side of the image.
const RIM: f32 = 0.035;

/// Largest angle between two checked directions of a moving camera `[degrees]`. Between them, the framed region extends
/// further by at most a thousandth of its distance from the axis, which is much less than the margin.
const LARGEST_STEP: f64 = 4.0;

/// Smallest depth that is drawn, in half diagonals of the framed region.
pub(super) const NEAREST: f32 = 0.05;

/// Direction to the sun in the first image. The components point right, up, and horizontally into the image.
const SUN: [f64; 3] = [-0.5, 0.78, -0.52];

/// A sphere that the image must contain. A corner of the box has radius 0.
#[derive(Debug, Clone, Copy)]
pub(in crate::view) struct Extent {
    pub position: Vector,
    pub radius: f64,
}

impl Extent {
    pub fn corners(&self) -> [Vector; 2] {
        let reach = Vector::repeat(self.radius);
        [self.position - reach, self.position + reach]
    }
}

#[derive(Debug, Clone)]
pub(super) struct Camera {
    /// Rotation to camera space. The rows point right, up and into the image.
    rotation: Matrix3<f64>,
    up: Vector,
    sun: Vector,
    centre: Vector,
    /// Half diagonal of the framed region `[length]`.
    unit: f64,
    /// Centre of the framed region in camera space.
    pub offset: Point,
    pub is_perspective: bool,
    /// Window coordinates of the upper left corner of the image.
    corner: [f32; 2],
    scale: f32,
    /// Size of the image, at most the size in the style.
    pub width: u32,
    pub height: u32,
}

impl Camera {
    /// Positions the camera so that the framed region fills the image above `footer` rows. Crops the image if
    /// `style.is_cut`. Returns `None` if the region has no extent or is too large for floating-point numbers.
    pub fn facing(frame: &Frame, style: &Style, framed: &[Extent], footer: f32) -> Option<Self> {
        let mut camera = Self::around(frame, style, framed)?;
        let spheres = camera.spheres(framed);
        let window = camera.fit(&spheres, footer);
        if style.is_cut {
            camera.crop(&window, footer);
        }
        camera.centre_on(&window, footer);
        Some(camera.zoomed(style.zoom, footer))
    }

    /// Positions the camera so that the framed region stays in the image while the camera moves by `turn` degrees.
    pub fn walking(frame: &Frame, style: &Style, framed: &[Extent], footer: f32, turn: f64) -> Option<Self> {
        let mut camera = Self::around(frame, style, framed)?;
        let round = turn.abs().min(360.0);
        let steps = if camera.is_perspective { trunc_to_u32((round / LARGEST_STEP).ceil()) } else { 0 };
        let mut spheres = Vec::new();
        for step in 0..=steps {
            let part = f64::from(step) / f64::from(steps.max(1));
            let azimuth = style.azimuth + part * round.copysign(turn);
            spheres.extend(camera.turned(frame, &Style { azimuth, ..style.clone() }).spheres(framed));
        }
        let window = camera.fit(&spheres, footer);
        camera.centre_on(&window, footer);
        Some(camera.zoomed(style.zoom, footer))
    }

    /// Returns the view, enlarged about the middle of the image above the footer.
    fn zoomed(mut self, zoom: f64, footer: f32) -> Self {
        let half = [0.5 * self.width as f32, 0.5 * (self.height as f32 - footer)];
        let middle = self.window(half);
        self.scale *= single(zoom);
        self.corner = [middle[0] - half[0] / self.scale, middle[1] + half[1] / self.scale];
        self
    }

    /// Returns the view with the middle of the image at the given coordinates. `None` leaves a coordinate unchanged.
    pub fn looking_at(mut self, focus: [Option<f64>; 3]) -> Self {
        for (own, focus) in self.centre.iter_mut().zip(focus) {
            *own = focus.filter(|focus| focus.is_finite()).unwrap_or(*own);
        }
        self
    }

    pub fn turned(&self, frame: &Frame, style: &Style) -> Self {
        Self { rotation: orientation(frame, style).0, ..self.clone() }
    }

    fn around(frame: &Frame, style: &Style, framed: &[Extent]) -> Option<Self> {
        let [lower, upper] = framed.iter().map(Extent::corners).reduce(joined)?;
        let unit = 0.5 * (upper - lower).norm();
        if !(unit.is_normal() && unit.recip().is_normal()) {
            return None;
        }
        let (rotation, is_perspective) = orientation(frame, style);
        let up = if is_perspective { upwards(frame, style) } else { rotation.row(1).transpose() };
        let right = rotation.row(0).transpose();
        let sun = (right * SUN[0] + up * SUN[1] + up.cross(&right) * SUN[2]).normalize();
        Some(Self {
            rotation,
            up,
            sun,
            centre: 0.5 * lower + 0.5 * upper,
            unit,
            offset: Point::zeros(),
            is_perspective,
            corner: [0.0; 2],
            scale: 1.0,
            width: style.width,
            height: style.height,
        })
    }

    fn spheres(&self, framed: &[Extent]) -> Vec<(Point, f32)> {
        framed.iter().map(|e| (self.place(&e.position), self.length(e.radius))).collect()
    }

    fn rim(&self) -> f32 {
        RIM * (self.width as f32).min(self.height as f32)
    }

    /// Fits the spheres into the image. Returns the bounds of the spheres in window coordinates.
    fn fit(&mut self, spheres: &[(Point, f32)], footer: f32) -> [f32; 4] {
        let (width, height) = (self.width as f32, self.height as f32);
        let rim = self.rim();
        // `room` is the usable width and height in pixels. `border` is half of `room` in window coordinates.
        let room = [(width - 2.0 * rim).max(1.0), (height - footer - 2.0 * rim).max(1.0)];
        let border = room.map(|pixels| HALF_VIEW * pixels / width.min(height));
        let mut distance = 0.0_f32;
        for axis in 0..2 {
            // Let the camera be at position `x_c` and distance `d`. The window coordinate `(x - x_c) / (z + d)` of a
            // point is at most `t` if `x - t z <= t d + x_c`, and at least `-t` if `x + t z >= x_c - t d`.
            let t = if self.is_perspective { border[axis] } else { 0.0 };
            let edge = (1.0 + t * t).sqrt();
            let most = spheres.iter().map(|(c, r)| c[axis] - t * c.z + r * edge).fold(f32::MIN, f32::max);
            let least = spheres.iter().map(|(c, r)| c[axis] + t * c.z - r * edge).fold(f32::MAX, f32::min);
            self.offset[axis] = -0.5 * (most + least);
            distance = distance.max(0.5 * (most - least) / border[axis]);
        }
        let nearest = spheres.iter().map(|(c, r)| c.z - r).fold(f32::MAX, f32::min);
        self.offset.z = if self.is_perspective { distance.max(0.5 - nearest) } else { 2.0 };
        self.scale = width.min(height) / (2.0 * HALF_VIEW);
        if !self.is_perspective {
            self.scale /= distance;
        }
        let mut window = [f32::MAX, f32::MIN, f32::MAX, f32::MIN];
        for (centre, radius) in spheres {
            if let Some([left, right, low, high]) = self.outline(&(centre + self.offset), *radius) {
                window = [window[0].min(left), window[1].max(right), window[2].min(low), window[3].max(high)];
            }
        }
        window
    }

    /// Crops the image to a region in window coordinates with a margin.
    fn crop(&mut self, window: &[f32; 4], footer: f32) {
        let [left, right, low, high] = window;
        let rim = self.rim();
        let pixels = |length: f32, most: u32| trunc_to_u32((length * self.scale + 2.0 * rim).ceil()).clamp(16, most);
        self.width = pixels(right - left, self.width);
        self.height = pixels(high - low + footer / self.scale, self.height);
    }

    /// Centres the image above the footer on a region in window coordinates.
    fn centre_on(&mut self, window: &[f32; 4], footer: f32) {
        let [left, right, low, high] = window;
        let half = [self.width as f32, self.height as f32 - footer].map(|pixels| 0.5 * pixels / self.scale);
        self.corner = [0.5 * (left + right) - half[0], 0.5 * (low + high) + half[1]];
    }

    pub fn place(&self, position: &Vector) -> Point {
        (self.rotation * ((position - self.centre) / self.unit)).cast::<f32>() + self.offset
    }

    pub fn turn(&self, direction: &Vector) -> Point {
        (self.rotation * direction).cast::<f32>()
    }

    pub fn up(&self) -> Point {
        self.turn(&self.up)
    }

    pub fn sun(&self) -> Point {
        self.turn(&self.sun)
    }

    /// Whether the camera is in front of the plane through `point` with the given normal.
    pub fn is_before(&self, point: &Vector, normal: &Vector) -> bool {
        let normal = self.turn(normal);
        let line = if self.is_perspective { self.place(point) } else { Point::z() };
        normal.dot(&line) < 0.0
    }

    /// Converts a length to half diagonals of the framed region.
    pub fn length(&self, length: f64) -> f32 {
        single(length / self.unit)
    }

    /// Returns the number of pixels per length in the middle of the framed region `[1 / length]`.
    pub fn pixels_per_length(&self) -> f64 {
        self.pixels_per_unit() / self.unit
    }

    /// Returns the number of pixels per half diagonal in the middle of the framed region.
    pub fn pixels_per_unit(&self) -> f64 {
        let depth = if self.is_perspective { self.offset.z } else { 1.0 };
        f64::from(self.scale / depth)
    }

    /// Converts pixels from the upper left corner to window coordinates.
    pub fn window(&self, [column, row]: [f32; 2]) -> [f32; 2] {
        [self.corner[0] + column / self.scale, self.corner[1] - row / self.scale]
    }

    /// Returns the position of a point in pixels from the upper left corner.
    pub fn pixel(&self, point: &Point) -> [f32; 2] {
        let depth = if self.is_perspective { point.z } else { 1.0 };
        [(point.x / depth - self.corner[0]) * self.scale, (self.corner[1] - point.y / depth) * self.scale]
    }

    /// Returns the pixels around a sphere: first and last column, first and last row. Returns `None` if the sphere
    /// reaches the camera or is not finite.
    pub fn rectangle(&self, centre: &Point, radius: f32) -> Option<[f32; 4]> {
        let [left, right, low, high] = self.outline(centre, radius)?;
        let columns = [left, right].map(|x| (x - self.corner[0]) * self.scale);
        let rows = [high, low].map(|y| (self.corner[1] - y) * self.scale);
        Some([columns[0], columns[1], rows[0], rows[1]])
    }

    /// Returns the left, right, lower and upper end of a sphere in window coordinates.
    fn outline(&self, centre: &Point, radius: f32) -> Option<[f32; 4]> {
        let is_in_front = centre.z - radius > NEAREST && centre.iter().all(|x| x.is_finite()) && radius.is_finite();
        if !is_in_front {
            return None;
        }
        let tangents = |x: f32| {
            if !self.is_perspective {
                return [x - radius, x + radius];
            }
            let (z, square) = (centre.z, centre.z * centre.z - radius * radius);
            let root = radius * (x * x + square).sqrt();
            [(x * z - root) / square, (x * z + root) / square]
        };
        let ([left, right], [low, high]) = (tangents(centre.x), tangents(centre.y));
        Some([left, right, low, high])
    }
}

/// Returns the upward direction from the style, or against gravity, or z (y if z is flat).
fn upwards(frame: &Frame, style: &Style) -> Vector {
    let is_y = frame.is_flat(2) && !frame.is_flat(0) && !frame.is_flat(1);
    let against = style.gravity.and_then(|gravity| (-gravity).try_normalize(0.0));
    style.up.map(|up| up.normalize()).or(against).unwrap_or_else(|| if is_y { Vector::y() } else { Vector::z() })
}

/// Returns the azimuth and elevation of the camera in radians. At azimuth 0, `right` points right in the image.
fn angles(style: &Style, right: &Vector, up: &Vector) -> [f64; 2] {
    let azimuth = style.azimuth.to_radians();
    let Some(from) = style.from.and_then(|from| from.try_normalize(0.0)) else {
        return [azimuth, style.elevation.to_radians()];
    };
    let [aside, behind, above] = [right.dot(&from), -up.cross(right).dot(&from), up.dot(&from)];
    // If the camera is exactly above or below the scene, `right` defines azimuth 0.
    let around = if aside.abs() + behind.abs() > 1e-9 { libm::atan2(aside, behind) } else { 0.0 };
    [azimuth + around, libm::asin(above.clamp(-1.0, 1.0))]
}

/// Returns the rotation to camera space, and whether the view is in perspective.
fn orientation(frame: &Frame, style: &Style) -> (Matrix3<f64>, bool) {
    let axis = |k: usize| Vector::from_fn(|i, _| f64::from(u8::from(i == k)));
    let flat: Vec<usize> = (0..3).filter(|&k| frame.is_flat(k)).collect();
    let rows =
        |right: Vector, up: Vector| Matrix3::from_rows(&[right, up, up.cross(&right)].map(|row| row.transpose()));
    let up = upwards(frame, style);
    match flat[..] {
        [] | [_, _, _] => {
            let aside = (0..3).map(axis).find(|side| side.dot(&up).abs() < 0.9).unwrap_or_else(Vector::x);
            let right = (aside - up * aside.dot(&up)).normalize();
            let [azimuth, elevation] = angles(style, &right, &up);
            let ((sine, cosine), (rise, level)) = (libm::sincos(azimuth), libm::sincos(elevation));
            let into = up.cross(&right) * cosine - right * sine;
            let right = right * cosine + up.cross(&right) * sine;
            (rows(right, up * level + into * rise), true)
        }
        [flat] => {
            let up = up - axis(flat) * up[flat];
            let up = if up.norm() > 0.1 { up.normalize() } else { axis(if flat == 2 { 1 } else { 2 }) };
            // The first axis of a flat scene points right.
            let right = up.cross(&axis(flat));
            let is_mirrored = right.iter().find(|x| x.abs() > 0.1).is_some_and(|&x| x < 0.0);
            (rows(if is_mirrored { -right } else { right }, up), false)
        }
        [first, second] => {
            let along = 3 - first - second;
            (rows(axis(along), axis((along + 1) % 3)), false)
        }
        _ => (Matrix3::identity(), false),
    }
}
