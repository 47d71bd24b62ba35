//! The audit of the engine: overlaps, and the depth that round-off can explain.

use super::parts::Engine;
use crate::Vector;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::sources::surface::Touching;
use crate::engine::surfaces::Surface;
use crate::model::ParticleId;
use crate::model::space::Boundary;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::Side;

/// A pair, or a particle and a wall, on the wrong side of a discontinuity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// The particle.
    pub particle: ParticleId,
    /// The partner of the particle; `None` for a wall.
    pub partner: Option<ParticleId>,
    /// Depth of the overlap, relative to the distance of the discontinuity. At a wall, it is relative to the radius of
    /// the particle.
    pub depth: f64,
    /// Largest relative depth that round-off can cause.
    pub round_off: f64,
}

impl Overlap {
    /// Returns whether the overlap is deeper than round-off can explain.
    #[must_use]
    pub fn is_real(&self) -> bool {
        self.depth > self.round_off.min(MOST_ROUND_OFF)
    }
}

/// Relative depth above which an overlap is always reported, even if rounding could explain it.
pub(super) const MOST_ROUND_OFF: f64 = 1e-6;

/// Largest rounding error of a pair at an event, in ulp of the coordinates, the squared distance or the time.
///
/// Each operation has an error of at most half an ulp. Streaming a coordinate takes three operations. Wrapping the
/// coordinate, or moving it to a new epoch, takes one. Two more operations choose the nearest image of a pair. All
/// operations happen twice, at the prediction and at the event. With three axes, the error is about 11 ulp of the
/// coordinates: `sqrt(3) (2 (3 + 1) + 2 + 2) / 2`.
///
/// The overlap function and its root contribute about 16 ulp of the squared distance. The time in the queue contributes
/// three ulp of the time.
const ROUNDINGS: f64 = 32.0;

/// Returns true if an overlap is certainly round-off. This quick test avoids the exact bound.
#[inline]
pub(super) fn is_surely_round_off(depth: f64, distance: f64) -> bool {
    depth <= ROUNDINGS * f64::EPSILON * distance
}

/// The unit of overlap depths at a surface: the radius of the particle, or 1 for a point particle.
pub(super) fn unit_of_surface(radius: f64) -> f64 {
    if radius > 0.0 { radius } else { 1.0 }
}

/// A pair at a discontinuity, with the data that determine its round-off.
pub(super) struct Meeting {
    pub pair: [u32; 2],
    /// Relative velocity of the images that meet `[length / time]`.
    pub velocity: Vector,
    /// Time since the state of each particle was last written `[time]`.
    pub flown: [f64; 2],
    /// Distance of the discontinuity `[length]`.
    pub distance: f64,
    /// Speed at which the discontinuity moves outwards `[length / time]`.
    pub opening_speed: f64,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Returns the largest depth beyond a discontinuity that round-off can cause `[length]`.
    ///
    /// The error of a distance at an event is at most [`ROUNDINGS`] times the round-off of these numbers:
    ///
    /// - the largest coordinates since the prediction, see [`Self::largest_coordinate`]. The coordinates at the event
    ///   are not enough: a pair near coordinate 0 may have been predicted across the side of the box, with one particle
    ///   at coordinate `L`;
    /// - in a sheared box, the displacement of images across the sliding sides, before whole periods are subtracted;
    /// - the time in the queue, see [`Self::clock`], multiplied by the relative speed of the images and of the
    ///   discontinuity;
    /// - the overlap function, divided by its slope `2 s`, where `s` is the distance of the discontinuity. Its terms
    ///   are as large as the squared distance at the prediction. This distance is at most `s` plus the path since then,
    ///   which is limited to [`Self::farthest_image`].
    ///
    /// The deepest overlap that was accepted so far is added, because an inelastic pair that hardly moves may keep the
    /// overlap of an earlier event.
    #[cold]
    pub(super) fn round_off_of_pair(&self, meeting: &Meeting) -> f64 {
        let &Meeting { pair: [i, j], ref velocity, flown, distance, opening_speed } = meeting;
        let (older, younger) = (flown[0].max(flown[1]), flown[0].min(flown[1]));
        // A contact is usually predicted at the last event of either particle. The prediction may be older if a state
        // was written without an event: at the end of an epoch, or at a sliding side.
        let is_written = older >= self.clock.now || self.images.are_sliding();
        let since = if is_written { older } else { younger };
        let acceleration = (self.acceleration(i) - self.acceleration(j)).norm();
        let speed = velocity.norm() + acceleration * since + opening_speed.abs();
        let clock = self.clock(older);
        let from = distance + (speed * since).min(self.farthest_image());
        let slid = self.images.farthest_slid(clock + older, &self.state.periods);
        let coordinates = self.largest_coordinate(i, flown[0]) + self.largest_coordinate(j, flown[1]) + slid;
        ROUNDINGS * f64::EPSILON * (coordinates + speed * clock + from * from / distance) + self.counts.accepted_overlap
    }

    /// Returns the largest depth of an overlap with a surface that round-off can cause `[length]`.
    pub(super) fn round_off_of_surface(&self, i: u32, at: &Touching, flown: f64) -> f64 {
        let normal = at.shape.normal(&at.position);
        let speed = normal.dot(&at.velocity).abs() + normal.dot(&self.acceleration(i)).abs() * flown;
        let mut scale = at.shape.terms(&at.position) + speed * (flown + self.clock(flown));
        if let Some(moment) = &at.moment {
            // The position of a moving surface is computed from the simulated time, whose round-off grows during a run.
            let own = moment.velocity_at(&at.place).norm();
            scale += at.place.lp_norm(1) + moment.pose.displacement.lp_norm(1) + own * self.time().abs();
        }
        ROUNDINGS * f64::EPSILON * scale + self.counts.accepted_overlap
    }

    /// Returns an upper bound for the coordinates of a particle since its state was written, `flown` ago.
    ///
    /// Each time the particle crosses the box, its coordinate is wrapped and rounded. [`ROUNDINGS`] counts only a few
    /// wraps, so the bound grows with the number of wraps.
    fn largest_coordinate(&self, i: u32, flown: f64) -> f64 {
        let body = &self.state.bodies[i as usize];
        let path = (body.velocity.norm() + self.acceleration(i).norm() * flown) * flown;
        let wraps = path / self.state.periods.min();
        (body.position.amax() + path + self.state.space.farthest_side()) * (1.0 + wraps / ROUNDINGS)
    }

    /// Returns the largest distance of two images that may collide; infinite if particles can escape from the box.
    fn farthest_image(&self) -> f64 {
        let space = &self.state.space;
        let is_open = (0..3).any(|axis| match space.boundary[axis] {
            Boundary::Periodic | Boundary::Flat => false,
            Boundary::Bounded { .. } => space.walls(axis) < 2,
        });
        if is_open { f64::INFINITY } else { 1.5 * space.size.norm() }
    }

    /// Returns the time of an event, counted from the epoch of its prediction. `flown` is the time since the
    /// prediction.
    fn clock(&self, flown: f64) -> f64 {
        if flown >= self.clock.now { flown + self.clock.last_reached } else { self.clock.now }
    }

    fn flown(&self, particle: u32) -> f64 {
        self.clock.now - self.state.bodies[particle as usize].time
    }

    /// Counts an overlap at an event, unless round-off explains it. Depths above `MOST_ROUND_OFF * unit` always count.
    pub(super) fn note_overlap(&mut self, depth: f64, unit: f64, round_off: f64) {
        if depth > round_off.min(MOST_ROUND_OFF * unit) {
            self.counts.totals.in_invalid_state += 1;
        } else if depth > self.counts.accepted_overlap && depth <= round_off - self.counts.accepted_overlap {
            self.counts.accepted_overlap = depth;
        }
    }

    /// Visits all overlaps with particles and surfaces. A pair of moving particles is visited twice.
    pub(super) fn for_each_overlap(&self, mut found: impl FnMut(Overlap)) {
        let mut near = Candidates::default();
        for particle in self.particles().filter(|&p| !self.is_static(p)) {
            self.overlaps_of_captured(particle, &mut found);
            self.overlaps_of_uncaptured(particle, &mut near, &mut found);
            self.overlaps_with_surfaces(particle, &mut found);
        }
    }

    pub(super) fn deepest_overlap(&self) -> Option<Overlap> {
        let mut deepest: Option<Overlap> = None;
        self.for_each_overlap(|overlap| {
            if deepest.is_none_or(|d| overlap.depth > d.depth) {
                deepest = Some(overlap);
            }
        });
        deepest
    }

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

    fn apart(&self, i: u32, j: u32) -> RelativeState {
        let [(ri, vi), (rj, vj)] = [i, j].map(|particle| self.state_at(particle, self.clock.now));
        self.nearest(ri - rj, vi - vj, self.clock.now).0
    }

    fn overlaps_of_captured(&self, particle: u32, found: &mut impl FnMut(Overlap)) {
        if !TABLE {
            return;
        }
        for captured in self.pairs.states.of(particle) {
            let apart = self.apart(particle, captured.partner);
            let distance = apart.position.norm();
            for side in [Side::Positive, Side::Negative] {
                let steps = &self.pairs.rules.steps[usize::from(captured.interaction)];
                if let Some(seen) = steps.seen_from(captured.state, side) {
                    let pair = [particle, captured.partner];
                    let of_pair = self.distance_of_pair(seen.distance, pair);
                    self.offer_pair(pair, &apart, side.sign() * (of_pair - distance), of_pair, found);
                }
            }
        }
    }

    fn overlaps_of_uncaptured(&self, particle: u32, near: &mut Candidates, found: &mut impl FnMut(Overlap)) {
        self.neighbours.find_candidates(particle, self.row(particle), near);
        if !self.images.are_sliding() {
            self.overlaps_with(particle, near.found(), found);
            return;
        }
        let mut others = near.found().to_vec();
        self.for_each_across(particle, |other| others.push(other));
        // In a sheared box, a particle may be found twice.
        others.sort_unstable();
        others.dedup();
        self.overlaps_with(particle, &others, found);
    }

    fn overlaps_with(&self, particle: u32, others: &[u32], found: &mut impl FnMut(Overlap)) {
        let now = self.clock.now;
        let (position, velocity) = self.state_at(particle, now);
        let row = self.row(particle);
        for &other in others.iter().filter(|&&other| other != particle) {
            let meeting = self.pairs.rules.meeting(row, self.row(other));
            if !meeting.exists {
                continue;
            }
            let (there, faster) = self.state_at(other, now);
            let (apart, _) = self.nearest(position - there, velocity - faster, now);
            let range = self.distances.at(self.distance_of_pair(meeting.squared.sqrt(), [particle, other]), now)[0];
            // Most candidates are far outside their contact distance.
            if apart.position.norm_squared() > range * range * (1.0 + 1e-12)
                || TABLE && self.pairs.states.get(particle, other).is_some()
            {
                continue;
            }
            self.offer_pair([particle, other], &apart, range - apart.position.norm(), range, found);
        }
    }

    fn offer_pair(
        &self,
        pair: [u32; 2],
        apart: &RelativeState,
        depth: f64,
        distance: f64,
        found: &mut impl FnMut(Overlap),
    ) {
        if depth > 0.0 {
            let opening_speed = self.distances.speed_of(distance / self.scale());
            let flown = pair.map(|particle| self.flown(particle));
            let round_off =
                self.round_off_of_pair(&Meeting { pair, velocity: apart.velocity, flown, distance, opening_speed });
            let [particle, partner] = pair.map(|particle| self.id(particle));
            let (depth, round_off) = (depth / distance, round_off / distance);
            found(Overlap { particle, partner: Some(partner), depth, round_off });
        }
    }

    fn overlaps_with_surfaces(&self, particle: u32, found: &mut impl FnMut(Overlap)) {
        let (position, _) = self.state_at(particle, self.clock.now);
        let radius = self.radius(particle);
        let unit = unit_of_surface(radius);
        let row = self.row(particle);
        self.sources.surfaces.for_each_near((&position, radius), row, self.time(), |surface, position| {
            let depth = -surface.shape.gap(position, radius);
            if depth > 0.0 {
                let at = self.touching(particle, surface, self.clock.now);
                let round_off = self.round_off_of_surface(particle, &at, self.flown(particle));
                let particle = self.id(particle);
                found(Overlap { particle, partner: None, depth: depth / unit, round_off: round_off / unit });
            }
        });
    }
}

#[cfg(test)]
mod drops;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_overlap_of_more_than_a_millionth_is_round_off() {
        let overlap = |depth, round_off| Overlap { particle: ParticleId(0), partner: None, depth, round_off };
        assert!(!overlap(1e-13, 1e-12).is_real());
        assert!(!overlap(0.9e-6, 0.15).is_real());
        assert!(overlap(1.1e-6, 0.15).is_real(), "real, even in a box of 1e14, where the round-off is larger");
        assert!(overlap(1e-12, 1e-13).is_real());
    }
}
