//! From surfaces and lights to colours.

use super::bodies::{Ball, Bodies};
use super::camera::{Camera, Point};
use super::colour::{self, Colour};
use super::light::{Fineness, Lights, Received, SurfacePoint};
use super::parallel::{self, Team};
use super::raster::{Keep, Layer, NOTHING, Rays, SAMPLES};
use super::sheets::{Fragment, Fragments};

/// Share of the light that comes from the sky and from the sun.
const SKY: f32 = 0.6;
const SUN: f32 = 0.68;

/// Brightness and narrowness of the sun's reflection.
const SHINE: f32 = 0.16;
const SHININESS: i32 = 40;

/// Opacity of a static surface that hides nothing but the background, relative to the one before other bodies.
const LAST_SIDE: f32 = 2.2;

/// Gain of opacity at the rim of a translucent sphere.
const RIM: f32 = 0.35;

/// How much of the far end of the scene is lost in the background.
const HAZE: f32 = 0.16;

/// Everything that is needed to colour a sample.
pub(super) struct Scenery<'a> {
    bodies: &'a Bodies,
    camera: &'a Camera,
    team: &'a Team<'a>,
    rays: Rays,
    lights: Lights,
    background: Colour,
    /// Opacity of the veil where it is seen straight on.
    opacity: f32,
    /// Opaque surfaces.
    pub solid: Layer,
    /// The nearest and the farthest of the translucent surfaces in front of it.
    veil: Option<[Layer; 2]>,
}

/// A side of a static surface on the ray of a sample.
#[derive(Debug, Clone, Copy)]
struct Film {
    depth: f32,
    ball: Ball,
    opacity: f32,
}

/// How much a translucent surface covers, given its opacity where it is seen straight on: it is denser at the rim, as glass is.
fn covered(opacity: f32, normal: &Point, view: &Point) -> f32 {
    let rim = 1.0 - normal.dot(view).clamp(0.0, 1.0);
    (opacity + (1.0 - opacity) * RIM * rim.powi(3)).min(1.0)
}

impl<'a> Scenery<'a> {
    pub fn new(bodies: &'a Bodies, camera: &'a Camera, opacity: f32, fineness: Fineness, team: &'a Team<'a>) -> Self {
        let rays = Rays::of(camera);
        let solid = Layer::of(&bodies.balls, &bodies.rods, (camera, &rays), Keep::Nearest, None, team);
        let veil = (!bodies.veil.is_empty() && opacity > 0.0).then(|| {
            [Keep::Nearest, Keep::Farthest]
                .map(|keep| Layer::of(&bodies.veil, &[], (camera, &rays), keep, Some(&solid), team))
        });
        let lights = Lights::on(&bodies.balls, camera.offset, fineness, team);
        let background = colour::linear(colour::BACKGROUND);
        Self { bodies, camera, team, rays, lights, background, opacity, solid, veil }
    }

    /// The mean of the samples of each pixel.
    pub fn colours(&self) -> Vec<Colour> {
        let (width, height) = (self.camera.width as usize, self.camera.height as usize);
        let mut pixels = vec![Colour::zeros(); width * height];
        let rows = parallel::rows_per_band(height);
        parallel::for_each(self.team, pixels.chunks_mut(rows * width).enumerate(), |(band, pixels)| {
            let last = (band * rows + pixels.len() / width) * SAMPLES;
            let sheets = &self.bodies.sheets;
            let fragments = (!sheets.is_empty())
                .then(|| Fragments::of(sheets, &self.rays, &self.solid, [band * rows * SAMPLES, last]));
            // Samples of one share ask the same few lights, whose maps stay in the cache.
            for share in 0..SAMPLES * SAMPLES {
                for (index, pixel) in pixels.iter_mut().enumerate() {
                    let (row, column) = (band * rows + index / width, index % width);
                    let (row, column) = (row * SAMPLES + share / SAMPLES, column * SAMPLES + share % SAMPLES);
                    *pixel += self.sample([row, column], share, fragments.as_ref()) / (SAMPLES * SAMPLES) as f32;
                }
            }
        });
        pixels
    }

    fn sample(&self, [row, column]: [usize; 2], share: usize, fragments: Option<&Fragments>) -> Colour {
        let place = row * self.solid.width + column;
        let body = self.solid.body[place];
        let veil = self.veil.as_ref().filter(|[near, _]| near.body[place] != NOTHING);
        let sheets = fragments.map_or(&[][..], |fragments| fragments.at(place));
        if body == NOTHING && veil.is_none() && sheets.is_empty() {
            return self.background;
        }
        let (origin, direction) = self.rays.through(row, column);
        let view = -direction.normalize();
        let mut colour = self.background;
        if body != NOTHING {
            let point = origin + direction * self.solid.depth[place];
            let (normal, own) = self.solid_surface(body as usize, &point);
            colour = self.shade(&SurfacePoint { position: point, normal, body }, &view, &own, share);
        }
        // From the farthest to the nearest: the two sides of a static surface, and between them and around them the sheets.
        let ray = (origin, direction);
        let mut left = sheets;
        for side in veil.map(|veil| self.sides(veil, place)).into_iter().flatten().flatten() {
            let farther = left.partition_point(|sheet| sheet.depth > side.depth);
            let (behind, before) = left.split_at(farther);
            colour = self.draw_sheets(colour, behind, ray, share);
            colour = self.draw_film(colour, &side, ray, share);
            left = before;
        }
        self.draw_sheets(colour, left, ray, share)
    }

    /// The far and the near side of a static surface.
    fn sides(&self, [near, far]: &[Layer; 2], place: usize) -> [Option<Film>; 2] {
        let ball_of = |layer: &Layer| self.bodies.veil.get(layer.body[place] as usize);
        let (Some(nearest), Some(farthest)) = (ball_of(near), ball_of(far)) else { return [None; 2] };
        // Neighbours in one wall overlap: they are one side.
        let has_two_sides = far.depth[place] - near.depth[place] > 2.0 * nearest.radius;
        let last = self.opacity * if self.solid.body[place] == NOTHING { LAST_SIDE } else { 1.0 };
        let film = |layer: &Layer, ball: &Ball, opacity| Film { depth: layer.depth[place], ball: *ball, opacity };
        match has_two_sides {
            true => [Some(film(far, farthest, last)), Some(film(near, nearest, self.opacity))],
            false => [None, Some(film(near, nearest, last))],
        }
    }

    /// A side of a static surface over what is behind it.
    fn draw_film(&self, behind: Colour, film: &Film, ray: (Point, Point), share: usize) -> Colour {
        let view = -ray.1.normalize();
        let point = ray.0 + ray.1 * film.depth;
        let normal = (point - film.ball.centre) / film.ball.radius;
        let surface = SurfacePoint { position: point, normal, body: NOTHING };
        let shaded = self.shade(&surface, &view, &film.ball.colour, share);
        let covered = covered(film.opacity, &normal, &view);
        behind * (1.0 - covered) + shaded * covered
    }

    /// Sheets over what is behind them.
    fn draw_sheets(&self, behind: Colour, sheets: &[Fragment], ray: (Point, Point), share: usize) -> Colour {
        let view = -ray.1.normalize();
        let window = [ray.0.x + ray.1.x, ray.0.y + ray.1.y];
        let all = &self.bodies.sheets;
        let mut colour = behind;
        for sheet in sheets {
            let point = ray.0 + ray.1 * sheet.depth;
            let normal = all.normal(sheet, window, &view);
            let surface = SurfacePoint { position: point, normal, body: NOTHING };
            let shaded = self.shade(&surface, &view, &all.colour, share);
            let covered = covered(all.opacity, &normal, &view);
            colour = colour * (1.0 - covered) + shaded * covered;
        }
        colour
    }

    /// Outward normal and colour of an opaque body at a point of its surface.
    fn solid_surface(&self, body: usize, point: &Point) -> (Point, Colour) {
        if let Some(ball) = self.bodies.balls.get(body) {
            return ((point - ball.centre) / ball.radius, ball.colour);
        }
        let rod = &self.bodies.rods[body - self.bodies.balls.len()];
        let axis = (rod.end - rod.start).normalize();
        let arm = point - rod.start;
        ((arm - axis * arm.dot(&axis)) / rod.radius, rod.colour)
    }

    fn shade(&self, surface: &SurfacePoint, view: &Point, own: &Colour, share: usize) -> Colour {
        let Received { sky, openness, sun } = self.lights.at(surface, &self.bodies.balls, share, SAMPLES * SAMPLES);
        // Light that a crevice keeps to itself takes the colour of its walls.
        let bounced = own.map(|albedo| 1.0 / (1.0 - 0.4 * albedo.min(1.0) * (1.0 - openness)));
        let mut colour = own.component_mul(&(bounced * (SKY * sky)).add_scalar(SUN * sun));
        let half = (view + Lights::sun_direction()).normalize();
        let shine = SHINE * surface.normal.dot(&half).max(0.0).powi(SHININESS) * if sun > 0.0 { openness } else { 0.0 };
        colour.add_scalar_mut(shine);
        if self.camera.is_perspective {
            let haze = HAZE * (0.5 * (surface.position.z - self.camera.offset.z + 1.0)).clamp(0.0, 1.0).powi(2);
            colour = colour * (1.0 - haze) + self.background * haze;
        }
        colour
    }
}
