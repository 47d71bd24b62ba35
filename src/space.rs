//! The region that holds the particles: a box whose axes are periodic, bounded or flat.

use crate::Vector;
use serde::{Deserialize, Serialize};

/// The names of the axes.
pub(crate) const AXES: [&str; 3] = ["x", "y", "z"];

/// What one side of a bounded axis does to a particle that reaches it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Face {
    /// Nothing: the particle flies on and is still simulated.
    Open,
    /// A flat wall. A particle meets it when its surface does, half a diameter before its centre.
    Wall {
        /// Ratio of the normal speeds after and before a contact, in `[0, 1]`.
        restitution: f64,
    },
}

/// How space continues along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Boundary {
    /// What leaves on one side enters on the other; pairs use the minimum image.
    Periodic,
    /// The two sides of the box, each open or a wall.
    Bounded {
        /// The side at the lower corner.
        lower: Face,
        /// The side at the upper corner.
        upper: Face,
    },
    /// No extent: every particle stays exactly at the lower corner's coordinate, with zero velocity.
    /// One flat axis makes a two-dimensional scene, two make a line.
    Flat,
}

impl Boundary {
    /// Both sides open.
    pub const OPEN: Self = Self::Bounded { lower: Face::Open, upper: Face::Open };

    /// Both sides walls of the same restitution.
    #[must_use]
    pub const fn walls(restitution: f64) -> Self {
        Self::Bounded { lower: Face::Wall { restitution }, upper: Face::Wall { restitution } }
    }
}

/// A box, aligned with the axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Space {
    /// Lower corner `[length]`.
    pub lower: Vector,
    /// Edge lengths `[length]`; 0 along flat axes, positive elsewhere. Along an open axis the length only
    /// sizes the grid of cells and the picture.
    pub size: Vector,
    /// What happens at the sides, per axis.
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

    /// Volume, area or length of the box: the product of the edges that are not flat.
    #[must_use]
    pub fn volume(&self) -> f64 {
        (0..3).filter(|&k| self.boundary[k] != Boundary::Flat).map(|k| self.size[k]).product()
    }

    /// Whether every axis that is not flat is periodic, so that the fluid is homogeneous.
    #[must_use]
    pub fn is_fully_periodic(&self) -> bool {
        self.boundary.iter().all(|b| matches!(b, Boundary::Periodic | Boundary::Flat))
    }

    /// Periods along the axes `[length]`; infinite where an axis is not periodic.
    #[must_use]
    pub fn periods(&self) -> Vector {
        Vector::from_fn(|k, _| if self.boundary[k] == Boundary::Periodic { self.size[k] } else { f64::INFINITY })
    }
}

/// The shortest of the images of one coordinate of a separation; see [`minimum_image`].
#[inline]
#[must_use]
pub fn minimum_image_along(x: f64, period: f64) -> f64 {
    x - if x.abs() > 0.5 * period { period.copysign(x) } else { 0.0 }
}

/// The shortest of the images of a separation, exactly antisymmetric in the separation.
///
/// Needs every coordinate within one period of the shortest image, which holds for particles that are
/// kept inside the box to within less than half a period.
#[inline]
#[must_use]
pub fn minimum_image(mut separation: Vector, periods: &Vector) -> Vector {
    for k in 0..3 {
        separation[k] = minimum_image_along(separation[k], periods[k]);
    }
    separation
}
