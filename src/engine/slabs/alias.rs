//! Engines of several threads that share the arrays of particles.

use super::part::Part;
use crate::engine::parts::Engine;
use std::mem::ManuallyDrop;
use std::ops::{Deref, DerefMut};
use std::ptr;

/// An engine that shares the arrays of particles with another engine. It has its own queue, counts and clock, and its
/// own memory for neighbour lists. Everything else is only read.
pub(super) struct Alias<const FALLING: bool, const TABLE: bool>(ManuallyDrop<Engine<FALLING, TABLE>>);

impl<const FALLING: bool, const TABLE: bool> Alias<FALLING, TABLE> {
    /// Creates an alias of an engine, with the queue, the counts and the memory for lists of a part.
    ///
    /// # Safety
    /// Until [`Self::give_back`] is called, the engine must not be changed or dropped. No two threads may access the
    /// same element of an array at the same time, unless both only read it.
    pub unsafe fn of(engine: &Engine<FALLING, TABLE>, part: &mut Part) -> Self {
        // SAFETY: the copy is never dropped. The arrays become aliases, and everything else that an alias changes is
        // replaced below, without dropping what belongs to `engine`.
        unsafe {
            let mut copy = ManuallyDrop::new(ptr::read(engine));
            copy.share_columns();
            // Collisions with the heat bath are drawn before each window.
            copy.sources.next_global = f64::INFINITY;
            copy.neighbours.share(&mut part.rooms);
            ptr::write(&raw mut copy.schedule.queue, std::mem::take(&mut part.queue));
            ptr::write(&raw mut copy.schedule.part, Some(std::mem::take(&mut part.own)));
            ptr::write(&raw mut copy.counts, std::mem::take(&mut part.counts));
            ptr::write(&raw mut copy.scratch, part.scratch.take());
            ptr::write(&raw mut copy.domains, None);
            ptr::write(&raw mut copy.slabs, None);
            Self(copy)
        }
    }

    /// Returns what belongs to the part.
    pub fn give_back(mut self, part: &mut Part) {
        let engine = &mut *self.0;
        part.queue = std::mem::take(&mut engine.schedule.queue);
        part.own = engine.schedule.part.take().unwrap_or_default();
        part.counts = std::mem::take(&mut engine.counts);
        part.scratch = engine.scratch.take();
        engine.neighbours.give_back(&mut part.rooms);
    }
}

impl<const FALLING: bool, const TABLE: bool> Deref for Alias<FALLING, TABLE> {
    type Target = Engine<FALLING, TABLE>;

    fn deref(&self) -> &Engine<FALLING, TABLE> {
        &self.0
    }
}

impl<const FALLING: bool, const TABLE: bool> DerefMut for Alias<FALLING, TABLE> {
    fn deref_mut(&mut self) -> &mut Engine<FALLING, TABLE> {
        &mut self.0
    }
}
