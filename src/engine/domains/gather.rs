//! Transfers the state of the domains to the single engine.

use super::Domains;
use super::cut::Cut;
use super::domain::Domain;
use super::team::Team;
use crate::engine::columns::PartNumbers;
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
        if self.team.has_others() {
            cut.gather_records(&self.team, whole);
        } else {
            cut.take_over(&self.team, whole, false);
        }
        self.work.gathering += begin.elapsed();
    }

    /// Copies predictions, places and neighbour lists to the single engine, after [`Self::settle`].
    pub(super) fn settle_plans(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        let Some(cut) = &self.cut else { return };
        let begin = Instant::now();
        if self.team.has_others() {
            cut.gather_lists(&self.team, whole);
        } else {
            cut.take_over(&self.team, whole, true);
            cut.take_lists(whole);
        }
        self.work.gathering += begin.elapsed();
    }

    /// Copies all data that the single engine needs to continue.
    pub fn complete(&mut self, whole: &mut Engine<FALLING, TABLE>) {
        self.settle(whole);
        if self.cut.as_ref().is_none_or(|cut| cut.is_complete) {
            return;
        }
        self.settle_plans(whole);
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
    /// Copies one kind of columns from the domains to the single engine.
    fn take_over(&self, team: &Team, whole: &mut Engine<FALLING, TABLE>, is_plan: bool) {
        for domain in &self.domains {
            let number = |particle: u32| domain.held.get(particle as usize).map(|held| held.whole);
            let numbers = PartNumbers { here: &domain.here, owned: &domain.owned, whole: &number };
            team.within(|| whole.take_over(&domain.engine, &numbers, is_plan));
        }
        if is_plan {
            for particle in whole.particles() {
                let absent = whole.schedule.predictions[particle as usize].absent_partner();
                if let Some(partner) = absent.and_then(|id| whole.state.number(id)) {
                    whole.schedule.predictions[particle as usize].partner = partner;
                }
            }
        }
    }

    fn take_lists(&self, whole: &mut Engine<FALLING, TABLE>) {
        let Some(lists) = whole.neighbours.lists_mut() else { return };
        let mut in_whole = Vec::new();
        for domain in &self.domains {
            let Some(verlet) = domain.engine.neighbours.verlet() else { continue };
            for particle in domain.owned_particles() {
                in_whole.clear();
                in_whole.extend(verlet.lists.of(particle).iter().map(|&other| domain.held[other as usize].whole));
                lists.set(domain.held[particle as usize].whole, &in_whole);
            }
        }
    }

    fn gather_records(&self, team: &Team, whole: &mut Engine<FALLING, TABLE>) {
        let record = |domain: &Domain<FALLING, TABLE>, particle: u32| {
            (domain.held[particle as usize].whole, domain.record_for_whole(particle))
        };
        self.gather(team, record, |(particle, mut record)| {
            // The record has global numbers, except for absent partners, which are given by their ids.
            let number =
                |number: u32| number.checked_sub(FIRST_ABSENT).map_or(Some(number), |id| whole.state.number(id));
            record.renumber(number);
            whole.write_record(particle, &record);
        });
    }

    fn gather_lists(&self, team: &Team, whole: &mut Engine<FALLING, TABLE>) {
        let Some(lists) = whole.neighbours.lists_mut() else { return };
        let list = |domain: &Domain<FALLING, TABLE>, particle: u32| {
            let list = domain.engine.neighbours.verlet().map_or(&[][..], |verlet| verlet.lists.of(particle));
            let list = list.iter().map(|&other| domain.held[other as usize].whole).collect::<Vec<u32>>();
            (domain.held[particle as usize].whole, list)
        };
        self.gather(team, list, |(particle, list)| lists.set(particle, &list));
    }

    /// Passes data of each particle from the owning domain to `write`, in all processes.
    fn gather<T: Serialize + DeserializeOwned>(
        &self,
        team: &Team,
        take: impl Fn(&Domain<FALLING, TABLE>, u32) -> T,
        mut write: impl FnMut(T),
    ) {
        let owned = |domain| Domain::owned_particles(domain).map(move |particle| (domain, particle));
        let mut left = self.domains.iter().flat_map(owned);
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
