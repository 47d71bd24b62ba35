//! Verlet lists: for each particle, the particles that it could meet before it leaves its skin.
//!
//! Each moving particle has a centre, which is the position where its list was built. Its skin is a ball of radius
//! `delta` around the centre. When the particle leaves the ball, its list is rebuilt. Two particles in their skins
//! cannot meet if the distance of their centres exceeds their range plus `2 delta`, so lists contain only particles
//! with nearer centres. Lists of moving particles are mutual. Static particles have no lists.

use super::cells::NO_PARTICLE;
use crate::base::numbers::id;
use crate::engine::array::Array;
use crate::engine::columns::Order;
use crate::engine::hardware::pages::enlarge;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::slabs::Rooms;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::ptr;

/// Number of entries in a block. Up to eight entries are read at a time.
const BLOCK: usize = 8;
const WIDTH: u32 = 8;

/// Number of bits of the length of a list, sufficient for the largest number of particles.
const LENGTH: u32 = 29;

/// Maximum number of unused blocks at the end of a list.
const MOST_SPARE: u32 = (1 << (32 - LENGTH)) - 1;

/// The place of a list.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
struct Span {
    first: u32,
    /// Length of the list in the lower bits, and number of unused blocks in the higher bits.
    filled: u32,
}

impl Span {
    fn new(first: u32, blocks: u32, length: u32) -> Self {
        let spare = blocks - length.div_ceil(WIDTH);
        debug_assert!(length >> LENGTH == 0 && spare <= MOST_SPARE, "{length} in {blocks} blocks");
        Self { first, filled: length | spare << LENGTH }
    }

    #[inline]
    fn start(self) -> usize {
        self.first as usize * BLOCK
    }

    #[inline]
    fn length(self) -> u32 {
        self.filled & ((1 << LENGTH) - 1)
    }

    #[inline]
    fn spare(self) -> u32 {
        self.filled >> LENGTH
    }

    #[inline]
    fn blocks(self) -> u32 {
        self.length().div_ceil(WIDTH) + self.spare()
    }
}

/// The lists of all particles. The unused entries of a list contain the particle itself.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Lists {
    spans: Array<Span>,
    entries: Array<u32>,
    /// Free runs of blocks, by their length.
    free: Vec<Vec<u32>>,
    /// Unused runs of blocks that were set apart for threads.
    #[serde(skip)]
    spare: Vec<Range<u32>>,
    /// Unused blocks of this thread, and the number of blocks that suffices for a rebuild.
    #[serde(skip)]
    own: Range<u32>,
    #[serde(skip)]
    needed: u32,
    /// Buffers for [`Self::renew`]: the previous entries of a list, and its new entries in ascending order.
    old: Vec<u32>,
    sorted: Vec<u32>,
    /// The particles added by the last [`Self::renew`], padded to whole blocks, and their number.
    newcomers: Vec<u32>,
    coming: usize,
}

/// Longer lists are sorted before they are compared.
const SHORT: usize = 64;

/// Returns true if a short list contains a particle. No branch depends on the entries.
#[inline]
fn holds(list: &[u32], particle: u32) -> bool {
    list.iter().fold(false, |found, entry| found | (*entry == particle))
}

impl Lists {
    #[must_use]
    pub fn new(particles: usize) -> Self {
        Self { spans: vec![Span::default(); particles].into(), ..Self::default() }
    }

    pub fn push_empty(&mut self) {
        self.spans.push(Span::default());
    }

    /// Returns the lists for a new order of particles. Lists of successive particles become adjacent in memory.
    pub fn permuted(&self, order: &Order) -> Self {
        let mut permuted = Self::new(order.old.len());
        permuted.spans.reserve(order.room);
        let mut list = Vec::new();
        for (&before, particle) in order.old.iter().zip(0..) {
            list.clear();
            let others = self.of(before).iter().map(|&other| order.new[other as usize]);
            list.extend(others.filter(|other| *other != NO_PARTICLE));
            permuted.set(particle, &list);
        }
        permuted.entries.reserve(permuted.entries.len() / order.old.len().max(1) * order.room);
        permuted
    }

    /// Checks lists from a file. Each list must lie within the array and contain numbers of particles.
    #[must_use]
    pub fn is_sound(&self, particles: usize) -> bool {
        let blocks = self.entries.len() / BLOCK;
        let is_within = |span: &Span| span.blocks() == 0 || span.first as usize + span.blocks() as usize <= blocks;
        self.spans.len() == particles
            && self.entries.len().is_multiple_of(BLOCK)
            && self.spans.iter().all(is_within)
            && (0..).zip(&self.spans).all(|(particle, _): (u32, _)| {
                self.filled_up(particle).0.iter().all(|&other| (other as usize) < particles)
            })
            && self.free.iter().flatten().all(|&first| (first as usize) < blocks)
            && self.coming <= self.newcomers.len()
            && self.newcomers.iter().chain(&self.old).chain(&self.sorted).all(|&other| (other as usize) < particles)
    }

    /// Number of blocks that suffices for a rebuild.
    fn needed_for_rebuild(&self) -> usize {
        let longest = self.spans.iter().map(|span| span.length()).max().unwrap_or(0);
        // A rebuild changes the lists of its former and new neighbours. In a while, lists may become somewhat longer.
        let longest = longest + longest / 2 + WIDTH;
        (2 * longest as usize + 1) * room_for(longest.div_ceil(WIDTH) + 1) as usize
    }

    /// Whether the room for several threads is affordable. It grows as the square of the length of the longest list.
    #[must_use]
    pub fn can_make_rooms(&self) -> bool {
        self.needed_for_rebuild() <= 4_096 + self.spans.len() / 8
    }

    /// Makes room for the rebuilds of one thread with `share` particles. `threads` counts this thread and the threads
    /// that follow. Free runs are divided evenly among these threads.
    pub fn make_room(&mut self, rooms: &mut Rooms, share: usize, threads: usize) {
        rooms.runs = self.free.iter_mut().map(|free| free.split_off(free.len() - free.len() / threads)).collect();
        rooms.needed = id(self.needed_for_rebuild());
        let least = 2 * rooms.needed as usize;
        rooms.blocks = match self.spare.iter().position(|spare| spare.len() >= least) {
            Some(at) => self.spare.swap_remove(at),
            None => {
                self.divide_spare();
                let first = self.entries.len() / BLOCK;
                let end = first + 2 * least + share / 4;
                self.entries.change(|entries| entries.resize(end * BLOCK, 0));
                id(first)..id(end)
            }
        };
    }

    /// Divides unused blocks into runs that are long enough for most lists.
    fn divide_spare(&mut self) {
        let lists = self.spans.len().max(1);
        let average = self.spans.iter().map(|span| span.length() as usize).sum::<usize>() / lists;
        let run = room_for(id(average.div_ceil(BLOCK) + 1));
        self.free.resize_with(self.free.len().max(run as usize + 1), Vec::new);
        for spare in self.spare.drain(..) {
            let runs = (spare.start..spare.end).step_by(run as usize).filter(|first| first + run <= spare.end);
            self.free[run as usize].extend(runs);
        }
    }

    /// Takes back the room of a thread.
    pub fn take_room(&mut self, rooms: &mut Rooms) {
        self.spare.push(std::mem::take(&mut rooms.blocks));
        self.free.resize_with(self.free.len().max(rooms.runs.len()), Vec::new);
        for (free, runs) in self.free.iter_mut().zip(&mut rooms.runs) {
            free.append(runs);
        }
    }

    /// Turns a bitwise copy into lists in shared arrays, with the room of one thread.
    ///
    /// # Safety
    /// As for [`Array::become_alias`]. The copy must not be dropped.
    pub unsafe fn become_alias(&mut self, rooms: &mut Rooms) {
        self.spans.become_alias();
        self.entries.become_alias();
        // SAFETY: the vectors belong to the original, so they are not dropped here.
        unsafe {
            ptr::write(&raw mut self.free, std::mem::take(&mut rooms.runs));
            for buffer in [&raw mut self.old, &raw mut self.sorted, &raw mut self.newcomers] {
                ptr::write(buffer, Vec::new());
            }
        }
        (self.own, self.needed, self.coming) = (rooms.blocks.clone(), rooms.needed, 0);
    }

    /// Returns the room of an alias, with what is left of it.
    pub fn give_back(&mut self, rooms: &mut Rooms) {
        (rooms.blocks, rooms.runs) = (self.own.clone(), std::mem::take(&mut self.free));
        for buffer in [&mut self.old, &mut self.sorted, &mut self.newcomers] {
            *buffer = Vec::new();
        }
    }

    /// Whether the room of this thread may be too small for the next rebuild.
    #[inline]
    #[must_use]
    pub fn is_short(&self) -> bool {
        self.own.len() < self.needed as usize
    }

    /// Number of entries for which there is memory.
    #[cfg(test)]
    pub fn memory(&self) -> usize {
        self.entries.len()
    }

    /// Empties all lists and frees their memory.
    pub fn let_go(&mut self) {
        *self = Self::new(self.spans.len());
    }

    pub fn enlarge(&self) {
        enlarge(&self.spans);
        enlarge(&self.entries);
    }

    #[inline]
    #[must_use]
    pub fn of(&self, particle: u32) -> &[u32] {
        let span = self.spans[particle as usize];
        self.entries.some(span.start()..span.start() + span.length() as usize)
    }

    /// Returns the list of a particle, padded with the particle itself to a multiple of eight, and the list's length.
    #[inline]
    #[must_use]
    pub fn filled_up(&self, particle: u32) -> (&[u32], usize) {
        let span = self.spans[particle as usize];
        let (first, length) = (span.start(), span.length() as usize);
        (self.entries.some(first..first + length.next_multiple_of(BLOCK)), length)
    }

    #[inline]
    pub fn prefetch_span(&self, particle: u32) {
        prefetch(&self.spans, particle as usize);
    }

    #[inline]
    pub fn prefetch_list(&self, particle: u32) {
        let span = self.spans[particle as usize];
        prefetch(&self.entries, span.start());
        prefetch(&self.entries, span.start() + BLOCK);
    }

    pub fn add(&mut self, particle: u32, other: u32) {
        let span = self.spans[particle as usize];
        let (mut first, mut blocks, length) = (span.first, span.blocks(), span.length());
        if length == blocks * WIDTH {
            (first, blocks) = self.move_to_room(particle, length, blocks + 1);
        }
        self.entries[first as usize * BLOCK + length as usize] = other;
        self.spans[particle as usize] = Span::new(first, blocks, length + 1);
    }

    pub fn remove(&mut self, particle: u32, other: u32) {
        if let Some(at) = self.of(particle).iter().position(|entry| *entry == other) {
            self.remove_at(particle, at);
        }
    }

    /// Takes a particle out of the lists of its neighbours, and empties its own list.
    pub fn withdraw(&mut self, particle: u32) {
        while let Some(&other) = self.of(particle).last() {
            self.remove(other, particle);
            self.remove_at(particle, self.of(particle).len() - 1);
        }
    }

    /// Removes an entry. The last entry of the list takes its place.
    pub fn remove_at(&mut self, particle: u32, at: usize) {
        let span = self.spans[particle as usize];
        let left = span.length() - 1;
        let last = span.start() + left as usize;
        self.entries[span.start() + at] = self.entries[last];
        self.entries[last] = particle;
        let needed = left.div_ceil(WIDTH);
        let (mut first, mut blocks) = (span.first, span.blocks());
        if blocks - needed > MOST_SPARE {
            (first, blocks) = self.move_to_room(particle, left, needed);
        }
        self.spans[particle as usize] = Span::new(first, blocks, left);
    }

    /// Replaces the list of a particle by `new`, and updates the lists of its new and former neighbours. Particles for
    /// which `keeps_none` is true have no lists.
    pub fn renew(&mut self, particle: u32, new: &[u32], keeps_none: impl Fn(u32) -> bool) {
        let (mut old, mut newcomers) = (std::mem::take(&mut self.old), std::mem::take(&mut self.newcomers));
        old.clear();
        old.extend_from_slice(self.of(particle));
        newcomers.clear();
        if new.len().max(old.len()) <= SHORT {
            newcomers.extend(new.iter().filter(|other| !holds(&old, **other)));
            for &other in old.iter().filter(|other| !holds(new, **other)) {
                self.remove(other, particle);
            }
        } else {
            let mut sorted = std::mem::take(&mut self.sorted);
            sorted.clear();
            sorted.extend_from_slice(new);
            sorted.sort_unstable();
            old.sort_unstable();
            newcomers.extend(new.iter().filter(|other| old.binary_search(other).is_err()));
            for &other in old.iter().filter(|other| sorted.binary_search(other).is_err()) {
                self.remove(other, particle);
            }
            self.sorted = sorted;
        }
        for &other in newcomers.iter().filter(|other| !keeps_none(**other)) {
            self.add(other, particle);
        }
        self.coming = newcomers.len();
        newcomers.resize(self.coming.next_multiple_of(BLOCK), particle);
        (self.old, self.newcomers) = (old, newcomers);
        self.set(particle, new);
    }

    /// Returns the particles that the last [`Self::renew`] added, padded to a multiple of eight, and their number.
    #[inline]
    #[must_use]
    pub fn newcomers(&self) -> (&[u32], usize) {
        (&self.newcomers, self.coming)
    }

    /// Replaces the list of a particle, but not the lists of its neighbours.
    pub fn set(&mut self, particle: u32, new: &[u32]) {
        let span = self.spans[particle as usize];
        let (mut first, mut blocks) = (span.first, span.blocks());
        #[expect(clippy::cast_possible_truncation, reason = "at most the number of particles, which fits into 32 bits")]
        let length = new.len() as u32;
        let needed = length.div_ceil(WIDTH);
        // A list that has become much shorter is moved, so that other lists can use its blocks.
        if needed > blocks || room_for(needed) < blocks {
            (first, blocks) = self.move_to_room(particle, 0, needed);
        } else if length < span.length() {
            self.entries.some_mut(span.start() + new.len()..span.start() + span.length() as usize).fill(particle);
        }
        let start = first as usize * BLOCK;
        self.entries.some_mut(start..start + new.len()).copy_from_slice(new);
        self.spans[particle as usize] = Span::new(first, blocks, length);
    }

    /// Moves a list to a place with room for `needed` blocks, and copies its first `kept` entries. Returns the first
    /// block and the number of blocks.
    fn move_to_room(&mut self, particle: u32, kept: u32, needed: u32) -> (u32, u32) {
        let span = self.spans[particle as usize];
        let blocks = span.blocks();
        let room = room_for(needed);
        self.free.resize_with(self.free.len().max(room.max(blocks) as usize + 1), Vec::new);
        let to = self.free[room as usize].pop().unwrap_or_else(|| {
            if self.own.len() >= room as usize {
                let to = self.own.start;
                self.own.start += room;
                return to;
            }
            let to = self.entries.len() / BLOCK;
            self.entries.change(|entries| entries.resize((to + room as usize) * BLOCK, particle));
            id(to)
        });
        let (old, new) = (span.start(), to as usize * BLOCK);
        for at in 0..kept as usize {
            self.entries[new + at] = self.entries[old + at];
        }
        self.entries.some_mut(new + kept as usize..new + room as usize * BLOCK).fill(particle);
        if blocks > 0 {
            self.free[blocks as usize].push(span.first);
        }
        (to, room)
    }
}

/// Returns the number of blocks for a list that needs `needed` blocks. A list gets up to a quarter more.
fn room_for(needed: u32) -> u32 {
    needed + (needed / 4).min(MOST_SPARE - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    #[test]
    fn shrinking_list_releases_memory() {
        let mut lists = Lists::new(2);
        (10..1010).for_each(|other| lists.add(0, other));
        lists.set(1, &(10..200).collect::<Vec<_>>());
        for length in (0..1000).rev() {
            lists.remove(0, 10 + length);
            let (filled_up, left) = lists.filled_up(0);
            assert!(left == length as usize && filled_up[left..].iter().all(|entry| *entry == 0));
            assert!(filled_up[..left].iter().copied().collect::<BTreeSet<_>>() == (10..10 + length).collect());
            assert!(lists.spans[0].blocks() <= length.div_ceil(WIDTH) + MOST_SPARE);
        }
        assert_eq!(lists.of(1), (10..200).collect::<Vec<_>>());
    }

    proptest! {
        #[test]
        fn lists_are_sets_padded_with_their_owner(
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
                for (particle, set) in (0..).zip(&sets) {
                    let list = lists.of(particle);
                    prop_assert_eq!(list.len(), set.len());
                    prop_assert_eq!(&list.iter().copied().collect::<BTreeSet<_>>(), set);
                    let (filled_up, length) = lists.filled_up(particle);
                    prop_assert!(filled_up.len().is_multiple_of(8) && length == list.len());
                    prop_assert_eq!(&filled_up[..length], list);
                    prop_assert!(filled_up[length..].iter().all(|entry| *entry == particle));
                }
            }
        }

        #[test]
        fn rebuilding_a_list_updates_its_neighbours_lists(
            steps in prop::collection::vec((0..12_u32, prop::collection::btree_set(0..14_u32, 0..14)), 1..60),
        ) {
            let mut lists = Lists::new(14);
            let mut pairs = BTreeSet::new();
            for (particle, mut new) in steps {
                new.remove(&particle);
                let old: BTreeSet<u32> = lists.of(particle).iter().copied().collect();
                let list: Vec<u32> = new.iter().rev().copied().collect();
                lists.renew(particle, &list, |other| other >= 12);
                let (newcomers, count) = lists.newcomers();
                prop_assert!(newcomers.len().is_multiple_of(8) && newcomers[count..].iter().all(|id| *id == particle));
                prop_assert_eq!(newcomers[..count].iter().copied().collect::<BTreeSet<_>>(), &new - &old);
                pairs.retain(|(a, b)| *a != particle && *b != particle);
                for other in new {
                    pairs.insert((particle, other));
                    if other < 12 {
                        pairs.insert((other, particle));
                    }
                }
                let listed = |a: u32| lists.of(a).iter().map(move |b| (a, *b));
                prop_assert_eq!((0..14).flat_map(listed).collect::<BTreeSet<_>>(), pairs.clone());
                prop_assert_eq!((0..14).flat_map(listed).count(), pairs.len());
            }
        }
    }
}
