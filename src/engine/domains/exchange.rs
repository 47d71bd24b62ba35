//! Comparison of domains after a window, and exchange of what differs.

use super::domain::{Domain, Held};
use super::regions::Regions;
use crate::base::numbers::id;
use crate::engine::columns::records::Record;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::neighbours::cells::NO_PARTICLE;

/// A step of a particle that more than one domain has: what the domains compare.
#[derive(Debug, Clone, Copy)]
pub struct Step {
    /// By its number in the whole.
    pub particle: u32,
    /// Since the epoch.
    pub time: f64,
    /// Of the step and of the motion that it leaves.
    pub hash: u64,
    /// Domains that can read the particle where it was before or is afterwards.
    pub readers: u64,
}

/// State of a particle at the end of a window that has touched it, as a hash.
#[derive(Debug, Clone, Copy)]
pub struct Summary {
    /// By its number in the whole.
    pub particle: u32,
    /// Of all that belongs to it.
    pub hash: u64,
    /// Where it is among those that were saved.
    pub saved: u32,
}

/// A particle as its owner has it, for other domains.
#[derive(Debug, Clone)]
pub struct Published {
    /// By its number in the whole, as all in the record.
    pub particle: u32,
    /// The domains that it is for.
    pub to: u64,
    pub record: Record,
}

/// A particle that has come near to other domains, or into the region of one.
#[derive(Debug, Clone, Copy)]
pub struct Transfer {
    /// By its number in the whole.
    pub particle: u32,
    /// Domains that have it from now on, and the one that owns it.
    pub known_to: u64,
    pub owner: u64,
}

/// Result of a comparison.
#[derive(Debug, Clone, Default)]
pub struct Compared {
    /// Time of the first step that is another one than that of a copy's owner, of copies that owned particles can have read.
    pub difference: Option<f64>,
    /// Owned particles that others have otherwise at the end, and who has: by their numbers here.
    pub to_publish: Vec<(u32, u64)>,
    /// Copies that this domain has touched and their owners have not: where they are among those that were saved.
    pub to_revert: Vec<u32>,
    /// Owned particles that others are to have, or to own.
    pub transfers: Vec<Transfer>,
}

impl<const FALLING: bool, const TABLE: bool> Domain<FALLING, TABLE> {
    /// Compares this domain with all others after a window.
    pub fn compare(&self, regions: &Regions, all: &[Self]) -> Compared {
        let difference = self.first_difference(regions, all);
        if difference.is_some() {
            return Compared { difference, ..Compared::default() };
        }
        let mut compared = Compared::default();
        let others: Vec<&Self> = all.iter().filter(|other| other.bit != self.bit).collect();
        let mut places = vec![0; others.len()];
        for summary in &self.summaries {
            let particle = self.here[summary.particle as usize];
            let held = self.held[particle as usize];
            let is_owned = held.is_owned();
            let (mut differing, mut is_reverted) = (0, !is_owned);
            for (other, place) in others.iter().zip(&mut places) {
                while other.summaries.get(*place).is_some_and(|theirs| theirs.particle < summary.particle) {
                    *place += 1;
                }
                let theirs = other.summaries.get(*place).filter(|theirs| theirs.particle == summary.particle);
                if is_owned {
                    let has_it = held.known_to & other.bit != 0;
                    if has_it && theirs.is_none_or(|theirs| theirs.hash != summary.hash) {
                        differing |= other.bit;
                    }
                } else if theirs.is_some() && other.held[other.here[summary.particle as usize] as usize].is_owned() {
                    // Either it is the same, or it is published.
                    is_reverted = false;
                }
            }
            if differing != 0 {
                compared.to_publish.push((particle, differing));
            }
            if is_reverted {
                compared.to_revert.push(summary.saved);
            }
        }
        self.find_transfers(regions, &mut compared);
        compared
    }

    /// Owned particles that have come to where other domains have copies, or into another region.
    fn find_transfers(&self, regions: &Regions, compared: &mut Compared) {
        let mut near = Candidates::default();
        for &particle in &self.moved {
            let column = regions.column(&self.engine, particle);
            let Held { known_to, whole, .. } = self.held[particle as usize];
            let new = regions.holders[column] & !known_to;
            let owner = 1 << regions.owner[column];
            let owner = if known_to & owner == 0 { self.bit } else { owner };
            if new == 0 && owner == self.bit {
                continue;
            }
            if new != 0 {
                compared.to_publish.push((particle, new));
                // They have dropped contacts with it.
                self.engine.neighbours.find_candidates(particle, &mut near);
                for &other in near.found() {
                    let to = self.held[other as usize].known_to & new;
                    if to != 0 && self.engine.schedule.predictions[other as usize].partner == particle {
                        compared.to_publish.push((other, to));
                    }
                }
            }
            compared.transfers.push(Transfer { particle: whole, known_to: known_to | new, owner });
        }
    }

    /// Records for other domains.
    pub fn publish(&self, to_publish: &[(u32, u64)]) -> Vec<Published> {
        let published = to_publish.iter().map(|&(particle, to)| {
            let mut record = self.engine.record(particle);
            record.renumber(|number| self.held.get(number as usize).map(|held| held.whole));
            Published { particle: self.held[particle as usize].whole, to, record }
        });
        published.collect()
    }

    /// Makes copies what their owners have.
    pub fn refresh(&mut self, published: &[Vec<Published>], compared: &[Compared], mine: usize) {
        let for_this = || published.iter().flatten().filter(|one| one.to & self.bit != 0);
        let mut coming: Vec<u32> = for_this().map(|one| one.particle).collect();
        coming.retain(|&particle| self.here[particle as usize] == NO_PARTICLE);
        for &particle in &coming {
            if self.here[particle as usize] == NO_PARTICLE {
                self.here[particle as usize] = id(self.held.len());
                self.held.push(Held::new(particle, 0));
            }
        }
        let reverted = compared[mine].to_revert.iter();
        let mut records: Vec<_> = reverted.map(|&saved| self.saved[saved as usize].clone()).collect();
        for one in published.iter().flatten().filter(|one| one.to & self.bit != 0) {
            let mut record = one.record.clone();
            self.take_in(&mut record);
            record.number = self.here[one.particle as usize];
            records.push(record);
        }
        self.add_copies(&records);
        self.write(&records);
        for transfer in compared.iter().flat_map(|compared| &compared.transfers) {
            let here = self.here[transfer.particle as usize];
            if here != NO_PARTICLE {
                let known_to = if transfer.owner == self.bit { transfer.known_to } else { 0 };
                self.held[here as usize].known_to = known_to;
            }
        }
    }

    /// Adds copies of particles that have not been here, of whose numbers there are records.
    pub fn add_copies(&mut self, records: &[Record]) {
        let first = self.engine.particles().end;
        let mut new: Vec<&Record> = records.iter().filter(|record| record.number >= first).collect();
        new.sort_by_key(|record| record.number);
        new.dedup_by_key(|record| record.number);
        for record in &new {
            self.engine.push_record(record);
        }
        if !new.is_empty() {
            self.engine.scratch = None;
        }
        for record in new {
            for pair in record.captured.iter().flatten() {
                self.engine.set_pair_state(record.number, pair.partner, pair.state, pair.interaction);
            }
            self.engine.fill_list(record.number);
        }
    }

    /// Writes records by the numbers here, has lists follow, and puts predictions into the queue.
    pub fn write(&mut self, records: &[Record]) {
        let mut moved = Vec::new();
        for record in records {
            let particle = record.number;
            let is_moved = record.place != Some(self.engine.neighbours.place(particle))
                || record.captured.as_ref().is_some_and(|captured| self.engine.pairs.states.of(particle) != captured);
            if is_moved {
                moved.push(particle);
            }
            self.engine.write_record(particle, record);
        }
        for particle in moved {
            self.engine.fill_list(particle);
        }
        for record in records {
            self.engine.enqueue(record.number);
        }
    }

    /// The time of the earliest step of this window that is another one than that of a copy's owner, of copies that owned particles can have read.
    fn first_difference(&self, regions: &Regions, all: &[Self]) -> Option<f64> {
        let is_copy = |step: &&Step| !self.held[self.here[step.particle as usize] as usize].is_owned();
        let mine: Vec<&Step> = self.steps.iter().filter(is_copy).collect();
        let mut theirs: Vec<&Step> = Vec::new();
        for other in all.iter().filter(|other| other.bit != self.bit) {
            let is_known =
                |step: &&Step| other.held[other.here[step.particle as usize] as usize].known_to & self.bit != 0;
            theirs.extend(other.steps.iter().filter(is_known));
        }
        theirs.sort_by_key(|step| step.particle);
        let (mut mine, mut theirs) = (&mine[..], &theirs[..]);
        let mut first: Option<f64> = None;
        loop {
            let particle = match (mine.first(), theirs.first()) {
                (Some(one), Some(other)) => one.particle.min(other.particle),
                (Some(one), None) => one.particle,
                (None, Some(other)) => other.particle,
                (None, None) => return first,
            };
            let count = |steps: &[&Step]| steps.iter().take_while(|step| step.particle == particle).count();
            let (one, mine_after) = mine.split_at(count(mine));
            let (other, theirs_after) = theirs.split_at(count(theirs));
            (mine, theirs) = (mine_after, theirs_after);
            let differs = |k: &usize| match (one.get(*k), other.get(*k)) {
                (Some(a), Some(b)) => a.hash != b.hash,
                _ => true,
            };
            let Some(k) = (0..one.len().max(other.len())).find(differs) else { continue };
            // A copy without a step is where it was at the start.
            let stays = || regions.readers[regions.column(&self.engine, self.here[particle as usize])];
            let at_start = if one.is_empty() { stays() } else { 0 };
            let readers = one.iter().chain(other).fold(at_start, |readers, step| readers | step.readers);
            if readers & self.bit != 0 {
                let time = |steps: &[&Step]| steps.get(k).map_or(f64::INFINITY, |step| step.time);
                let time = time(one).min(time(other));
                first = Some(first.map_or(time, |first| first.min(time)));
            }
        }
    }
}

/// A hash of some numbers: each is mixed in by a multiplication of which all bits are kept.
#[inline]
pub fn hash(kind: u64, numbers: impl IntoIterator<Item = u64>) -> u64 {
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
    numbers.into_iter().fold(kind ^ FACTOR, |hash, number| {
        let product = u128::from(hash ^ number) * u128::from(FACTOR);
        #[expect(clippy::cast_possible_truncation, reason = "both halves are taken")]
        let folded = (product >> 64) as u64 ^ product as u64;
        folded.wrapping_add(hash.rotate_left(29))
    })
}
