//! Searches in cells, and prefetches data for them.

use super::Cells;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::neighbours::grid::CellFace;

impl Cells {
    #[inline]
    pub fn prefetch_home(&self, particle: u32) {
        prefetch(&self.homes, particle as usize);
        prefetch(&self.next, particle as usize);
    }

    #[inline]
    pub fn prefetch_rows(&self, cell: u32) {
        self.grid.for_each_run(cell, |first, _| prefetch(&self.first, first));
    }

    /// Prefetches the first particles in a cell and in the adjacent cells. Calls `expect` for each of these particles.
    #[inline]
    pub fn prefetch_near(&self, cell: u32, expect: impl Fn(u32)) {
        self.grid.for_each_run(cell, |first, count| {
            for &head in self.first.some(first..first + count) {
                self.prefetch_head(head, &expect);
            }
        });
    }

    #[inline]
    pub fn find_candidates(&self, cell: u32, near: &mut Candidates) {
        let mut heads = near.heads();
        self.grid.for_each_run(cell, |first, count| {
            for &head in self.first.some(first..first + count) {
                heads.put(head);
            }
        });
        let found = heads.length;
        near.follow(found, &self.next);
    }

    /// Finds the particles that become candidates when a particle enters `cell` through `face`.
    #[inline]
    pub fn find_new_candidates(&self, cell: u32, face: CellFace, near: &mut Candidates) {
        let mut heads = near.heads();
        self.grid.for_each_new(cell, face, |new| heads.put(self.first[new as usize]));
        let found = heads.length;
        near.follow(found, &self.next);
    }

    #[inline]
    pub fn prefetch_transition(&self, cell: u32, face: CellFace) {
        prefetch(&self.first, cell as usize);
        self.for_each_new_after(cell, face, |new| prefetch(&self.first, new as usize));
    }

    #[inline]
    pub fn prefetch_new(&self, cell: u32, face: CellFace, expect: impl Fn(u32)) {
        self.for_each_new_after(cell, face, |new| self.prefetch_head(self.first[new as usize], &expect));
    }

    /// Prefetches data of the first particle of a cell, or of the last particle of the system if the cell is empty.
    /// This costs less than a mispredicted branch.
    #[inline(always)]
    fn prefetch_head(&self, head: u32, expect: &impl Fn(u32)) {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "`affordable` in scene/limits.rs accepts at most MOST_PARTICLES particles"
        )]
        let last = self.next.len() as u32 - 1;
        let particle = head.min(last);
        prefetch(&self.next, particle as usize);
        expect(particle);
    }

    #[inline(always)]
    fn for_each_new_after(&self, cell: u32, face: CellFace, visit: impl FnMut(u32)) {
        if let Some((to, _)) = self.grid.behind(cell, face)
            && to != cell
        {
            self.grid.for_each_new(to, face, visit);
        }
    }
}
