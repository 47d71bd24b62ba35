//! Lists of neighbour candidates. Particles are added without branches that depend on the particles.

use super::cells::NO_PARTICLE;
use crate::engine::array::Array;

/// A list of candidates. Its memory is reused in the next search.
#[derive(Debug, Clone, Default)]
pub struct Candidates {
    found: Vec<u32>,
    length: usize,
}

/// Writes the first entries of a candidate list: the first particle of each cell.
#[derive(Debug)]
pub struct Heads<'a> {
    particles: &'a mut [u32; 32],
    pub length: usize,
}

impl Heads<'_> {
    /// Appends a particle, or nothing for [`NO_PARTICLE`].
    ///
    /// A branch would be mispredicted half of the time, because about half of the cells are empty.
    #[inline(always)]
    pub fn put(&mut self, particle: u32) {
        self.particles[self.length % 32] = particle;
        self.length += usize::from(particle != NO_PARTICLE);
    }
}

impl Candidates {
    #[inline]
    pub fn clear(&mut self) {
        self.length = 0;
    }

    /// Clears the list, and returns a writer for the first particles of up to 27 cells.
    #[inline(always)]
    #[cfg_attr(not(test), expect(clippy::unreachable, reason = "it has grown where it was too short"))]
    pub fn heads(&mut self) -> Heads<'_> {
        if self.found.len() < 64 {
            self.grow();
        }
        let Some(particles) = self.found.first_chunk_mut() else { unreachable!("it has just grown") };
        Heads { particles, length: 0 }
    }

    #[inline(always)]
    pub fn put(&mut self, particle: u32) {
        if self.length == self.found.len() {
            self.grow();
        }
        self.found[self.length] = particle;
        self.length += usize::from(particle != NO_PARTICLE);
    }

    #[cfg_attr(not(target_arch = "x86_64"), allow(dead_code, reason = "other processors have no AVX2"))]
    #[inline(always)]
    pub fn put_eight(&mut self, (particles, count): ([u32; 8], usize)) {
        if self.length + 8 > self.found.len() {
            self.grow();
        }
        self.found[self.length..self.length + 8].copy_from_slice(&particles);
        self.length += count;
    }

    #[cold]
    #[inline(never)]
    fn grow(&mut self) {
        self.found.resize(2 * self.found.len() + 64, NO_PARTICLE);
    }

    /// Appends all other particles of the cells whose first particles are in the list. `heads` is the number of first
    /// particles. `next` holds, for each particle, the next particle in the same cell.
    #[inline]
    pub fn follow(&mut self, heads: usize, next: &Array<u32>) {
        let (mut at, mut length) = (0, heads);
        while at < length {
            if length == self.found.len() {
                self.grow();
            }
            let found = &mut self.found[..];
            let room = found.len();
            while at < length && length < room {
                let particle = next[found[at] as usize];
                found[length] = particle;
                length += usize::from(particle != NO_PARTICLE);
                at += 1;
            }
        }
        self.length = length;
    }

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

    #[inline]
    #[must_use]
    pub fn found(&self) -> &[u32] {
        &self.found[..self.length]
    }

    pub fn found_mut(&mut self) -> &mut [u32] {
        &mut self.found[..self.length]
    }

    /// Returns the candidates and their number. The list is padded with the particle `with` to a multiple of eight.
    #[inline]
    pub fn filled_up(&mut self, with: u32) -> (&[u32], usize) {
        let filled_up = self.length.next_multiple_of(8);
        if self.found.len() < filled_up {
            self.grow();
        }
        for entry in &mut self.found[self.length..filled_up] {
            *entry = with;
        }
        (&self.found[..filled_up], self.length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linked_lists_are_followed_to_their_end() {
        // The cells hold the particles 5, 2, 0, then 3, then 1, 4.
        let next = vec![NO_PARTICLE, 4, 0, NO_PARTICLE, NO_PARTICLE, 2].into();
        let mut near = Candidates::default();
        let mut heads = near.heads();
        for first in [5, NO_PARTICLE, 3, 1, NO_PARTICLE] {
            heads.put(first);
        }
        let found = heads.length;
        near.follow(found, &next);
        assert_eq!(near.found(), [5, 3, 1, 2, 4, 0]);
        near.retain(|id| id != 1);
        assert_eq!(near.found(), [5, 3, 2, 4, 0]);
        near.retain(|particle| particle % 2 == 0);
        assert_eq!(near.found(), [2, 4, 0]);
        assert_eq!(near.filled_up(7), (&[2, 4, 0, 7, 7, 7, 7, 7][..], 3));
        near.clear();
        assert_eq!(near.filled_up(7), (&[][..], 0));
    }
}
