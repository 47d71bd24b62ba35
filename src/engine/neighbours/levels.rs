//! Centres of Verlet lists in cells. Particles of similar size share a level, and each level has cells of its own size.
//!
//! With one grid for all sizes, a small particle would have to be compared with all small particles around the largest
//! one. With levels, a search visits few cells of each level: the cells around a position on levels of larger particles,
//! and the cells within reach on levels of smaller ones. See V. Ogarko and S. Luding, Comput. Phys. Commun. 183, 931
//! (2012).

use super::candidates::Candidates;
use super::packed::Packed;
use super::ranges::Ranges;
use crate::Vector;
use crate::base::numbers::id;
use crate::engine::columns::Order;
use crate::model::space::Space;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Levels {
    /// The cells of each level. Small particles come first.
    grids: Vec<Packed>,
    /// Number of particles on each level when the cells were made, and now. Empty if there is one level.
    sorted: Vec<usize>,
    held: Vec<usize>,
    /// The level of each row.
    of_rows: Vec<u8>,
    /// The level of each particle. Empty if there is one level.
    of_particles: Vec<u8>,
    /// For each row and level, the largest distance between the centres of a listed pair `[length]`; negative if such
    /// pairs never meet.
    reaches: Vec<f64>,
}

impl Levels {
    /// Sorts centres at `positions` into cells. `rows` are the rows of all particles; empty if there is only one.
    /// `reach_of(a, b)` is the largest distance between the centres of a listed pair `[length]`.
    #[must_use]
    pub fn new(
        space: &Space,
        ranges: &Ranges,
        reach_of: impl Fn(usize, usize) -> f64,
        positions: &[Vector],
        rows: &[u16],
    ) -> Self {
        let of_rows = ranges.levels.clone();
        let count = ranges.level_count();
        let occurring = |level: usize| ranges.occurring().filter(move |&row| usize::from(ranges.levels[row]) == level);
        let of_row = |row: usize, level: usize| occurring(level).map(|b| reach_of(row, b)).fold(-1.0, f64::max);
        let reaches = (0..of_rows.len()).flat_map(|row| (0..count).map(move |level| (row, level)));
        let reaches: Vec<f64> = reaches.map(|(row, level)| of_row(row, level)).collect();
        let level_of = |particle: usize| of_rows[rows.get(particle).map_or(0, |row| usize::from(*row))];
        let of_particles: Vec<u8> = (0..positions.len()).filter(|_| count > 1).map(level_of).collect();
        let grid_of = |level: usize| {
            let own = occurring(level).map(|row| reaches[row * count + level]).fold(0.0, f64::max);
            // Particles that do not meet particles of their level are found from other levels.
            let others = ranges.occurring().map(|row| reaches[row * count + level]).filter(|reach| *reach > 0.0);
            let own = if own > 0.0 { own } else { others.reduce(f64::min).unwrap_or(0.0) };
            if count == 1 {
                return Packed::new(space, own, positions);
            }
            let here = positions.iter().zip(&of_particles).filter(|(_, other)| usize::from(**other) == level);
            Packed::new(space, own, &here.map(|(position, _)| *position).collect::<Vec<_>>())
        };
        let grids = (0..count).map(grid_of).collect();
        let held = if count > 1 { vec![0; count] } else { Vec::new() };
        let mut levels = Self { grids, sorted: Vec::new(), held, of_rows, of_particles, reaches };
        levels.put_all(positions);
        levels.sorted.clone_from(&levels.held);
        levels
    }

    /// Whether the number of particles on any level has changed much since the cells were made.
    pub fn are_outgrown(&self, is_outgrown: impl Fn(usize, usize) -> bool) -> bool {
        self.held.iter().zip(&self.sorted).any(|(now, before)| is_outgrown(*now, *before))
    }

    fn put_all(&mut self, centres: &[Vector]) {
        for (centre, particle) in centres.iter().zip(0..) {
            self.put(particle, centre);
        }
    }

    /// Returns the same levels with other particles. `centres` are their centres in the new order.
    pub fn permuted(&self, order: &Order, centres: &[Vector]) -> Self {
        let is_single = self.of_particles.is_empty();
        let mut levels = Self {
            grids: self.grids.iter().map(Packed::emptied).collect(),
            sorted: self.sorted.clone(),
            held: vec![0; self.held.len()],
            of_rows: self.of_rows.clone(),
            of_particles: if is_single { Vec::new() } else { order.permuted(&self.of_particles) },
            reaches: self.reaches.clone(),
        };
        levels.put_all(centres);
        levels
    }

    /// Checks data from a file.
    #[must_use]
    pub fn is_sound(&self, particles: usize, rows: usize) -> bool {
        let count = self.grids.len();
        let exist = |levels: &[u8]| levels.iter().all(|&level| usize::from(level) < count);
        let of_levels = if count > 1 { count } else { 0 };
        self.of_rows.len() == rows
            && [self.sorted.len(), self.held.len()] == [of_levels; 2]
            && self.reaches.len() == rows * count
            && self.of_particles.len() == if count > 1 { particles } else { 0 }
            && exist(&self.of_rows)
            && exist(&self.of_particles)
            && self.grids.iter().all(|grid| grid.is_sound(particles))
    }

    /// Largest distance between the centres of a listed pair `[length]`.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        self.reaches.iter().copied().fold(0.0, f64::max)
    }

    #[inline]
    fn grid_of(&self, particle: u32) -> &Packed {
        &self.grids[self.level_of(particle)]
    }

    #[inline]
    fn level_of(&self, particle: u32) -> usize {
        if self.of_particles.is_empty() { 0 } else { usize::from(self.of_particles[particle as usize]) }
    }

    pub fn lift(&mut self, particle: u32, centre: &Vector) {
        let level = self.level_of(particle);
        self.grids[level].lift(particle, centre);
        if let Some(held) = self.held.get_mut(level) {
            *held = held.saturating_sub(1);
        }
    }

    pub fn put(&mut self, particle: u32, centre: &Vector) {
        let level = self.level_of(particle);
        self.grids[level].put(particle, centre);
        if let Some(held) = self.held.get_mut(level) {
            *held += 1;
        }
    }

    /// Appends a particle.
    pub fn push(&mut self, particle: u32, centre: &Vector, row: u16) {
        if self.grids.len() > 1 {
            debug_assert_eq!(id(self.of_particles.len()), particle);
            self.of_particles.push(self.of_rows[usize::from(row)]);
        }
        self.put(particle, centre);
    }

    /// Finds all particles that may be listed for a particle of a row at `centre`, and others nearby.
    pub fn find_candidates(&self, centre: &Vector, row: u16, near: &mut Candidates) {
        near.clear();
        self.for_each_reach(row, |grid, reach| grid.add_candidates(centre, reach, near));
    }

    /// Finds all particles that may be listed for a particle of a row at `centre`. Returns true if all of them are
    /// certainly within the largest reach of the row. See [`Packed::add_within`].
    #[inline]
    pub fn find_within(&self, centre: &Vector, row: u16, wraps: bool, near: &mut Candidates) -> bool {
        near.clear();
        if let [only] = &self.grids[..] {
            return only.add_within(centre, self.reaches[usize::from(row)].max(0.0), wraps, near);
        }
        let mut are_certain = true;
        self.for_each_reach(row, |grid, reach| are_certain &= grid.add_within(centre, reach, wraps, near));
        are_certain
    }

    fn for_each_reach<'a>(&'a self, row: u16, mut visit: impl FnMut(&'a Packed, f64)) {
        let count = self.grids.len();
        let reaches = &self.reaches[usize::from(row) * count..][..count];
        self.grids
            .iter()
            .zip(reaches)
            .filter(|(_, reach)| **reach >= 0.0)
            .for_each(|(grid, reach)| visit(grid, *reach));
    }

    pub fn enlarge(&self) {
        self.grids.iter().for_each(Packed::enlarge);
    }

    /// Prefetches the cells of a particle's own level around a centre.
    #[inline]
    pub fn prefetch_rows(&self, particle: u32, centre: &Vector) {
        let grid = self.grid_of(particle);
        grid.prefetch_rows(grid.home(centre));
    }

    /// Prefetches the first blocks of these cells. Call [`Self::prefetch_rows`] first.
    #[inline]
    pub fn prefetch_near(&self, particle: u32, centre: &Vector) {
        let grid = self.grid_of(particle);
        grid.prefetch_near(grid.home(centre));
    }
}

#[cfg(test)]
mod tests;
