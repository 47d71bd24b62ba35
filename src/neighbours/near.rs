//! Who has been found near a particle: a list that is filled without a branch on what is found.

use super::cells::NOBODY;

/// Particles found. Room is kept from one search to the next.
#[derive(Debug, Default)]
pub struct Near {
    found: Vec<u32>,
    length: usize,
}

impl Near {
    /// Forgets all.
    #[inline]
    pub fn clear(&mut self) {
        self.length = 0;
    }

    /// Takes note of a particle, or of nobody.
    ///
    /// Cells hold one particle or none about as often: a processor that had to guess would be wrong half of the time.
    #[inline(always)]
    pub fn put(&mut self, particle: u32) {
        if self.length == self.found.len() {
            self.found.resize(2 * self.length + 64, NOBODY);
        }
        self.found[self.length] = particle;
        self.length += usize::from(particle != NOBODY);
    }

    /// Goes on from each particle to its successor, until there is nobody left.
    #[inline]
    pub fn follow(&mut self, next: &[u32]) {
        let mut at = 0;
        while at < self.length {
            self.put(next[self.found[at] as usize]);
            at += 1;
        }
    }

    /// Keeps those for which something holds.
    #[inline]
    pub fn retain(&mut self, mut is_kept: impl FnMut(u32) -> bool) {
        let mut kept = 0;
        for at in 0..self.length {
            let particle = self.found[at];
            self.found[kept] = particle;
            kept += usize::from(is_kept(particle));
        }
        self.length = kept;
    }

    /// Keeps those for which something holds, asked for four at a time.
    #[inline(always)]
    pub fn retain_fours(&mut self, mut are_kept: impl FnMut([u32; 4]) -> [bool; 4]) {
        let length = self.length;
        // The last four are filled up with the first one, which is not kept again.
        while !self.length.is_multiple_of(4) {
            self.put(self.found[0]);
        }
        let mut kept = 0;
        for four in 0..self.length / 4 {
            let ids: [u32; 4] = std::array::from_fn(|lane| self.found[4 * four + lane]);
            let are_kept = are_kept(ids);
            for lane in 0..4 {
                self.found[kept] = ids[lane];
                kept += usize::from(are_kept[lane] && 4 * four + lane < length);
            }
        }
        self.length = kept;
    }

    /// Those found.
    #[inline]
    #[must_use]
    pub fn found(&self) -> &[u32] {
        &self.found[..self.length]
    }

    /// Those found in fours, the last one filled up with `nobody_new`.
    #[inline]
    pub fn fours(&mut self, nobody_new: u32) -> &[[u32; 4]] {
        while !self.length.is_multiple_of(4) {
            self.put(nobody_new);
        }
        self.found().as_chunks().0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn successors_are_followed_to_the_last() {
        // 5 -> 2 -> 0, 3 -> nobody, 1 -> 4.
        let next = [NOBODY, 4, 0, NOBODY, NOBODY, 2];
        let mut near = Near::default();
        for first in [5, NOBODY, 3, 1, NOBODY] {
            near.put(first);
        }
        near.follow(&next);
        assert_eq!(near.found(), [5, 3, 1, 2, 4, 0]);
        near.retain_fours(|ids| ids.map(|id| id != 1));
        assert_eq!(near.found(), [5, 3, 2, 4, 0]);
        near.retain(|particle| particle % 2 == 0);
        assert_eq!(near.found(), [2, 4, 0]);
        assert_eq!(near.fours(7), [[2, 4, 0, 7]]);
        near.clear();
        assert!(near.fours(7).is_empty());
    }
}
