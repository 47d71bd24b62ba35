//! Bodies to draw, in camera space.

use std::collections::{HashMap, HashSet};

use super::Style;
use super::camera::{Camera, Point};
use super::colour::{self, Colour};
use super::sheets::Sheets;
use crate::base::numbers::single;
use crate::model::ParticleId;
use crate::trajectory::Frame;
use crate::trajectory::frame::FrameParticle;

/// Radius of a bond, relative to its smaller particle.
pub(in crate::view) const BOND_RADIUS: f64 = 0.36;

#[derive(Debug, Clone, Copy)]
pub(super) struct Ball {
    pub centre: Point,
    pub radius: f32,
    pub colour: Colour,
}

/// A cylinder that shows half of a bond.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rod {
    pub start: Point,
    pub end: Point,
    pub radius: f32,
    pub colour: Colour,
}

#[derive(Debug, Clone, Default)]
pub(super) struct Bodies {
    pub balls: Vec<Ball>,
    pub veil: Vec<Ball>,
    pub rods: Vec<Rod>,
    pub sheets: Sheets,
}

impl Bodies {
    /// `numbers` are the numbers of the particles that colours show, on a scale from 0 to `top`.
    pub fn of((frame, numbers): (&Frame, &[f64]), style: &Style, camera: &Camera, top: f64) -> Self {
        let colours = species_colours(frame, style);
        let mut bodies = Self::default();
        let colour_of = |particle: &FrameParticle, number: f64| {
            if style.colour_by.has_scale() && !frame.is_static(particle) {
                return colour::viridis(single(number / top));
            }
            colours.get(particle.species.0 as usize).copied().unwrap_or_else(|| colour::linear(colour::STATIC))
        };
        let by_id: HashMap<_, _> = if frame.bonds.is_empty() {
            HashMap::new()
        } else {
            frame.particles.iter().map(|particle| (particle.id, particle)).collect()
        };
        let mut holds_bond: HashSet<ParticleId> = HashSet::new();
        for ends in &frame.bonds {
            let (Some(a), Some(b)) = (by_id.get(&ends[0]), by_id.get(&ends[1])) else { continue };
            holds_bond.extend(ends);
            let radius = camera.length(BOND_RADIUS * a.radius.min(b.radius));
            let separation = b.position - a.position;
            let half = 0.5 * frame.nearest_image(separation);
            let is_through_side = 2.0 * half != separation;
            for (end, half) in [(a, half), (b, -half)] {
                let (start, end) = (camera.place(&end.position), camera.place(&(end.position + half)));
                let colour = colour::linear(colour::STATIC);
                bodies.rods.push(Rod { start, end, radius, colour });
                if is_through_side {
                    bodies.balls.push(Ball { centre: end, radius, colour });
                }
            }
        }
        for (particle, number) in frame.particles.iter().zip(numbers) {
            let ball = Ball {
                centre: camera.place(&particle.position),
                radius: camera.length(particle.radius),
                colour: colour_of(particle, *number),
            };
            // A static particle with a bond is a pivot. It stays visible among translucent particles.
            let is_veil = style.static_opacity < 1.0 && frame.is_static(particle) && !holds_bond.contains(&particle.id);
            if is_veil { &mut bodies.veil } else { &mut bodies.balls }.push(ball);
        }
        bodies
    }
}

/// Moving species have the colours of the palette, and static species a pale colour.
fn species_colours(frame: &Frame, style: &Style) -> Vec<Colour> {
    let mut palette = style.palette.iter().cycle();
    let colour = |is_static: bool| match is_static {
        true => Some(colour::STATIC),
        false => palette.next().copied(),
    };
    let colours = frame.species.iter().map(|species| species.is_static).map(colour);
    colours.map(|colour| colour::linear(colour.unwrap_or(colour::STATIC))).collect()
}
