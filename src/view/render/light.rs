//! Where light comes from, and which of it reaches a point.
//!
//! The sky is a set of directions all around, brighter above; the sun is a narrow bundle of them. Each has a map of the
//! spheres that it sees first. A point is in the shade of the sphere that the map shows in its place, if that sphere
//! stands between: the test is exact, so that shadows have no stairs however coarse the map.

use super::bodies::Ball;
use super::camera::{Camera, Point};
use super::map::{Disc, Map};
use super::parallel::{self, Team};
use super::raster::NOTHING;
use crate::base::numbers::trunc_to_usize;

/// Directions of the sky in a still picture, and in an image of a movie: multiples of the samples of a pixel.
const SKY_LIGHTS: usize = 45;
const MOVIE_SKY_LIGHTS: usize = 27;

const SUN_LIGHTS: usize = 9;

/// The most cells of a map along each side; fewer where balls as large as the scene cover it many times.
const MAP_SIZE: usize = 768;

/// The least of them.
const LEAST_MAP_SIZE: usize = 16;

/// Cells of a map for each pixel of an image of a movie, about as many as in a picture of the default size.
const CELLS_PER_PIXEL: f64 = 0.6;

/// Radius of a large ball, relative to the side of a map.
const LARGE: f32 = 0.125;

/// How often large balls may cover a whole map before it becomes coarser: each is compared with all cells that it covers, and nothing of it is
/// lost between cells.
const MOST_COVERS: f32 = 8.0;

/// The most that all maps take `[bytes]`.
pub(in crate::view) const MAP_BYTES: u64 = ((SKY_LIGHTS + SUN_LIGHTS) * MAP_SIZE * MAP_SIZE * size_of::<u32>()) as u64;

/// Most width of the soft edge of a shadow, relative to the radius of what throws it.
const WIDEST_EDGE: f32 = 0.3;

/// Towards the sun in camera space: from above, to the left, behind the viewer.
const SUN: [f32; 3] = [-0.5, 0.72, -0.62];

/// Half the opening angle of the sun's bundle [radians].
const SUN_SPREAD: f32 = 0.07;

/// How finely light is sampled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Fineness {
    sky_lights: usize,
    /// Cells of a map along each side.
    map_size: usize,
}

/// Lights of equal kind, each with the part of the whole that it gives.
#[derive(Debug)]
pub(super) struct Lights {
    sky: Vec<Light>,
    sun: Vec<Light>,
}

/// A point of the surface of a body.
pub(super) struct SurfacePoint {
    pub position: Point,
    /// Outward.
    pub normal: Point,
    /// The ball that it belongs to, which casts no shadow on itself.
    pub body: u32,
}

/// Light that reaches a point: 1 for a surface that faces up, or the sun, with nothing between.
#[derive(Debug, Clone, Copy)]
pub(super) struct Received {
    pub sky: f32,
    /// Of the sky, what is not hidden: 1 in the open.
    pub openness: f32,
    pub sun: f32,
}

#[derive(Debug)]
struct Light {
    /// Towards the light.
    direction: Point,
    strength: f32,
    /// Width of the soft edge of a shadow, relative to the distance from what throws it.
    softness: f32,
    /// Directions of a row and of a column of the map, one cell long.
    axes: [Point; 2],
    centre: Point,
    map: Map,
}

impl Fineness {
    /// That of a still picture.
    pub const PICTURE: Self = Self { sky_lights: SKY_LIGHTS, map_size: MAP_SIZE };

    /// That of an image of a movie, which is seen for a moment.
    pub fn of_movie(camera: &Camera) -> Self {
        let size = trunc_to_usize(2.0 * CELLS_PER_PIXEL * camera.pixels_per_unit());
        Self { sky_lights: MOVIE_SKY_LIGHTS, map_size: size.clamp(LEAST_MAP_SIZE, MAP_SIZE) }
    }
}

impl Lights {
    /// Lights for spheres around a centre; those farther than 1 from it throw no shadow.
    pub fn on(balls: &[Ball], centre: Point, fineness: Fineness, team: &Team) -> Self {
        let sun = Point::from(SUN).normalize();
        let (right, up) = across(&sun);
        let spread = |k: usize| {
            let (radius, angle) = (((k as f32 + 0.5) / SUN_LIGHTS as f32).sqrt() * SUN_SPREAD, k as f32 * GOLDEN_ANGLE);
            (sun + (right * angle.cos() + up * angle.sin()) * radius).normalize()
        };
        let around = |k: usize| {
            let (height, angle) = (1.0 - (2 * k + 1) as f32 / fineness.sky_lights as f32, k as f32 * GOLDEN_ANGLE);
            let radius = (1.0 - height * height).sqrt();
            Point::new(radius * angle.cos(), height, radius * angle.sin())
        };
        let size = map_size(balls, fineness);
        let light = |direction: Point, strength, softness| {
            let (right, up) = across(&direction);
            let axes = [right, up].map(|axis| axis * (0.5 * size as f32));
            Light { direction, strength, softness, axes, centre, map: Map::default() }
        };
        // Brightness rises from the ground to the zenith.
        let mut sky: Vec<Light> = (0..fineness.sky_lights)
            .map(around)
            .map(|direction| light(direction, 0.6 + 0.4 * direction.y, 0.35))
            .collect();
        let total: f32 = sky.iter().map(|light| light.strength * light.direction.y.max(0.0)).sum();
        sky.iter_mut().for_each(|light| light.strength /= total);
        let mut sun: Vec<Light> =
            (0..SUN_LIGHTS).map(|k| light(spread(k), 1.0 / SUN_LIGHTS as f32, SUN_SPREAD)).collect();
        parallel::for_each(team, sky.iter_mut().chain(&mut sun), |light| light.map = light.draw_map(balls, size));
        Self { sky, sun }
    }

    /// Light that reaches a point of a surface with an outward normal. Each sample of a pixel asks its share of the lights,
    /// so that the pixel hears all of them.
    pub fn at(&self, surface: &SurfacePoint, balls: &[Ball], share: usize, shares: usize) -> Received {
        let gather = |lights: &[Light]| {
            let (mut received, mut possible) = (0.0, 0.0);
            for light in lights.iter().skip(share).step_by(shares) {
                let cosine = surface.normal.dot(&light.direction);
                if cosine > 0.0 {
                    let strength = light.strength * cosine * shares as f32;
                    possible += strength;
                    received += strength * light.visibility(&surface.position, surface.body, balls);
                }
            }
            (received, possible)
        };
        let ((sky, possible), (sun, _)) = (gather(&self.sky), gather(&self.sun));
        Received { sky, openness: if possible > 0.0 { sky / possible } else { 1.0 }, sun }
    }

    /// Towards the middle of the sun.
    pub fn sun_direction() -> Point {
        Point::from(SUN).normalize()
    }
}

/// Cells along each side of the maps for some balls.
fn map_size(balls: &[Ball], fineness: Fineness) -> usize {
    let radii = balls.iter().map(|ball| 0.5 * ball.radius).filter(|radius| *radius >= LARGE);
    let covers: f32 = radii.map(|radius| (4.0 * radius * radius).min(1.0)).sum();
    let size = fineness.map_size as f32 * (MOST_COVERS / covers).sqrt().min(1.0);
    trunc_to_usize(size).max(LEAST_MAP_SIZE)
}

/// Successive steps of it spread evenly over a circle [radians].
const GOLDEN_ANGLE: f32 = 2.399_963_2;

/// Two directions that complete one to a frame of reference.
fn across(direction: &Point) -> (Point, Point) {
    let aside = if direction.x.abs() < 0.7 { Point::x() } else { Point::y() };
    let right = direction.cross(&aside).normalize();
    (right, direction.cross(&right))
}

impl Light {
    /// Place in the light's plane, in cells from the centre.
    fn place(&self, point: &Point) -> [f32; 2] {
        let arm = point - self.centre;
        self.axes.map(|axis| arm.dot(&axis))
    }

    /// Draws the balls as the light sees them, into a map of `size` cells along each side.
    fn draw_map(&self, balls: &[Ball], size: usize) -> Map {
        let half = 0.5 * size as f32;
        let discs = (0..NOTHING).zip(balls).filter_map(|(index, ball)| {
            let top = (ball.centre - self.centre).dot(&self.direction) * half;
            Disc::of(index, self.place(&ball.centre), top, ball.radius * half, size)
        });
        Map::of(&discs.collect::<Vec<Disc>>(), size)
    }

    /// How much of the light reaches a point, 0 to 1. Asks the four cells around it, because the sphere that the middle
    /// of one cell sees may let through a ray beside it that another sphere stops.
    fn visibility(&self, point: &Point, own: u32, balls: &[Ball]) -> f32 {
        let Some(cells) = self.map.around(self.place(point)) else { return 1.0 };
        let (mut visibility, mut asked) = (1.0_f32, own);
        for between in cells {
            if between != own && between != asked && visibility > 0.0 {
                visibility = visibility.min(balls.get(between as usize).map_or(1.0, |ball| self.passing(ball, point)));
                asked = between;
            }
        }
        visibility
    }

    /// How much of the light passes a sphere on its way to a point.
    fn passing(&self, ball: &Ball, point: &Point) -> f32 {
        let arm = ball.centre - point;
        let along = arm.dot(&self.direction);
        if along <= 0.0 {
            return 1.0;
        }
        let inside = ball.radius - (arm - self.direction * along).norm();
        1.0 - (inside / (self.softness * along).min(WIDEST_EDGE * ball.radius)).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::colour::Colour;
    use super::*;

    fn balls(count: u8, radius: f32) -> Vec<Ball> {
        let ball = |k: u8| Ball { centre: Point::repeat(f32::from(k) * 1e-3), radius, colour: Colour::zeros() };
        (0..count).map(ball).collect()
    }

    #[test]
    fn balls_as_large_as_the_scene_make_maps_coarse_and_others_do_not() {
        for (count, radius) in [(255, 0.2), (255, 1e-4), (16, 0.6), (8, 1e9), (1, f32::INFINITY)] {
            assert_eq!(map_size(&balls(count, radius), Fineness::PICTURE), MAP_SIZE, "{count}, {radius}");
        }
        for radius in [0.5, 1.0, 30.0, 1e7, f32::INFINITY] {
            let balls = balls(255, radius);
            let lights = Lights::on(&balls, Point::zeros(), Fineness::PICTURE, &Team::whole());
            let compared = |light: &Light| balls.len() * light.map.cells();
            let most = 2.0 * MOST_COVERS * (MAP_SIZE * MAP_SIZE) as f32 / (radius * radius).min(1.0);
            assert!(lights.sky.iter().chain(&lights.sun).all(|light| compared(light) as f32 <= most), "{radius}");
        }
    }
}
