//! Centres of Verlet lists, packed in blocks of eight. A search tests the centres of a block at once.
//!
//! Packed centres have single precision. A search finds all particles that *may* be within reach. If single precision
//! is not sufficient, all particles found are tested again in double precision, see [`super::verlet::VerletLists`].

use super::candidates::Candidates;
use super::cells::NO_PARTICLE;
use super::grid::{Around, Grid, Region};
use crate::Vector;
use crate::base::numbers::{id, single};
use crate::engine::array::Array;
use crate::engine::hardware::pages::enlarge;
use crate::engine::hardware::prefetch::{prefetch, prefetch_both};
use crate::model::space::{Boundary, Space};
use crate::physics::detection::lanes::Simd;
use serde::{Deserialize, Serialize};

const LANES: usize = 8;

/// Marks the end of a linked list of blocks.
const NONE: u32 = u32::MAX;

/// Rounding error of numbers near 1 in single precision.
const ROUNDING: f64 = 0.5 * f32::EPSILON as f64;

/// Larger coordinates are not tested, because their squares could overflow in single precision.
const FAR: f64 = 1e15;

/// Cells are as small as the reach permits, but there is at most about one cell per particle.
const FINEST: [f64; 3] = [0.0; 3];
const CELLS_PER_PARTICLE: f64 = 1.0;

/// If the reach of a search is below this fraction of the reach of the cells, a window is smaller than the block of
/// adjacent cells.
const SHORT_REACH: f64 = 0.8;

/// Eight centres in one cell. The x coordinate of unused places is NaN.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[repr(C, align(64))]
struct Block {
    at: [[f32; LANES]; 3],
    ids: [u32; LANES],
}

impl Block {
    const EMPTY: Self = Self { at: [[f32::NAN; LANES]; 3], ids: [NO_PARTICLE; LANES] };
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Packed {
    /// Cells no smaller than the reach.
    pub grid: Grid,
    /// The reach for which the cells were made `[length]`.
    reach: f64,
    /// First block of each cell.
    first: Array<u32>,
    blocks: Array<Block>,
    /// For each block, the next block of the same cell.
    next: Array<u32>,
    free: Vec<u32>,
    /// Periods of the box; infinite along axes that are not periodic.
    periods: [f32; 3],
    /// Largest absolute coordinate of the box along periodic axes `[length]`.
    scale: f64,
    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "other processors have no AVX2"))]
    #[serde(skip, default = "Simd::most")]
    width: Simd,
}

/// The sphere in which a search finds centres.
#[derive(Debug, Clone, Copy)]
struct Ball {
    centre: [f32; 3],
    /// Squared radius, increased by the rounding errors of single precision.
    squared: f32,
    /// Squared radius, decreased by the rounding errors. Centres inside are certainly within reach.
    certain: f32,
    periods: [f32; 3],
}

impl Packed {
    /// Creates empty cells for centres at about `positions` and a given reach `[length]`.
    #[must_use]
    pub fn new(space: &Space, reach: f64, positions: &[Vector]) -> Self {
        let grid = Grid::new(space, reach, positions, FINEST, CELLS_PER_PARTICLE);
        let corner = |k: usize| space.lower[k].abs().max(space.upper()[k].abs());
        let periodic = (0..3).filter(|&k| space.boundary[k] == Boundary::Periodic);
        Self {
            first: vec![NONE; grid.count()].into(),
            blocks: Array::new(),
            next: Array::new(),
            free: Vec::new(),
            periods: space.periods().map(single).into(),
            scale: periodic.map(corner).fold(0.0, f64::max),
            width: Simd::most(),
            reach,
            grid,
        }
    }

    /// Returns the same cells without particles.
    #[must_use]
    pub fn emptied(&self) -> Self {
        Self {
            grid: self.grid.clone(),
            first: vec![NONE; self.grid.count()].into(),
            blocks: Array::new(),
            next: Array::new(),
            free: Vec::new(),
            ..*self
        }
    }

    /// Checks data from a file. Each block must be free or in one cell, and all particle numbers must be valid.
    #[must_use]
    pub fn is_sound(&self, particles: usize) -> bool {
        let mut is_used = vec![false; self.blocks.len()];
        let mut take = |at: u32| is_used.get_mut(at as usize).is_some_and(|is_used| !std::mem::replace(is_used, true));
        if !self.grid.is_sound() || self.first.len() != self.grid.count() || self.next.len() != self.blocks.len() {
            return false;
        }
        for &first in &self.first {
            let mut at = first;
            while at != NONE {
                if !take(at) {
                    return false;
                }
                at = self.next[at as usize];
            }
        }
        let mut lanes = self.blocks.iter().flat_map(|block| block.ids.into_iter().zip(block.at[0]));
        self.free.iter().all(|&at| take(at))
            && lanes.all(|(id, x)| if id == NO_PARTICLE { x.is_nan() } else { (id as usize) < particles })
    }

    /// Returns free blocks for one thread.
    pub fn make_room(&mut self, blocks: usize) -> Vec<u32> {
        let mut room = self.free.split_off(self.free.len().saturating_sub(blocks));
        let (first, more) = (self.blocks.len(), blocks - room.len());
        self.blocks.change(|all| all.resize(first + more, Block::EMPTY));
        self.next.change(|all| all.resize(first + more, NONE));
        room.extend(id(first)..id(first + more));
        room
    }

    pub fn take_room(&mut self, room: &mut Vec<u32>) {
        self.free.append(room);
    }

    /// Turns a bitwise copy into cells in shared arrays, with the room of one thread.
    ///
    /// # Safety
    /// As for [`Array::become_alias`](crate::engine::array::Array::become_alias). The copy must not be dropped.
    pub unsafe fn become_alias(&mut self, room: Vec<u32>) {
        for array in [&mut self.first, &mut self.next] {
            array.become_alias();
        }
        self.blocks.become_alias();
        // SAFETY: the vector belongs to the original, so it is not dropped here.
        unsafe { std::ptr::write(&raw mut self.free, room) };
    }

    pub fn give_back(&mut self) -> Vec<u32> {
        std::mem::take(&mut self.free)
    }

    /// Whether there is no free block.
    #[inline]
    pub fn is_short(&self) -> bool {
        self.free.is_empty()
    }

    pub fn enlarge(&self) {
        enlarge(&self.first);
        enlarge(&self.blocks);
        enlarge(&self.next);
    }

    pub fn lift(&mut self, particle: u32, centre: &Vector) {
        let cell = self.home(centre);
        let (mut before, mut at) = (NONE, self.first[cell as usize]);
        while at != NONE {
            let block = &mut self.blocks[at as usize];
            let next = self.next[at as usize];
            if let Some(lane) = block.ids.iter().position(|id| *id == particle) {
                block.ids[lane] = NO_PARTICLE;
                block.at[0][lane] = f32::NAN;
                if block.ids == [NO_PARTICLE; LANES] {
                    let link =
                        if before == NONE { &mut self.first[cell as usize] } else { &mut self.next[before as usize] };
                    *link = next;
                    self.free.push(at);
                }
                return;
            }
            (before, at) = (at, next);
        }
    }

    pub fn put(&mut self, particle: u32, centre: &Vector) {
        let cell = self.home(centre);
        let mut at = self.first[cell as usize];
        while at != NONE {
            if let Some(lane) = self.blocks[at as usize].ids.iter().position(|id| *id == NO_PARTICLE) {
                return self.write(particle, at, lane, centre);
            }
            at = self.next[at as usize];
        }
        let next = self.first[cell as usize];
        let at = if let Some(free) = self.free.pop() {
            self.next[free as usize] = next;
            free
        } else {
            self.next.push(next);
            self.blocks.push(Block::EMPTY);
            id(self.next.len() - 1)
        };
        self.first[cell as usize] = at;
        self.write(particle, at, 0, centre);
    }

    #[inline]
    fn write(&mut self, particle: u32, at: u32, lane: usize, centre: &Vector) {
        let block = &mut self.blocks[at as usize];
        block.ids[lane] = particle;
        for k in 0..3 {
            block.at[k][lane] = single(centre[k]);
        }
    }

    #[inline]
    #[must_use]
    pub fn home(&self, centre: &Vector) -> u32 {
        self.grid.cell_at(centre)
    }

    /// Adds all particles with centres within `reach`, and others nearby.
    pub fn add_candidates(&self, centre: &Vector, reach: f64, near: &mut Candidates) {
        let mut put = |block: &Block| {
            for id in block.ids {
                near.put(id);
            }
        };
        if self.has_cells_for(reach) {
            self.for_each_block(Around(self.home(centre)), &mut put);
        } else {
            self.for_each_block(self.grid.window(centre, reach), &mut put);
        }
    }

    /// Whether the adjacent cells are the right region for a search within `reach`. If not, the search visits the cells
    /// of a window.
    #[inline]
    fn has_cells_for(&self, reach: f64) -> bool {
        reach <= self.reach && reach > SHORT_REACH * self.reach
    }

    /// Returns the largest rounding error of a distance up to `reach`; infinite beyond [`FAR`].
    ///
    /// Coordinates, differences and periods are rounded. In units of `ROUNDING * scale`, the errors add up to less than
    /// 8 along each axis, and to less than 14 in three dimensions.
    #[inline]
    fn slack(&self, reach: f64, centre: &Vector) -> f64 {
        let scale = self.scale.max(centre.amax()) + reach;
        if scale >= FAR { f64::INFINITY } else { 14.0 * ROUNDING * scale }
    }

    /// Adds all particles with centres within `reach`. May also add particles that are farther away by about twice
    /// [`Self::slack`]. Returns true if all particles added are certainly within reach.
    ///
    /// The sum of squares adds up to 4 rounding errors to the squared distance. The squared radii allow for 8.
    #[inline]
    pub fn add_within(&self, centre: &Vector, reach: f64, wraps: bool, near: &mut Candidates) -> bool {
        let slack = self.slack(reach, centre);
        if slack.is_infinite() {
            self.add_candidates(centre, reach, near);
            return false;
        }
        let (radius, inner) = (reach + slack, (reach - slack).max(0.0));
        let ball = Ball {
            centre: std::array::from_fn(|k| single(centre[k])),
            squared: single(radius * radius * (1.0 + 8.0 * ROUNDING)).next_up(),
            certain: single(inner * inner * (1.0 - 8.0 * ROUNDING)).next_down(),
            periods: self.periods,
        };
        if self.has_cells_for(reach) {
            self.add_in_ball(Around(self.home(centre)), &ball, wraps, near)
        } else {
            self.add_in_ball(self.grid.window(centre, radius), &ball, wraps, near)
        }
    }

    #[inline]
    fn add_in_ball(
        &self,
        region: impl Region,
        ball: &Ball,
        #[cfg_attr(not(target_arch = "x86_64"), expect(unused_variables, reason = "it makes AVX2 shorter"))]
        wraps: bool,
        near: &mut Candidates,
    ) -> bool {
        #[cfg(target_arch = "x86_64")]
        if self.width.has_avx2() {
            // SAFETY: the processor supports AVX2, as just checked.
            return unsafe { self.add_in_ball_avx2(region, ball, wraps, near) };
        }
        let mut are_certain = true;
        self.for_each_block(region, |block| {
            for lane in 0..LANES {
                let squared = ball.squared_distance(block, lane);
                if squared <= ball.squared {
                    near.put(block.ids[lane]);
                    are_certain &= squared <= ball.certain;
                }
            }
        });
        are_certain
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2")]
    fn add_in_ball_avx2(&self, region: impl Region, ball: &Ball, wraps: bool, near: &mut Candidates) -> bool {
        let mut are_certain = true;
        if wraps {
            self.for_each_block(region, |block| are_certain &= avx2::find_in_ball::<true>(block, ball, near));
        } else {
            self.for_each_block(region, |block| are_certain &= avx2::find_in_ball::<false>(block, ball, near));
        }
        are_certain
    }

    #[inline(always)]
    fn for_each_block(&self, region: impl Region, mut visit: impl FnMut(&Block)) {
        region.for_each_run(&self.grid, |first, count| {
            for &first in self.first.some(first..first + count) {
                let mut at = first;
                while at != NONE {
                    visit(&self.blocks[at as usize]);
                    at = self.next[at as usize];
                }
            }
        });
    }

    #[inline]
    pub fn prefetch_rows(&self, cell: u32) {
        self.grid.for_each_run(cell, |first, _| prefetch(&self.first, first));
    }

    /// Prefetches the first blocks in a cell and in the adjacent cells. Call [`Self::prefetch_rows`] first.
    #[inline]
    pub fn prefetch_near(&self, cell: u32) {
        self.grid.for_each_run(cell, |first, count| {
            for &at in self.first.some(first..first + count) {
                if at != NONE {
                    prefetch_both(&self.blocks, at as usize);
                    prefetch(&self.next, at as usize);
                }
            }
        });
    }
}

impl Ball {
    /// Squared distance from the centre of the ball, with the same operations as in the AVX2 version.
    #[inline]
    fn squared_distance(&self, block: &Block, lane: usize) -> f32 {
        let [x, y, z]: [f32; 3] = std::array::from_fn(|k| {
            let apart = (self.centre[k] - block.at[k][lane]).abs();
            let apart = apart.min((self.periods[k] - apart).abs());
            apart * apart
        });
        (x + y) + z
    }
}

#[cfg(target_arch = "x86_64")]
mod avx2 {
    use super::{Ball, Block, Candidates};
    use std::arch::x86_64::*;

    /// For each subset of the eight places in a block, the indices of these places, one byte each.
    const LANES_OF: [u64; 256] = {
        let mut lanes = [0_u64; 256];
        let mut set = 0;
        while set < 256 {
            let (mut lane, mut count) = (0, 0);
            while lane < 8 {
                if set >> lane & 1 == 1 {
                    lanes[set] |= lane << (8 * count);
                    count += 1;
                }
                lane += 1;
            }
            set += 1;
        }
        lanes
    };

    /// Appends the particles in the ball to `near`. Returns true if all of them are certainly within reach.
    #[target_feature(enable = "avx2")]
    #[inline]
    pub fn find_in_ball<const WRAPS: bool>(block: &Block, ball: &Ball, near: &mut Candidates) -> bool {
        let mut sum = _mm256_setzero_ps();
        for k in 0..3 {
            // SAFETY: the eight numbers that are loaded are a whole array.
            let there = unsafe { _mm256_loadu_ps(block.at[k].as_ptr()) };
            let mut apart = _mm256_sub_ps(_mm256_set1_ps(ball.centre[k]), there);
            if WRAPS {
                let sign = _mm256_set1_ps(-0.0);
                apart = _mm256_andnot_ps(sign, apart);
                let other = _mm256_andnot_ps(sign, _mm256_sub_ps(_mm256_set1_ps(ball.periods[k]), apart));
                apart = _mm256_min_ps(other, apart);
            }
            let square = _mm256_mul_ps(apart, apart);
            sum = if k == 0 { square } else { _mm256_add_ps(sum, square) };
        }
        let is_in = _mm256_cmp_ps::<_CMP_LE_OQ>(sum, _mm256_set1_ps(ball.squared));
        let set = _mm256_movemask_ps(is_in) as usize;
        let is_certain = _mm256_cmp_ps::<_CMP_LE_OQ>(sum, _mm256_set1_ps(ball.certain));
        let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(LANES_OF[set & 255].cast_signed()));
        let mut ids = [0; 8];
        // SAFETY: the eight numbers that are loaded or stored are a whole array.
        unsafe {
            let all = _mm256_loadu_si256(block.ids.as_ptr().cast());
            _mm256_storeu_si256(ids.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(all, lanes));
        }
        near.put_eight((ids, set.count_ones() as usize));
        _mm256_movemask_ps(is_certain) as usize == set
    }
}

#[cfg(test)]
mod tests;
