//! The event queue: a calendar of unsorted time buckets and a small sorted front.
//!
//! A bucket stores the particles that are due in a time interval. When the interval begins, these particles are sorted
//! and become the front. If the event of a particle is predicted anew, old entries of the particle stay in the queue
//! and are dropped later. (Alias: future event list, calendar queue; Paul, J. Comput. Phys. 221, 615, 2007.)

mod buckets;

use crate::base::numbers::trunc_to_usize;
use buckets::Buckets;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QueueEntry {
    /// Time at which the particle is due, since the epoch.
    pub time: f64,
    pub particle: u32,
    /// Order of simultaneous entries: the lowest value comes first. Entries with equal values are ordered by rank.
    pub tie_order: u32,
}

impl QueueEntry {
    #[inline]
    fn ties_with(&self, other: &Self) -> bool {
        self.time == other.time && self.tie_order == other.tie_order
    }

    #[inline]
    fn key(&self) -> u128 {
        let bits = self.time.to_bits().cast_signed();
        // Makes integers sort like floats: all bits of a negative number are inverted, otherwise only the sign bit.
        let ordered = bits.cast_unsigned() ^ ((bits >> 63).cast_unsigned() | 1 << 63);
        u128::from(ordered) << 64 | u128::from(self.tie_order) << 32 | u128::from(self.particle)
    }
}

/// Gives the event queue access to the pending predictions of all particles.
pub trait Pending {
    /// Returns the entry of a particle. The time is infinite if no event is predicted.
    fn entry(&self, particle: u32) -> QueueEntry;

    /// Order of entries with equal time and tie order: the lowest rank comes first. Ranks must not depend on the order
    /// of particles in memory.
    fn rank(&self, particle: u32) -> u64;

    fn prefetch(&self, particle: u32);
}

/// Upper limit of the initial length of a bucket. It keeps the length of an epoch finite.
const LONGEST: f64 = 1e290;

/// Approximate number of particles per bucket in a large system.
const PARTICLES: usize = 8;

/// Target number of steps per epoch for each group of [`PARTICLES`] particles.
const TARGET: u32 = 64;

/// An epoch ends early if the number of steps exceeds the target by this factor. Otherwise, an epoch that begins with
/// particles at rest could be much too long.
const CROWDED: u64 = 4;

/// Number of ticks of an epoch. An epoch may end early only at a tick. The number of ticks is constant, so the number of
/// buckets does not affect the results.
const TICKS: usize = 64;

/// Data are prefetched for the entry this many places ahead.
const AHEAD: usize = 8;

/// The event queue. It holds the entries from the epoch to the horizon. Later entries are not stored.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EventQueue {
    /// Entries of the current bucket, sorted from the latest to the earliest.
    front: Vec<QueueEntry>,
    buckets: Buckets,
    opened: Vec<u32>,
    cursor: usize,
    /// Duration of a bucket. It is a power of two, so bucket numbers and horizons are exact.
    width: f64,
    per_width: f64,
    /// Number of steps in this epoch. A step removes an entry that was due.
    steps: u64,
    target: u64,
}

impl EventQueue {
    /// Returns a queue for `particles` particles. The argument `due` is the number of particles with a predicted event.
    /// Half of these events are due within the time `median` after the epoch.
    #[must_use]
    pub fn new(particles: usize, due: usize, median: f64) -> Self {
        // The target is at least about eight steps per particle. Longer epochs would be less accurate, because larger
        // times have more round-off.
        let parts = Self::parts(particles);
        let span = if median.is_finite() && median > 0.0 {
            power_of_two((median * f64::from(TARGET) / due as f64).min(LONGEST)) * parts as f64
        } else {
            parts as f64
        };
        Self::with_buckets(parts.max(TICKS), parts, span)
    }

    fn parts(particles: usize) -> usize {
        (particles / PARTICLES).next_power_of_two().min(1 << 22)
    }

    /// Whether the queue suits this number of particles, within a factor of four.
    pub fn fits(&self, particles: usize) -> bool {
        let (parts, now) = (Self::parts(particles) as u64, self.target / u64::from(TARGET));
        parts <= now && now < 4 * parts
    }

    /// Fits an empty queue to another number of particles. The duration of an epoch is unchanged.
    pub fn fit_to(&mut self, particles: usize) {
        if !self.fits(particles) {
            let parts = Self::parts(particles);
            *self = Self::with_buckets(parts.max(TICKS), parts, self.span());
        }
    }

    /// Returns an empty queue. The number of buckets is a power of two and affects only speed.
    fn with_buckets(buckets: usize, parts: usize, span: f64) -> Self {
        let width = span / buckets as f64;
        Self {
            front: Vec::new(),
            buckets: Buckets::new(buckets),
            opened: Vec::new(),
            cursor: 0,
            width,
            per_width: width.recip(),
            steps: 0,
            target: u64::from(TARGET) * parts as u64,
        }
    }

    /// Duration of an epoch that does not end early.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.width * self.buckets.count() as f64
    }

    /// Time from the epoch to the end of the current bucket. At the end of an epoch, this is the duration of the epoch.
    #[must_use]
    pub fn reached(&self) -> f64 {
        self.width * (self.cursor + 1) as f64
    }

    #[inline]
    fn bucket(&self, time: f64) -> usize {
        trunc_to_usize(time * self.per_width)
    }

    /// Adds the entry of a particle, if an event is predicted.
    #[inline]
    pub fn enter(&mut self, particle: u32, pending: &impl Pending) {
        let entry = pending.entry(particle);
        if entry.time < f64::INFINITY {
            self.push(entry, pending);
        }
    }

    /// Adds an entry. Entries beyond the horizon are dropped. The next epoch adds all particles anew.
    #[inline]
    pub fn push(&mut self, entry: QueueEntry, pending: &impl Pending) {
        let bucket = self.bucket(entry.time);
        if bucket <= self.cursor {
            let after = {
                let key = entry.key();
                self.front.partition_point(|other| key < other.key())
            };
            self.front.insert(after, entry);
            let is_tie = |other: Option<&QueueEntry>| other.is_some_and(|other| other.ties_with(&entry));
            if is_tie(self.front.get(after + 1)) || is_tie(after.checked_sub(1).map(|before| &self.front[before])) {
                let first = self.front[..after].iter().rposition(|other| !other.ties_with(&entry));
                self.order_ties(first.map_or(0, |before| before + 1), pending);
            }
        } else if bucket < self.buckets.count() {
            self.buckets.push(bucket, entry.particle);
        }
    }

    /// Returns the earliest entry.
    ///
    /// Returns `None` if the epoch has ended, or if nothing is due in the buckets up to the bucket of `limit`. Later
    /// buckets stay closed, because an event at `limit` may add earlier entries.
    #[inline]
    pub fn peek(&mut self, limit: f64, pending: &impl Pending) -> Option<QueueEntry> {
        loop {
            if let Some(front) = self.front.last() {
                return Some(*front);
            }
            if limit < self.reached() {
                return None;
            }
            let reached = self.cursor + 1;
            let is_tick = reached.is_multiple_of(self.buckets.count() / TICKS);
            if reached >= self.buckets.count() || (is_tick && self.steps > CROWDED * self.target) {
                return None;
            }
            self.cursor += 1;
            self.open(pending);
        }
    }

    /// Removes the earliest entry, and counts a step.
    #[inline]
    pub fn pop(&mut self) {
        self.steps += 1;
        self.front.pop();
    }

    /// Removes the earliest entry without counting a step.
    #[inline]
    pub fn discard(&mut self) {
        self.front.pop();
    }

    /// Returns the particle of an entry in the front. The entry with `ahead = 0` is the earliest.
    #[inline]
    #[must_use]
    pub fn coming(&self, ahead: usize) -> Option<u32> {
        let at = self.front.len().checked_sub(ahead + 1)?;
        Some(self.front[at].particle)
    }

    fn open(&mut self, pending: &impl Pending) {
        self.opened.clear();
        self.buckets.take(self.cursor, &mut self.opened);
        for &particle in self.opened.iter().take(AHEAD) {
            pending.prefetch(particle);
        }
        for at in 0..self.opened.len() {
            if let Some(&particle) = self.opened.get(at + AHEAD) {
                pending.prefetch(particle);
            }
            let entry = pending.entry(self.opened[at]);
            if self.bucket(entry.time) == self.cursor {
                self.front.push(entry);
            }
        }
        self.front.sort_unstable_by_key(|entry| !entry.key());
        let mut has_ties = false;
        // The same particle may occur several times in a bucket.
        self.front.dedup_by(|entry, before| {
            has_ties |= entry.ties_with(before) && entry.particle != before.particle;
            entry.particle == before.particle
        });
        let mut at = 0;
        while has_ties && at < self.front.len() {
            at = self.order_ties(at, pending);
        }
    }

    /// Sorts all entries that tie with the entry `first`, and removes duplicates. Returns the index after the last tie.
    #[cold]
    fn order_ties(&mut self, first: usize, pending: &impl Pending) -> usize {
        let one = self.front[first];
        let end = first + self.front[first..].iter().take_while(|entry| entry.ties_with(&one)).count();
        if end == first + 1 {
            return end;
        }
        let mut ties: Vec<QueueEntry> = self.front[first..end].to_vec();
        ties.retain(|entry| pending.entry(entry.particle) == *entry);
        ties.sort_unstable_by_key(|entry| (!pending.rank(entry.particle), entry.particle));
        ties.dedup();
        let end_of_ties = first + ties.len();
        self.front.splice(first..end, ties);
        end_of_ties
    }

    /// Returns an empty queue for an engine with a part of the particles. The new queue never ends the epoch early.
    pub fn of_part(&self, now: f64, some: usize, all: usize) -> Self {
        // With fewer buckets, the average number of entries in a bucket is unchanged.
        let fewer = (all / some.max(1)).max(2).next_power_of_two();
        let buckets = (self.buckets.count() / fewer).max(TICKS);
        let mut queue = Self { target: u64::MAX / CROWDED, ..Self::with_buckets(buckets, 1, self.span()) };
        queue.cursor = queue.cursor_at(now);
        queue
    }

    /// Empties the queue, and continues the epoch at the time `now`, after `steps` steps.
    pub fn resume(&mut self, now: f64, steps: u64) {
        self.clear();
        (self.cursor, self.steps) = (self.cursor_at(now), steps);
    }

    fn cursor_at(&self, time: f64) -> usize {
        self.bucket(time).min(self.buckets.count() - 1)
    }

    /// Moves the queue back to an earlier time of the same epoch. Removed entries are not restored.
    pub fn rewind(&mut self, time: f64, pending: &impl Pending) {
        self.cursor = self.cursor_at(time);
        for entry in std::mem::take(&mut self.front) {
            self.push(entry, pending);
        }
    }

    /// Returns the next time after `now` at which the epoch may end early.
    pub fn next_tick(&self, now: f64) -> f64 {
        let part = self.span() / TICKS as f64;
        part * (trunc_to_usize(now / part) + 1) as f64
    }

    /// Whether the epoch ends at the time `tick`, after `steps` steps.
    pub fn ends_at(&self, tick: f64, steps: u64) -> bool {
        tick >= self.span() || steps > CROWDED * self.target
    }

    pub fn steps(&self) -> u64 {
        self.steps
    }

    pub fn target(&self) -> u64 {
        self.target
    }

    /// Removes all entries. The epoch continues.
    pub fn clear(&mut self) {
        self.front.clear();
        self.buckets.clear();
    }

    /// Empties the queue for a new epoch. The new duration follows from the number of steps in the previous epoch.
    pub fn restart(&mut self) {
        self.clear();
        let expected = self.target as f64 * (self.reached() / self.span());
        let crowd = self.steps as f64 / expected;
        (self.cursor, self.steps) = (0, 0);
        // The duration is unchanged if the number of steps was within a factor of two of the target.
        let factor =
            if (0.5..=2.0).contains(&crowd) { 1.0 } else { power_of_two(crowd.recip().clamp(1.0 / 1024.0, 1024.0)) };
        let width = self.width * factor;
        if width.is_normal() && (width * self.buckets.count() as f64).is_finite() && width.recip().is_normal() {
            self.width = width;
            self.per_width = width.recip();
        }
    }

    /// Checks data that was read from a file: all entries must refer to existing particles and buckets.
    pub fn is_sound(&self, particles: usize) -> bool {
        let is_particle = |entry: &QueueEntry| (entry.particle as usize) < particles;
        let count = self.buckets.count();
        let has_ticks = count.is_power_of_two() && count >= TICKS && self.cursor < count;
        let has_times = self.width > 0.0 && self.width.is_finite() && self.per_width == self.width.recip();
        has_ticks && has_times && self.front.iter().all(is_particle) && self.buckets.is_sound(particles)
    }

    /// Returns an empty queue with epochs of the same duration and a different number of buckets.
    #[cfg(test)]
    pub fn rebuilt(&self, buckets: usize) -> Self {
        assert_eq!((self.cursor, self.steps), (0, 0), "the queue is at the beginning of an epoch");
        Self { target: self.target, ..Self::with_buckets(buckets, 1, self.span()) }
    }
}

impl Default for EventQueue {
    fn default() -> Self {
        Self::new(0, 0, 1.0)
    }
}

/// Returns the largest power of two up to `x`, which must be positive.
fn power_of_two(x: f64) -> f64 {
    let x = x.clamp(f64::MIN_POSITIVE * 1024.0, f64::MAX / 1024.0);
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

#[cfg(test)]
mod tests;
