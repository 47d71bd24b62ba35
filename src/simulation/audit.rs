//! The engine's own check of its state.

use super::engine::Engine;
use crate::overlap::Side;
use crate::scene::ParticleId;
use crate::space::minimum_image;

/// A pair, or a particle and a wall, in an invalid state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// The particle.
    pub particle: ParticleId,
    /// Its partner, or none for a wall.
    pub partner: Option<ParticleId>,
    /// How far beyond the discontinuity, relative to the discontinuity's distance.
    pub depth: f64,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// The deepest overlap of all pairs that know each other or are near, and of particles and walls.
    pub(super) fn deepest_overlap(&self) -> Option<Overlap> {
        let mut deepest: Option<Overlap> = None;
        let mut offer = |particle: u32, partner: Option<u32>, depth: f64| {
            if depth > deepest.map_or(0.0, |d| d.depth) {
                deepest = Some(Overlap { particle: ParticleId(particle), partner: partner.map(ParticleId), depth });
            }
        };
        for particle in (0..self.bodies.len() as u32).filter(|&p| !self.is_static(p)) {
            let (position, _) = self.state_at(particle, self.now);
            let distance_to =
                |other: u32| minimum_image(position - self.state_at(other, self.now).0, &self.periods).norm();
            if TABLE {
                for known in self.memory.of(particle) {
                    let distance = distance_to(known.partner);
                    for side in [Side::Positive, Side::Negative] {
                        if let Some(seen) =
                            self.rules.steps[usize::from(known.interaction)].seen_from(known.state, side)
                        {
                            let depth = side.sign() * (seen.distance - distance) / seen.distance;
                            offer(particle, Some(known.partner), depth);
                        }
                    }
                }
            }
            self.cells.for_each_near(self.bodies[particle as usize].cell, |other| {
                let species = |id: u32| self.species[id as usize];
                let meeting = self.rules.meeting(species(particle), species(other));
                if other != particle && meeting.exists && !(TABLE && self.memory.get(particle, other).is_some()) {
                    let range = meeting.squared.sqrt();
                    offer(particle, Some(other), (range - distance_to(other)) / range);
                }
            });
            let radius = self.rules.species[usize::from(self.species[particle as usize])].radius;
            for wall in &self.walls {
                let inwards = if wall.face.is_upper { -1.0 } else { 1.0 };
                let height = inwards * (position[usize::from(wall.face.axis)] - wall.at);
                offer(particle, None, (radius - height) / if radius > 0.0 { radius } else { 1.0 });
            }
        }
        deepest
    }
}
