//! Equidistant sampling times.

use serde::{Deserialize, Serialize};

/// Equidistant sampling times `start + k interval`, `k = 1, 2, ...`, each computed by one multiplication.
///
/// An interval given in the scene is kept. A default interval follows from the expected duration. It is doubled
/// whenever there are twice as many samples as intended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SamplingTimes {
    start: f64,
    interval: f64,
    index: f64,
    /// Number of samples so far at the current interval, and the intended number; `None` for a fixed interval.
    chosen: Option<[u32; 2]>,
    left: u32,
}

impl SamplingTimes {
    /// Sampling times at a fixed interval.
    #[must_use]
    pub fn given(start: f64, interval: f64) -> Self {
        Self { start, interval, index: 1.0, chosen: None, left: u32::MAX }
    }

    /// About `aim` sampling times in the expected duration, at least `shortest` apart.
    #[must_use]
    pub fn expecting(start: f64, duration: f64, aim: u32, shortest: f64) -> Self {
        Self { chosen: Some([0, aim]), ..Self::given(start, (duration / f64::from(aim)).max(shortest)) }
    }

    /// Limits the number of sampling times.
    #[must_use]
    pub fn at_most(self, most: u32) -> Self {
        Self { left: most, ..self }
    }

    /// The sampling interval `[time]`.
    #[must_use]
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// The next sampling time; infinite if there is none.
    #[must_use]
    pub fn next(&self) -> f64 {
        if self.left == 0 { f64::INFINITY } else { self.start + self.index * self.interval }
    }

    /// Whether `time` has reached the next sampling time. If so, advances to the first sampling time after `time`.
    pub(crate) fn is_due(&mut self, time: f64) -> bool {
        let is_due = time >= self.next();
        if is_due {
            self.pass(time);
        }
        is_due
    }

    /// Advances to the first sampling time after `time`.
    pub fn pass(&mut self, time: f64) {
        self.pass_early(time, 0.0);
    }

    /// Advances to the first sampling time after `time`. A sampling time that is later by at most `early * interval` is
    /// passed, too, because times may be rounded.
    pub fn pass_early(&mut self, time: f64, early: f64) {
        if self.left < u32::MAX {
            self.left = self.left.saturating_sub(1);
        }
        if let Some([count, aim]) = &mut self.chosen {
            *count += 1;
            if *count >= 2 * *aim {
                self.interval *= 2.0;
                *count = *aim;
            }
        }
        self.index = ((time - self.start) / self.interval + early).floor() + 1.0;
        // Because of round-off, or an interval below the spacing of floats, the result may be at or before `time`.
        let mut step = 1.0;
        while self.next() <= time {
            self.index += step;
            step *= 2.0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_given_interval_is_kept_and_does_not_accumulate_rounding() {
        let mut times = SamplingTimes::given(1.0, 0.1);
        for k in 1..=1000 {
            assert_eq!(times.next(), 1.0 + f64::from(k) * 0.1);
            times.pass(times.next());
        }
    }

    #[test]
    fn ticks_that_were_passed_are_left_out() {
        let mut times = SamplingTimes::given(0.0, 1.0);
        times.pass(7.5);
        assert_eq!(times.next(), 8.0);
        times.pass(8.0);
        assert_eq!(times.next(), 9.0);
    }

    #[test]
    fn a_chosen_interval_doubles_when_the_run_lasts_longer_than_expected() {
        let mut times = SamplingTimes::expecting(0.0, 20.0, 20, 0.0);
        let mut count = 0;
        while times.next() <= 20.0 * 1024.0 {
            times.pass(times.next());
            count += 1;
        }
        assert!((200..=240).contains(&count), "{count}");
    }

    #[test]
    fn limited_number_of_times_ends() {
        let mut times = SamplingTimes::expecting(0.0, 20.0, 20, 0.0).at_most(3);
        for due in [1.0, 2.0, 3.0] {
            assert_eq!(times.next(), due);
            times.pass(due);
        }
        assert_eq!(times.next(), f64::INFINITY);
        assert_eq!(SamplingTimes::expecting(0.0, 20.0, 20, 0.0).at_most(0).next(), f64::INFINITY);
    }

    #[test]
    fn next_time_advances_despite_interval_below_float_spacing() {
        let mut times = SamplingTimes::given(1e10, 1e-90);
        times.pass(1e10);
        assert!(times.next() > 1e10);
    }

    #[test]
    fn a_rounded_time_is_not_asked_for_twice() {
        let mut times = SamplingTimes::given(1.0, 0.1);
        for k in 1..=1000 {
            let due = 1.0 + f64::from(k) * 0.1;
            assert_eq!(times.next(), due);
            times.pass_early(if k % 2 == 0 { due.next_down() } else { due.next_up() }, 1e-6);
        }
    }
}
