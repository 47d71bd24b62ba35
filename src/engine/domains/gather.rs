//! Transfers the state of the domains to the single engine.

use super::Domains;
use super::cut::Cut;
use super::domain::Domain;
use super::team::Team;
use crate::engine::parts::Engine;
use crate::engine::prediction::FIRST_ABSENT;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::time::Instant;

const MOST_AT_ONCE: usize = 20_000;

impl<const FALLING: bool, const TABLE: bool> Domains<FALLING, TABLE> {
    /// Copies all states to the single engine, which can continue only after [`Self::complete`].
    pub fn settle(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        let Some(cut) = self.cut.as_mut().filter(|cut| !cut.is_settled) else { return };
        let begin = Instant::now();
        cut.is_settled = true;
        whole.clock.now = cut.latest;
        whole.schedule.queue.resume(cut.now, cut.steps);
        let record = |domain: &Domain<FALLING, TABLE>, particle: u32| {
            (domain.held[particle as usize].whole, domain.record_for_whole(particle))
        };
        cut.gather(&self.team, record, |(particle, mut record)| {
            let of_id = |id: u32| whole.state.numbers.get(id as usize).copied();
            // The record has global numbers, except for absent partners, which are given by their ids.
            record.renumber(|number| number.checked_sub(FIRST_ABSENT).map_or(Some(number), of_id));
            whole.write_record(particle, &record);
        });
        self.work.gathering += begin.elapsed();
    }

    pub(super) fn settle_lists(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        let (Some(cut), Some(lists)) = (&self.cut, whole.neighbours.lists_mut()) else { return };
        let begin = Instant::now();
        let list = |domain: &Domain<FALLING, TABLE>, particle: u32| {
            let list = domain.engine.neighbours.verlet().map_or(&[][..], |verlet| verlet.lists.of(particle));
            let list = list.iter().map(|&other| domain.held[other as usize].whole).collect::<Vec<u32>>();
            (domain.held[particle as usize].whole, list)
        };
        cut.gather(&self.team, list, |(particle, list)| lists.set(particle, &list));
        self.work.gathering += begin.elapsed();
    }

    /// Copies all data that the single engine needs to continue.
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

    pub fn join(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        self.complete(whole);
        self.cut = None;
    }
}

impl<const FALLING: bool, const TABLE: bool> Cut<FALLING, TABLE> {
    /// Passes data of each particle from the owning domain to `write`.
    fn gather<T: Serialize + DeserializeOwned>(
        &self,
        team: &Team,
        take: impl Fn(&Domain<FALLING, TABLE>, u32) -> T,
        mut write: impl FnMut(T),
    ) {
        let owned = |domain| Domain::owned_particles(domain).map(move |particle| (domain, particle));
        let mut left = self.domains.iter().flat_map(owned);
        if !team.has_others() {
            left.for_each(|(domain, particle)| write(take(domain, particle)));
            return;
        }
        loop {
            let some = left.by_ref().take(MOST_AT_ONCE).map(|(domain, particle)| take(domain, particle)).collect();
            let all = team.all(some);
            if all.is_empty() {
                return;
            }
            all.into_iter().for_each(&mut write);
        }
    }
}
