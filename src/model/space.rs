//! The region that contains the particles: a box whose axes are periodic, bounded or flat.

use crate::Vector;
use crate::physics::response::ContactLaw;
use serde::{Deserialize, Serialize};

pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// Boundary condition at one face of the box: open, or a wall.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Face {
    /// No boundary. Particles leave the box here and are still simulated.
    Open,
    /// A flat wall. A particle touches the wall when its centre is half a diameter away.
    Wall(ContactLaw),
}

/// Boundary condition along one axis: periodic, bounded or flat.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Boundary {
    /// Particles that leave on one side enter on the other side. Pairs interact through their minimum image.
    #[default]
    Periodic,
    /// The two sides of the box, each open or a wall.
    Bounded {
        /// Boundary condition at the side through the lower corner.
        lower: Face,
        /// Boundary condition at the side through the upper corner.
        upper: Face,
    },
    /// The box has no extent along this axis. Every particle stays at the coordinate of the lower corner. With one flat
    /// axis a scene is two-dimensional, with two flat axes it is one-dimensional.
    Flat,
}

impl Boundary {
    /// Both sides open.
    pub const OPEN: Self = Self::Bounded { lower: Face::Open, upper: Face::Open };

    /// Contact laws of the walls at the lower and the upper side; `None` for a side that is not a wall.
    pub(crate) fn contact_laws(&self) -> [Option<ContactLaw>; 2] {
        let of = |face: &Face| if let Face::Wall(law) = face { Some(*law) } else { None };
        match self {
            Self::Bounded { lower, upper } => [of(lower), of(upper)],
            Self::Periodic | Self::Flat => [None; 2],
        }
    }

    /// Walls with the same coefficient of restitution on both sides.
    #[must_use]
    pub const fn walls(restitution: f64) -> Self {
        let wall = Face::Wall(ContactLaw::smooth(restitution));
        Self::Bounded { lower: wall, upper: wall }
    }
}

/// The simulation box, aligned with the axes.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Space {
    /// Lower corner `[length]`.
    pub lower: Vector,
    /// Edge lengths `[length]`; 0 along flat axes, otherwise positive. Edges along open axes do not bound particles.
    pub size: Vector,
    /// Boundary conditions, per axis.
    pub boundary: [Boundary; 3],
}

impl Space {
    /// A cube with its lower corner at the origin, periodic along every axis.
    #[must_use]
    pub fn periodic_cube(length: f64) -> Self {
        Self { lower: Vector::zeros(), size: Vector::repeat(length), boundary: [Boundary::Periodic; 3] }
    }

    /// Upper corner `[length]`.
    #[must_use]
    pub fn upper(&self) -> Vector {
        self.lower + self.size
    }

    /// Number of axes along which particles move: 3, 2 or 1.
    #[must_use]
    pub fn dimensions(&self) -> usize {
        self.boundary.iter().filter(|b| **b != Boundary::Flat).count()
    }

    /// Whether a particle can turn about an axis: about any axis in three dimensions, about the flat axis in two, and
    /// about none on a line.
    #[must_use]
    pub fn turns_about(&self, axis: usize) -> bool {
        match self.dimensions() {
            3 => true,
            2 => self.boundary[axis] == Boundary::Flat,
            _ => false,
        }
    }

    /// Volume, area or length of the box: the product of the edges that are not flat.
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..3).filter(|&k| self.boundary[k] != Boundary::Flat).map(|k| self.size[k]).product()
    }

    /// Whether the lower and the upper side across an axis are walls.
    #[must_use]
    pub fn walled_sides(&self, axis: usize) -> [bool; 2] {
        self.boundary[axis].contact_laws().map(|wall| wall.is_some())
    }

    /// Replaces the values of sides without a wall by `None`.
    pub(crate) fn of_walls<T: Copy>(&self, values: [[Option<T>; 2]; 3]) -> [[Option<T>; 2]; 3] {
        std::array::from_fn(|axis| {
            let is_wall = self.walled_sides(axis);
            std::array::from_fn(|side| values[axis][side].filter(|_| is_wall[side]))
        })
    }

    /// Number of walls across an axis: 0, 1 or 2.
    #[must_use]
    pub fn walls(&self, axis: usize) -> usize {
        self.walled_sides(axis).into_iter().filter(|is_wall| *is_wall).count()
    }

    /// Whether no side is open.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        (0..3).all(|axis| self.is_closed_along(axis))
    }

    fn is_closed_along(&self, axis: usize) -> bool {
        !matches!(self.boundary[axis], Boundary::Bounded { .. }) || self.walls(axis) == 2
    }

    /// Length along an axis that particle centres can reach `[length]`. Centres stay one radius away from each wall.
    #[must_use]
    pub fn accessible_length(&self, axis: usize, diameter: f64) -> f64 {
        match self.walls(axis) {
            0 => self.size[axis],
            walls => (self.size[axis] - 0.5 * diameter * walls as f64).max(0.0),
        }
    }

    /// Volume, area or length that particle centres can reach: `[length^D]` in `D` dimensions.
    #[must_use]
    pub fn accessible_volume(&self, diameter: f64) -> f64 {
        let axes = (0..3).filter(|&axis| self.boundary[axis] != Boundary::Flat);
        axes.map(|axis| self.accessible_length(axis, diameter)).product()
    }

    /// Area that particle centres can reach at a wall across an axis `[length^(D - 1)]`; `None` if infinite.
    #[must_use]
    pub fn accessible_area(&self, axis: usize, diameter: f64) -> Option<f64> {
        self.area(axis, |other| self.accessible_length(other, diameter))
    }

    /// Area of a wall across an axis `[length^(D - 1)]`, 1 in one dimension; `None` if the area is infinite.
    #[must_use]
    pub fn wall_area(&self, axis: usize) -> Option<f64> {
        self.area(axis, |other| self.size[other])
    }

    fn area(&self, axis: usize, length: impl Fn(usize) -> f64) -> Option<f64> {
        let others = || (0..3).filter(|&other| other != axis && self.boundary[other] != Boundary::Flat);
        others().all(|other| self.is_closed_along(other)).then(|| others().map(length).product())
    }

    /// Whether every axis is periodic or flat.
    #[must_use]
    pub fn is_fully_periodic(&self) -> bool {
        self.boundary.iter().all(|b| matches!(b, Boundary::Periodic | Boundary::Flat))
    }

    /// Whether all edges have the same length within round-off. A box with a flat axis is not a cube.
    #[must_use]
    pub fn is_cube(&self) -> bool {
        const ROUNDING: f64 = 1e-9;
        self.size.max() - self.size.min() <= ROUNDING * self.size.max()
    }

    /// Largest magnitude of the coordinates of periodic sides `[length]`; 0 without periodic axes. Wrapping rounds a
    /// coordinate to a unit in the last place of this value.
    #[must_use]
    pub(crate) fn farthest_side(&self) -> f64 {
        let upper = self.upper();
        let periodic = (0..3).filter(|&axis| self.boundary[axis] == Boundary::Periodic);
        periodic.map(|axis| self.lower[axis].abs().max(upper[axis].abs())).fold(0.0, f64::max)
    }

    /// Wraps a position into the box along periodic axes. Along flat axes, sets the coordinate of the box.
    #[must_use]
    pub(crate) fn wrapped(&self, mut position: Vector) -> Vector {
        for k in 0..3 {
            match self.boundary[k] {
                Boundary::Flat => position[k] = self.lower[k],
                Boundary::Periodic => {
                    let (lower, size, upper) = (self.lower[k], self.size[k], self.upper()[k]);
                    if !(lower..upper).contains(&position[k]) {
                        let turned = lower + (position[k] - lower).rem_euclid(size);
                        // Wrapping can round a position just below the lower side to exactly the upper side.
                        position[k] = if turned < upper { turned } else { lower };
                    }
                }
                Boundary::Bounded { .. } => {}
            }
        }
        position
    }

    /// Periods along the axes `[length]`; infinite along axes that are not periodic.
    #[must_use]
    pub fn periods(&self) -> Vector {
        Vector::from_fn(|k, _| if self.boundary[k] == Boundary::Periodic { self.size[k] } else { f64::INFINITY })
    }
}

/// Returns the shortest image of one component of a separation; see [`minimum_image`].
#[inline]
#[must_use]
pub fn minimum_image_along(x: f64, period: f64) -> f64 {
    x - if x.abs() > 0.5 * period { period.copysign(x) } else { 0.0 }
}

/// Returns the shortest image of a separation. Opposite separations give exactly opposite images.
///
/// The shortest image must differ from the separation by at most one period along each axis. This condition is true for
/// two particles in the box, or if one of them is up to half a period outside.
#[inline]
#[must_use]
pub fn minimum_image(mut separation: Vector, periods: &Vector) -> Vector {
    for k in 0..3 {
        separation[k] = minimum_image_along(separation[k], periods[k]);
    }
    separation
}

/// [`minimum_image`] in a sheared box, where the next image along y is displaced by `displacement` along x `[length]`.
/// The displacement is at most half a period, as returned by [`displacement_within_period`], and 0 without shear.
///
/// The image along y is chosen first, together with its displacement, then the images along x and z. If the shortest
/// image is shorter than half of the shortest period, it is the result.
#[inline]
#[must_use]
pub fn nearest_image(mut separation: Vector, periods: &Vector, displacement: f64) -> Vector {
    if separation.y.abs() > 0.5 * periods.y {
        separation.x -= 1.0_f64.copysign(separation.y) * displacement;
    }
    minimum_image(separation, periods)
}

/// Subtracts whole periods from a displacement along x. The result is in `(-period / 2, period / 2]`.
#[must_use]
pub fn displacement_within_period(displacement: f64, period: f64) -> f64 {
    let rest = libm::fmod(displacement, period);
    if rest > 0.5 * period {
        rest - period
    } else if rest <= -0.5 * period {
        rest + period
    } else {
        rest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shortest(separation: &Vector, size: &Vector, displacement: f64) -> f64 {
        let mut shortest = f64::INFINITY;
        for (i, j, k) in (-2..=2).flat_map(|i| (-2..=2).flat_map(move |j| (-2..=2).map(move |k| (i, j, k)))) {
            let [i, j, k] = [i, j, k].map(f64::from);
            let image = Vector::new(i * size.x + j * displacement, j * size.y, k * size.z);
            shortest = shortest.min((separation + image).norm());
        }
        shortest
    }

    #[test]
    fn nearest_image_is_exact_up_to_half_the_shortest_period() {
        let size = Vector::new(6.0, 4.0, 7.0);
        for displacement in [0.0, 0.7, -1.9, 2.4, -2.9, 3.0] {
            let mut near = 0;
            for index in 0..20_000_u32 {
                // Quasi-random numbers spread the separations evenly.
                let part = |factor: f64| 2.0 * (f64::from(index) * factor).fract() - 1.0;
                let apart = Vector::new(part(0.754_878), part(0.569_84), part(0.430_16)).component_mul(&size);
                let nearest = nearest_image(apart, &size, displacement);
                assert_eq!(nearest_image(-apart, &size, displacement), -nearest, "antisymmetric");
                assert!(nearest.iter().zip(&size).all(|(x, period)| x.abs() <= 0.5 * period), "{nearest}");
                let expected = shortest(&apart, &size, displacement);
                if expected < 2.0 {
                    near += 1;
                    assert!((nearest.norm() - expected).abs() < 1e-14, "{apart} {displacement}: {nearest} {expected}");
                }
            }
            // A sphere of radius 2 fills a fifth of the box, so about 4000 of the 20 000 separations are short.
            assert!(near > 3000, "{near}");
        }
    }

    #[test]
    fn shear_displacement_is_reduced_to_half_a_period() {
        for (displacement, expected) in
            [(0.0, 0.0), (3.0, 3.0), (-3.0, 3.0), (3.5, -2.5), (-3.5, 2.5), (6.0, 0.0), (20.0, 2.0), (-20.0, -2.0)]
        {
            assert_eq!(displacement_within_period(displacement, 6.0), expected, "{displacement}");
        }
    }

    #[test]
    fn wrapping_moves_positions_into_the_box_and_keeps_inner_ones() {
        let mut space = Space { lower: Vector::new(-3.0, 0.5, 1.0), ..Space::periodic_cube(10.0) };
        space.boundary = [Boundary::Periodic, Boundary::OPEN, Boundary::Flat];
        let x = |x: f64| space.wrapped(Vector::new(x, 12.0, 1.5));
        for (given, expected) in [
            (-3.0, -3.0),
            (7.0_f64.next_down(), 7.0_f64.next_down()),
            (7.0, -3.0),
            (-5.0, 5.0),
            (25.0, 5.0),
            // Adding a period rounds this position to exactly the upper side, so it is wrapped to the lower side.
            ((-3.0_f64).next_down(), -3.0),
        ] {
            assert_eq!(x(given), Vector::new(expected, 12.0, 1.0), "{given}");
        }
    }
}
