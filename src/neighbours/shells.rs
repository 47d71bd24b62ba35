//! Shells: where each particle may be until its neighbour list is made anew.

use super::lists::Lists;
use super::near::Near;
use crate::Vector;
use crate::space::{Boundary, Space, minimum_image, minimum_image_along};

/// Shells are left this much early, so that the round-off of positions and times (below some `1e-10` of the box) never lets
/// two particles meet that are not in each other's lists.
const MARGIN: f64 = 1e-6;

/// A centre, with one number to spare: four of them turn into columns of four.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(32))]
pub struct Centre([f64; 4]);

impl Centre {
    /// A centre at a position.
    #[must_use]
    pub fn new(position: &Vector) -> Self {
        Self([position.x, position.y, position.z, 0.0])
    }

    /// The position of a centre.
    #[inline]
    #[must_use]
    pub fn position(&self) -> Vector {
        Vector::new(self.0[0], self.0[1], self.0[2])
    }
}

/// The centres of the particles' shells, and the lists of those within reach.
#[derive(Debug)]
pub struct Shells {
    /// Radius `delta` of a shell `[length]`.
    pub radius: f64,
    /// Where each particle was when its list was made.
    pub centres: Vec<Centre>,
    /// Who is within reach of whom.
    pub lists: Lists,
    /// By species and species: the square of the distance of two centres within reach, negative for those who never meet.
    squared: Vec<f64>,
    species: usize,
    /// Between these corners, the nearest image of whoever is within reach is itself.
    inner: [Vector; 2],
}

impl Shells {
    /// Shells of a radius in `space`; `ranges` are the distances at which strangers of each two species meet, negative for those
    /// who never do; `longest` is the longest one, bonds included.
    #[must_use]
    pub fn new(space: &Space, radius: f64, ranges: &[f64], longest: f64, positions: &[Vector]) -> Self {
        let reach = |range: f64| if range < 0.0 { -1.0 } else { range + 2.0 * radius * (1.0 + MARGIN) };
        let widest = reach(longest) + 3.0 * radius;
        let margin =
            Vector::from_fn(|k, _| if space.boundary[k] == Boundary::Periodic { widest } else { f64::NEG_INFINITY });
        Self {
            radius,
            lists: Lists::new(positions.len()),
            centres: positions.iter().map(Centre::new).collect(),
            squared: ranges.iter().map(|&range| reach(range) * reach(range).abs()).collect(),
            species: ranges.len().isqrt(),
            inner: [space.lower + margin, space.upper() - margin],
        }
    }

    /// The side that cells need for the longest of some ranges.
    #[must_use]
    pub fn reach(radius: f64, range: f64) -> f64 {
        range + 2.0 * radius * (1.0 + MARGIN)
    }

    /// Whether shells of a radius fit a box: the nearest image of a pair stays the same one while both are in their shells.
    #[must_use]
    pub fn fit(space: &Space, radius: f64, range: f64) -> bool {
        (0..3).all(|k| space.boundary[k] != Boundary::Periodic || space.size[k] > 2.0 * (range + 4.1 * radius))
    }

    /// Whether a particle at `position` may meet others across a side of the box.
    #[inline]
    #[must_use]
    pub fn wraps(&self, position: &Vector) -> bool {
        (0..3).any(|k| position[k] < self.inner[0][k] || position[k] > self.inner[1][k])
    }

    /// Whether a centre is within reach of another particle's.
    #[inline]
    #[must_use]
    pub fn is_within_reach(&self, centre: &Vector, other: u32, species: [u16; 2], periods: &Vector) -> bool {
        let apart = minimum_image(centre - self.centres[other as usize].position(), periods);
        apart.norm_squared() < self.squared[usize::from(species[0]) * self.species + usize::from(species[1])]
    }

    /// Keeps those in `near` whose centres are within reach of another centre, of a particle of some species.
    ///
    /// `species` are those of all, or empty if there is only one.
    #[inline]
    pub fn keep_within_reach(&self, centre: &Vector, mine: u16, species: &[u16], periods: &Vector, near: &mut Near) {
        let wraps = self.wraps(centre);
        let squared = &self.squared[usize::from(mine) * self.species..];
        near.retain_fours(|ids| {
            let rows = ids.map(|id| &self.centres[id as usize].0);
            let mut apart = [0.0; 4];
            for k in 0..3 {
                for lane in 0..4 {
                    let x = centre[k] - rows[lane][k];
                    let x = if wraps { minimum_image_along(x, periods[k]) } else { x };
                    apart[lane] += x * x;
                }
            }
            std::array::from_fn(|lane| {
                let other = if species.is_empty() { 0 } else { usize::from(species[ids[lane] as usize]) };
                apart[lane] < squared[other]
            })
        });
    }
}
