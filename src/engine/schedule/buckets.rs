//! The buckets of the calendar. A bucket is a linked list of chunks from a common pool.

use crate::engine::hardware::pages::enlarge;
use serde::{Deserialize, Serialize};

/// Number of entries in a chunk. A chunk fills one cache line.
const ENTRIES: usize = 15;

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[repr(C, align(64))]
struct Chunk {
    entries: [u32; ENTRIES],
    next: u32,
}

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Bucket {
    newest: u32,
    length: u32,
}

/// Lists of particle indices, which can only grow or be emptied.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Buckets {
    buckets: Vec<Bucket>,
    chunks: Vec<Chunk>,
    free: Vec<u32>,
}

impl Buckets {
    pub fn new(count: usize) -> Self {
        // Capacity for one entry per particle and for one incomplete chunk per bucket.
        let chunks = Vec::with_capacity(2 * count);
        enlarge(&chunks);
        let buckets = vec![Bucket::default(); count];
        enlarge(&buckets);
        Self { buckets, chunks, free: Vec::new() }
    }

    #[inline]
    pub fn count(&self) -> usize {
        self.buckets.len()
    }

    #[inline]
    pub fn push(&mut self, bucket: usize, particle: u32) {
        let bucket = &mut self.buckets[bucket];
        let at = bucket.length as usize % ENTRIES;
        if at == 0 {
            let chunk = Chunk { entries: [particle; ENTRIES], next: bucket.newest };
            bucket.newest = if let Some(free) = self.free.pop() {
                self.chunks[free as usize] = chunk;
                free
            } else {
                self.chunks.push(chunk);
                #[expect(
                    clippy::cast_possible_truncation,
                    reason = "an epoch has fewer than 2^32 entries: one for each particle, and two after each of at most 2^30 pops"
                )]
                let last = self.chunks.len() as u32 - 1;
                last
            };
        } else {
            self.chunks[bucket.newest as usize].entries[at] = particle;
        }
        bucket.length += 1;
    }

    /// Moves the entries of a bucket to `into`, in arbitrary order.
    pub fn take(&mut self, bucket: usize, into: &mut Vec<u32>) {
        let Bucket { mut newest, length } = std::mem::take(&mut self.buckets[bucket]);
        let mut left = length as usize;
        while left > 0 {
            let filled = (left - 1) % ENTRIES + 1;
            let chunk = &self.chunks[newest as usize];
            into.extend_from_slice(&chunk.entries[..filled]);
            self.free.push(newest);
            newest = chunk.next;
            left -= filled;
        }
    }

    /// Checks data that was read from a file. All particles must exist, and a chunk must not be in two buckets.
    pub fn is_sound(&self, particles: usize) -> bool {
        let mut is_used = vec![false; self.chunks.len()];
        let mut take =
            |chunk: u32| is_used.get_mut(chunk as usize).is_some_and(|is_used| !std::mem::replace(is_used, true));
        if !self.free.iter().all(|&chunk| take(chunk)) {
            return false;
        }
        for bucket in &self.buckets {
            let (mut newest, mut left) = (bucket.newest, bucket.length as usize);
            while left > 0 {
                if !take(newest) {
                    return false;
                }
                let filled = (left - 1) % ENTRIES + 1;
                let chunk = &self.chunks[newest as usize];
                if chunk.entries[..filled].iter().any(|&particle| particle as usize >= particles) {
                    return false;
                }
                newest = chunk.next;
                left -= filled;
            }
        }
        true
    }

    pub fn clear(&mut self) {
        self.buckets.fill(Bucket::default());
        self.chunks.clear();
        self.free.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn buckets_behave_like_lists(steps in prop::collection::vec((0..3_usize, 0..1000_u32, prop::bool::weighted(0.02)), 1..600)) {
            let mut buckets = Buckets::new(3);
            let mut lists = vec![Vec::new(); 3];
            for (bucket, particle, is_taken) in steps {
                if is_taken {
                    let mut taken = Vec::new();
                    buckets.take(bucket, &mut taken);
                    taken.sort_unstable();
                    lists[bucket].sort_unstable();
                    prop_assert_eq!(&taken, &lists[bucket]);
                    lists[bucket].clear();
                } else {
                    buckets.push(bucket, particle);
                    lists[bucket].push(particle);
                }
            }
        }
    }
}
