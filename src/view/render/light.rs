//! Light at a point from the sky and the sun.
//!
//! The sun is a disc, so shadows have soft edges. A sphere blocks the fraction of sunlight that equals the covered
//! fraction of the disc. Nearby spheres and overhead objects dim the light from the sky.

use super::bodies::Ball;
use super::camera::{Camera, Point};
use super::lists::{Lists, numbered};
use super::raster::NOTHING;
use crate::base::numbers::single;

/// Tangents of half the angular widths of the sun and of the overhead sky.
const SUN_WIDTH: f32 = 0.16;
const ZENITH_WIDTH: f32 = 0.75;

/// Largest half-width of a shadow's soft edge, relative to the radius of the sphere.
const WIDEST_EDGE: f32 = 1.3;

/// A sphere dims the sky at distances from its centre of up to `REACH` times its radius. Beyond `FADE` times its
/// radius, the dimming decreases to zero.
const REACH: f32 = 3.2;
const FADE: f32 = 2.0;

/// Brightness of the sky on a vertical surface, and the additional brightness on a surface that faces up.
const LEVEL: f32 = 0.68;
const SLOPE: f32 = 0.32;

/// Largest fraction of the light from the sky that overhead objects can block.
const ZENITH_SHARE: f32 = 0.5;

/// Smaller fractions of light are treated as zero.
const DARK: f32 = 0.004;

/// Cell widths of the grids, relative to the mean radius of the spheres.
const SHADOW_CELL: f32 = 0.7;
const NEAR_CELL: f32 = 1.6;

pub(super) struct SurfacePoint {
    pub position: Point,
    pub normal: Point,
    /// Index of the body at the point. A sphere casts no shadow on itself.
    pub body: u32,
}

/// Light at a point. In the open, `sky` is 1 on a surface that faces up, and `sun` on a surface that faces the sun.
#[derive(Debug, Clone, Copy)]
pub(super) struct Received {
    pub sky: f32,
    /// Visible fraction of the sky.
    pub openness: f32,
    pub sun: f32,
}

#[derive(Debug)]
pub(super) struct Lights {
    up: Point,
    pub sun_direction: Point,
    sun: Shadows,
    zenith: Shadows,
    near: Near,
}

impl Lights {
    /// Spheres outside the grid around the framed region cast no shadow.
    pub fn on(balls: &[Ball], camera: &Camera) -> Self {
        let (up, sun_direction) = (camera.up(), camera.sun());
        let occluders: Vec<(Ball, f32)> = balls.iter().map(|ball| (*ball, 1.0)).collect();
        Self {
            up,
            sun_direction,
            sun: Shadows::of(&occluders, sun_direction, SUN_WIDTH, camera),
            zenith: Shadows::of(&occluders, up, ZENITH_WIDTH, camera),
            near: Near::of(balls, camera.offset),
        }
    }

    pub fn in_the_open(&self, normal: &Point) -> Received {
        let sky = LEVEL + SLOPE * normal.dot(&self.up);
        Received { sky, openness: 1.0, sun: normal.dot(&self.sun_direction).max(0.0) }
    }

    pub fn at(&self, surface: &SurfacePoint) -> Received {
        let SurfacePoint { position, normal, body } = surface;
        let above = normal.dot(&self.up);
        let cosine = normal.dot(&self.sun_direction);
        let sun = if cosine > 0.0 { cosine * self.sun.passing(position, *body) } else { 0.0 };
        let near = self.near.openness(position, normal, *body, &self.up);
        let share = ZENITH_SHARE * (0.5 + 0.5 * above);
        let openness = near * (1.0 - share * (1.0 - self.zenith.passing(position, *body)));
        Received { sky: (LEVEL + SLOPE * above) * openness, openness, sun }
    }
}

/// Light on the ground. Translucent spheres cast lighter shadows.
#[derive(Debug)]
pub(super) struct GroundLights {
    sun: Shadows,
    zenith: Shadows,
}

impl GroundLights {
    pub fn on(occluders: &[(Ball, f32)], camera: &Camera) -> Self {
        Self {
            sun: Shadows::of(occluders, camera.sun(), SUN_WIDTH, camera),
            zenith: Shadows::of(occluders, camera.up(), ZENITH_WIDTH, camera),
        }
    }

    /// Returns the fractions of sunlight and of light from the sky at a point.
    pub fn at(&self, point: &Point) -> [f32; 2] {
        [self.sun.passing(point, NOTHING), self.zenith.passing(point, NOTHING)]
    }
}

/// A sphere projected along the direction to a light.
#[derive(Debug, Clone, Copy)]
struct Disc {
    place: [f32; 2],
    /// Coordinate of the centre along the direction to the light.
    height: f32,
    radius: f32,
    opacity: f32,
}

#[derive(Debug)]
struct Shadows {
    /// Directions right, up and towards the light.
    axes: [Point; 3],
    centre: Point,
    /// Tangent of half the angular width of the light.
    width: f32,
    /// Half-width of the sharpest shadow edge: half a pixel.
    narrowest: f32,
    discs: Vec<Disc>,
    /// Spheres by their position normal to the light. Spheres nearest to the light come first.
    lists: Lists<2>,
}

impl Shadows {
    fn of(occluders: &[(Ball, f32)], direction: Point, width: f32, camera: &Camera) -> Self {
        let aside = if direction.x.abs() < 0.7 { Point::x() } else { Point::y() };
        let right = direction.cross(&aside).normalize();
        let axes = [right, direction.cross(&right), direction];
        let centre = camera.offset;
        let disc = |(ball, opacity): &(Ball, f32)| {
            let [x, y, height] = axes.map(|axis| (ball.centre - centre).dot(&axis));
            Disc { place: [x, y], height, radius: ball.radius, opacity: *opacity }
        };
        let discs: Vec<Disc> = occluders.iter().map(disc).collect();
        let mut order: Vec<(u32, &Disc)> = numbered(&discs).collect();
        order.sort_by(|(_, a), (_, b)| (b.height + b.radius).total_cmp(&(a.height + a.radius)));
        let reach = |disc: &Disc| {
            let reach = disc.radius * (1.0 + WIDEST_EDGE);
            disc.place.map(|x| [x - reach, x + reach])
        };
        let reaches: Vec<_> = order.into_iter().map(|(number, disc)| (number, reach(disc))).collect();
        let lists = Lists::of(&reaches, SHADOW_CELL * mean_radius(occluders.iter().map(|(ball, _)| ball)));
        let narrowest = single(0.5 / camera.pixels_per_unit());
        Self { axes, centre, width, narrowest, discs, lists }
    }

    /// Returns the fraction of the light that reaches a point of a body.
    fn passing(&self, point: &Point, own: u32) -> f32 {
        let arm = point - self.centre;
        let [x, y, height] = self.axes.map(|axis| arm.dot(&axis));
        let mut left = 1.0_f32;
        for number in self.lists.at([x, y]) {
            let Some(disc) = self.discs.get(*number as usize) else { continue };
            if disc.height + disc.radius <= height {
                break;
            }
            let along = disc.height - height;
            if along <= 0.0 || *number == own {
                continue;
            }
            let edge = (self.width * along).min(WIDEST_EDGE * disc.radius).max(self.narrowest);
            let (dx, dy) = (x - disc.place[0], y - disc.place[1]);
            let (square, rim) = (dx * dx + dy * dy, disc.radius + edge);
            if square < rim * rim {
                let part = ((rim - square.sqrt()) / (2.0 * edge)).min(1.0);
                let smooth = part * part * (3.0 - 2.0 * part);
                // A sphere that looks smaller than the light covers only a part of the light.
                let most = (disc.radius / edge).min(1.0);
                left *= 1.0 - disc.opacity * smooth * most * most;
                if left < DARK {
                    return 0.0;
                }
            }
        }
        left
    }
}

#[derive(Debug)]
struct Near {
    centre: Point,
    balls: Vec<(Point, f32)>,
    lists: Lists<3>,
}

impl Near {
    fn of(balls: &[Ball], centre: Point) -> Self {
        let reach = |ball: &Ball| {
            let arm = ball.centre - centre;
            [arm.x, arm.y, arm.z].map(|x| [x - REACH * ball.radius, x + REACH * ball.radius])
        };
        let reaches: Vec<_> = numbered(balls).map(|(number, ball)| (number, reach(ball))).collect();
        let lists = Lists::of(&reaches, NEAR_CELL * mean_radius(balls.iter()));
        Self { centre, balls: balls.iter().map(|ball| (ball.centre, ball.radius)).collect(), lists }
    }

    fn openness(&self, point: &Point, normal: &Point, own: u32, up: &Point) -> f32 {
        let arm = point - self.centre;
        let mut left = 1.0_f32;
        for number in self.lists.at([arm.x, arm.y, arm.z]) {
            let Some((centre, radius)) = self.balls.get(*number as usize).filter(|_| *number != own) else { continue };
            let arm = centre - point;
            let along = normal.dot(&arm);
            if along <= -radius {
                continue;
            }
            let (square, area) = (arm.norm_squared(), radius * radius);
            if square >= REACH * REACH * area {
                continue;
            }
            let inverse = 1.0 / square.max(0.25 * area).sqrt();
            let (cosine, form) = (along * inverse, area * inverse * inverse);
            let hidden = if along < *radius {
                let above = (0.5 * (along / radius + 1.0)).clamp(0.0, 1.0);
                form * above * above.sqrt()
            } else {
                form * cosine
            };
            let fade = ((REACH * REACH - square / area) / (REACH * REACH - FADE * FADE)).min(1.0);
            let brightness = LEVEL + SLOPE * up.dot(&arm) * inverse;
            left *= 1.0 - (hidden * fade * brightness).min(0.95);
        }
        left
    }
}

fn mean_radius<'b>(balls: impl Iterator<Item = &'b Ball>) -> f32 {
    let (mut sum, mut count) = (0.0_f32, 0.0_f32);
    for radius in balls.map(|ball| ball.radius).filter(|radius| radius.is_finite()) {
        (sum, count) = (sum + radius, count + 1.0);
    }
    if count > 0.0 { sum / count } else { 1.0 }
}
