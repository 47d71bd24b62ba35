//! Facets: the features of surfaces and the periodic images of these features.

use super::approach::{Approach, Boundary};
use super::contact::Contact;
use super::foot::Foot;
use super::moving::Beside;
use super::rules::Side;
use super::swing::Swing;
use super::window::{MARGIN, reach_along};
use super::world::World;
use crate::Vector;
use crate::check::reference::{Across, Barrier, Feature, Motion, Passage, features};
use crate::engine::States;
use crate::model::space::Space;
use crate::model::surface_motion::Piece;
use crate::model::{ParticleId, Scene};
use std::sync::Arc;

/// Relative rounding error when distant features are skipped.
const ROUNDING: f64 = MARGIN - 1.0;
/// At larger distances from a feature, in particle radii, round-off cannot explain a gap.
const NEAR: f64 = 1.001;

/// A feature of a surface (a point, a line or a plane), or one of its periodic images.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    pub feature: Feature,
    pub surface: u32,
    bounds: [Vector; 2],
    pub farthest: f64,
    slenderness: f64,
}

pub(super) fn facets(scene: &Scene, periods: &Vector) -> Vec<Facet> {
    let diameters = scene.diameters_of_species();
    let radius = 0.5 * diameters.iter().map(|range| range.largest).fold(0.0, f64::max);
    let all = features(&scene.surfaces).into_iter();
    all.flat_map(|feature| images(feature, &scene.space, periods, radius)).map(Facet::of).collect()
}

/// Returns a feature and its images that particles may touch within a window. A particle is at most half a period
/// outside the box, and travels at most one period within a window.
fn images(feature: Feature, space: &Space, periods: &Vector, radius: f64) -> Vec<Feature> {
    let mut images = vec![feature];
    for axis in (0..3).filter(|&k| periods[k] > 0.0) {
        let [start, end] = feature.bounds().map(|corner| corner[axis]);
        if !(start.is_finite() && end.is_finite()) {
            continue;
        }
        let (period, lower) = (periods[axis], space.lower[axis]);
        let first = ((lower - 1.5 * period - radius - end) / period).floor();
        let last = ((lower + 2.5 * period + radius - start) / period).ceil();
        let numbers: Vec<f64> =
            std::iter::successors(Some(first), |n| Some(n + 1.0)).take_while(|n| *n <= last).collect();
        let moved = |image: Feature| {
            numbers.iter().map(move |n| {
                let mut by = Vector::zeros();
                by[axis] = n * period;
                image.moved(&by)
            })
        };
        images = images.into_iter().flat_map(moved).collect();
    }
    images
}

impl Facet {
    fn of(feature: Feature) -> Self {
        let (farthest, slenderness) = (feature.farthest(), feature.slenderness());
        // An index that is too large becomes `u32::MAX`, which is not the index of any surface.
        let surface = u32::try_from(feature.surface).unwrap_or(u32::MAX);
        Self { feature, surface, bounds: feature.bounds(), farthest, slenderness }
    }

    pub fn contact(&self, i: u32) -> Contact {
        Contact::Surface { particle: ParticleId(i), surface: self.surface }
    }

    pub fn reaches(&self, [lower, upper]: &[Vector; 2]) -> bool {
        let [start, end] = &self.bounds;
        (0..3).all(|k| start[k] <= upper[k] && lower[k] <= end[k])
    }

    /// Returns true if a sphere may touch the facet. The motion of the sphere is relative to the surface.
    pub fn is_near(&self, Motion { position, radius, .. }: &Motion, beside: &Beside<'_>) -> bool {
        let rounding = ROUNDING * (position.amax() + self.farthest + beside.sway.length);
        let around = Vector::repeat(radius * NEAR + rounding);
        self.reaches(&[position - around, position + around])
    }

    pub fn is_endless(&self, axis: usize) -> bool {
        self.bounds[0][axis] == f64::NEG_INFINITY
    }

    /// Returns the flight of a particle towards the facet, from the time `since` in the window.
    pub fn approach(&self, world: &World, states: &States, i: u32, since: f64) -> Approach {
        let (motion, now) = (world.motion(states, i), world.motions.now(&states.elapsed));
        self.approach_in(world.motions.piece(self.surface, &states.elapsed), &motion, now, since)
    }

    /// Like [`Self::approach`], for the current piece of the surface's motions; `None` if the surface never moves.
    /// `now` is the simulated time at `since`.
    pub fn approach_in(&self, piece: Option<&Piece>, motion: &Motion, now: f64, since: f64) -> Approach {
        let slenderness = self.slenderness;
        let Some(piece) = piece else { return approach_of(&self.feature, slenderness, motion, since) };
        if piece.kind.is_none_or(|kind| kind.is_polynomial()) {
            return approach_of(&self.feature, slenderness, &motion.seen(piece, now), since);
        }
        let passage = Passage { feature: self.feature, motion: *motion, piece: *piece, now };
        Arc::new(Swing::new(passage, slenderness, since)).at(since)
    }

    /// Returns true if a particle provably never reaches the facet, provided that the surface never changes its current
    /// motion. `seen` is the particle's motion relative to the surface. The rounded coordinates have an additional
    /// magnitude `size`, which is 0 for a surface at rest `[length]`.
    pub fn is_clear(&self, seen: &Motion, size: f64) -> bool {
        let Motion { position, velocity, acceleration, radius } = *seen;
        let size = size + position.norm() + self.farthest + radius;
        let across = approach_of(&self.feature, self.slenderness, seen, 0.0);
        if across.is_clear(size) {
            return true;
        }
        if across.foot.is_none() {
            return false;
        }
        // A particle behind the face cannot reach the face if it never touches the plane from behind.
        let height = across.position.x + radius;
        if across.boundary == Boundary::Plane && height < 0.0 {
            let along = |length: f64| Vector::new(length, 0.0, 0.0);
            let behind = Approach {
                position: along(-height - radius),
                velocity: -across.velocity,
                acceleration: -across.acceleration,
                ..across.clone()
            };
            if behind.is_clear(size) {
                return true;
            }
        }
        // A bounded feature fits into a sphere around the centre of its bounding box.
        let [start, end] = self.bounds;
        let distance = 0.5 * (end - start).norm() + radius;
        let boundary = Boundary::Sphere { distance, side: Side::Positive };
        let position = position - 0.5 * (start + end);
        Approach { since: 0.0, position, velocity, acceleration, boundary, foot: None, swing: None }.is_clear(size)
    }
}

/// Returns the flight towards a feature relative to the surface, from the time `since` in the window.
pub(super) fn approach_of(feature: &Feature, slenderness: f64, motion: &Motion, since: f64) -> Approach {
    let Across { position, velocity, acceleration, barrier } = feature.across(motion);
    let boundary = match barrier {
        Barrier::Round { distance, side } => {
            let side = if side.sign() > 0.0 { Side::Positive } else { Side::Negative };
            Boundary::Sphere { distance, side }
        }
        Barrier::Flat => Boundary::Plane,
    };
    let foot = feature.extents(motion).map(|extents| Foot { extents, slenderness });
    Approach { since, position, velocity, acceleration, boundary, foot, swing: None }
}

impl World {
    /// Returns the motion of a particle. Facets have images only near the box, so the particle is moved into the box.
    pub fn motion(&self, states: &States, i: u32) -> Motion {
        let at = i as usize;
        let (position, velocity) = (self.brought_back(states.positions[at]), states.velocities[at]);
        Motion { position, velocity, acceleration: self.accelerations[at], radius: self.radius(i) }
    }

    /// Returns the facets that a particle may reach within `time`, except for surfaces that ignore the particle.
    pub fn facets_near<'a>(&'a self, states: &States, i: u32, time: f64) -> impl Iterator<Item = &'a Facet> + use<'a> {
        let motion = self.motion(states, i);
        let Motion { position, velocity, acceleration, radius } = motion;
        let reach = reach_along(&velocity, &acceleration, time) * MARGIN;
        let around = reach.add_scalar(radius + ROUNDING * (position.amax() + self.farthest_facet));
        let swept = [position - around, position + around];
        let swept_beside = self.motions.swept(&motion, &states.elapsed, time);
        let is_met = self.meets(i);
        self.facets.iter().filter(move |facet| {
            let surface = facet.surface as usize;
            let swept = swept_beside.get(surface).and_then(Option::as_ref).unwrap_or(&swept);
            is_met[surface] && facet.reaches(swept)
        })
    }
}
