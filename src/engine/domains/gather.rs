//! The one engine for all takes over what its domains have.

use super::Domains;
use crate::engine::parts::Engine;
use std::time::Instant;

impl<const FALLING: bool, const TABLE: bool> Domains<FALLING, TABLE> {
    /// Gives the one engine what the domains have of all particles: its state is up to date, but it cannot go on until [`Self::complete`].
    pub fn settle(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        let Some(cut) = self.cut.as_mut().filter(|cut| !cut.is_settled) else { return };
        let begin = Instant::now();
        cut.is_settled = true;
        // As where the one engine pauses: at its last step, however far it has looked.
        whole.clock.now = cut.latest;
        whole.schedule.queue.resume(cut.now, cut.steps);
        for domain in &cut.domains {
            for particle in domain.owned_particles() {
                let mut record = domain.engine.record(particle);
                record.renumber(|number| domain.held.get(number as usize).map(|held| held.whole));
                whole.write_record(domain.held[particle as usize].whole, &record);
            }
        }
        self.work.gathering += begin.elapsed();
    }

    /// Gives the one engine the lists of all particles.
    pub(super) fn settle_lists(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        let (Some(cut), Some(lists)) = (&self.cut, whole.neighbours.lists_mut()) else { return };
        let begin = Instant::now();
        let mut list = Vec::new();
        for domain in &cut.domains {
            let Some(verlet) = domain.engine.neighbours.verlet() else { continue };
            for particle in domain.owned_particles() {
                list.clear();
                list.extend(verlet.lists.of(particle).iter().map(|&other| domain.held[other as usize].whole));
                lists.set(domain.held[particle as usize].whole, &list);
            }
        }
        self.work.gathering += begin.elapsed();
    }

    /// Gives the one engine all that it needs to go on where the domains are.
    pub fn complete(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        self.settle(whole);
        if self.cut.as_ref().is_none_or(|cut| cut.is_complete) {
            return;
        }
        self.settle_lists(whole);
        for particle in whole.particles() {
            whole.enqueue(particle);
        }
        if let Some(cut) = &mut self.cut {
            cut.is_complete = true;
        }
    }

    /// Leaves everything to the one engine.
    pub fn join(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        self.complete(whole);
        self.cut = None;
    }
}
