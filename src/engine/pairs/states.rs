//! States of captured pairs. The state of a pair is the number of steps of the potential that the pair has entered.
//!
//! The state of a pair changes only at an event. It is never recomputed from the distance, because round-off may put a
//! distance on the wrong side of a step. A pair without an entry is uncaptured: it is in state 0 of the potential of
//! the two species. Bonded pairs always have an entry, even in state 0, and count as captured here. Each moving
//! particle has its own list of partners.

use crate::engine::array::Array;
use crate::engine::hardware::prefetch::prefetch;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct PairState {
    pub partner: u32,
    pub state: u16,
    pub interaction: u16,
}

/// The states of captured and bonded pairs. All lists are in one array, with the same capacity for each particle.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct CapturedPairs {
    room: usize,
    lengths: Array<u32>,
    entries: Array<PairState>,
}

impl CapturedPairs {
    #[must_use]
    pub fn new(particles: usize) -> Self {
        Self { room: 0, lengths: vec![0; particles].into(), entries: Array::new() }
    }

    /// Whether there is no room for another partner of a particle.
    #[inline]
    #[must_use]
    pub fn is_full(&self, particle: u32) -> bool {
        self.room > 0 && self.lengths[particle as usize] as usize == self.room
    }

    /// Whether any pair has ever been captured or bonded.
    #[inline]
    #[must_use]
    pub fn is_used(&self) -> bool {
        self.room > 0
    }

    /// Makes room for some partners of each particle.
    pub fn make_room(&mut self) {
        let longest = self.lengths.iter().copied().max().unwrap_or(0);
        while self.room < longest as usize + 2 {
            self.grow();
        }
    }

    /// See [`Array::become_alias`].
    pub fn become_alias(&mut self) {
        self.lengths.become_alias();
        self.entries.become_alias();
    }

    /// Number of lists: one for each particle, or 0 if no pair can be captured.
    pub fn len(&self) -> usize {
        self.lengths.len()
    }

    pub fn push_empty(&mut self) {
        self.lengths.push(0);
        let length = self.room * self.lengths.len();
        self.entries.change(|entries| entries.resize(length, PairState::default()));
    }

    /// Returns true if no particle has a list.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.lengths.is_empty()
    }

    /// Checks data from a file. All partners must be particles, and lists must exist exactly if `has_lists` is true.
    #[must_use]
    pub fn is_sound(&self, particles: usize, has_lists: bool) -> bool {
        let expected = if has_lists { particles } else { 0 };
        self.lengths.len() == expected
            && self.room.checked_mul(expected) == Some(self.entries.len())
            && self.lengths.iter().all(|&length| length as usize <= self.room)
            && self.entries.iter().all(|pair| (pair.partner as usize) < particles)
    }

    /// The entries of all lists. A pair of moving particles has two entries.
    pub fn all(&self) -> impl Iterator<Item = &PairState> {
        (0..).zip(&self.lengths).flat_map(|(particle, _)| self.of(particle))
    }

    #[inline]
    #[must_use]
    pub fn of(&self, particle: u32) -> &[PairState] {
        if !self.is_used() {
            return &[];
        }
        let at = particle as usize * self.room;
        self.entries.some(at..at + self.lengths[particle as usize] as usize)
    }

    #[inline]
    pub fn prefetch(&self, particle: u32) {
        prefetch(&self.lengths, particle as usize);
        prefetch(&self.entries, particle as usize * self.room);
    }

    #[inline]
    #[must_use]
    pub fn get(&self, particle: u32, partner: u32) -> Option<PairState> {
        self.of(particle).iter().copied().find(|captured| captured.partner == partner)
    }

    /// Returns true if the partner is new in the list.
    pub fn set(&mut self, particle: u32, captured: PairState) -> bool {
        let length = self.lengths[particle as usize] as usize;
        let at = particle as usize * self.room;
        if let Some(old) = self.entries.some_mut(at..at + length).iter_mut().find(|old| old.partner == captured.partner)
        {
            *old = captured;
            return false;
        }
        if length == self.room {
            self.grow();
        }
        self.entries[particle as usize * self.room + length] = captured;
        self.lengths[particle as usize] += 1;
        true
    }

    pub fn replace(&mut self, particle: u32, captured: &[PairState]) {
        self.lengths[particle as usize] = 0;
        captured.iter().for_each(|pair| {
            self.set(particle, *pair);
        });
    }

    /// Returns true if the partner was in the list.
    pub fn remove(&mut self, particle: u32, partner: u32) -> bool {
        let length = self.lengths[particle as usize] as usize;
        let at = particle as usize * self.room;
        let list = self.entries.some_mut(at..at + length);
        let found = list.iter().position(|captured| captured.partner == partner);
        if let Some(position) = found {
            list[position] = list[length - 1];
            self.lengths[particle as usize] -= 1;
        }
        found.is_some()
    }

    fn grow(&mut self) {
        let room = (2 * self.room).max(4);
        let mut entries = vec![PairState::default(); room * self.lengths.len()];
        for (particle, &length) in self.lengths.iter().enumerate() {
            let (from, to) = (particle * self.room, particle * room);
            entries[to..to + length as usize].copy_from_slice(self.entries.some(from..from + length as usize));
        }
        (self.room, self.entries) = (room, entries.into());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    #[test]
    fn lists_grow_without_mixing() {
        let mut states = CapturedPairs::new(3);
        for partner in 0..20 {
            for state in 0..3 {
                states.set(u32::from(state), PairState { partner, state, interaction: 7 });
            }
        }
        assert_eq!(states.of(2).len(), 20);
        assert_eq!(states.get(1, 13), Some(PairState { partner: 13, state: 1, interaction: 7 }));
        assert_eq!(states.get(1, 20), None);
    }

    proptest! {
        #[test]
        fn captured_pairs_behave_like_a_map(steps in prop::collection::vec((0..4_u32, 0..12_u32, 0..4_u16), 1..200)) {
            let mut states = CapturedPairs::new(4);
            let mut map = BTreeMap::new();
            for (particle, partner, state) in steps {
                if state == 0 {
                    let was_there = map.remove(&(particle, partner)).is_some();
                    prop_assert_eq!(states.remove(particle, partner), was_there);
                } else {
                    states.set(particle, PairState { partner, state, interaction: 0 });
                    map.insert((particle, partner), state);
                }
                for key in 0..4 {
                    for other in 0..12 {
                        let captured = states.get(key, other).map(|k| k.state);
                        prop_assert_eq!(captured, map.get(&(key, other)).copied());
                    }
                }
            }
        }
    }
}
