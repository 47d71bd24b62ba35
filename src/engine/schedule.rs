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
    /// Decides between entries of the same time, before the particle's number does.
    pub tie_order: u32,
}

impl QueueEntry {
    /// One number that orders entries by time, tie order and particle.
    #[inline]
    fn key(&self) -> u128 {
        let bits = self.time.to_bits().cast_signed();
        // All bits of a negative number are turned around, and the sign of a positive one.
        let ordered = bits.cast_unsigned() ^ ((bits >> 63).cast_unsigned() | 1 << 63);
        u128::from(ordered) << 64 | u128::from(self.tie_order) << 32 | u128::from(self.particle)
    }
}

/// The pending predictions that the queue puts in order.
pub trait Pending {
    /// When a particle is due; at an infinite time if it never is.
    fn entry(&self, particle: u32) -> QueueEntry;

    /// Prefetches the prediction of a particle.
    fn prefetch(&self, particle: u32);
}

/// Entries per bucket that the width is tuned to.
const TARGET: u32 = 64;

/// An epoch ends early after this many times the entries that its length is tuned to. One that was planned in a quiet time, of a
/// start at rest or of particles far apart, would otherwise count the times of a busy one with too few digits.
const CROWDED: u64 = 4;

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
    popped: u64,
}

impl EventQueue {
    /// A queue for `particles`, of which `due` have an entry now; half of these lie within `median` of the epoch.
    ///
    /// The others may move later, and an epoch, which costs a time for each particle, is to be worth it then.
    #[must_use]
    pub fn new(particles: usize, due: usize, median: f64) -> Self {
        // Eight or more entries per particle and epoch, however few particles there are: a longer epoch counts times with fewer digits.
        let buckets = (particles / 8).next_power_of_two().min(1 << 22);
        let width = if median.is_finite() && median > 0.0 {
            // The rate of entries per unit time is about due / median.
            power_of_two(median * f64::from(TARGET) / due as f64)
        } else {
            1.0
        };
        Self {
            front: Vec::new(),
            buckets: Buckets::new(buckets),
            opened: Vec::new(),
            cursor: 0,
            width,
            per_width: width.recip(),
            popped: 0,
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
    pub fn push(&mut self, entry: QueueEntry) {
        let bucket = self.bucket(entry.time);
        if bucket <= self.cursor {
            let after = {
                let key = entry.key();
                self.front.partition_point(|other| key < other.key())
            };
            self.front.insert(after, entry);
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
            let is_crowded = self.popped > CROWDED * u64::from(TARGET) * self.buckets.count() as u64;
            if self.cursor + 1 >= self.buckets.count() || is_crowded {
                return None;
            }
            self.cursor += 1;
            self.open(pending);
        }
    }

    /// Removes the entry that [`Self::peek`] has just returned.
    #[inline]
    pub fn pop(&mut self) {
        self.popped += 1;
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
        // A particle may have come to the same bucket more than once.
        self.front.dedup_by_key(|entry| entry.particle);
    }

    /// Removes all entries; the epoch goes on.
    pub fn clear(&mut self) {
        self.front.clear();
        self.buckets.clear();
    }

    /// Empties the queue for a new epoch, and tunes the width of its buckets to the last one's number of entries.
    pub fn restart(&mut self) {
        self.clear();
        let per_bucket = self.popped as f64 / (self.cursor + 1) as f64;
        (self.cursor, self.popped) = (0, 0);
        // Within a factor of two of the target nothing changes; an empty epoch looks far ahead.
        let target = f64::from(TARGET);
        let factor = if !(0.5 * target..=2.0 * target).contains(&per_bucket) {
            power_of_two((target / per_bucket).clamp(1.0 / 1024.0, 1024.0))
        } else {
            1.0
        };
        let width = self.width * factor;
        if width.is_normal() && (width * self.buckets.count() as f64).is_finite() && width.recip().is_normal() {
            self.width = width;
            self.per_width = width.recip();
        }
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
    fn ties_come_out_by_tie_order_then_by_number() {
        for time in [0.5, 300.0] {
            let mut queue = EventQueue::new(1024, 1024, 64.0);
            let mut pending = Times::new(&[time; 10]);
            pending.1[5] = 1;
            for particle in [5, 9, 3] {
                queue.push(pending.entry(particle));
            }
            let mut order = Vec::new();
            while let Some(next) = queue.peek(&pending) {
                queue.pop();
                order.push(next.particle);
            }
            assert_eq!(order, [3, 9, 5]);
        }
    }

    #[test]
    fn a_bucket_is_opened_with_the_wake_times_of_then() {
        let mut queue = EventQueue::new(1024, 1024, 64.0);
        let mut pending = Times::new(&[100.0, 200.0, 300.0]);
        for (particle, time) in [(0, 100.0), (1, 200.0), (2, 300.0), (1, 200.0)] {
            queue.push(entry(time, particle));
        }
        pending.0[0] = 250.0;
        queue.push(entry(250.0, 0));
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
            queue.push(entry(time, 0));
            assert_eq!(queue.peek(&pending), Some(entry(time, 0)));
            queue.pop();
        }
        queue.push(entry(1.5 * width, 1));
        assert_eq!(queue.peek(&pending), None);
        assert_eq!(queue.reached(), width);
        queue.restart();
        assert_eq!(queue.span(), span / 512.0);
        queue.push(entry(0.5 * queue.width, 1));
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
                queue.push(entry(time, k));
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
                    queue.push(entry(time, u32::try_from(particle).unwrap()));
                    if time < queue.span() { expected.push(time); }
                    particle += 1;
                }
            }
            expected.sort_by(f64::total_cmp);
            prop_assert_eq!(found, expected);
        }
    }
}
