//! Shadows on the ground.

use super::Style;
use super::bodies::Bodies;
use super::camera::{Camera, NEAREST, Point};
use super::light::GroundLights;
use crate::Vector;
use crate::base::numbers::single;
use crate::trajectory::Frame;
use crate::view::Surfaces;

/// Fraction of the ground's light from the sun and from the sky. The remaining light casts no shadows.
const SUN: f32 = 0.4;
const SKY: f32 = 0.3;

/// Opacity of translucent spheres in shadows, divided by the opacity in the image.
const VEIL: f32 = 1.2;

/// The opacity of a shadow decreases with height by two factors: one is 1/2 at `HALF_HEIGHT`, the other is 0 at
/// `MOST_HEIGHT`. With constant opacity, high spheres would darken the whole ground.
const HALF_HEIGHT: f32 = 0.28;
const MOST_HEIGHT: f32 = 0.7;

#[derive(Debug)]
pub(super) struct Ground {
    normal: Point,
    offset: f32,
    lights: GroundLights,
}

impl Ground {
    /// Returns the ground below a frame. There is no ground in flat scenes, without gravity, or if gravity is along a
    /// periodic axis.
    pub fn of(frame: &Frame, surfaces: &Surfaces, style: &Style, camera: &Camera, bodies: &Bodies) -> Option<Self> {
        let level = level(frame, surfaces, style)?;
        let normal = camera.up();
        let offset = normal.dot(&camera.place(&level));
        let veil = (VEIL * single(style.static_opacity)).min(1.0);
        let all = bodies.balls.iter().map(|ball| (ball, 1.0)).chain(bodies.veil.iter().map(|ball| (ball, veil)));
        let near = all.filter_map(|(ball, opacity)| {
            let height = (normal.dot(&ball.centre) - offset - ball.radius).max(0.0);
            let (part, rest) = (height / HALF_HEIGHT, 1.0 - height / MOST_HEIGHT);
            (rest > 0.0).then(|| (*ball, opacity * rest / (1.0 + part * part)))
        });
        let lights = GroundLights::on(&near.collect::<Vec<_>>(), camera);
        Some(Self { normal, offset, lights })
    }

    pub fn depth(&self, (origin, direction): (Point, Point)) -> Option<f32> {
        let slope = self.normal.dot(&direction);
        let depth = (self.offset - self.normal.dot(&origin)) / slope;
        (slope < 0.0 && depth > NEAREST && depth.is_finite()).then_some(depth)
    }

    /// Returns the brightness of the ground relative to a point without shadow.
    pub fn brightness(&self, point: &Point) -> f32 {
        let [sun, sky] = self.lights.at(point);
        1.0 - SUN * (1.0 - sun) - SKY * (1.0 - sky)
    }
}

/// Returns a point of the ground: the lowest corner of the box, or otherwise the lowest point of particles and
/// surfaces.
fn level(frame: &Frame, surfaces: &Surfaces, style: &Style) -> Option<Vector> {
    let up = -style.gravity.filter(|_| style.has_ground)?.try_normalize(0.0)?;
    let axis = up.iamax();
    let is_flat = (0..3).any(|k| frame.is_flat(k)) && frame.size.iter().any(|edge| *edge > 0.0);
    if is_flat || frame.periodic[axis] {
        return None;
    }
    let lowest = |points: &mut dyn Iterator<Item = Vector>| {
        points.min_by(|a, b| a.dot(&up).total_cmp(&b.dot(&up))).filter(|point| point.iter().all(|x| x.is_finite()))
    };
    if frame.size[axis] > 0.0 {
        return lowest(&mut super::corners(&frame.lower, &frame.size).into_iter());
    }
    let particles = frame.particles.iter().map(|particle| particle.position - up * particle.radius);
    lowest(&mut particles.chain(surfaces.skins.iter().flat_map(|skin| skin.bounds)))
}
