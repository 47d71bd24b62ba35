//! Compares the domains after a window, and updates copies that differ.

use super::domain::{Domain, Held, Touched};
use super::regions::Regions;
use crate::base::numbers::id;
use crate::engine::columns::records::Record;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::marks::Marks;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::prediction::{absent, id_of};
use serde::{Deserialize, Serialize};

/// Data are prefetched for the report this many places ahead.
const AHEAD: usize = 8;

/// A step of a particle that several domains hold.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Step {
    /// Local number of the particle in a domain, or its global number in a message.
    pub particle: u32,
    /// True if the particle was only predicted again. Such a step does not change the state of the particle.
    pub is_void: bool,
    /// Time of the step since the epoch.
    pub time: f64,
    /// Hash of the time and of the data that the step changed.
    pub hash: u64,
    /// Domains with particles that can read this particle before or after the step, as bits.
    pub readers: u64,
}

/// Report of a domain about the steps of its copies in a window. The owner of the copies receives the report.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Report {
    pub from: u8,
    pub to: u8,
    /// Global numbers of the copies that had steps, and the digests of their steps.
    pub touched: Vec<(u32, u64)>,
    pub steps: Vec<Step>,
}

/// Current state of a particle. The owner of the particle sends it to other domains.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Published {
    pub from: u8,
    /// Global number of the particle. The numbers in the record are global, too.
    pub particle: u32,
    /// Id of the predicted partner.
    pub partner: u32,
    /// The receiving domains, as bits.
    pub to: u64,
    pub record: Record,
}

/// A particle that needs copies in more domains, or a new owner.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub struct Transfer {
    /// Global number.
    pub particle: u32,
    /// Domains that hold the particle after the transfer, as bits.
    pub known_to: u64,
    pub owner: u8,
}

/// Differences between the owned particles and the copies in other domains.
#[derive(Debug, Clone, Default)]
pub struct Compared {
    /// Earliest time at which a copy differs from the owned particle, ignoring copies that no particle can have read.
    pub difference: Option<f64>,
    /// Local numbers of the particles to send, and the receiving domains as bits.
    pub to_publish: Vec<(u32, u64)>,
    pub transfers: Vec<Transfer>,
}

impl<const FALLING: bool, const TABLE: bool> Domain<FALLING, TABLE> {
    pub fn reports(&self, domains: usize) -> Vec<Report> {
        let new = |to: u8| Report { from: self.number, to, touched: Vec::new(), steps: Vec::new() };
        let mut reports: Vec<Report> = (0..).take(domains).map(new).collect();
        for Touched { held, digest, .. } in self.touched.iter().filter(|touched| !touched.held.is_owned()) {
            reports[usize::from(held.owner)].touched.push((held.whole, *digest));
        }
        for (owner, step) in &self.steps_of_copies {
            reports[usize::from(*owner)].steps.push(*step);
        }
        reports.swap_remove(usize::from(self.number));
        reports
    }

    pub fn compare(&self, regions: &Regions, reports: &[Report]) -> Compared {
        let mut compared = Compared::default();
        for report in reports.iter().filter(|report| report.to == self.number) {
            self.compare_with(report, &mut compared);
        }
        if compared.difference.is_none() {
            self.find_transfers(regions, &mut compared);
        }
        compared
    }

    fn compare_with(&self, report: &Report, compared: &mut Compared) {
        let bit = 1 << report.from;
        let mut differing = Vec::new();
        let mut are_touched = Marks::default();
        for (at, &(whole, digest)) in report.touched.iter().enumerate() {
            self.prefetch_reported(report, at);
            let mine = self.here[whole as usize];
            let touch = self.touch(mine);
            if let Some(touch) = touch {
                are_touched.put(id(touch), true);
            }
            if touch.is_none_or(|touch| self.touched[touch].digest != digest) {
                differing.push((mine, whole));
            }
        }
        for (touch, &Touched { particle, held, .. }) in (0..).zip(&self.touched) {
            if held.known_to & bit != 0 && !are_touched.has(touch) {
                differing.push((particle, held.whole));
            }
        }
        let (mine, theirs): (Vec<u32>, Vec<u32>) = differing.iter().copied().unzip();
        let (mine, theirs) = (steps_of(&self.steps, &mine), steps_of(&report.steps, &theirs));
        for (one, copy) in differing {
            compared.to_publish.push((one, bit));
            let difference = first_difference(of_particle(&mine, one), of_particle(&theirs, copy), bit);
            compared.difference = compared.difference.into_iter().chain(difference).min_by(f64::total_cmp);
        }
    }

    #[inline]
    fn prefetch_reported(&self, report: &Report, at: usize) {
        if let Some((whole, _)) = report.touched.get(at + 2 * AHEAD) {
            prefetch(&self.here, *whole as usize);
        }
        if let Some((whole, _)) = report.touched.get(at + AHEAD) {
            prefetch(&self.held, self.here[*whole as usize] as usize);
        }
    }

    fn find_transfers(&self, regions: &Regions, compared: &mut Compared) {
        let mut near = Candidates::default();
        for &particle in &self.moved {
            let columns = regions.columns(&self.engine, particle);
            let Held { known_to, whole, .. } = self.held[particle as usize];
            let new = regions.holders(columns) & !known_to;
            let owner = regions.owner(columns);
            let owner = if known_to & 1 << owner == 0 { self.number } else { owner };
            if new == 0 && owner == self.number {
                continue;
            }
            if owner != self.number && new & 1 << owner == 0 {
                // The new owner has a copy, but the copy may have a different prediction.
                compared.to_publish.push((particle, 1 << owner));
            }
            if new != 0 {
                compared.to_publish.push((particle, new));
                // The new domain may hold a neighbour that is predicted to meet this particle. There, the prediction
                // marks this particle as absent, so the neighbour is sent, too.
                self.engine.neighbours.find_candidates(particle, self.engine.row(particle), &mut near);
                let captured = if TABLE { self.engine.pairs.states.of(particle) } else { &[] };
                let captured = captured.iter().map(|pair| pair.partner);
                for other in near.found().iter().copied().chain(captured) {
                    let to = self.held[other as usize].known_to & new;
                    if to != 0 && self.engine.schedule.predictions[other as usize].partner == particle {
                        compared.to_publish.push((other, to));
                    }
                }
            }
            compared.transfers.push(Transfer { particle: whole, known_to: known_to | new, owner });
        }
    }

    pub fn publish(&self, to_publish: &[(u32, u64)]) -> Vec<Published> {
        let published = to_publish.iter().map(|&(particle, to)| {
            let partner = self.engine.schedule.predictions[particle as usize].partner;
            Published {
                from: self.number,
                particle: self.held[particle as usize].whole,
                partner: if partner == NO_PARTICLE { partner } else { id_of(partner, &self.engine.state.bodies) },
                to,
                record: self.record_for_whole(particle),
            }
        });
        published.collect()
    }

    pub fn refresh(&mut self, published: &[Published], transfers: &[Transfer]) {
        let bit = self.bit;
        let mut for_this: Vec<&Published> = Vec::new();
        for one in published.iter().filter(|one| one.to & bit != 0) {
            if self.here[one.particle as usize] == NO_PARTICLE {
                self.here[one.particle as usize] = id(self.held.len());
                self.hold(Held::new(one.particle, one.from, 0));
            }
            for_this.push(one);
        }
        let as_here = for_this.into_iter().map(|one| {
            let mut record = one.record.clone();
            record.renumber(|number| self.here.get(number as usize).copied().filter(|here| *here != NO_PARTICLE));
            record.number = self.here[one.particle as usize];
            if let Some(prediction) = record.prediction.as_mut().filter(|it| it.absent_partner().is_some()) {
                prediction.partner = absent(one.partner);
            }
            record
        });
        let records: Vec<Record> = as_here.collect();
        self.add_copies(&records);
        self.write(&records);
        for transfer in transfers {
            let here = self.here[transfer.particle as usize];
            if here != NO_PARTICLE {
                let known_to = if transfer.owner == self.number { transfer.known_to } else { 0 };
                self.set_held(here, Held::new(transfer.particle, transfer.owner, known_to));
            }
        }
    }

    /// Adds the particles in `records` that this domain does not hold yet.
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

    /// Writes records in the given order, updates neighbour lists, and puts predictions into the queue.
    pub fn write(&mut self, records: &[Record]) {
        let written = self.engine.restore(records);
        written.into_iter().for_each(|particle| self.engine.enqueue(particle));
    }
}

fn steps_of(steps: &[Step], particles: &[u32]) -> Vec<Step> {
    let mut wanted = particles.to_vec();
    wanted.sort_unstable();
    let is_wanted = |step: &&Step| wanted.binary_search(&step.particle).is_ok();
    let mut steps: Vec<Step> = steps.iter().filter(is_wanted).copied().collect();
    steps.sort_by_key(|step| step.particle);
    steps
}

fn of_particle(steps: &[Step], particle: u32) -> &[Step] {
    let first = steps.partition_point(|step| step.particle < particle);
    let end = steps.partition_point(|step| step.particle <= particle);
    &steps[first..end]
}

/// Returns the time of the first step in which a particle and its copy differ. Returns `None` if they agree, or if no
/// particle in the domain of the copy can have read the copy.
fn first_difference(one: &[Step], copy: &[Step], bit: u64) -> Option<f64> {
    if one.iter().chain(copy).all(|step| step.readers & bit == 0) {
        return None;
    }
    let mut one = one.iter().filter(|step| !step.is_void);
    let mut copy = copy.iter().filter(|step| !step.is_void);
    loop {
        match (one.next(), copy.next()) {
            (None, None) => return None,
            (Some(one), Some(copy)) if one.hash == copy.hash => {}
            (one, copy) => return one.into_iter().chain(copy).map(|step| step.time).min_by(f64::total_cmp),
        }
    }
}

/// Returns a hash of a list of numbers.
#[inline(always)]
pub fn hash<const N: usize>(start: u64, numbers: [u64; N]) -> u64 {
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
    numbers.into_iter().fold(start ^ FACTOR, |hash, number| {
        let product = u128::from(hash ^ number) * u128::from(FACTOR);
        #[expect(clippy::cast_possible_truncation, reason = "both halves are taken")]
        let folded = (product >> 64) as u64 ^ product as u64;
        folded.wrapping_add(hash.rotate_left(29))
    })
}
