//! Neighbour lists: whom a particle could meet before it leaves its shell.
//!
//! Each moving particle has a centre, where it was when its list was made, and stays within its shell, a ball of radius
//! `delta` around it; an event is due when it leaves. Two particles whose centres are further apart than their range and two
//! shells cannot meet, so a list holds the others whose centres are nearer. Every pair is in the lists of both, but for static
//! particles, which keep none. (Alias: Verlet list.)

use crate::pages::enlarge;
use crate::prefetch::prefetch;

/// Entries are read four at a time; blocks of room hold a multiple of that.
const BLOCK: usize = 8;

/// Where the list of a particle is, in blocks, and how long it is.
#[derive(Debug, Clone, Copy, Default)]
struct Span {
    first: u32,
    blocks: u32,
    length: u32,
}

/// Lists of others, in one array. Unused entries of a particle name itself, whom it never meets.
#[derive(Debug, Default)]
pub struct Lists {
    spans: Vec<Span>,
    entries: Vec<u32>,
    /// Blocks no longer in use, by their number.
    free: Vec<Vec<u32>>,
}

impl Lists {
    /// Empty lists.
    #[must_use]
    pub fn new(particles: usize) -> Self {
        Self { spans: vec![Span::default(); particles], entries: Vec::new(), free: Vec::new() }
    }

    /// Asks for large pages.
    pub fn enlarge(&self) {
        enlarge(&self.spans);
        enlarge(&self.entries);
    }

    /// The others in a particle's list.
    #[inline]
    #[must_use]
    pub fn of(&self, particle: u32) -> &[u32] {
        let span = self.spans[particle as usize];
        let first = span.first as usize * BLOCK;
        &self.entries[first..first + span.length as usize]
    }

    /// The same in fours, the last one filled with the particle itself.
    #[inline]
    #[must_use]
    pub fn fours_of(&self, particle: u32) -> &[[u32; 4]] {
        let span = self.spans[particle as usize];
        let first = span.first as usize * BLOCK;
        let length = (span.length as usize).next_multiple_of(4);
        self.entries[first..first + length].as_chunks().0
    }

    /// Expects questions about where a list is.
    #[inline]
    pub fn expect_span(&self, particle: u32) {
        prefetch(&self.spans, particle);
    }

    /// Expects questions about who is in a list.
    #[inline]
    pub fn expect_list(&self, particle: u32) {
        let span = self.spans[particle as usize];
        prefetch(&self.entries, span.first * BLOCK as u32);
        prefetch(&self.entries, (span.first + 1) * BLOCK as u32);
    }

    /// Adds an other to a particle's list.
    pub fn add(&mut self, particle: u32, other: u32) {
        let span = self.spans[particle as usize];
        if span.length as usize == span.blocks as usize * BLOCK {
            self.grow(particle);
        }
        let span = &mut self.spans[particle as usize];
        self.entries[span.first as usize * BLOCK + span.length as usize] = other;
        span.length += 1;
    }

    /// Takes an other out of a particle's list, if it is there.
    pub fn remove(&mut self, particle: u32, other: u32) {
        if let Some(at) = self.of(particle).iter().position(|entry| *entry == other) {
            self.remove_at(particle, at);
        }
    }

    /// Takes the entry number `at` out of a particle's list; the last one takes its place.
    pub fn remove_at(&mut self, particle: u32, at: usize) {
        let span = &mut self.spans[particle as usize];
        let first = span.first as usize * BLOCK;
        span.length -= 1;
        let last = first + span.length as usize;
        self.entries[first + at] = self.entries[last];
        self.entries[last] = particle;
    }

    /// Moves a list to where it has room for another block.
    fn grow(&mut self, particle: u32) {
        let Span { first, blocks, length } = self.spans[particle as usize];
        let more = blocks + 1 + blocks / 4;
        self.free.resize_with(self.free.len().max(more as usize + 1), Vec::new);
        let to = self.free[more as usize].pop().unwrap_or_else(|| {
            let to = self.entries.len() / BLOCK;
            self.entries.resize((to + more as usize) * BLOCK, particle);
            to as u32
        });
        let (old, new) = (first as usize * BLOCK, to as usize * BLOCK);
        self.entries.copy_within(old..old + length as usize, new);
        self.entries[new + length as usize..new + more as usize * BLOCK].fill(particle);
        if blocks > 0 {
            self.free[blocks as usize].push(first);
        }
        self.spans[particle as usize] = Span { first: to, blocks: more, length };
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn lists_are_sets_filled_up_with_their_owner(
            steps in prop::collection::vec((0..4_u32, 4..40_u32, prop::bool::weighted(0.7)), 1..400),
        ) {
            let mut lists = Lists::new(4);
            let mut sets = vec![BTreeSet::new(); 4];
            for (particle, other, is_added) in steps {
                let set = &mut sets[particle as usize];
                if is_added && set.insert(other) {
                    lists.add(particle, other);
                } else if !is_added {
                    set.remove(&other);
                    lists.remove(particle, other);
                }
                for (particle, set) in sets.iter().enumerate() {
                    let list = lists.of(particle as u32);
                    prop_assert_eq!(list.len(), set.len());
                    prop_assert_eq!(&list.iter().copied().collect::<BTreeSet<_>>(), set);
                    let fours = lists.fours_of(particle as u32).as_flattened();
                    prop_assert_eq!(&fours[..list.len()], list);
                    prop_assert!(fours[list.len()..].iter().all(|entry| *entry == particle as u32));
                }
            }
        }
    }
}
