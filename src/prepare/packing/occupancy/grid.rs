//! A grid of cells in a hash table. Memory use depends on the number of particles, not on the volume.

use super::Kind;
use crate::Vector;
use crate::base::numbers::trunc_to_i64;
use crate::model::space::{Boundary, Space};

/// Offsets to the adjacent cells, nearest first, because overlaps are most likely in the nearest cells.
const NEIGHBOURS: [[i64; 3]; 27] = neighbours();

const fn neighbours() -> [[i64; 3]; 27] {
    let mut sorted = [[0; 3]; 27];
    let (mut count, mut distance) = (0, 0);
    while distance <= 3 {
        let mut k = 0;
        while k < 27 {
            let offset = [k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1];
            if offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2] == distance {
                sorted[count] = offset;
                count += 1;
            }
            k += 1;
        }
        distance += 1;
    }
    sorted
}

const NONE: u32 = u32::MAX;

pub(super) struct Taken {
    pub(super) position: Vector,
    pub(super) kind: Kind,
    next: u32,
}

impl Taken {
    pub(super) fn new(position: Vector, kind: Kind) -> Self {
        Self { position, kind, next: NONE }
    }
}

pub(super) struct Grid<'a> {
    space: &'a Space,
    pub(super) periods: Vector,
    edge: Vector,
    /// Number of cells along each periodic axis; 0 along other axes.
    around: [i64; 3],
    /// Number of cells to search in either direction along each axis: 1, or 0 if there is only one cell.
    reach: [i64; 3],
    /// Longest contact distance of each species `[length]`.
    pub(super) ranges: Vec<f64>,
    /// Contacts up to this distance are always in adjacent cells `[length]`.
    finest: f64,
    heads: Vec<u32>,
    members: Vec<u32>,
}

impl<'a> Grid<'a> {
    /// Creates an empty grid. Contacts up to the distance `cell` are always in adjacent cells.
    pub(super) fn new(space: &'a Space, cell: f64, ranges: Vec<f64>, capacity: usize) -> Self {
        let mut edge = Vector::repeat(cell);
        let (mut around, mut reach) = ([0; 3], [1; 3]);
        for k in 0..3 {
            match space.boundary[k] {
                Boundary::Flat => reach[k] = 0,
                Boundary::Periodic => {
                    let cells = (space.size[k] / cell).floor().clamp(1.0, f64::from(1_u32 << 30));
                    edge[k] = space.size[k] / cells;
                    around[k] = trunc_to_i64(cells);
                    reach[k] = i64::from(cells > 1.0);
                }
                Boundary::Bounded { .. } => {}
            }
        }
        Self {
            space,
            periods: space.periods(),
            edge,
            around,
            reach,
            ranges,
            finest: cell,
            heads: vec![NONE; (2 * capacity.max(8)).next_power_of_two()],
            members: Vec::with_capacity(capacity),
        }
    }

    pub(super) fn take(&mut self, number: u32, taken: &mut [Taken]) {
        self.members.push(number);
        if 2 * self.members.len() <= self.heads.len() {
            self.link(number, taken);
            return;
        }
        self.heads = vec![NONE; 2 * self.heads.len()];
        for member in 0..self.members.len() {
            self.link(self.members[member], taken);
        }
    }

    fn link(&mut self, number: u32, taken: &mut [Taken]) {
        let bucket = self.bucket(self.cell(&taken[number as usize].position));
        taken[number as usize].next = self.heads[bucket];
        self.heads[bucket] = number;
    }

    /// Calls `found` for all particles within `range`, and for some other particles. Returns the first result.
    pub(super) fn find<T>(
        &self,
        taken: &[Taken],
        position: &Vector,
        range: f64,
        found: impl Fn(u32) -> Option<T>,
    ) -> Option<T> {
        if range > self.finest {
            return self.find_far(taken, position, range, found);
        }
        let cell = self.cell(position);
        let within = self.within(position);
        // The factor covers round-off.
        let longest_squared = range * range * (1.0 + 1e-6);
        // Cache misses overlap if the heads of all lists are loaded before the search.
        let (mut lists, mut count) = ([NONE; NEIGHBOURS.len()], 0);
        for offset in &NEIGHBOURS {
            let mut squared = 0.0;
            let mut is_reached = true;
            for k in 0..3 {
                let away = match offset[k] {
                    0 => 0.0,
                    1 => 1.0 - within[k],
                    _ => within[k],
                } * self.edge[k];
                squared += away * away;
                is_reached &= offset[k].abs() <= self.reach[k];
            }
            if !is_reached || squared > longest_squared {
                continue;
            }
            let neighbour = [0, 1, 2].map(|k| cell[k].wrapping_add(offset[k]));
            lists[count] = self.heads[self.bucket(self.wrap(neighbour))];
            count += 1;
        }
        lists[..count].iter().find_map(|&first| find_in(taken, first, &found))
    }

    /// Searches all cells within `range`. Searches all particles if there are fewer particles than cells.
    fn find_far<T>(
        &self,
        taken: &[Taken],
        position: &Vector,
        range: f64,
        found: impl Fn(u32) -> Option<T>,
    ) -> Option<T> {
        let steps = [0, 1, 2].map(|k| if self.reach[k] == 0 { 0.0 } else { (range / self.edge[k]).ceil() + 1.0 });
        let cells: f64 = steps.iter().map(|steps| 2.0 * steps + 1.0).product();
        if cells > self.members.len() as f64 {
            return self.members.iter().find_map(|&number| found(number));
        }
        let cell = self.cell(position);
        let steps = steps.map(trunc_to_i64);
        let along = |k: usize| -steps[k]..=steps[k];
        along(0).flat_map(|x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z]))).find_map(|offset| {
            let there = [0, 1, 2].map(|k| cell[k].wrapping_add(offset[k]));
            find_in(taken, self.heads[self.bucket(self.wrap(there))], &found)
        })
    }

    fn within(&self, position: &Vector) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let along = (position[k] - self.space.lower[k]) / self.edge[k];
            along - along.floor()
        })
    }

    fn cell(&self, position: &Vector) -> [i64; 3] {
        let along = |k: usize| trunc_to_i64(((position[k] - self.space.lower[k]) / self.edge[k]).floor());
        self.wrap([along(0), along(1), along(2)])
    }

    fn wrap(&self, mut cell: [i64; 3]) -> [i64; 3] {
        for (index, &around) in cell.iter_mut().zip(&self.around) {
            if around > 0 && !(0..around).contains(index) {
                *index = index.rem_euclid(around);
            }
        }
        cell
    }

    /// Returns the hash of a cell. Adjacent cells along x share cache lines.
    fn bucket(&self, [x, y, z]: [i64; 3]) -> usize {
        let key = x.wrapping_add(y.wrapping_mul(8_191)).wrapping_add(z.wrapping_mul(67_867_967));
        #[expect(clippy::cast_possible_truncation, reason = "the lowest bits of a hash")]
        let hash = key as u64 as usize;
        hash & (self.heads.len() - 1)
    }
}

fn find_in<T>(taken: &[Taken], first: u32, found: &impl Fn(u32) -> Option<T>) -> Option<T> {
    let mut number = first;
    while number != NONE {
        let found = found(number);
        if found.is_some() {
            return found;
        }
        number = taken[number as usize].next;
    }
    None
}
