//! The memory of pairs: which pairs are captured, through how many steps.
//!
//! The state of a pair is discrete and changes only with an event (Capture, Release). It is never recomputed from a distance,
//! because round-off puts distances on the wrong side. A pair without an entry is a stranger, in state 0 of its
//! species' potential; bonded pairs always have one. Each moving particle keeps its own list of partners.

use crate::engine::hardware::prefetch::prefetch;
use serde::{Deserialize, Serialize};

/// What a particle remembers of a partner.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Known {
    /// The other particle.
    pub partner: u32,
    /// How many radii the pair has been captured through.
    pub state: u16,
    /// Which interaction holds for the pair.
    pub interaction: u16,
}

/// Lists of known partners, in one array with the same room for each particle.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct PairMemory {
    room: usize,
    lengths: Vec<u32>,
    entries: Vec<Known>,
}

impl PairMemory {
    /// Empty lists for a number of particles.
    #[must_use]
    pub fn new(particles: usize) -> Self {
        Self { room: 0, lengths: vec![0; particles], entries: Vec::new() }
    }

    /// The partners that a particle knows.
    #[inline]
    #[must_use]
    pub fn of(&self, particle: u32) -> &[Known] {
        let at = particle as usize * self.room;
        &self.entries[at..at + self.lengths[particle as usize] as usize]
    }

    /// Expects questions about a particle.
    #[inline]
    pub fn expect(&self, particle: u32) {
        prefetch(&self.lengths, particle as usize);
        prefetch(&self.entries, particle as usize * self.room);
    }

    /// What a particle knows of a partner.
    #[inline]
    #[must_use]
    pub fn get(&self, particle: u32, partner: u32) -> Option<Known> {
        self.of(particle).iter().copied().find(|known| known.partner == partner)
    }

    /// Makes a particle know a partner, or changes what it knows of it; whether the partner is new to it.
    pub fn set(&mut self, particle: u32, known: Known) -> bool {
        let length = self.lengths[particle as usize] as usize;
        let at = particle as usize * self.room;
        if let Some(old) = self.entries[at..at + length].iter_mut().find(|old| old.partner == known.partner) {
            *old = known;
            return false;
        }
        if length == self.room {
            self.grow();
        }
        self.entries[particle as usize * self.room + length] = known;
        self.lengths[particle as usize] += 1;
        true
    }

    /// Makes a particle forget a partner; whether it had it.
    pub fn forget(&mut self, particle: u32, partner: u32) -> bool {
        let length = self.lengths[particle as usize] as usize;
        let at = particle as usize * self.room;
        let list = &mut self.entries[at..at + length];
        let found = list.iter().position(|known| known.partner == partner);
        if let Some(position) = found {
            list[position] = list[length - 1];
            self.lengths[particle as usize] -= 1;
        }
        found.is_some()
    }

    /// Doubles the room of every list.
    fn grow(&mut self) {
        let room = (2 * self.room).max(4);
        let mut entries = vec![Known::default(); room * self.lengths.len()];
        for (particle, &length) in self.lengths.iter().enumerate() {
            let (from, to) = (particle * self.room, particle * room);
            entries[to..to + length as usize].copy_from_slice(&self.entries[from..from + length as usize]);
        }
        (self.room, self.entries) = (room, entries);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeMap;

    #[test]
    fn lists_grow_without_mixing() {
        let mut memory = PairMemory::new(3);
        for partner in 0..20 {
            for state in 0..3 {
                memory.set(u32::from(state), Known { partner, state, interaction: 7 });
            }
        }
        assert_eq!(memory.of(2).len(), 20);
        assert_eq!(memory.get(1, 13), Some(Known { partner: 13, state: 1, interaction: 7 }));
        assert_eq!(memory.get(1, 20), None);
    }

    proptest! {
        #[test]
        fn a_memory_is_a_map(steps in prop::collection::vec((0..4_u32, 0..12_u32, 0..4_u16), 1..200)) {
            let mut memory = PairMemory::new(4);
            let mut map = BTreeMap::new();
            for (particle, partner, state) in steps {
                if state == 0 {
                    let was_there = map.remove(&(particle, partner)).is_some();
                    prop_assert_eq!(memory.forget(particle, partner), was_there);
                } else {
                    memory.set(particle, Known { partner, state, interaction: 0 });
                    map.insert((particle, partner), state);
                }
                for key in 0..4 {
                    for other in 0..12 {
                        let known = memory.get(key, other).map(|k| k.state);
                        prop_assert_eq!(known, map.get(&(key, other)).copied());
                    }
                }
            }
        }
    }
}
