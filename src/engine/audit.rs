//! The engine's own check of its state: overlaps, and how much of them is round-off.

use super::parts::Engine;
use crate::Vector;
use crate::engine::neighbours::candidates::Candidates;
use crate::model::ParticleId;
use crate::physics::overlap::Side;

/// A pair, or a particle and a wall, in an invalid state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// The particle.
    pub particle: ParticleId,
    /// Its partner, or none for a wall.
    pub partner: Option<ParticleId>,
    /// How far beyond the discontinuity, relative to the discontinuity's distance.
    pub depth: f64,
    /// How much of that round-off explains.
    pub round_off: f64,
}

impl Overlap {
    /// Whether it is deeper than round-off explains.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.depth > self.round_off.min(MOST_ROUND_OFF)
    }
}

/// An overlap of more than a millionth of the distance is never sound, though coordinates or speeds may be so large that rounding
/// explains it.
pub(super) const MOST_ROUND_OFF: f64 = 1e-6;

/// How many roundings the position of a pair at its event carries: of its six coordinates in two streamings, the minimum image,
/// the three terms of each coefficient of the overlap function, the discriminant and the quotient that give the time, and the
/// sum that makes it a time of the queue, all below one unit in the last place of what they round.
const ROUNDINGS: f64 = 32.0;

/// What depths at a wall are compared with: a point particle has no length of its own.
pub(super) fn unit_of_wall(radius: f64) -> f64 {
    if radius > 0.0 { radius } else { 1.0 }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// How far rounding can put two particles beyond a discontinuity of theirs, that they were predicted to meet after moving
    /// by `path` relative to each other `[length]`, `flown` ago `[time]`.
    ///
    /// Three sources: the coordinates; the queue's time, at the relative speed; and the overlap function, whose terms are as
    /// large as the squared distance from which the pair came, over its slope in space, `2 s`.
    pub(super) fn round_off_of_pair(&self, i: u32, j: u32, distance: f64, path: f64, flown: f64) -> f64 {
        let (a, b) = (&self.state.bodies[i as usize], &self.state.bodies[j as usize]);
        let speed = (a.velocity - b.velocity).norm();
        let from = distance + path;
        let scale = a.position.amax() + b.position.amax() + speed * self.clock(flown) + from * from / distance;
        ROUNDINGS * f64::EPSILON * scale
    }

    /// The same for a wall at coordinate `at`, whose overlap function is a length.
    pub(super) fn round_off_of_wall(&self, i: u32, axis: usize, at: f64, path: f64, flown: f64) -> f64 {
        let body = &self.state.bodies[i as usize];
        let scale = body.position[axis].abs() + at.abs() + body.velocity[axis].abs() * self.clock(flown) + path;
        ROUNDINGS * f64::EPSILON * scale
    }

    /// The size of a time of the queue that was predicted `flown` ago: since the epoch, or since the one before if that was when.
    fn clock(&self, flown: f64) -> f64 {
        if flown > self.clock.now { flown + self.clock.last_reached } else { self.clock.now }
    }

    /// How long ago the state of a particle was last rounded.
    fn flown(&self, particle: u32) -> f64 {
        self.clock.now - self.state.bodies[particle as usize].time
    }

    /// All overlaps of captured pairs and of neighbours, and of particles and walls; pairs of moving particles twice.
    pub(super) fn for_each_overlap(&self, mut found: impl FnMut(Overlap)) {
        for particle in self.particles().filter(|&p| !self.is_static(p)) {
            self.overlaps_of_captured(particle, &mut found);
            self.overlaps_of_uncaptured(particle, &mut found);
            self.overlaps_with_walls(particle, &mut found);
        }
    }

    /// The deepest overlap.
    pub(super) fn deepest_overlap(&self) -> Option<Overlap> {
        let mut deepest: Option<Overlap> = None;
        self.for_each_overlap(|overlap| {
            if deepest.is_none_or(|d| overlap.depth > d.depth) {
                deepest = Some(overlap);
            }
        });
        deepest
    }

    /// The overlaps deeper than round-off, each once.
    pub(super) fn real_overlaps(&self) -> Vec<Overlap> {
        let mut real = Vec::new();
        self.for_each_overlap(|overlap| {
            let is_first = overlap.partner.is_none_or(|p| overlap.particle < p || self.is_static(self.number(p)));
            if is_first && overlap.is_real() {
                real.push(overlap);
            }
        });
        real
    }

    fn distance(&self, i: u32, j: u32) -> f64 {
        let apart = self.state_at(i, self.clock.now).0 - self.state_at(j, self.clock.now).0;
        self.nearest(apart, Vector::zeros(), self.clock.now).0.position.norm()
    }

    fn overlaps_of_captured(&self, particle: u32, found: &mut impl FnMut(Overlap)) {
        if !TABLE {
            return;
        }
        for captured in self.pairs.states.of(particle) {
            let distance = self.distance(particle, captured.partner);
            for side in [Side::Positive, Side::Negative] {
                let steps = &self.pairs.rules.steps[usize::from(captured.interaction)];
                if let Some(seen) = steps.seen_from(captured.state, side) {
                    let depth = side.sign() * (seen.distance - distance);
                    self.offer_pair(particle, captured.partner, depth, seen.distance, found);
                }
            }
        }
    }

    fn overlaps_of_uncaptured(&self, particle: u32, found: &mut impl FnMut(Overlap)) {
        let species = |id: u32| self.row(id);
        let mut near = Candidates::default();
        self.neighbours.find_candidates(particle, &mut near);
        let mut others = near.found().to_vec();
        if self.sources.lees_edwards.is_some() {
            self.for_each_across(particle, |other| others.push(other));
            // Some are near in both ways.
            others.sort_unstable();
            others.dedup();
        }
        for other in others {
            let meeting = self.pairs.rules.meeting(species(particle), species(other));
            if other != particle && meeting.exists && !(TABLE && self.pairs.states.get(particle, other).is_some()) {
                let range = meeting.squared.sqrt() * self.scale();
                self.offer_pair(particle, other, range - self.distance(particle, other), range, found);
            }
        }
    }

    fn offer_pair(&self, i: u32, j: u32, depth: f64, distance: f64, found: &mut impl FnMut(Overlap)) {
        if depth > 0.0 {
            // What has overlapped since the last event came from no further than the discontinuity itself.
            let round_off = self.round_off_of_pair(i, j, distance, distance, self.flown(i).min(self.flown(j)));
            let (particle, partner) = (self.name(i), Some(self.name(j)));
            found(Overlap { particle, partner, depth: depth / distance, round_off: round_off / distance });
        }
    }

    fn overlaps_with_walls(&self, particle: u32, found: &mut impl FnMut(Overlap)) {
        let (position, _) = self.state_at(particle, self.clock.now);
        let radius = self.pairs.rules.species[usize::from(self.row(particle))].radius;
        let unit = unit_of_wall(radius);
        for wall in &self.sources.walls {
            let axis = usize::from(wall.face.axis);
            let inwards = wall.face.inwards();
            let depth = radius - inwards * (position[axis] - wall.at);
            if depth > 0.0 {
                let round_off = self.round_off_of_wall(particle, axis, wall.at, radius, self.flown(particle));
                let particle = self.name(particle);
                found(Overlap { particle, partner: None, depth: depth / unit, round_off: round_off / unit });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_overlap_of_more_than_a_millionth_is_round_off() {
        let overlap = |depth, round_off| Overlap { particle: ParticleId(0), partner: None, depth, round_off };
        assert!(!overlap(1e-13, 1e-12).is_real());
        assert!(!overlap(0.9e-6, 0.15).is_real());
        assert!(overlap(1.1e-6, 0.15).is_real(), "in a box of 1e14, where rounding explains anything");
        assert!(overlap(1e-12, 1e-13).is_real());
    }
}
