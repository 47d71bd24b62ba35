//! Centres of Verlet lists in cells. Particles of similar size share a level, and each level has cells of its own size.
//!
//! With one grid for all sizes, cells would be as large as the largest particle, and a small particle would have to be
//! compared with all small particles in these large cells. With levels, a search visits few cells of each level: the
//! cells around a position on levels of larger particles, and the cells within reach on levels of smaller ones. See V.
//! Ogarko and S. Luding, Comput. Phys. Commun. 183, 931 (2012).

use super::candidates::Candidates;
use super::packed::Packed;
use super::ranges::Ranges;
use crate::Vector;
use crate::base::numbers::id;
use crate::engine::array::Array;
use crate::engine::columns::Order;
use crate::engine::slabs::Rooms;
use crate::model::space::Space;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Levels {
    /// Levels in order of particle size, the smallest first.
    all: Vec<Level>,
    /// The level of each row.
    of_rows: Vec<u8>,
    /// The level of each particle. Empty if there is one level.
    of_particles: Array<u8>,
    /// For each row and level, the largest distance between the centres of a listed pair `[length]`; negative if such
    /// pairs never meet.
    reaches: Vec<f64>,
}

/// The particles of similar size.
#[derive(Debug, Clone, Serialize, Deserialize)]
struct Level {
    cells: Packed,
    /// Number of particles when the cells were made, and now.
    sorted: usize,
    held: usize,
}

impl Level {
    fn empty(cells: Packed, sorted: usize) -> Self {
        Self { cells, sorted, held: 0 }
    }
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
        let of_rows = ranges.levels().to_vec();
        let count = ranges.level_count();
        let occurring =
            |level: usize| ranges.occurring().filter(move |&row| usize::from(ranges.levels()[row]) == level);
        let of_row = |row: usize, level: usize| occurring(level).map(|b| reach_of(row, b)).fold(-1.0, f64::max);
        let reaches = (0..of_rows.len()).flat_map(|row| (0..count).map(move |level| (row, level)));
        let reaches: Vec<f64> = reaches.map(|(row, level)| of_row(row, level)).collect();
        let level_of = |particle: usize| of_rows[rows.get(particle).map_or(0, |row| usize::from(*row))];
        let of_particles: Array<u8> = (0..positions.len()).filter(|_| count > 1).map(level_of).collect();
        let new = |level: usize| {
            let own = occurring(level).map(|row| reaches[row * count + level]).fold(0.0, f64::max);
            // Particles that do not meet particles of their level are found from other levels.
            let others = ranges.occurring().map(|row| reaches[row * count + level]).filter(|reach| *reach > 0.0);
            let own = if own > 0.0 { own } else { others.reduce(f64::min).unwrap_or(0.0) };
            if count == 1 {
                return Level::empty(Packed::new(space, own, positions), positions.len());
            }
            let here = positions.iter().zip(&of_particles).filter(|(_, other)| usize::from(**other) == level);
            let here: Vec<Vector> = here.map(|(position, _)| *position).collect();
            Level::empty(Packed::new(space, own, &here), here.len())
        };
        let mut levels = Self { all: (0..count).map(new).collect(), of_rows, of_particles, reaches };
        levels.put_all(positions);
        levels
    }

    /// Whether the number of particles on any level has changed much since the cells were made.
    pub fn are_outgrown(&self, is_outgrown: impl Fn(usize, usize) -> bool) -> bool {
        self.all.iter().any(|level| is_outgrown(level.held, level.sorted))
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
            all: self.all.iter().map(|level| Level::empty(level.cells.emptied(), level.sorted)).collect(),
            of_rows: self.of_rows.clone(),
            of_particles: if is_single { Array::new() } else { order.permuted(&self.of_particles) },
            reaches: self.reaches.clone(),
        };
        levels.put_all(centres);
        levels
    }

    /// Checks data from a file.
    #[must_use]
    pub fn is_sound(&self, particles: usize, rows: usize) -> bool {
        let count = self.all.len();
        let exist = |levels: &[u8]| levels.iter().all(|&level| usize::from(level) < count);
        self.of_rows.len() == rows
            && self.reaches.len() == rows * count
            && self.of_particles.len() == if count > 1 { particles } else { 0 }
            && exist(&self.of_rows)
            && exist(&self.of_particles)
            && self.all.iter().all(|level| level.cells.is_sound(particles))
    }

    /// Largest distance between the centres of a listed pair `[length]`.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        self.reaches.iter().copied().fold(0.0, f64::max)
    }

    #[inline]
    fn cells_of(&self, particle: u32) -> &Packed {
        &self.all[self.level_of(particle)].cells
    }

    #[inline]
    fn level_of(&self, particle: u32) -> usize {
        if self.of_particles.is_empty() { 0 } else { usize::from(self.of_particles[particle as usize]) }
    }

    pub fn lift(&mut self, particle: u32, centre: &Vector) {
        let level = self.level_of(particle);
        let level = &mut self.all[level];
        level.cells.lift(particle, centre);
        level.held = level.held.saturating_sub(1);
    }

    pub fn put(&mut self, particle: u32, centre: &Vector) {
        let level = self.level_of(particle);
        let level = &mut self.all[level];
        level.cells.put(particle, centre);
        level.held += 1;
    }

    /// Appends a particle.
    pub fn push(&mut self, particle: u32, centre: &Vector, row: u16) {
        if self.all.len() > 1 {
            debug_assert_eq!(id(self.of_particles.len()), particle);
            self.of_particles.push(self.of_rows[usize::from(row)]);
        }
        self.put(particle, centre);
    }

    /// Moves a particle to the level of another row. It must have been lifted.
    pub fn change_row(&mut self, particle: u32, row: u16) {
        if self.all.len() > 1 {
            self.of_particles[particle as usize] = self.of_rows[usize::from(row)];
        }
    }

    /// Finds all particles that may be listed for a particle at `centre` with the table row `row`, and others nearby.
    pub fn find_candidates(&self, centre: &Vector, row: u16, near: &mut Candidates) {
        near.clear();
        self.for_each_reach(row, |cells, reach| cells.add_candidates(centre, reach, near));
    }

    /// Finds all particles that may be listed for a particle at `centre` with the table row `row`. Returns true if all
    /// of them are certainly within the largest reach of the row. See [`Packed::add_within`].
    #[inline]
    pub fn find_within(&self, centre: &Vector, row: u16, wraps: bool, near: &mut Candidates) -> bool {
        near.clear();
        if let [only] = &self.all[..] {
            return only.cells.add_within(centre, self.reaches[usize::from(row)].max(0.0), wraps, near);
        }
        let mut are_certain = true;
        self.for_each_reach(row, |cells, reach| are_certain &= cells.add_within(centre, reach, wraps, near));
        are_certain
    }

    fn for_each_reach<'a>(&'a self, row: u16, mut visit: impl FnMut(&'a Packed, f64)) {
        let count = self.all.len();
        let reaches = &self.reaches[usize::from(row) * count..][..count];
        let reached = self.all.iter().zip(reaches).filter(|(_, reach)| **reach >= 0.0);
        reached.for_each(|(level, reach)| visit(&level.cells, *reach));
    }

    /// Width of the widest cells along an axis `[length]`.
    #[must_use]
    pub fn widest_cell(&self, axis: usize) -> f64 {
        self.all.iter().map(|level| level.cells.grid.width(axis)).fold(0.0, f64::max)
    }

    /// Makes room for one thread with `share` particles.
    pub fn make_room(&mut self, rooms: &mut Rooms, share: usize) {
        let wanted = share / 16 + 64;
        rooms.of_levels = self.all.iter_mut().map(|level| level.cells.make_room(wanted)).collect();
    }

    pub fn take_room(&mut self, rooms: &mut Rooms) {
        for (level, room) in self.all.iter_mut().zip(&mut rooms.of_levels) {
            level.cells.take_room(room);
        }
    }

    /// Turns a bitwise copy into cells in shared arrays, with the room of one thread.
    ///
    /// # Safety
    /// As for [`Array::become_alias`](crate::engine::array::Array::become_alias). The copy must not be dropped.
    pub unsafe fn become_alias(&mut self, rooms: &mut Rooms) {
        self.of_particles.become_alias();
        // SAFETY: the levels are copied bit by bit. Neither the copies nor the vector of the original are dropped here.
        unsafe {
            let mut all: Vec<Level> = self.all.iter().map(|level| std::ptr::read(level)).collect();
            for (level, room) in all.iter_mut().zip(std::mem::take(&mut rooms.of_levels)) {
                level.cells.become_alias(room);
            }
            std::ptr::write(&raw mut self.all, all);
        }
    }

    /// Returns the room of an alias. The alias has no levels afterwards.
    pub fn give_back(&mut self, rooms: &mut Rooms) {
        let levels = std::mem::take(&mut self.all).into_iter().map(std::mem::ManuallyDrop::new);
        rooms.of_levels = levels.map(|mut level| level.cells.give_back()).collect();
    }

    /// Whether the cells of a particle may need more memory.
    #[inline]
    pub fn are_short(&self, particle: u32) -> bool {
        self.cells_of(particle).is_short()
    }

    pub fn enlarge(&self) {
        self.all.iter().for_each(|level| level.cells.enlarge());
    }

    /// Prefetches the cells of a particle's own level around a centre.
    #[inline]
    pub fn prefetch_rows(&self, particle: u32, centre: &Vector) {
        let cells = self.cells_of(particle);
        cells.prefetch_rows(cells.home(centre));
    }

    /// Prefetches the first blocks of these cells. Call [`Self::prefetch_rows`] first.
    #[inline]
    pub fn prefetch_near(&self, particle: u32, centre: &Vector) {
        let cells = self.cells_of(particle);
        cells.prefetch_near(cells.home(centre));
    }
}

#[cfg(test)]
mod tests;
