//! The event queue: a calendar of unsorted time buckets behind a small ordered front.
//!
//! Each particle has at most one entry, that of its prediction. A bucket holds only the numbers of the particles that
//! are due in its time; an entry is never removed. When time reaches a bucket, its particles are asked when they are
//! due: those that no longer are in it are dropped, the others are sorted and become the front. An entry of the front is
//! stale if its time is no longer that of the particle's prediction, and the event loop drops it. (Alias: future event list, calendar
//! queue; Paul, J. Comput. Phys. 221, 615, 2007.)

mod buckets;

use crate::base::numbers::trunc_to_usize;
use buckets::Buckets;
use serde::{Deserialize, Serialize};

/// An entry of the queue: a particle is due.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct QueueEntry {
    /// Time since the epoch.
    pub time: f64,
    /// Which particle.
    pub particle: u32,
    /// Decides between entries of the same time, before [`Pending::rank`] does.
    pub tie_order: u32,
}

impl QueueEntry {
    /// One number that orders entries by time and tie order.
    #[inline]
    fn key(&self) -> u128 {
        let bits = self.time.to_bits().cast_signed();
        // All bits of a negative number are turned around, and the sign of a positive one.
        let ordered = bits.cast_unsigned() ^ ((bits >> 63).cast_unsigned() | 1 << 63);
        u128::from(ordered) << 32 | u128::from(self.tie_order)
    }
}

/// The pending predictions that the queue puts in order.
pub trait Pending {
    /// When a particle is due; at an infinite time if it never is.
    fn entry(&self, particle: u32) -> QueueEntry;

    /// Decides between entries of the same time and tie order: numbers in memory decide nothing.
    fn rank(&self, particle: u32) -> u64;

    /// Prefetches the prediction of a particle.
    fn prefetch(&self, particle: u32);
}

/// A bucket is no longer than this at the start, so that the length of an epoch is a number.
const LONGEST: f64 = 1e290;

/// Particles that come with so many steps to an epoch.
const PARTICLES: usize = 8;

/// Steps of an epoch, for each so many particles, that its length is tuned to; entries in a bucket, if there are as many buckets.
const TARGET: u32 = 64;

/// An epoch ends early after this many times the steps that its length is tuned to. One that was planned in a quiet time, of a
/// start at rest or of particles far apart, would otherwise count the times of a busy one with too few digits.
const CROWDED: u64 = 4;

/// Parts of an epoch, at whose ends it may end early. Neither they nor its length have to do with buckets: how entries are kept decides no bit.
const TICKS: usize = 64;

/// While a bucket is opened, particles this many entries ahead are prefetched.
const AHEAD: usize = 8;

/// Event queue: entries between the epoch and its horizon; later ones wait outside.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct EventQueue {
    /// The bucket that time has reached, latest first.
    front: Vec<QueueEntry>,
    buckets: Buckets,
    /// Scratch: the particles of the bucket that is being opened.
    opened: Vec<u32>,
    /// Number of the bucket in `front`.
    cursor: usize,
    /// Width of a bucket, a power of two so that bucket numbers and horizons are exact.
    width: f64,
    per_width: f64,
    /// Steps of this epoch: entries that were due.
    steps: u64,
    /// Steps that its length is tuned to.
    target: u64,
}

impl EventQueue {
    /// A queue for `particles`, of which `due` have an entry now; half of these lie within `median` of the epoch.
    ///
    /// The others may move later, and an epoch, which costs a time for each particle, is to be worth it then.
    #[must_use]
    pub fn new(particles: usize, due: usize, median: f64) -> Self {
        // Eight or more steps per particle and epoch, however few particles there are: a longer epoch counts times with fewer digits.
        let parts = (particles / PARTICLES).next_power_of_two().min(1 << 22);
        let span = if median.is_finite() && median > 0.0 {
            // The rate of entries per unit time is about due / median.
            power_of_two((median * f64::from(TARGET) / due as f64).min(LONGEST)) * parts as f64
        } else {
            parts as f64
        };
        Self::with_buckets(parts.max(TICKS), parts, span)
    }

    /// With a number of buckets, a power of two, which decides nothing but speed.
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

    /// Time from the epoch to the end of the last bucket: how far the queue sees.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.width * self.buckets.count() as f64
    }

    /// Time from the epoch to the end of the bucket that time has reached: how far the epoch moves next. It is the span, unless
    /// there were too many entries.
    #[must_use]
    pub fn reached(&self) -> f64 {
        self.width * (self.cursor + 1) as f64
    }

    /// The bucket of a time; times before the epoch saturate at 0.
    #[inline]
    fn bucket(&self, time: f64) -> usize {
        trunc_to_usize(time * self.per_width)
    }

    /// Adds an entry. One beyond the horizon is dropped: moving the epoch enters every particle again.
    #[inline]
    pub fn push(&mut self, entry: QueueEntry, pending: &impl Pending) {
        let bucket = self.bucket(entry.time);
        if bucket <= self.cursor {
            let key = entry.key();
            let after = self.front.partition_point(|other| key < other.key());
            self.front.insert(after, entry);
            if self.front.get(after + 1).is_some_and(|other| other.key() == key) {
                self.order_ties(after, pending);
            }
        } else if bucket < self.buckets.count() {
            self.buckets.push(bucket, entry.particle);
        }
    }

    /// The earliest entry, or none if the epoch has come to its end, at the horizon or after too many entries.
    #[inline]
    pub fn peek(&mut self, pending: &impl Pending) -> Option<QueueEntry> {
        loop {
            if let Some(front) = self.front.last() {
                return Some(*front);
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

    /// Removes the entry that [`Self::peek`] has just returned, for the step that was due.
    #[inline]
    pub fn pop(&mut self) {
        self.steps += 1;
        self.front.pop();
    }

    /// Removes the entry that [`Self::peek`] has just returned, which is void.
    #[inline]
    pub fn discard(&mut self) {
        self.front.pop();
    }

    /// The particle whose entry comes up after `ahead` others, as far as the front knows.
    #[inline]
    #[must_use]
    pub fn coming(&self, ahead: usize) -> Option<u32> {
        let at = self.front.len().checked_sub(ahead + 1)?;
        Some(self.front[at].particle)
    }

    /// Makes the bucket under the cursor the front.
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
        if self.front.is_sorted_by(|entry, next| entry.key() > next.key()) {
            return;
        }
        let mut at = 0;
        while at < self.front.len() {
            at = self.order_ties(at, pending);
        }
    }

    /// Orders the entries of the same time and tie order as the one at an index, the first of them, each particle once; returns the index after the
    /// last of them.
    #[cold]
    fn order_ties(&mut self, first: usize, pending: &impl Pending) -> usize {
        let key = self.front[first].key();
        let end = first + self.front[first..].partition_point(|entry| entry.key() == key);
        let mut ties: Vec<QueueEntry> = self.front[first..end].to_vec();
        // One of a particle that is due at another time now is void.
        ties.retain(|entry| pending.entry(entry.particle) == *entry);
        ties.sort_unstable_by_key(|entry| (!pending.rank(entry.particle), entry.particle));
        // A particle may have come to the same bucket more than once.
        ties.dedup();
        let end_of_ties = first + ties.len();
        self.front.splice(first..end, ties);
        end_of_ties
    }

    /// Removes all entries; the epoch goes on.
    pub fn clear(&mut self) {
        self.front.clear();
        self.buckets.clear();
    }

    /// Empties the queue for a new epoch, and tunes its length to the last one's number of steps.
    pub fn restart(&mut self) {
        self.clear();
        let expected = self.target as f64 * (self.reached() / self.span());
        let crowd = self.steps as f64 / expected;
        (self.cursor, self.steps) = (0, 0);
        // Within a factor of two of the target nothing changes; an empty epoch looks far ahead.
        let factor =
            if (0.5..=2.0).contains(&crowd) { 1.0 } else { power_of_two(crowd.recip().clamp(1.0 / 1024.0, 1024.0)) };
        let width = self.width * factor;
        if width.is_normal() && (width * self.buckets.count() as f64).is_finite() && width.recip().is_normal() {
            self.width = width;
            self.per_width = width.recip();
        }
    }

    /// A queue of epochs as long, without entries, with another number of buckets.
    #[cfg(test)]
    pub fn rebuilt(&self, buckets: usize) -> Self {
        assert_eq!((self.cursor, self.steps), (0, 0), "at the beginning of an epoch");
        Self { target: self.target, ..Self::with_buckets(buckets, 1, self.span()) }
    }
}

/// The largest power of two that is not above a positive, normal `x`.
fn power_of_two(x: f64) -> f64 {
    let x = x.clamp(f64::MIN_POSITIVE * 1024.0, f64::MAX / 1024.0);
    f64::from_bits(x.to_bits() & 0x7ff0_0000_0000_0000)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Due times and tie orders by particle.
    struct Times(Vec<f64>, Vec<u32>);

    impl Times {
        fn new(times: &[f64]) -> Self {
            Self(times.to_vec(), vec![0; times.len()])
        }
    }

    impl Pending for Times {
        fn entry(&self, particle: u32) -> QueueEntry {
            QueueEntry { time: self.0[particle as usize], particle, tie_order: self.1[particle as usize] }
        }

        /// As if the last came first in memory.
        fn rank(&self, particle: u32) -> u64 {
            u64::from(u32::MAX - particle)
        }

        fn prefetch(&self, _: u32) {}
    }

    fn entry(time: f64, particle: u32) -> QueueEntry {
        QueueEntry { time, particle, tie_order: 0 }
    }

    #[test]
    fn a_power_of_two_is_exact() {
        assert_eq!(power_of_two(1.0), 1.0);
        assert_eq!(power_of_two(1.0_f64.next_down()), 0.5);
        assert_eq!(power_of_two(1000.0), 512.0);
        assert!(power_of_two(0.0) > 0.0);
    }

    #[test]
    fn an_epoch_is_long_enough_for_all_that_may_move_later() {
        let [few, many] = [1, 1 << 14].map(|due| EventQueue::new(1 << 14, due, 1.0));
        assert_eq!(few.buckets.count(), many.buckets.count());
        assert_eq!(few.width, 64.0);
        assert_eq!(many.width, 64.0 / f64::from(1 << 14));
    }

    #[test]
    fn ties_come_out_by_tie_order_then_by_rank() {
        for time in [0.5, 300.0] {
            let mut queue = EventQueue::new(1024, 1024, 64.0);
            let mut pending = Times::new(&[time; 10]);
            pending.1[5] = 1;
            for particle in [5, 9, 3] {
                queue.push(pending.entry(particle), &pending);
            }
            let mut order = Vec::new();
            while let Some(next) = queue.peek(&pending) {
                queue.pop();
                order.push(next.particle);
            }
            assert_eq!(order, [9, 3, 5]);
        }
    }

    #[test]
    fn a_bucket_is_opened_with_the_wake_times_of_then() {
        let mut queue = EventQueue::new(1024, 1024, 64.0);
        let mut pending = Times::new(&[100.0, 200.0, 300.0]);
        for (particle, time) in [(0, 100.0), (1, 200.0), (2, 300.0), (1, 200.0)] {
            queue.push(entry(time, particle), &pending);
        }
        pending.0[0] = 250.0;
        queue.push(entry(250.0, 0), &pending);
        let mut order = Vec::new();
        while let Some(next) = queue.peek(&pending) {
            queue.pop();
            order.push((next.time, next.particle));
        }
        assert_eq!(order, [(200.0, 1), (250.0, 0), (300.0, 2)]);
    }

    #[test]
    fn a_crowded_epoch_ends_with_its_bucket_and_the_next_one_is_shorter() {
        let mut queue = EventQueue::new(512, 512, 64.0);
        let (span, width) = (queue.span(), queue.width);
        assert_eq!(span, 64.0 * width);
        let most = 4 * 64 * 64;
        let pending = Times::new(&[0.0; 2]);
        for k in 0..=most {
            let time = width * f64::from(k) / f64::from(most + 1);
            queue.push(entry(time, 0), &pending);
            assert_eq!(queue.peek(&pending), Some(entry(time, 0)));
            queue.pop();
        }
        queue.push(entry(1.5 * width, 1), &pending);
        assert_eq!(queue.peek(&pending), None);
        assert_eq!(queue.reached(), width);
        queue.restart();
        assert_eq!(queue.span(), span / 512.0);
        queue.push(entry(0.5 * queue.width, 1), &pending);
        assert!(queue.peek(&pending).is_some());
    }

    proptest! {
        #[test]
        fn entries_come_out_in_order_whenever_they_came_in(
            times in prop::collection::vec(0.0..8.0_f64, 1..200),
            median in 1e-3..1e3_f64,
        ) {
            let mut queue = EventQueue::new(times.len(), times.len(), median);
            let (early, later) = times.split_at(times.len() / 2);
            let mut pending = Times::new(&times);
            for (k, &time) in (0..).zip(early) {
                queue.push(entry(time, k), &pending);
            }
            let mut expected: Vec<f64> = early.iter().copied().filter(|t| *t < queue.span()).collect();
            let mut now = 0.0;
            let mut found = Vec::new();
            let mut particle = early.len();
            while let Some(next) = queue.peek(&pending) {
                queue.pop();
                prop_assert!(next.time >= now);
                now = next.time;
                found.push(now);
                // A new entry is never earlier than now, and may be exactly now.
                if let Some(dt) = later.get(particle - early.len()) {
                    let time = now + dt;
                    pending.0[particle] = time;
                    queue.push(entry(time, u32::try_from(particle).unwrap()), &pending);
                    if time < queue.span() { expected.push(time); }
                    particle += 1;
                }
            }
            expected.sort_by(f64::total_cmp);
            prop_assert_eq!(found, expected);
        }
    }
}
