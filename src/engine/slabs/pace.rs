//! Chooses between several threads and one thread, by measuring how fast both are. The results do not depend on it.
//!
//! Several threads are slower than one if the system is small, or if other programs use the cores.

use crate::base::numbers::trunc_to_u64;
use std::time::Duration;

/// A measurement has `PER_PARTICLE * n + LEAST` steps in a system with `n` moving particles.
const PER_PARTICLE: f64 = 1.0 / 16.0;
const LEAST: f64 = 20_000.0;

/// The first steps after a change are not measured, because a change takes time. Their number is the length of a
/// measurement divided by this number.
const IGNORED: u64 = 4;

/// An epoch is long if it lasts longer than this number of measurements.
const LONG_EPOCH: u64 = 4;

/// First interval between two trials, in measurements. The interval doubles after each trial that changes nothing.
const FIRST: u32 = 64;
/// Longest interval between two trials, in measurements.
const LONGEST: u32 = 1024;

/// Interval after a change, in measurements. It is short, because the change may have been wrong.
const AFTER_CHANGE: u32 = 16;

/// Number of measurements before the first trial.
const BEFORE_FIRST: u32 = 4;

/// A trial begins early if this number of measurements in a row are slow.
const IN_A_ROW: u32 = 3;
/// A measurement is slow if a step takes longer than at the last trial, by more than this factor.
const SLOWER: f64 = 1.25;
/// Number of parts of the interval. At least one part must pass between two trials.
const PARTS: u32 = 32;

/// Weight of a new measurement in the mean.
const WEIGHT: f64 = 0.3;

/// The other choice must be faster by this factor.
const FASTER: f64 = 0.97;

/// Whether one thread or several threads execute the next steps.
#[derive(Debug, Clone)]
pub struct Pace {
    /// Whether one thread is faster, as far as is known.
    is_alone: bool,
    /// Whether the other choice is tried.
    is_trial: bool,
    /// Whether the other choice was faster in the first measurement of the trial.
    was_faster: bool,
    /// Whether the next steps are the first after a change. They are ignored, because a change takes time.
    is_first: bool,
    /// Duration of a step of the present choice `[s]`: recent mean, and at the last trial.
    recent: Option<f64>,
    usual: Option<f64>,
    /// Number of measurements since the last trial.
    since: u32,
    /// Number of slow measurements in a row.
    slow: u32,
    interval: u32,
    /// The measurement that is not complete.
    steps: u64,
    took: Duration,
}

impl Pace {
    pub fn new() -> Self {
        Self {
            is_alone: false,
            is_trial: false,
            was_faster: false,
            is_first: true,
            recent: None,
            usual: None,
            since: FIRST - BEFORE_FIRST,
            slow: 0,
            interval: FIRST,
            steps: 0,
            took: Duration::ZERO,
        }
    }

    /// Whether one thread executes the next steps.
    pub fn is_alone(&self) -> bool {
        self.is_alone != self.is_trial
    }

    /// Number of steps above which an epoch is long. Measurements during which a long epoch began are not noted.
    pub fn long_epoch(moving: usize) -> u64 {
        LONG_EPOCH * Self::of_measurement(moving)
    }

    fn of_measurement(moving: usize) -> u64 {
        trunc_to_u64(PER_PARTICLE * moving as f64 + LEAST)
    }

    fn all_steps(&self, moving: usize) -> u64 {
        let all = Self::of_measurement(moving);
        if self.is_first { all / IGNORED } else { all }
    }

    /// Number of steps until the end of the measurement.
    pub fn steps(&self, moving: usize) -> u64 {
        self.all_steps(moving).saturating_sub(self.steps).max(1)
    }

    /// Notes the duration of some steps. `moving` is the number of moving particles.
    pub fn note(&mut self, steps: u64, took: Duration, moving: usize) {
        self.steps += steps;
        self.took += took;
        // Some of the requested steps may not count.
        if self.steps < self.all_steps(moving) / 2 {
            return;
        }
        let duration = self.took.as_secs_f64() / self.steps as f64;
        (self.steps, self.took) = (0, Duration::ZERO);
        match () {
            () if std::mem::take(&mut self.is_first) => {}
            () if self.is_trial => self.compare(duration),
            () => self.measure(duration),
        }
    }

    fn measure(&mut self, duration: f64) {
        self.since += 1;
        let recent = self.recent.map_or(duration, |recent| recent + WEIGHT * (duration - recent));
        self.recent = Some(recent);
        let is_slow = self.usual.is_some_and(|usual| duration > SLOWER * usual);
        self.slow = if is_slow { self.slow + 1 } else { 0 };
        let is_slower = self.slow >= IN_A_ROW && self.since >= self.interval / PARTS;
        if is_slower || self.since >= self.interval {
            (self.is_trial, self.is_first, self.since, self.slow) = (true, true, 0, 0);
        }
    }

    /// Ends a trial. A better result must be confirmed, because other programs may disturb a measurement.
    fn compare(&mut self, duration: f64) {
        let is_better = self.recent.is_none_or(|recent| duration < FASTER * recent);
        if is_better && !std::mem::replace(&mut self.was_faster, true) {
            return;
        }
        if is_better {
            (self.is_alone, self.recent, self.interval) = (!self.is_alone, Some(duration), AFTER_CHANGE);
        } else {
            (self.interval, self.is_first) = ((2 * self.interval).min(LONGEST), true);
        }
        (self.usual, self.is_trial, self.was_faster) = (self.recent, false, false);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs measurements with given durations of a step on several threads and on one thread, in units of 100 ns.
    /// Returns the share of the steps on one thread.
    fn alone(pace: &mut Pace, several: f64, one: f64, measurements: u32) -> f64 {
        let particles = 8_000;
        let mut count = 0;
        for _ in 0..measurements {
            let nanoseconds = 100.0 * if pace.is_alone() { one } else { several };
            count += u32::from(pace.is_alone());
            let steps = pace.steps(particles);
            for part in [steps / 3, steps - steps / 3 - 1] {
                pace.note(part, Duration::from_secs_f64(1e-9 * nanoseconds * part as f64), particles);
            }
        }
        f64::from(count) / f64::from(measurements)
    }

    #[test]
    fn the_faster_choice_is_found_and_kept() {
        assert!(alone(&mut Pace::new(), 6.0, 10.0, 2_000) < 0.02);
        assert!(alone(&mut Pace::new(), 11.0, 10.0, 2_000) > 0.97);
    }

    #[test]
    fn a_change_of_speed_is_noticed_soon() {
        let mut pace = Pace::new();
        alone(&mut pace, 6.0, 10.0, 3_000);
        // Another program begins to use a core.
        assert!(alone(&mut pace, 25.0, 12.0, 50) > 0.85);
        // It ends. One thread is not slower than before, so only the next trial finds out.
        alone(&mut pace, 6.0, 10.0, LONGEST + 4);
        assert!(alone(&mut pace, 6.0, 10.0, 1_000) < 0.05);
    }

    #[test]
    fn equal_speeds_change_nothing() {
        let mut pace = Pace::new();
        assert!(alone(&mut pace, 10.0, 10.0, 3_000) < 0.02);
    }
}
