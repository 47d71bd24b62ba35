//! A grid of cells no smaller than the longest interaction range.
//!
//! Along axes that are not periodic, the outermost cells extend to infinity.

use super::divisor::Divisor;
use crate::Vector;
use crate::base::numbers::trunc_to_u32;
use crate::model::space::{Boundary, Face, Space};
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A face through which a particle leaves its cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct CellFace {
    /// Index of the axis normal to the face: 0, 1 or 2.
    pub axis: u8,
    pub is_upper: bool,
}

impl CellFace {
    /// Returns 1 if the direction into the cell is along the axis, otherwise -1.
    #[inline]
    #[must_use]
    pub fn inwards(self) -> f64 {
        if self.is_upper { -1.0 } else { 1.0 }
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Grid {
    counts: [u32; 3],
    by: [Divisor; 2],
    is_periodic: [bool; 3],
    lower: Vector,
    side: Vector,
}

/// A block of cells, given by its first cell and its number of cells along each axis. Along periodic axes, the block
/// may wrap around from the last cell to the first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Window {
    first: [u32; 3],
    count: [u32; 3],
}

/// Cells that a search visits.
pub trait Region {
    /// Calls `visit(first, count)` for runs of consecutive cells, which together are the region.
    fn for_each_run(&self, grid: &Grid, visit: impl FnMut(usize, usize));
}

/// A cell and all adjacent cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Around(pub u32);

impl Region for Around {
    #[inline(always)]
    fn for_each_run(&self, grid: &Grid, visit: impl FnMut(usize, usize)) {
        grid.for_each_run(self.0, visit);
    }
}

impl Region for Window {
    #[inline(always)]
    fn for_each_run(&self, grid: &Grid, visit: impl FnMut(usize, usize)) {
        grid.for_each_run_in(self, visit);
    }
}

/// With more cells along a periodic axis, particles in adjacent cells can only meet in their nearest image. With
/// exactly this number, two images may be equally near, because particles can be half a period apart.
const UNAMBIGUOUS: u32 = 4;

/// Cells are wider than the interaction range by this factor, because positions have round-off.
const MARGIN: f64 = 1.0 + 1e-6;

impl Grid {
    /// Creates a grid over `space` for interactions up to `range` `[length]`. At open faces, the grid extends to all
    /// `positions`.
    ///
    /// The grid ends at walls. Static particles beyond a wall are assigned to the outermost cells at the wall.
    ///
    /// Cells are no smaller than `finest` times the mean distance of particles. `finest` has one number each for one,
    /// two and three dimensions. Except in small systems, there are at most `most` cells per particle.
    #[must_use]
    pub fn new(space: &Space, range: f64, positions: &[Vector], finest: [f64; 3], most: f64) -> Self {
        let is_periodic = space.boundary.map(|b| b == Boundary::Periodic);
        let (mut lower, mut upper) = (space.lower, space.upper());
        for position in positions {
            for k in 0..3 {
                let Boundary::Bounded { lower: low, upper: high } = space.boundary[k] else { continue };
                if low == Face::Open {
                    lower[k] = lower[k].min(position[k]);
                }
                if high == Face::Open {
                    upper[k] = upper[k].max(position[k]);
                }
            }
        }
        let extent = upper - lower;
        let most = most * positions.len() as f64 + 64.0;
        let moving = (0..3).filter(|&k| extent[k] > 0.0);
        let volume_each = moving.clone().map(|k| extent[k]).product::<f64>() / positions.len() as f64;
        let spacing = match moving.count() {
            3 => finest[2] * libm::cbrt(volume_each),
            2 => finest[1] * volume_each.sqrt(),
            _ => finest[0] * volume_each,
        };
        let mut target = (range * MARGIN).max(spacing);
        let counts = loop {
            let counts = std::array::from_fn(|k| {
                let fit = |side: f64| if side > 0.0 { (extent[k] / side).floor() } else { 0.0 };
                // In systems of few particles, cells could be so large that pairs must be tested in several images. If
                // the range permits, this minimum number of cells avoids such tests.
                let few = if is_periodic[k] { fit(range * MARGIN).min(f64::from(UNAMBIGUOUS)) } else { 1.0 };
                fit(target).max(few).clamp(1.0, f64::from(u32::MAX))
            });
            let [nx, ny, nz]: [f64; 3] = counts;
            if nx * ny * nz <= most {
                break counts.map(trunc_to_u32);
            }
            target = if target > 0.0 { target * 1.05 } else { extent.max() / most };
        };
        Self {
            counts,
            by: [Divisor::new(counts[0]), Divisor::new(counts[1])],
            is_periodic,
            lower,
            side: Vector::from_fn(|k, _| extent[k] / f64::from(counts[k])),
        }
    }

    /// Checks data from a file.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        let [x, y, z] = self.counts;
        let count = x.checked_mul(y).and_then(|plane| plane.checked_mul(z));
        count.is_some_and(|count| count > 0) && self.by == [Divisor::new(x), Divisor::new(y)]
    }

    #[must_use]
    pub fn count(&self) -> usize {
        self.counts.iter().map(|&n| n as usize).product()
    }

    /// Returns the cell beyond a face, and the number of periods to add to the coordinate of a particle that enters the
    /// cell. `None` at the end of an axis that is not periodic.
    #[inline]
    #[must_use]
    pub fn behind(&self, cell: u32, face: CellFace) -> Option<(u32, i32)> {
        let mut at = self.split(cell);
        let axis = usize::from(face.axis);
        let (index, wrap) = self.beyond(axis, at[axis], face.is_upper)?;
        at[axis] = index;
        Some((self.join(at), wrap))
    }

    /// Calls `visit(first, count)` for runs of consecutive cells, which together cover a cell and all adjacent cells.
    #[inline(always)]
    pub fn for_each_run(&self, cell: u32, mut visit: impl FnMut(usize, usize)) {
        let at = self.split(cell);
        let strides = [1, self.counts[0], self.counts[0] * self.counts[1]];
        if (0..3).all(|axis| self.is_inner(axis, at[axis])) {
            let first = cell - strides[2] - strides[1] - 1;
            for z in 0..3 {
                for y in 0..3 {
                    visit((first + z * strides[2] + y * strides[1]) as usize, 3);
                }
            }
            return;
        }
        let (zs, nz) = self.around(2, at[2]);
        let (ys, ny) = self.around(1, at[1]);
        let (xs, nx) = self.around(0, at[0]);
        for &z in &zs[..nz] {
            for &y in &ys[..ny] {
                for &x in &xs[..nx] {
                    visit((z * strides[2] + y * strides[1] + x) as usize, 1);
                }
            }
        }
    }

    /// Returns the cells that contain all positions within `radius` of `centre`. Along a periodic axis, the window may
    /// include all cells, but it never includes a cell twice.
    #[must_use]
    pub fn window(&self, centre: &Vector, radius: f64) -> Window {
        let radius = radius * MARGIN;
        let along = |k: usize| -> [u32; 2] {
            let n = self.counts[k];
            let [low, high] = [centre[k] - radius, centre[k] + radius].map(|at| {
                let index = ((at - self.lower[k]) / self.side[k]).floor();
                // On flat axes, 0/0 is NaN, which becomes the first cell.
                if self.is_periodic[k] { index } else { index.clamp(0.0, f64::from(n - 1)) }
            });
            let count = high - low + 1.0;
            if n == 1 || count.is_nan() || count >= f64::from(n) {
                return [0, n];
            }
            // The window begins less than a period below the box.
            let first = if low < 0.0 { low + f64::from(n) } else { low };
            [trunc_to_u32(first) % n, trunc_to_u32(count)]
        };
        let along = [0, 1, 2].map(along);
        Window { first: along.map(|[first, _]| first), count: along.map(|[_, count]| count) }
    }

    /// Calls `visit(first, count)` for runs of consecutive cells, which together are a window.
    #[inline(always)]
    fn for_each_run_in(&self, window: &Window, mut visit: impl FnMut(usize, usize)) {
        let [nx, ny, nz] = self.counts;
        let (first, count) = (window.first, window.count);
        let until_end = count[0].min(nx - first[0]);
        for z in first[2]..first[2] + count[2] {
            for y in first[1]..first[1] + count[1] {
                let row = self.join([0, y % ny, z % nz]);
                visit((row + first[0]) as usize, until_end as usize);
                if count[0] > until_end {
                    visit(row as usize, (count[0] - until_end) as usize);
                }
            }
        }
    }

    /// Calls `visit` for runs of consecutive cells, which together cover a cell and all adjacent cells. A run is one
    /// cell, or a row along x.
    ///
    /// If images slide past each other, every cell of a row beyond a sliding side may be adjacent.
    pub fn for_each_row(&self, cell: u32, is_sliding: bool, mut visit: impl FnMut(Range<u32>)) {
        let at = self.split(cell);
        let [(xs, nx), (ys, ny), (zs, nz)] = [0, 1, 2].map(|axis| self.around(axis, at[axis]));
        for &z in &zs[..nz] {
            for &y in &ys[..ny] {
                let first = self.join([0, y, z]);
                if is_sliding && (self.counts[1] < 3 || at[1].abs_diff(y) > 1) {
                    visit(first..first + self.counts[0]);
                    continue;
                }
                xs[..nx].iter().for_each(|&x| visit(first + x..first + x + 1));
            }
        }
    }

    /// Calls `visit` for each cell adjacent to `cell` that was not adjacent to the previous cell of a particle. The
    /// particle leaves the previous cell through `face`.
    #[inline(always)]
    pub fn for_each_new(&self, cell: u32, face: CellFace, mut visit: impl FnMut(u32)) {
        let at = self.split(cell);
        let axis = usize::from(face.axis);
        let n = self.counts[axis];
        if self.is_periodic[axis] && n <= 3 {
            return; // all cells along the axis were adjacent
        }
        let Some((ahead, _)) = self.beyond(axis, at[axis], face.is_upper) else { return };
        let (others_a, others_b) = ((axis + 1) % 3, (axis + 2) % 3);
        let stride = [1, self.counts[0], self.counts[0] * self.counts[1]];
        let start = ahead * stride[axis];
        if self.is_inner(others_a, at[others_a]) && self.is_inner(others_b, at[others_b]) {
            let (a, b) = (stride[others_a], stride[others_b]);
            let first = start + (at[others_a] - 1) * a + (at[others_b] - 1) * b;
            for i in 0..3 {
                (0..3).for_each(|j| visit(first + i * a + j * b));
            }
            return;
        }
        let (aa, na) = self.around(others_a, at[others_a]);
        let (bb, nb) = self.around(others_b, at[others_b]);
        for &a in &aa[..na] {
            for &b in &bb[..nb] {
                visit(start + a * stride[others_a] + b * stride[others_b]);
            }
        }
    }

    #[must_use]
    pub fn counts(&self) -> [u32; 3] {
        self.counts
    }

    /// Returns the displacements of images, except the nearest, in which a pair can meet before a cell transition.
    ///
    /// The list is empty unless a periodic axis has fewer than four cells. Between two predictions of a pair, each
    /// particle travels at most one cell. The list therefore contains images one period away along axes of two to four
    /// cells, and up to two periods away along axes of one cell. For four cells, see [`Self::tied_axes`].
    #[must_use]
    pub fn further_images(&self, periods: &Vector) -> Vec<Vector> {
        let mut images = vec![Vector::zeros()];
        if (0..3).all(|axis| !self.is_periodic[axis] || self.counts[axis] >= UNAMBIGUOUS) {
            return Vec::new();
        }
        for axis in 0..3 {
            let most = match self.counts[axis] {
                _ if !self.is_periodic[axis] => 0,
                1 => 2,
                2..=UNAMBIGUOUS => 1,
                _ => 0,
            };
            images = images
                .iter()
                .flat_map(|image| {
                    (-most..=most).map(move |k: i32| {
                        let mut shifted = *image;
                        if k != 0 {
                            shifted[axis] += f64::from(k) * periods[axis];
                        }
                        shifted
                    })
                })
                .collect();
        }
        images.retain(|image| *image != Vector::zeros());
        images
    }

    /// Returns the periodic axes with exactly four cells. Along such an axis, particles in adjacent cells can be half a
    /// period apart, so two images are equally near.
    #[must_use]
    pub fn tied_axes(&self) -> [bool; 3] {
        std::array::from_fn(|axis| self.is_periodic[axis] && self.counts[axis] == UNAMBIGUOUS)
    }

    /// Returns the cell of a position.
    #[must_use]
    pub fn cell_at(&self, position: &Vector) -> u32 {
        let index = |k: usize| {
            let at = (position[k] - self.lower[k]) / self.side[k];
            // The conversion saturates. Positions outside the grid are in the outermost cells. On flat axes, 0/0 is
            // NaN, which becomes the first cell.
            trunc_to_u32(at).min(self.counts[k] - 1)
        };
        self.join([index(0), index(1), index(2)])
    }

    #[inline]
    #[must_use]
    pub fn index_along(&self, cell: u32, axis: usize) -> u32 {
        self.split(cell)[axis]
    }

    /// Coordinate of the middle of a cell `[length]`.
    #[inline]
    #[must_use]
    pub fn middle(&self, cell: u32, axis: usize) -> f64 {
        self.lower[axis] + (f64::from(self.index_along(cell, axis)) + 0.5) * self.side[axis]
    }

    /// Width of a cell `[length]`.
    #[must_use]
    pub fn width(&self, axis: usize) -> f64 {
        self.side[axis]
    }

    #[inline]
    fn join(&self, [x, y, z]: [u32; 3]) -> u32 {
        (z * self.counts[1] + y) * self.counts[0] + x
    }

    #[inline]
    fn split(&self, cell: u32) -> [u32; 3] {
        let [yz, x] = self.by[0].divide(cell);
        let [z, y] = self.by[1].divide(yz);
        [x, y, z]
    }

    /// Whether a cell has adjacent cells on both sides along an axis, without wrapping around.
    #[inline]
    fn is_inner(&self, axis: usize, index: u32) -> bool {
        index.wrapping_sub(1) < self.counts[axis].saturating_sub(2)
    }

    /// Returns the indices of a cell and of its adjacent cells along an axis, and the number of these cells.
    #[inline]
    fn around(&self, axis: usize, index: u32) -> ([u32; 3], usize) {
        let n = self.counts[axis];
        if self.is_periodic[axis] {
            match n {
                1 => ([0; 3], 1),
                2 => ([0, 1, 0], 2),
                _ => {
                    let before = if index == 0 { n - 1 } else { index - 1 };
                    let after = if index + 1 == n { 0 } else { index + 1 };
                    ([before, index, after], 3)
                }
            }
        } else {
            let first = index.saturating_sub(1);
            let last = (index + 1).min(n - 1);
            ([first, first + 1, first + 2], (last - first + 1) as usize)
        }
    }

    /// Like [`Self::behind`], for the index of a cell along one axis.
    #[inline]
    fn beyond(&self, axis: usize, index: u32, is_upper: bool) -> Option<(u32, i32)> {
        let last = self.counts[axis] - 1;
        match (is_upper, self.is_periodic[axis]) {
            (true, _) if index < last => Some((index + 1, 0)),
            (false, _) if index > 0 => Some((index - 1, 0)),
            (true, true) => Some((0, -1)),
            (false, true) => Some((last, 1)),
            _ => None,
        }
    }

    /// Calls `visit(face, coordinate)` for the faces through which a particle can leave its cell.
    #[inline]
    pub fn for_each_face(&self, cell: u32, mut visit: impl FnMut(CellFace, f64)) {
        let at = self.split(cell);
        for (axis, index) in at.into_iter().enumerate() {
            let n = self.counts[axis];
            #[expect(clippy::cast_possible_truncation, reason = "one of three axes")]
            let face = |is_upper| CellFace { axis: axis as u8, is_upper };
            if self.is_periodic[axis] || index > 0 {
                visit(face(false), self.lower[axis] + f64::from(index) * self.side[axis]);
            }
            if self.is_periodic[axis] || index + 1 < n {
                visit(face(true), self.lower[axis] + f64::from(index + 1) * self.side[axis]);
            }
        }
    }

    /// Calls `visit(face, coordinate)` for the faces that a particle with constant velocity approaches.
    #[inline]
    pub fn for_each_face_ahead(&self, cell: u32, velocity: &Vector, mut visit: impl FnMut(CellFace, f64)) {
        let at = self.split(cell);
        for (axis, index) in at.into_iter().enumerate() {
            let is_upper = velocity[axis] > 0.0;
            let last = if is_upper { self.counts[axis] - 1 } else { 0 };
            if velocity[axis] != 0.0 && (self.is_periodic[axis] || index != last) {
                let line = f64::from(index + u32::from(is_upper));
                #[expect(clippy::cast_possible_truncation, reason = "one of three axes")]
                let face = CellFace { axis: axis as u8, is_upper };
                visit(face, self.lower[axis] + line * self.side[axis]);
            }
        }
    }

    /// Returns the cell of a particle that has crossed a sliding side. The cell is in the first or last row along the
    /// gradient, and has the index of the cell `along` in the direction of the flow.
    #[must_use]
    pub fn slid(&self, cell: u32, along: u32, [flow, gradient]: [usize; 2], is_last: bool) -> u32 {
        let mut at = self.split(cell);
        at[flow] = self.split(along)[flow];
        at[gradient] = if is_last { self.counts[gradient] - 1 } else { 0 };
        self.join(at)
    }

    /// Calls `visit` for the adjacent cells beyond a sliding side, including all cells along the flow.
    pub fn for_each_across(&self, cell: u32, [flow, gradient]: [usize; 2], mut visit: impl FnMut(u32)) {
        let mut at = self.split(cell);
        let last = self.counts[gradient] - 1;
        at[gradient] = match at[gradient] {
            0 => last,
            index if index == last => 0,
            _ => return,
        };
        let third = 3 - flow - gradient;
        let (around, count) = self.around(third, at[third]);
        for &index in &around[..count] {
            at[third] = index;
            for index in 0..self.counts[flow] {
                at[flow] = index;
                visit(self.join(at));
            }
        }
    }

    /// Returns the lower and the upper corner of a cell. Coordinates of unbounded cells are infinite.
    #[must_use]
    pub fn bounds(&self, cell: u32) -> [Vector; 2] {
        let mut bounds = [Vector::repeat(f64::NEG_INFINITY), Vector::repeat(f64::INFINITY)];
        self.for_each_face(cell, |face, at| bounds[usize::from(face.is_upper)][usize::from(face.axis)] = at);
        bounds
    }

    /// Returns two flags: the cell is the first along an axis, the cell is the last.
    #[inline]
    #[must_use]
    pub fn is_outermost(&self, cell: u32, axis: usize) -> [bool; 2] {
        let index = self.split(cell)[axis];
        [index == 0, index + 1 == self.counts[axis]]
    }
}
