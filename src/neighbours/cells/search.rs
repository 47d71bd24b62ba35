//! The search in the cells around a particle's, and the look ahead at what it will touch.

use super::{Cells, Face, NOBODY};
use crate::neighbours::near::Near;
use crate::prefetch::prefetch;

impl Cells {
    /// Expects questions about the cell that a particle is in.
    #[inline]
    pub fn expect_home(&self, particle: u32) {
        prefetch(&self.homes, particle);
        prefetch(&self.next, particle);
    }

    /// Expects a search near a cell.
    #[inline]
    pub fn expect_rows(&self, cell: u32) {
        self.for_each_row(cell, |row, xs| prefetch(&self.first, row + xs[0]));
    }

    /// Expects a search near a cell, and questions about those it finds first.
    #[inline]
    pub fn expect_near(&self, cell: u32, expect: impl Fn(u32)) {
        self.for_each_row(cell, |row, xs| {
            for &x in xs {
                let particle = self.first[(row + x) as usize];
                if particle != NOBODY {
                    prefetch(&self.next, particle);
                    expect(particle);
                }
            }
        });
    }

    /// Calls `visit(row, xs)` for the rows of cells near a cell: the first cell of the whole row, and the indices in it.
    #[inline(always)]
    fn for_each_row(&self, cell: u32, mut visit: impl FnMut(u32, &[u32])) {
        let at = self.split(cell);
        let (zs, nz) = self.around(2, at[2]);
        let (ys, ny) = self.around(1, at[1]);
        let (xs, nx) = self.around(0, at[0]);
        for &z in &zs[..nz] {
            for &y in &ys[..ny] {
                visit((z * self.counts[1] + y) * self.counts[0], &xs[..nx]);
            }
        }
    }

    /// Puts every particle in `cell` and the cells next to it into `near`.
    #[inline]
    pub fn find_near(&self, cell: u32, near: &mut Near) {
        near.clear();
        self.for_each_row(cell, |row, xs| {
            for &x in xs {
                near.put(self.first[(row + x) as usize]);
            }
        });
        near.follow(&self.next);
    }

    /// Puts every particle that is near to `cell` and was not near to the cell before a transition through `face` into `near`.
    #[inline]
    pub fn find_new(&self, cell: u32, face: Face, near: &mut Near) {
        near.clear();
        self.for_each_new(cell, face, |new| near.put(self.first[new as usize]));
        near.follow(&self.next);
    }

    /// Calls `visit` for every cell that is near to `cell` and was not near to the cell before a transition through `face`.
    #[inline(always)]
    fn for_each_new(&self, cell: u32, face: Face, mut visit: impl FnMut(u32)) {
        let at = self.split(cell);
        let axis = usize::from(face.axis);
        let n = self.counts[axis];
        if self.is_periodic[axis] && n <= 3 {
            return; // every cell along the axis was near before
        }
        let Some((ahead, _)) = self.beyond(axis, at[axis], face.is_upper) else { return };
        let (others_a, others_b) = ((axis + 1) % 3, (axis + 2) % 3);
        let (aa, na) = self.around(others_a, at[others_a]);
        let (bb, nb) = self.around(others_b, at[others_b]);
        let mut index = at;
        index[axis] = ahead;
        for &a in &aa[..na] {
            for &b in &bb[..nb] {
                (index[others_a], index[others_b]) = (a, b);
                visit(self.join(index));
            }
        }
    }

    /// Expects a particle to leave a cell through a face: the heads of its cell and of those that become near.
    #[inline]
    pub fn expect_transition(&self, cell: u32, face: Face) {
        prefetch(&self.first, cell);
        self.for_each_new_after(cell, face, |new| prefetch(&self.first, new));
    }

    /// Expects questions about those in the cells that become near.
    #[inline]
    pub fn expect_new(&self, cell: u32, face: Face, expect: impl Fn(u32)) {
        self.for_each_new_after(cell, face, |new| {
            let particle = self.first[new as usize];
            if particle != NOBODY {
                prefetch(&self.next, particle);
                expect(particle);
            }
        });
    }

    #[inline(always)]
    fn for_each_new_after(&self, cell: u32, face: Face, visit: impl FnMut(u32)) {
        let mut at = self.split(cell);
        let axis = usize::from(face.axis);
        if let Some((to, _)) = self.beyond(axis, at[axis], face.is_upper) {
            at[axis] = to;
            self.for_each_new(self.join(at), face, visit);
        }
    }
}
