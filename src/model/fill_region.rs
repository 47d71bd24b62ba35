//! Regions to fill: boxes, and the interiors of cylinders, cones and spheres.

use std::f64::consts::PI;

use super::Region;
use super::random::Random;
use super::space::{Boundary, Space};
use crate::Vector;
use crate::physics::kinetics::volume_of_ball;
use serde::{Deserialize, Serialize};

const ROUNDING: f64 = 1e-12;

/// A region to fill. In two dimensions a cylinder is a strip, a cone a trapezium and a sphere a disk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum FillRegion {
    /// A box aligned with the axes of space.
    Box(Region),
    /// The interior of a conical frustum, or of a cylinder if the radii are equal.
    Cone {
        /// Centre of the first end of the cone `[length]`.
        base: Vector,
        /// Direction from the first end to the second, of any length.
        axis: Vector,
        /// Radii of the two ends of the cone `[length]`.
        radii: [f64; 2],
        /// Distance between the two ends of the cone along its axis `[length]`.
        length: f64,
    },
    /// The interior of a sphere.
    Sphere {
        /// Centre of the sphere `[length]`.
        centre: Vector,
        /// Radius of the sphere `[length]`.
        radius: f64,
    },
}

impl Region {
    /// Volume in the `D` dimensions of space `[length^D]`.
    pub(crate) fn volume(&self, space: &Space) -> f64 {
        let axes = (0..3).filter(|&k| space.boundary[k] != Boundary::Flat);
        axes.map(|k| self.upper[k] - self.lower[k]).product()
    }

    /// Draws a uniformly distributed position such that the whole particle is inside the box.
    pub(crate) fn draw(&self, space: &Space, radius: f64, random: &mut Random) -> Vector {
        Vector::from_fn(|k, _| {
            if space.boundary[k] == Boundary::Flat {
                return space.lower[k];
            }
            let full = self.lower[k] == space.lower[k] && self.upper[k] == space.upper()[k];
            let margin = if full && space.boundary[k] == Boundary::Periodic { 0.0 } else { radius };
            let (lower, upper) = (self.lower[k] + margin, self.upper[k] - margin);
            let drawn = lower + (upper - lower).max(0.0) * random.uniform();
            // The upper side is part of the next image of the box.
            if drawn < upper { drawn } else { lower }
        })
    }
}

impl FillRegion {
    /// Volume in the `D` dimensions of space `[length^D]`.
    pub(crate) fn volume(&self, space: &Space) -> f64 {
        let dimensions = space.dimensions();
        match self {
            Self::Box(region) => region.volume(space),
            Self::Sphere { radius, .. } => volume_of_ball(*radius, dimensions),
            Self::Cone { radii: [a, b], length, .. } => match dimensions {
                3 => PI / 3.0 * length * (a * a + a * b + b * b),
                2 => length * (a + b),
                _ => *length,
            },
        }
    }

    pub(crate) fn bounds(&self, space: &Space) -> Region {
        let around = |k: usize, low: f64, high: f64| match space.boundary[k] {
            Boundary::Flat => [space.lower[k]; 2],
            _ => [low, high],
        };
        let ends: [[f64; 2]; 3] = match self {
            Self::Box(region) => return *region,
            Self::Sphere { centre, radius } => [0, 1, 2].map(|k| around(k, centre[k] - radius, centre[k] + radius)),
            Self::Cone { base, axis, radii, length } => {
                let axis = axis.normalize();
                [0, 1, 2].map(|k| {
                    // Half-width of a unit disk along the axis `k`. The disk is perpendicular to the cone's axis.
                    let reach = (1.0 - axis[k] * axis[k]).max(0.0).sqrt();
                    let places = [base[k], base[k] + length * axis[k]];
                    let low = (places[0] - radii[0] * reach).min(places[1] - radii[1] * reach);
                    around(k, low, (places[0] + radii[0] * reach).max(places[1] + radii[1] * reach))
                })
            }
        };
        Region { lower: Vector::from(ends.map(|end| end[0])), upper: Vector::from(ends.map(|end| end[1])) }
    }

    /// Returns true if a particle of radius `particle` lies inside the region. In a box, only the centre must lie
    /// inside.
    pub(crate) fn holds(&self, position: &Vector, particle: f64) -> bool {
        match self {
            Self::Box(region) => (0..3).all(|k| (region.lower[k]..=region.upper[k]).contains(&position[k])),
            Self::Sphere { centre, radius } => {
                (position - centre).norm() <= (radius - particle) + ROUNDING * (radius + particle)
            }
            Self::Cone { base, axis, length, .. } => {
                let axis = axis.normalize();
                let from = position - base;
                let along = from.dot(&axis);
                let rounding = ROUNDING * (length + particle);
                (particle - rounding..=length - particle + rounding).contains(&along)
                    && (from - axis * along).norm() <= self.room_at(along, particle) + rounding
            }
        }
    }

    /// Returns the largest distance of a particle's centre from the cone's axis, at the position `along` on the axis.
    /// The distance is negative where the cone is too narrow.
    fn room_at(&self, along: f64, particle: f64) -> f64 {
        let Self::Cone { radii: [a, b], length, .. } = self else { return 0.0 };
        a + (b - a) * along / length - particle * libm::hypot(1.0, (b - a) / length)
    }

    /// Returns the lowest and highest position along a cone's axis at which a particle fits; `None` if it fits nowhere.
    fn stretch(&self, particle: f64) -> Option<[f64; 2]> {
        let Self::Cone { radii: [a, b], length, .. } = self else { return None };
        let ends = [particle, length - particle];
        let room = ends.map(|end| self.room_at(end, particle));
        let slope = (b - a) / length;
        let apex = ends[0] - room[0] / slope;
        let [low, high] = [if room[0] < 0.0 { apex } else { ends[0] }, if room[1] < 0.0 { apex } else { ends[1] }];
        (ends[0] <= ends[1] && room[0].max(room[1]) >= 0.0).then_some([low, high])
    }

    pub(crate) fn has_room(&self, particle: f64) -> bool {
        match self {
            Self::Box(_) => true,
            Self::Sphere { radius, .. } => particle <= *radius,
            Self::Cone { .. } => self.stretch(particle).is_some(),
        }
    }

    /// Draws a uniformly distributed position inside the region. The particle must fit, see [`Self::has_room`].
    pub(crate) fn draw(&self, space: &Space, particle: f64, random: &mut Random) -> Vector {
        match self {
            Self::Box(region) => region.draw(space, particle, random),
            Self::Sphere { centre, radius } => {
                let uniform = random.uniform();
                let part = match space.dimensions() {
                    3 => libm::cbrt(uniform),
                    2 => uniform.sqrt(),
                    _ => uniform,
                };
                centre + random.direction(space) * ((radius - particle).max(0.0) * part)
            }
            Self::Cone { base, axis, .. } => {
                let axis = axis.normalize();
                let [low, high] = self.stretch(particle).unwrap_or_default();
                let widest = self.room_at(low, particle).max(self.room_at(high, particle)).max(0.0);
                loop {
                    let along = low + (high - low) * random.uniform();
                    let across = disk(&axis, space, random) * widest;
                    // At least a third of the attempts succeed: a cone has a third of the volume of a cylinder.
                    if across.norm() <= self.room_at(along, particle).max(0.0) || widest == 0.0 {
                        return base + axis * along + across;
                    }
                }
            }
        }
    }
}

/// Draws a position in the unit disk perpendicular to an axis, or on a line in two dimensions.
fn disk(axis: &Vector, space: &Space, random: &mut Random) -> Vector {
    let reach = if space.dimensions() == 3 { random.uniform().sqrt() } else { random.uniform() };
    loop {
        let direction = random.direction(space);
        let across = direction - axis * axis.dot(&direction);
        // If the two directions are nearly parallel, `across` is mostly rounding error.
        if across.norm_squared() > 1e-12 {
            return across.normalize() * reach;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::random::Purpose;

    fn space(dimensions: usize) -> Space {
        let mut space = Space::periodic_cube(20.0);
        for k in dimensions..3 {
            (space.boundary[k], space.size[k]) = (Boundary::Flat, 0.0);
        }
        space
    }

    fn shapes(dimensions: usize) -> [FillRegion; 4] {
        let in_plane = |x, y, z| Vector::new(x, y, if dimensions == 3 { z } else { 0.0 });
        let (base, axis) = (in_plane(8.0, 9.0, 7.0), in_plane(1.0, 2.0, 3.0));
        [
            FillRegion::Sphere { centre: in_plane(10.0, 10.0, 10.0), radius: 3.0 },
            FillRegion::Cone { base, axis, radii: [2.0, 2.0], length: 5.0 },
            FillRegion::Cone { base, axis, radii: [1.0, 3.0], length: 4.0 },
            FillRegion::Cone { base, axis, radii: [3.0, 0.0], length: 6.0 },
        ]
    }

    #[test]
    fn region_volume_matches_monte_carlo() {
        for dimensions in [2, 3] {
            let space = space(dimensions);
            for shape in shapes(dimensions) {
                let bounds = FillRegion::Box(shape.bounds(&space));
                let mut random = Random::new(3, Purpose::Placement, 0);
                let count = 40_000;
                let inside = (0..count).filter(|_| shape.holds(&bounds.draw(&space, 0.0, &mut random), 0.0)).count();
                let part = shape.volume(&space) / bounds.volume(&space);
                let error = (part * (1.0 - part) / f64::from(count)).sqrt();
                let measured = inside as f64 / f64::from(count);
                assert!((measured - part).abs() < 4.0 * error, "{shape:?}: {measured} for {part}");
            }
        }
    }

    #[test]
    fn random_positions_are_uniform_and_keep_particles_inside() {
        for dimensions in [2, 3] {
            let space = space(dimensions);
            for shape in shapes(dimensions) {
                let mut random = Random::new(3, Purpose::Placement, 0);
                let (particle, count) = (0.4, 4000);
                let mut even = 0.0;
                let middle = {
                    let Region { lower, upper } = shape.bounds(&space);
                    0.5 * (lower + upper)
                };
                for _ in 0..count {
                    let place = shape.draw(&space, particle, &mut random);
                    assert!(shape.holds(&place, particle), "{shape:?}: {place}");
                    even += place.x;
                }
                let bounds = FillRegion::Box(shape.bounds(&space));
                let (mut sum, mut inside) = (0.0, 0.0);
                while inside < f64::from(count) {
                    let place = bounds.draw(&space, 0.0, &mut random);
                    if shape.holds(&place, particle) {
                        sum += place.x;
                        inside += 1.0;
                    }
                }
                let (even, expected) = (even / f64::from(count), sum / inside);
                // Four standard errors of the difference of the means. The standard deviation of x is at most 3.
                assert!(
                    (even - expected).abs() < 4.0 * 3.0 * (2.0 / inside).sqrt(),
                    "{shape:?}: {even} {expected} {middle}"
                );
            }
        }
    }

    #[test]
    fn region_has_room_up_to_its_inscribed_sphere() {
        let sphere = FillRegion::Sphere { centre: Vector::zeros(), radius: 2.0 };
        assert!(sphere.has_room(2.0) && !sphere.has_room(2.0_f64.next_up()));
        let cone = |radii, length| FillRegion::Cone { base: Vector::zeros(), axis: Vector::z(), radii, length };
        assert!(cone([1.0, 1.0], 5.0).has_room(1.0) && !cone([1.0, 1.0], 5.0).has_room(1.01));
        assert!(cone([3.0, 3.0], 1.0).has_room(0.5) && !cone([3.0, 3.0], 1.0).has_room(0.51));
        // A section through the axis is a triangle of base 6 and height 4. The inscribed circle has the radius `area /
        // half the perimeter = 12 / 8`.
        assert!(cone([3.0, 0.0], 4.0).has_room(1.499) && !cone([3.0, 0.0], 4.0).has_room(1.501));
        assert!(cone([0.0, 3.0], 4.0).has_room(1.499) && !cone([0.0, 3.0], 4.0).has_room(1.501));
    }
}
