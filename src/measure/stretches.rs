//! Even stretches of time that instruments cut a run into.

use serde::{Deserialize, Serialize};

/// Part of an interval by which a sample may come early and still be the one that was asked for: times are rounded.
pub(super) const EARLY: f64 = 1e-6;

/// Shortest interval, of the expected duration: with shorter ones a run would never end.
const SHORTEST: f64 = 1e-8;

/// An interval as it was given, unless it is too short for the duration.
pub(super) fn feasible(interval: f64, duration: f64) -> f64 {
    interval.max(SHORTEST * duration)
}

/// Stretches that end at `start + k interval`, `k = 1, 2, ...`
///
/// An interval that the user gave is kept. A chosen one doubles whenever there are twice as many samples as were aimed at, because the
/// duration that it was chosen from may be a poor guess.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Stretches {
    start: f64,
    interval: f64,
    index: f64,
    /// Samples since the interval last doubled, and how many are aimed at; none if it is kept.
    chosen: Option<[u32; 2]>,
}

impl Stretches {
    /// At a given interval, or some `aim` samples in a duration.
    pub fn new(start: f64, given: Option<f64>, duration: f64, aim: u32) -> Self {
        let interval = given.map_or(duration / f64::from(aim), |given| feasible(given, duration));
        Self { start, interval, index: 1.0, chosen: given.is_none().then_some([0, aim]) }
    }

    /// Between two samples now `[time]`.
    pub fn interval(&self) -> f64 {
        self.interval
    }

    /// The next time.
    pub fn next(&self) -> f64 {
        self.start + self.index * self.interval
    }

    /// Goes on to the first time after `time`.
    pub fn pass(&mut self, time: f64) {
        if let Some([count, aim]) = &mut self.chosen {
            *count += 1;
            if *count == 2 * *aim {
                self.interval *= 2.0;
                *count = *aim;
            }
        }
        self.index = ((time - self.start) / self.interval + EARLY).floor() + 1.0;
        // An interval below the spacing of numbers.
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
    fn a_given_interval_is_kept_and_a_rounded_time_is_not_asked_for_twice() {
        let mut stretches = Stretches::new(1.0, Some(0.1), 1.0, 10);
        for k in 1..=1000 {
            let due = 1.0 + f64::from(k) * 0.1;
            assert_eq!(stretches.next(), due);
            stretches.pass(if k % 2 == 0 { due.next_down() } else { due.next_up() });
        }
    }

    #[test]
    fn a_chosen_interval_doubles_when_the_run_lasts_longer() {
        let mut stretches = Stretches::new(0.0, None, 20.0, 20);
        let mut count = 0;
        while stretches.next() <= 20.0 * 1024.0 {
            stretches.pass(stretches.next());
            count += 1;
        }
        assert!((200..=240).contains(&count), "{count}");
    }

    #[test]
    fn an_interval_below_the_spacing_of_numbers_ends() {
        let mut stretches = Stretches::new(1e20, Some(1e-90), 1.0, 10);
        stretches.pass(1e20);
        assert!(stretches.next() > 1e20);
        assert_eq!(Stretches::new(0.0, Some(1e-90), 1.0, 10).next(), 1e-8);
    }
}
