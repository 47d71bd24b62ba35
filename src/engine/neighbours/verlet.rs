//! Verlet lists with a skin. The skin is the region in which a particle may move before its list is rebuilt.

use super::candidates::Candidates;
use super::levels::Levels;
use super::lists::Lists;
use super::ranges::Ranges;
use crate::Vector;
use crate::base::numbers::id;
use crate::engine::array::Array;
use crate::engine::columns::Order;
use crate::engine::hardware::pages::enlarge;
use crate::model::space::{Boundary, Space, minimum_image};
use serde::{Deserialize, Serialize};

/// Margin of the reach, as a fraction of the skin. Without the margin, unlisted particles could meet because of
/// round-off.
const MARGIN: f64 = 1e-6;

/// The centres of all particles, and for each particle the list of particles with centres within reach.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct VerletLists {
    /// Half of the skin, `delta`: the largest distance of a particle from its centre `[length]`.
    pub half_skin: f64,
    /// Position of each particle when its list was built.
    pub centres: Array<Vector>,
    /// The centres, sorted into cells by the size of their particles.
    pub levels: Levels,
    /// The lists can be rebuilt from the centres and the captured pairs.
    pub lists: Lists,
    /// For each pair of table rows, the largest squared distance between the centres of a listed pair `[length^2]`.
    /// Negative for pairs that never meet.
    squared: Vec<f64>,
    rows: usize,
    periods: Vector,
    /// Corners of the inner part of the box, in which particles meet no particle across a side of the box.
    inner: [Vector; 2],
}

impl VerletLists {
    /// Creates empty lists. Ranges are multiplied by `factor`. `rows` are the rows of all particles; empty if there is
    /// only one row.
    #[must_use]
    pub fn new(
        space: &Space,
        half_skin: f64,
        (ranges, factor): (&Ranges, f64),
        positions: Vec<Vector>,
        rows: &[u16],
    ) -> Self {
        let reach = |range: f64| if range < 0.0 { -1.0 } else { range * factor + 2.0 * half_skin * (1.0 + MARGIN) };
        // Width of the outer part of the box. It includes two half skins for two particles, and one for a centre
        // outside the box.
        let widest = reach(ranges.longest) + 3.0 * half_skin;
        let margin =
            Vector::from_fn(|k, _| if space.boundary[k] == Boundary::Periodic { widest } else { f64::NEG_INFINITY });
        Self {
            half_skin,
            lists: Lists::new(positions.len()),
            levels: Levels::new(space, ranges, |a, b| reach(ranges.at(a, b)), &positions, rows),
            centres: positions.into(),
            squared: ranges.between.iter().map(|&range| reach(range) * reach(range).abs()).collect(),
            rows: ranges.between.len().isqrt(),
            periods: space.periods(),
            inner: [space.lower + margin, space.upper() - margin],
        }
    }

    #[must_use]
    pub fn is_sound(&self, particles: usize, rows: usize) -> bool {
        self.centres.len() == particles
            && self.rows == rows
            && self.squared.len() == rows * rows
            && self.lists.is_sound(particles)
            && self.levels.is_sound(particles, rows)
    }

    /// Returns the largest half skin that a box allows, so that the nearest image of a pair does not change within the
    /// skins. Infinite without periodic axes; negative if the box is too small for lists.
    #[must_use]
    pub fn widest_half_skin(space: &Space, range: f64) -> f64 {
        // Half a period must exceed `range + 4 half_skin`: two half skins for the reach of lists, and one for each
        // particle. The divisor is 4.1 to allow for rounding.
        let periodic = (0..3).filter(|&k| space.boundary[k] == Boundary::Periodic);
        periodic.map(|k| (0.5 * space.size[k] - range) / 4.1).fold(f64::INFINITY, f64::min)
    }

    /// Prefetches the cells around the centre of a particle.
    #[inline]
    pub fn prefetch_rows(&self, particle: u32) {
        self.levels.prefetch_rows(particle, &self.centres[particle as usize]);
    }

    /// Prefetches the contents of these cells.
    #[inline]
    pub fn prefetch_near(&self, particle: u32) {
        self.levels.prefetch_near(particle, &self.centres[particle as usize]);
    }

    /// Returns true if a particle at `position` may meet other particles across a side of the box.
    #[inline]
    #[must_use]
    pub fn wraps(&self, position: &Vector) -> bool {
        (0..3).any(|k| position[k] < self.inner[0][k] || position[k] > self.inner[1][k])
    }

    #[inline]
    fn is_within_reach(&self, centre: &Vector, other: u32, rows: [u16; 2]) -> bool {
        let apart = minimum_image(centre - self.centres[other as usize], &self.periods);
        apart.norm_squared() < self.squared[usize::from(rows[0]) * self.rows + usize::from(rows[1])]
    }

    /// Finds the particles whose centres are within reach of `centre`. `mine` is the table row of the particle there, and
    /// `row_of` returns the rows of other particles.
    #[inline]
    pub fn find_neighbours_within(
        &self,
        centre: &Vector,
        mine: u16,
        row_of: impl Fn(u32) -> u16,
        near: &mut Candidates,
    ) {
        let are_certain = self.levels.find_within(centre, mine, self.wraps(centre), near);
        if self.rows > 1 || !are_certain {
            near.retain(|other| self.is_within_reach(centre, other, [mine, row_of(other)]));
        }
    }

    pub fn push(&mut self, centre: Vector, row: u16) {
        self.levels.push(id(self.centres.len()), &centre, row);
        self.centres.push(centre);
        self.lists.push_empty();
    }

    /// Moves the centre of a particle's list. The lists do not change.
    pub fn relocate(&mut self, particle: u32, centre: Vector) {
        let before = std::mem::replace(&mut self.centres[particle as usize], centre);
        if before != centre {
            self.levels.lift(particle, &before);
            self.levels.put(particle, &centre);
        }
    }

    /// Takes a particle out of all lists, and empties its own list.
    pub fn withdraw(&mut self, particle: u32) {
        self.levels.lift(particle, &self.centres[particle as usize]);
        self.lists.withdraw(particle);
    }

    /// Gives a particle another row, an empty list and a new centre. The particle is in no list afterwards.
    pub fn change_row(&mut self, particle: u32, centre: &Vector, row: u16) {
        self.withdraw(particle);
        self.levels.change_row(particle, row);
        self.centres[particle as usize] = *centre;
        self.levels.put(particle, centre);
    }

    pub fn permuted(&self, order: &Order) -> Self {
        let centres = order.permuted(&self.centres);
        let levels = self.levels.permuted(order, &centres);
        Self { centres, levels, lists: self.lists.permuted(order), squared: self.squared.clone(), ..*self }
    }

    pub fn enlarge(&self) {
        enlarge(&self.centres);
        self.levels.enlarge();
        self.lists.enlarge();
    }
}
