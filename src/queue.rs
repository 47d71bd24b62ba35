//! The event queue: a calendar of unsorted time buckets behind a small ordered front.
//!
//! Each particle has at most one valid entry, the time at which it wakes for its earliest prediction. An entry is never
//! removed: one whose time is no longer the particle's wake time is stale, and whoever pops it drops it. Only the bucket
//! that time has reached is sorted. (Alias: future event list, calendar queue; Paul, J. Comput. Phys. 221, 615, 2007.)

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

/// A particle wakes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wake {
    /// Time since the epoch.
    pub time: f64,
    /// Which particle.
    pub particle: u32,
    /// Decides between entries of the same time: kind in the high bits, the lower of the pair's ids below.
    pub rank: u32,
}

impl Eq for Wake {}

impl Ord for Wake {
    fn cmp(&self, other: &Self) -> Ordering {
        self.time.total_cmp(&other.time).then(self.rank.cmp(&other.rank)).then(self.particle.cmp(&other.particle))
    }
}

impl PartialOrd for Wake {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Entries per bucket that the width is tuned to.
const TARGET: f64 = 64.0;

/// An epoch ends early after this many times the entries that its length is tuned to. One that was planned in a quiet time, of a
/// start at rest or of particles far apart, would otherwise count the times of a busy one with too few digits.
const CROWDED: u64 = 4;

/// What the queue holds between the epoch and its horizon; later entries wait outside.
#[derive(Debug)]
pub struct EventQueue {
    /// The bucket that time has reached, latest first.
    front: Vec<Wake>,
    /// Entries that came for the front's time after it was sorted.
    late: BinaryHeap<Reverse<Wake>>,
    buckets: Vec<Vec<Wake>>,
    /// Number of the bucket in `front`.
    cursor: usize,
    /// Width of a bucket, a power of two so that bucket numbers and horizons are exact.
    width: f64,
    per_width: f64,
    popped: u64,
}

impl EventQueue {
    /// A queue for `particles` entries of which half lie within `median` of the epoch.
    #[must_use]
    pub fn new(particles: usize, median: f64) -> Self {
        // Eight or more entries per particle and epoch, however few particles there are: a longer epoch counts times with fewer digits.
        let buckets = (particles / 8).next_power_of_two().min(1 << 22);
        let width = if median.is_finite() && median > 0.0 {
            // The rate of wakes per unit time is about particles / median.
            power_of_two(median * TARGET / particles as f64)
        } else {
            1.0
        };
        Self {
            front: Vec::new(),
            late: BinaryHeap::new(),
            buckets: vec![Vec::new(); buckets],
            cursor: 0,
            width,
            per_width: width.recip(),
            popped: 0,
        }
    }

    /// Time from the epoch to the end of the last bucket: how far the queue sees.
    #[must_use]
    pub fn span(&self) -> f64 {
        self.width * self.buckets.len() as f64
    }

    /// Time from the epoch to the end of the bucket that time has reached: how far the epoch moves next. It is the span, unless
    /// there were too many entries.
    #[must_use]
    pub fn reached(&self) -> f64 {
        self.width * (self.cursor + 1) as f64
    }

    /// Adds an entry. One beyond the horizon is dropped: moving the epoch asks every particle for its wake time again.
    #[inline]
    pub fn push(&mut self, wake: Wake) {
        // Times before the epoch saturate at bucket 0.
        let bucket = (wake.time * self.per_width) as usize;
        if bucket <= self.cursor {
            self.late.push(Reverse(wake));
        } else if let Some(bucket) = self.buckets.get_mut(bucket) {
            bucket.push(wake);
        }
    }

    /// The earliest entry, or none if the epoch has come to its end, at the horizon or after too many entries.
    #[inline]
    pub fn peek(&mut self) -> Option<Wake> {
        loop {
            match (self.front.last(), self.late.peek()) {
                (Some(front), Some(Reverse(late))) => return Some(*front.min(late)),
                (Some(front), None) => return Some(*front),
                (None, Some(Reverse(late))) => return Some(*late),
                (None, None) => {
                    let is_crowded = self.popped > CROWDED * TARGET as u64 * self.buckets.len() as u64;
                    if self.cursor + 1 >= self.buckets.len() || is_crowded {
                        return None;
                    }
                    self.cursor += 1;
                    std::mem::swap(&mut self.front, &mut self.buckets[self.cursor]);
                    self.front.sort_unstable_by(|a, b| b.cmp(a));
                }
            }
        }
    }

    /// Removes the entry that [`Self::peek`] has just returned.
    #[inline]
    pub fn pop(&mut self) {
        self.popped += 1;
        match (self.front.last(), self.late.peek()) {
            (Some(front), Some(Reverse(late))) if late < front => drop(self.late.pop()),
            (Some(_), _) => drop(self.front.pop()),
            (None, _) => drop(self.late.pop()),
        }
    }

    /// Empties the queue for a new epoch, and tunes the width of its buckets to the last one's number of entries.
    pub fn restart(&mut self) {
        self.front.clear();
        self.late.clear();
        for bucket in &mut self.buckets {
            bucket.clear();
        }
        let per_bucket = self.popped as f64 / (self.cursor + 1) as f64;
        (self.cursor, self.popped) = (0, 0);
        // Within a factor of two of the target nothing changes; an empty epoch looks far ahead.
        let factor = if !(0.5 * TARGET..=2.0 * TARGET).contains(&per_bucket) {
            power_of_two((TARGET / per_bucket).clamp(1.0 / 1024.0, 1024.0))
        } else {
            1.0
        };
        let width = self.width * factor;
        if width.is_normal() && (width * self.buckets.len() as f64).is_finite() && width.recip().is_normal() {
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

    fn wake(time: f64, particle: u32) -> Wake {
        Wake { time, particle, rank: 0 }
    }

    #[test]
    fn a_power_of_two_is_exact() {
        assert_eq!(power_of_two(1.0), 1.0);
        assert_eq!(power_of_two(1.0_f64.next_down()), 0.5);
        assert_eq!(power_of_two(1000.0), 512.0);
        assert!(power_of_two(0.0) > 0.0);
    }

    #[test]
    fn ties_come_out_by_rank_then_particle() {
        let mut queue = EventQueue::new(10, 1.0);
        for (rank, particle) in [(1, 5), (0, 9), (0, 3)] {
            queue.push(Wake { time: 0.5, particle, rank });
        }
        let mut order = Vec::new();
        while let Some(next) = queue.peek() {
            queue.pop();
            order.push(next.particle);
        }
        assert_eq!(order, [3, 9, 5]);
    }

    #[test]
    fn a_crowded_epoch_ends_with_its_bucket_and_the_next_one_is_shorter() {
        let mut queue = EventQueue::new(512, 64.0);
        let (span, width) = (queue.span(), queue.width);
        assert_eq!(span, 64.0 * width);
        let most = 4 * 64 * 64;
        for k in 0..=most {
            let time = width * f64::from(k) / f64::from(most + 1);
            queue.push(wake(time, 0));
            assert_eq!(queue.peek(), Some(wake(time, 0)));
            queue.pop();
        }
        queue.push(wake(1.5 * width, 1));
        assert_eq!(queue.peek(), None);
        assert_eq!(queue.reached(), width);
        queue.restart();
        assert_eq!(queue.span(), span / 512.0);
        queue.push(wake(0.5 * queue.width, 1));
        assert!(queue.peek().is_some());
    }

    proptest! {
        #[test]
        fn entries_come_out_in_order_whenever_they_came_in(
            times in prop::collection::vec(0.0..8.0_f64, 1..200),
            median in 1e-3..1e3_f64,
        ) {
            let mut queue = EventQueue::new(times.len(), median);
            let (early, later) = times.split_at(times.len() / 2);
            let mut expected: Vec<f64> = Vec::new();
            for (k, &time) in early.iter().enumerate() {
                queue.push(wake(time, k as u32));
            }
            let mut pending: Vec<f64> = early.iter().copied().filter(|t| *t < queue.span()).collect();
            let mut later = later.iter();
            let mut now = 0.0;
            let mut found = Vec::new();
            while let Some(next) = queue.peek() {
                queue.pop();
                prop_assert!(next.time >= now);
                now = next.time;
                found.push(now);
                // A new entry is never earlier than now, and may be exactly now.
                if let Some(dt) = later.next() {
                    let time = now + dt;
                    queue.push(wake(time, 0));
                    if time < queue.span() { pending.push(time); }
                }
            }
            expected.append(&mut pending);
            expected.sort_by(f64::total_cmp);
            prop_assert_eq!(found, expected);
        }
    }
}
