//! Colours from bodies and lights.
//!
//! An image is drawn in bands of a few rows. A pixel is the mean of its samples. All samples of a body in a pixel share
//! one colour.

mod memory;

use std::ops::Range;

use super::bodies::{Ball, Bodies};
use super::camera::{Camera, Point};
use super::colour::Colour;
use super::ground::Ground;
use super::light::{Lights, Received, SurfacePoint};
use super::parallel::{self, Team};
use super::raster::{Keep, Layer, NOTHING, Rays, SAMPLES, Stamps};
use super::sheets::{Fragment, Fragments};
use super::stroke::{Edge, draw_edges, draw_outline};
use memory::{Memory, Seen};

const SKY: f32 = 0.62;
const SUN: f32 = 0.62;

const SHINE: f32 = 0.13;
const SHININESS: i32 = 32;

/// Factor for the opacity of static spheres in front of the background.
const LAST_SIDE: f32 = 2.2;

/// Largest additional opacity of a translucent surface, at its rim.
const RIM: f32 = 0.35;

const HAZE: f32 = 0.2;

/// Order of the samples of a pixel, from the centre outwards. The colour of a body is computed at its first sample.
const ORDER: [usize; SAMPLES * SAMPLES] = [4, 1, 3, 5, 7, 0, 2, 6, 8];

pub(super) struct Scenery<'a> {
    pub bodies: &'a Bodies,
    pub camera: &'a Camera,
    pub rays: Rays,
    pub lights: Lights,
    pub ground: Option<Ground>,
    pub background: Colour,
    /// Opacity of static spheres seen straight on.
    pub opacity: f32,
    pub outline: Vec<Edge>,
    pub edges: Vec<Edge>,
}

struct Band<'a> {
    solid: Layer,
    /// The nearest and the farthest static sphere in front of the opaque bodies.
    veil: Option<[Layer; 2]>,
    sheets: Option<Fragments>,
    scenery: &'a Scenery<'a>,
}

/// One side of a surface of static spheres, on the ray of a sample.
#[derive(Debug, Clone, Copy)]
struct Film<'a> {
    depth: f32,
    body: u32,
    ball: &'a Ball,
    opacity: f32,
}

/// Returns the additional opacity of a translucent surface. It is largest at the rim, as in glass.
fn density(normal: &Point, view: &Point) -> f32 {
    let rim = 1.0 - normal.dot(view).clamp(0.0, 1.0);
    RIM * rim * rim * rim
}

fn covered(opacity: f32, density: f32) -> f32 {
    (opacity + (1.0 - opacity) * density).min(1.0)
}

impl Scenery<'_> {
    pub fn colours(&self, team: &Team) -> Vec<Colour> {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let mut pixels = vec![Colour::zeros(); width * height];
        let rows = parallel::rows_per_band(height);
        let solid = Stamps::of(&self.bodies.balls, &self.bodies.rods, self.camera, &self.rays);
        let has_veil = !self.bodies.veil.is_empty() && self.opacity > 0.0;
        let veil = has_veil.then(|| Stamps::of(&self.bodies.veil, &[], self.camera, &self.rays));
        parallel::for_each(team, pixels.chunks_mut(rows * width).enumerate(), |(band, pixels)| {
            let first = band * rows;
            self.band(pixels, first..first + pixels.len() / width, &solid, veil.as_ref());
        });
        pixels
    }

    fn band(&self, pixels: &mut [Colour], rows: Range<usize>, solid: &Stamps, veil: Option<&Stamps>) {
        let samples = [rows.start * SAMPLES, rows.end * SAMPLES];
        let solid = Layer::of(solid, &self.rays, samples, Keep::Nearest, None);
        let in_front = |stamps: &Stamps| {
            [Keep::Nearest, Keep::Farthest].map(|keep| Layer::of(stamps, &self.rays, samples, keep, Some(&solid)))
        };
        let veil = veil.map(in_front);
        let sheets = &self.bodies.sheets;
        let sheets = (!sheets.is_empty()).then(|| Fragments::of(sheets, &self.rays, &solid, samples));
        let band = Band { solid, veil, sheets, scenery: self };
        let width = self.camera.width as usize;
        for (index, pixel) in pixels.iter_mut().enumerate() {
            *pixel = band.pixel(rows.start + index / width, index % width);
        }
        let is_perspective = self.camera.is_perspective;
        draw_outline(pixels, &band.solid, &rows, &self.outline, is_perspective);
        draw_edges(pixels, &band.solid, &rows, &self.edges, is_perspective);
    }

    fn solid_surface(&self, body: usize, point: &Point) -> (Point, Colour) {
        if let Some(ball) = self.bodies.balls.get(body) {
            return ((point - ball.centre) / ball.radius, ball.colour);
        }
        let rod = &self.bodies.rods[body - self.bodies.balls.len()];
        let axis = (rod.end - rod.start).normalize();
        let arm = point - rod.start;
        ((arm - axis * arm.dot(&axis)) / rod.radius, rod.colour)
    }

    fn shade(&self, surface: &SurfacePoint, view: &Point, own: &Colour, received: Received) -> Colour {
        let Received { sky, openness, sun } = received;
        // Repeated reflection gives a crevice the colour of its walls.
        let bounced = own.map(|albedo| 1.0 / (1.0 - 0.35 * albedo.min(1.0) * (1.0 - openness)));
        let mut colour = own.component_mul(&(bounced * (SKY * sky)).add_scalar(SUN * sun));
        if sun > 0.0 {
            let half = (view + self.lights.sun_direction).normalize();
            let shine = surface.normal.dot(&half).max(0.0).powi(SHININESS);
            colour.add_scalar_mut(SHINE * shine * openness * (4.0 * sun).min(1.0));
        }
        if self.camera.is_perspective {
            let part = (0.5 * (surface.position.z - self.camera.offset.z + 1.0)).clamp(0.0, 1.0);
            let haze = HAZE * part * part;
            colour = colour * (1.0 - haze) + self.background * haze;
        }
        colour
    }

    fn behind(&self, ray: (Point, Point)) -> Colour {
        let Some(ground) = &self.ground else { return self.background };
        match ground.depth(ray) {
            Some(depth) => self.background * ground.brightness(&(ray.0 + ray.1 * depth)),
            None => self.background,
        }
    }
}

impl Band<'_> {
    fn pixel(&self, row: usize, column: usize) -> Colour {
        let mut memory = Memory::default();
        if self.is_uniform(row * SAMPLES, column * SAMPLES) {
            return self.sample([row * SAMPLES + SAMPLES / 2, column * SAMPLES + SAMPLES / 2], &mut memory);
        }
        let mut sum = Colour::zeros();
        for sample in ORDER {
            let (row, column) = (row * SAMPLES + sample / SAMPLES, column * SAMPLES + sample % SAMPLES);
            sum += self.sample([row, column], &mut memory);
        }
        sum / (SAMPLES * SAMPLES) as f32
    }

    fn is_uniform(&self, row: usize, column: usize) -> bool {
        let first = self.solid.place(row, column);
        let starts = [first, first + self.solid.width, first + 2 * self.solid.width];
        let is_one = |layer: &Layer| {
            let body = layer.body[first];
            starts.iter().all(|start| layer.body[*start..start + SAMPLES].iter().all(|own| *own == body))
        };
        is_one(&self.solid)
            && self.veil.iter().flatten().all(is_one)
            && self.sheets.as_ref().is_none_or(|sheets| {
                let numbers = |place| sheets.at(place).iter().map(|sheet| sheet.triangle);
                let mut places = starts.iter().flat_map(|start| *start..start + SAMPLES);
                places.all(|place| numbers(place).eq(numbers(first)))
            })
    }

    fn sample(&self, [row, column]: [usize; 2], memory: &mut Memory) -> Colour {
        let scenery = self.scenery;
        let place = self.solid.place(row, column);
        let body = self.solid.body[place];
        let veil = self.veil.as_ref().filter(|[near, _]| near.body[place] != NOTHING);
        let sheets = self.sheets.as_ref().map_or(&[][..], |fragments| fragments.at(place));
        let ray = scenery.rays.through(row, column);
        let mut colour = if body == NOTHING {
            memory.recall(Seen::Nothing, || (scenery.behind(ray), 1.0)).0
        } else {
            memory.recall(Seen::Solid(body), || (self.solid(body, ray, place), 1.0)).0
        };
        // Blends both sides of a static surface with the translucent triangles, from back to front.
        let mut left = sheets;
        for side in veil.map(|veil| self.sides(veil, place)).into_iter().flatten().flatten() {
            let farther = left.partition_point(|sheet| sheet.depth > side.depth);
            let (behind, before) = left.split_at(farther);
            colour = self.draw_sheets(colour, behind, ray, memory);
            let (shaded, density) = memory.recall(Seen::Veil(side.body), || self.film(&side, ray));
            let covered = covered(side.opacity, density);
            colour = colour * (1.0 - covered) + shaded * covered;
            left = before;
        }
        self.draw_sheets(colour, left, ray, memory)
    }

    fn solid(&self, body: u32, ray: (Point, Point), place: usize) -> Colour {
        let position = ray.0 + ray.1 * self.solid.depth[place];
        let (normal, own) = self.scenery.solid_surface(body as usize, &position);
        let surface = SurfacePoint { position, normal, body };
        self.scenery.shade(&surface, &-ray.1.normalize(), &own, self.scenery.lights.at(&surface))
    }

    /// Returns the far and the near side of a static surface. If both sides are one wall, returns only the near side.
    fn sides(&self, [near, far]: &[Layer; 2], place: usize) -> [Option<Film<'_>>; 2] {
        let scenery = self.scenery;
        let ball_of = |layer: &Layer| scenery.bodies.veil.get(layer.body[place] as usize);
        let (Some(nearest), Some(farthest)) = (ball_of(near), ball_of(far)) else { return [None; 2] };
        // Overlapping spheres form one wall.
        let has_two_sides = far.depth[place] - near.depth[place] > 2.0 * nearest.radius;
        let last = scenery.opacity * if self.solid.body[place] == NOTHING { LAST_SIDE } else { 1.0 };
        let film =
            |layer: &Layer, ball, opacity| Film { depth: layer.depth[place], body: layer.body[place], ball, opacity };
        match has_two_sides {
            true => [Some(film(far, farthest, last)), Some(film(near, nearest, scenery.opacity))],
            false => [None, Some(film(near, nearest, last))],
        }
    }

    fn film(&self, film: &Film, ray: (Point, Point)) -> (Colour, f32) {
        let view = -ray.1.normalize();
        let position = ray.0 + ray.1 * film.depth;
        let normal = (position - film.ball.centre) / film.ball.radius;
        let surface = SurfacePoint { position, normal, body: NOTHING };
        let received = self.scenery.lights.in_the_open(&normal);
        (self.scenery.shade(&surface, &view, &film.ball.colour, received), density(&normal, &view))
    }

    fn draw_sheets(&self, behind: Colour, sheets: &[Fragment], ray: (Point, Point), memory: &mut Memory) -> Colour {
        let all = &self.scenery.bodies.sheets;
        let mut colour = behind;
        for sheet in sheets {
            let (shaded, covered) = memory.recall(Seen::Sheet(sheet.triangle), || {
                let view = -ray.1.normalize();
                let position = ray.0 + ray.1 * sheet.depth;
                let normal = all.normal(sheet, [ray.0.x + ray.1.x, ray.0.y + ray.1.y], &view);
                let surface = SurfacePoint { position, normal, body: NOTHING };
                let received = self.scenery.lights.at(&surface);
                (
                    self.scenery.shade(&surface, &view, &all.colour, received),
                    covered(all.opacity, density(&normal, &view)),
                )
            });
            colour = colour * (1.0 - covered) + shaded * covered;
        }
        colour
    }
}
