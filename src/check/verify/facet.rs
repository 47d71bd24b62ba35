//! The features of a scene's surfaces, as flights come to them: where they are, who meets them, and when they are there.

use super::approach::{Approach, Boundary};
use super::contact::Contact;
use super::foot::Foot;
use super::rules::Side;
use super::window::{MARGIN, reach_along};
use super::world::World;
use crate::Vector;
use crate::check::reference::{Across, Barrier, Feature, Motion, features};
use crate::engine::States;
use crate::model::space::Space;
use crate::model::{ParticleId, Scene};

/// Rounding of coordinates in the comparison that leaves out what is too far away.
const ROUNDING: f64 = MARGIN - 1.0;
/// Beyond so many radii no gap is of rounding.
const NEAR: f64 = 1.001;

/// A feature of a surface, or its image in a periodic box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facet {
    pub feature: Feature,
    /// Number of its surface among those of the scene.
    pub surface: u32,
    /// Corners of a box around it `[length]`.
    bounds: [Vector; 2],
    /// Its largest coordinate `[length]`.
    pub farthest: f64,
    slenderness: f64,
}

/// All facets of a scene.
pub(super) fn facets(scene: &Scene, periods: &Vector) -> Vec<Facet> {
    let radius = 0.5 * scene.species.iter().map(|species| species.diameter).fold(0.0, f64::max);
    let all = features(&scene.surfaces).into_iter();
    all.flat_map(|feature| images(feature, &scene.space, periods, radius)).map(Facet::of).collect()
}

/// A feature with its images that particles may meet within a window: they are within half a period of the box, and move by one at most.
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
        // Of so many that there are more than numbers, none is met.
        let surface = u32::try_from(feature.surface).unwrap_or(u32::MAX);
        Self { feature, surface, bounds: feature.bounds(), farthest, slenderness }
    }

    /// The contact of a particle with the surface that it belongs to.
    pub fn contact(&self, i: u32) -> Contact {
        Contact::Surface { particle: ParticleId(i), surface: self.surface }
    }

    /// Whether it has anything in a box.
    pub fn reaches(&self, [lower, upper]: &[Vector; 2]) -> bool {
        let [start, end] = &self.bounds;
        (0..3).all(|k| start[k] <= upper[k] && lower[k] <= end[k])
    }

    /// Whether a sphere may touch it.
    pub fn is_near(&self, Motion { position, radius, .. }: Motion) -> bool {
        let around = Vector::repeat(radius * NEAR + ROUNDING * (position.amax() + self.farthest));
        self.reaches(&[position - around, position + around])
    }

    /// Whether it has no end along an axis.
    pub fn is_endless(&self, axis: usize) -> bool {
        self.bounds[0][axis] == f64::NEG_INFINITY
    }

    /// The flight of a particle towards it, from a time within the window on.
    pub fn approach(&self, world: &World, states: &States, i: u32, since: f64) -> Approach {
        let motion = world.motion(states, i);
        let Across { position, velocity, acceleration, barrier } = self.feature.across(&motion);
        let boundary = match barrier {
            Barrier::Round { distance, side } => {
                let side = if side.sign() > 0.0 { Side::Positive } else { Side::Negative };
                Boundary::Sphere { distance, side }
            }
            Barrier::Flat => Boundary::Plane,
        };
        let slenderness = self.slenderness;
        let foot = self.feature.extents(&motion).map(|extents| Foot { extents, slenderness });
        Approach { since, position, velocity, acceleration, boundary, foot }
    }

    /// Whether it is shown that a particle never comes to it, in a box that is not periodic.
    pub fn is_clear(&self, world: &World, states: &States, i: u32) -> bool {
        let Motion { position, velocity, acceleration, radius } = world.motion(states, i);
        let size = position.norm() + self.farthest + radius;
        let across = self.approach(world, states, i, 0.0);
        if across.is_clear(size) {
            return true;
        }
        if across.foot.is_none() {
            return false;
        }
        // A face from behind: what never comes to its other side does not come through it either.
        let height = across.position.x + radius;
        if across.boundary == Boundary::Plane && height < 0.0 {
            let along = |length: f64| Vector::new(length, 0.0, 0.0);
            let behind = Approach {
                position: along(-height - radius),
                velocity: -across.velocity,
                acceleration: -across.acceleration,
                ..across
            };
            if behind.is_clear(size) {
                return true;
            }
        }
        // What has ends is within a sphere.
        let [start, end] = self.bounds;
        let distance = 0.5 * (end - start).norm() + radius;
        let boundary = Boundary::Sphere { distance, side: Side::Positive };
        let position = position - 0.5 * (start + end);
        Approach { since: 0.0, position, velocity, acceleration, boundary, foot: None }.is_clear(size)
    }
}

impl World {
    /// A particle as features see it, within half a period of the box, wherever its flight has led.
    pub fn motion(&self, states: &States, i: u32) -> Motion {
        let at = i as usize;
        let (position, velocity) = (self.brought_back(states.positions[at]), states.velocities[at]);
        Motion { position, velocity, acceleration: self.accelerations[at], radius: self.radius(i) }
    }

    /// The facets that are there, that a particle meets, and that it may come to in some time.
    pub fn facets_near<'a>(&'a self, states: &States, i: u32, time: f64) -> impl Iterator<Item = &'a Facet> + use<'a> {
        let Motion { position, velocity, acceleration, radius } = self.motion(states, i);
        let reach = reach_along(&velocity, &acceleration, time) * MARGIN;
        let around = reach.add_scalar(radius + ROUNDING * (position.amax() + self.farthest_facet));
        let swept = [position - around, position + around];
        let is_met = self.meets(i);
        self.facets.iter().filter(move |facet| is_met[facet.surface as usize] && facet.reaches(&swept))
    }
}
