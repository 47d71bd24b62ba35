//! The event queue: a calendar of unsorted time buckets and a small sorted front.
//!
//! Each particle has at most one entry, for its prediction. A bucket stores only the numbers of the particles
//! that are due within its time. Entries are never removed from a bucket. When time reaches a bucket, the
//! present predictions of its particles are read. Particles that are no longer due within the bucket are
//! dropped, and all other particles are sorted and become the front. An entry of the front is stale if its
//! time differs from the time of the particle's prediction; the event loop drops stale entries. (Alias:
//! future event list, calendar queue; Paul, J. Comput. Phys. 221, 615, 2007.)

mod buckets;

use crate::base::numbers::trunc_to_usize;
use buckets::Buckets;
use serde::{Deserialize, Serialize};

/// An entry of the queue: a particle with the time at which it is due.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QueueEntry {
    /// Time since the epoch.
    pub time: f64,
    /// Number of the particle.
    pub particle: u32,
    /// Orders entries of the same time, before [`Pending::rank`].
    pub tie_order: u32,
}

impl QueueEntry {
    /// Whether two entries have the same time and tie order.
    #[inline]
    fn ties_with(&self, other: &Self) -> bool {
        self.time == other.time && self.tie_order == other.tie_order
    }

    /// A number that orders entries by time and tie order, and then by particle.
    #[inline]
    fn key(&self) -> u128 {
        let bits = self.time.to_bits().cast_signed();
        // Inverts all bits of a negative number, and the sign bit of a positive one.
        let ordered = bits.cast_unsigned() ^ ((bits >> 63).cast_unsigned() | 1 << 63);
        u128::from(ordered) << 64 | u128::from(self.tie_order) << 32 | u128::from(self.particle)
    }
}

/// The pending predictions that the queue orders.
pub trait Pending {
    /// The entry of a particle; its time is infinite if the particle is never due.
    fn entry(&self, particle: u32) -> QueueEntry;

    /// Orders entries of the same time and tie order, independently of the order in memory.
    fn rank(&self, particle: u32) -> u64;

    /// Prefetches the prediction of a particle.
    fn prefetch(&self, particle: u32);
}

/// Maximum initial length of a bucket, so that the length of an epoch is finite.
const LONGEST: f64 = 1e290;

/// Number of particles to which [`TARGET`] refers.
const PARTICLES: usize = 8;

/// Number of steps per epoch of [`PARTICLES`] particles, to which the length of an epoch is tuned. Also the
/// number of entries in a bucket at the default number of buckets.
const TARGET: u32 = 64;

/// An epoch ends early after this multiple of the steps to which its length is tuned. It may have been
/// planned in a quiet time, such as a start at rest or with distant particles. If such an epoch did not end
/// early, the times of a busy period would have too few digits.
const CROWDED: u64 = 4;

/// Number of parts of an epoch. An epoch may end early at the end of a part. The parts and the length of an
/// epoch are independent of buckets, so that the queue's layout does not affect the results.
const TICKS: usize = 64;

/// Number of entries by which prefetching runs ahead while a bucket is opened.
const AHEAD: usize = 8;

/// Event queue: entries between the epoch and its horizon. Later entries are not stored.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EventQueue {
    /// The bucket that time has reached, sorted with the latest first.
    front: Vec<QueueEntry>,
    buckets: Buckets,
    /// Scratch: the particles of a bucket while it is opened.
    opened: Vec<u32>,
    /// Index of the bucket in `front`.
    cursor: usize,
    /// Width of a bucket, a power of two so that bucket numbers and horizons are exact.
    width: f64,
    per_width: f64,
    /// Number of steps in this epoch: entries that were due.
    steps: u64,
    /// Number of steps to which the length of an epoch is tuned.
    target: u64,
}

impl EventQueue {
    /// Returns a queue for `particles`. At present, `due` of them have an entry, and half of these entries
    /// are within `median` of the epoch.
    ///
    /// The other particles may become due later. The cost of an epoch is proportional to the number of
    /// particles. An epoch must be long enough to pay then, too.
    #[must_use]
    pub fn new(particles: usize, due: usize, median: f64) -> Self {
        // At least eight steps per particle and epoch, even for few particles. A longer epoch counts times
        // with fewer digits.
        let parts = (particles / PARTICLES).next_power_of_two().min(1 << 22);
        let span = if median.is_finite() && median > 0.0 {
            // The rate of entries per unit time is about due / median.
            power_of_two((median * f64::from(TARGET) / due as f64).min(LONGEST)) * parts as f64
        } else {
            parts as f64
        };
        Self::with_buckets(parts.max(TICKS), parts, span)
    }

    /// A queue with a given number of buckets, a power of two. It affects only speed.
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

    /// Time from the epoch to the end of the last bucket, the horizon of the queue.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.width * self.buckets.count() as f64
    }

    /// Returns the time from the epoch to the end of the bucket that time has reached. The epoch moves there
    /// next. This time is the span, unless there were too many entries.
    #[must_use]
    pub fn reached(&self) -> f64 {
        self.width * (self.cursor + 1) as f64
    }

    /// The bucket of a time; times before the epoch saturate at 0.
    #[inline]
    fn bucket(&self, time: f64) -> usize {
        trunc_to_usize(time * self.per_width)
    }

    /// Adds an entry. An entry beyond the horizon is dropped, because every particle is entered again when
    /// the epoch moves.
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
    /// Returns `None` if the epoch has ended, at the horizon or after too many entries. Also returns `None`
    /// if nothing is due in the buckets up to the bucket of `limit`. Later buckets stay closed, because an
    /// event at `limit` may add entries that are due before them. After too many entries, the epoch ends
    /// early, at the next tick.
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

    /// Removes the entry that [`Self::peek`] has just returned and counts it as a step.
    #[inline]
    pub fn pop(&mut self) {
        self.steps += 1;
        self.front.pop();
    }

    /// Removes the entry that [`Self::peek`] has just returned, without counting it.
    #[inline]
    pub fn discard(&mut self) {
        self.front.pop();
    }

    /// Returns the particle whose entry comes after `ahead` other entries, if it is in the front.
    #[inline]
    #[must_use]
    pub fn coming(&self, ahead: usize) -> Option<u32> {
        let at = self.front.len().checked_sub(ahead + 1)?;
        Some(self.front[at].particle)
    }

    /// Makes the bucket at the cursor the front.
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
        // A particle may have been entered in the same bucket more than once.
        self.front.dedup_by(|entry, before| {
            has_ties |= entry.ties_with(before) && entry.particle != before.particle;
            entry.particle == before.particle
        });
        let mut at = 0;
        while has_ties && at < self.front.len() {
            at = self.order_ties(at, pending);
        }
    }

    /// Sorts the entries with the same time and tie order as the entry at index `first`, and keeps each
    /// particle once. Returns the index after the last of these entries.
    #[cold]
    fn order_ties(&mut self, first: usize, pending: &impl Pending) -> usize {
        let one = self.front[first];
        let end = first + self.front[first..].iter().take_while(|entry| entry.ties_with(&one)).count();
        if end == first + 1 {
            return end;
        }
        let mut ties: Vec<QueueEntry> = self.front[first..end].to_vec();
        // Entries of particles that are now due at another time are void.
        ties.retain(|entry| pending.entry(entry.particle) == *entry);
        ties.sort_unstable_by_key(|entry| (!pending.rank(entry.particle), entry.particle));
        ties.dedup();
        let end_of_ties = first + ties.len();
        self.front.splice(first..end, ties);
        end_of_ties
    }

    /// Returns an empty queue of the same epoch for a subset of the particles. It ends only at the epoch's
    /// horizon.
    pub fn of_part(&self, now: f64, some: usize, all: usize) -> Self {
        // As many entries per bucket as in the queue of all particles.
        let fewer = (all / some.max(1)).max(1).next_power_of_two();
        let buckets = (self.buckets.count() / fewer).max(TICKS);
        let mut queue = Self { target: u64::MAX / CROWDED, ..Self::with_buckets(buckets, 1, self.span()) };
        queue.cursor = queue.cursor_at(now);
        queue
    }

    /// Empties the queue and continues from a time, after `steps` of the epoch.
    pub fn resume(&mut self, now: f64, steps: u64) {
        self.clear();
        (self.cursor, self.steps) = (self.cursor_at(now), steps);
    }

    /// Index of the bucket of a time; the last bucket if the time is beyond the horizon, because nothing was
    /// due before.
    fn cursor_at(&self, time: f64) -> usize {
        self.bucket(time).min(self.buckets.count() - 1)
    }

    /// Returns to an earlier time of the epoch. Entries removed since then are not restored.
    pub fn rewind(&mut self, time: f64, pending: &impl Pending) {
        self.cursor = self.cursor_at(time);
        for entry in std::mem::take(&mut self.front) {
            self.push(entry, pending);
        }
    }

    /// The end of the part of an epoch that contains a time. Epochs end early only there.
    pub fn next_tick(&self, now: f64) -> f64 {
        let part = self.span() / TICKS as f64;
        part * (trunc_to_usize(now / part) + 1) as f64
    }

    /// Whether the epoch ends at a tick after the given number of steps.
    pub fn ends_at(&self, tick: f64, steps: u64) -> bool {
        tick >= self.span() || steps > CROWDED * self.target
    }

    /// Steps of the epoch so far.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Returns the number of steps to which the length of an epoch is tuned.
    pub fn target(&self) -> u64 {
        self.target
    }

    /// Removes all entries. The epoch continues.
    pub fn clear(&mut self) {
        self.front.clear();
        self.buckets.clear();
    }

    /// Empties the queue for a new epoch, and tunes the length of the epoch to the number of steps of the
    /// last epoch.
    pub fn restart(&mut self) {
        self.clear();
        let expected = self.target as f64 * (self.reached() / self.span());
        let crowd = self.steps as f64 / expected;
        (self.cursor, self.steps) = (0, 0);
        // The length does not change if the steps are within a factor of two of the target. An empty epoch is
        // followed by a much longer epoch.
        let factor =
            if (0.5..=2.0).contains(&crowd) { 1.0 } else { power_of_two(crowd.recip().clamp(1.0 / 1024.0, 1024.0)) };
        let width = self.width * factor;
        if width.is_normal() && (width * self.buckets.count() as f64).is_finite() && width.recip().is_normal() {
            self.width = width;
            self.per_width = width.recip();
        }
    }

    /// Checks data that was read: whether all entries are valid particles, and all buckets exist.
    pub fn is_sound(&self, particles: usize) -> bool {
        let is_particle = |entry: &QueueEntry| (entry.particle as usize) < particles;
        let count = self.buckets.count();
        let has_ticks = count.is_power_of_two() && count >= TICKS && self.cursor < count;
        let has_times = self.width > 0.0 && self.width.is_finite() && self.per_width == self.width.recip();
        has_ticks && has_times && self.front.iter().all(is_particle) && self.buckets.is_sound(particles)
    }

    /// An empty queue with epochs of the same length and another number of buckets.
    #[cfg(test)]
    pub fn rebuilt(&self, buckets: usize) -> Self {
        assert_eq!((self.cursor, self.steps), (0, 0), "at the beginning of an epoch");
        Self { target: self.target, ..Self::with_buckets(buckets, 1, self.span()) }
    }
}

/// The largest power of two that does not exceed a positive, normal `x`.
fn power_of_two(x: f64) -> f64 {
    let x = x.clamp(f64::MIN_POSITIVE * 1024.0, f64::MAX / 1024.0);
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

#[cfg(test)]
mod tests;
