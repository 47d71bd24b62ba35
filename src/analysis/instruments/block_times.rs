//! Ends of the equal blocks of time that a measurement is divided into.

use crate::analysis::sampling_times::SamplingTimes;
use serde::{Deserialize, Serialize};

/// Part of an interval by which a sample may come early and still be the one that was asked for: times are rounded.
pub(super) const EARLY: f64 = 1e-6;

/// Shortest interval, of the expected duration: with shorter ones a run would never end.
const SHORTEST: f64 = 1e-8;

/// An interval as it was given, unless it is too short for the duration.
pub(super) fn feasible(interval: f64, duration: f64) -> f64 {
    interval.max(SHORTEST * duration)
}

/// End times of equal blocks, whose length the plan gives or the run chooses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct BlockTimes(SamplingTimes);

impl BlockTimes {
    /// At a given interval, or some `aim` samples in a duration.
    pub fn new(start: f64, given: Option<f64>, duration: f64, aim: u32) -> Self {
        Self(match given {
            Some(interval) => SamplingTimes::given(start, feasible(interval, duration)),
            None => SamplingTimes::expecting(start, duration, aim, 0.0),
        })
    }

    /// Between two samples now `[time]`.
    pub fn interval(&self) -> f64 {
        self.0.interval()
    }

    /// The next time.
    pub fn next(&self) -> f64 {
        self.0.next()
    }

    /// Goes on to the first time after `time`.
    pub fn pass(&mut self, time: f64) {
        self.0.pass_early(time, EARLY);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_given_interval_is_not_shorter_than_a_run_can_bear() {
        let mut blocks = BlockTimes::new(1e20, Some(1e-90), 1.0, 10);
        blocks.pass(1e20);
        assert!(blocks.next() > 1e20);
        assert_eq!(BlockTimes::new(0.0, Some(1e-90), 1.0, 10).next(), 1e-8);
    }
}
