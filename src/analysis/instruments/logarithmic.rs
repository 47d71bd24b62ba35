//! Times on a fine grid, and logarithmically spaced time lags of 1, 2, 3, 4, 6, 8, 12, ... ticks.

use serde::{Deserialize, Serialize};

use super::block_times::EARLY;
use crate::base::numbers::trunc_to_u64;

/// Shortest tick, in units of the spacing of floating-point numbers at the end of the run.
const SPACINGS: f64 = 8.0;

/// A grid of times since the start of a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Ticks {
    pub start: f64,
    /// Duration of a tick `[time]`.
    pub tick: f64,
}

impl Ticks {
    /// Returns the shortest tick for which the times of two ticks always differ `[time]`.
    pub fn shortest(start: f64, duration: f64) -> f64 {
        SPACINGS * f64::EPSILON * (start.abs() + duration)
    }

    pub fn time(&self, ticks: u64) -> f64 {
        self.start + self.duration(ticks)
    }

    pub fn duration(&self, ticks: u64) -> f64 {
        ticks as f64 * self.tick
    }

    /// Number of ticks that have passed at a time. If the time of the tick `due` has been reached, the result is at
    /// least `due`, even if round-off at very late times gives a smaller number.
    pub fn passed(&self, time: f64, due: u64) -> u64 {
        let passed = trunc_to_u64((time - self.start) / self.tick + EARLY);
        passed.max(if time >= self.time(due) { due } else { 0 })
    }
}

/// Number of logarithmic lags. The longest lag, about 2^63 ticks, is longer than any run.
pub const LOGARITHMIC: usize = 126;

/// Returns the logarithmic lag with index `number`, in ticks. The lags are 1, 2, 3, 4, 6, 8, 12, ...
pub fn logarithmic_ticks(number: usize) -> u64 {
    match number {
        0 => 1,
        odd if odd % 2 == 1 => 2 << (odd / 2),
        even => 3 << (even / 2 - 1),
    }
}

fn logarithmic_up_to(ticks: u64) -> Option<usize> {
    let power = ticks.checked_ilog2()? as usize;
    let number = (2 * power).saturating_sub(1);
    Some(if power >= 1 && logarithmic_ticks(number + 1) <= ticks { number + 1 } else { number })
}

pub fn logarithmic(ticks: u64) -> Option<usize> {
    logarithmic_up_to(ticks).filter(|&number| logarithmic_ticks(number) == ticks)
}

pub fn next_logarithmic(ticks: u64) -> u64 {
    logarithmic_ticks(logarithmic_up_to(ticks).map_or(0, |number| number + 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithmic_lags_are_consecutive() {
        let times: Vec<u64> = (0..10).map(logarithmic_ticks).collect();
        assert_eq!(times, [1, 2, 3, 4, 6, 8, 12, 16, 24, 32]);
        let mut ticks = 0;
        for (number, time) in times.iter().enumerate() {
            assert_eq!(next_logarithmic(ticks), *time);
            assert_eq!(logarithmic(*time), Some(number));
            ticks = *time;
        }
        assert_eq!([0, 5, 7, 25].map(logarithmic), [None; 4]);
        assert_eq!(logarithmic(logarithmic_ticks(LOGARITHMIC - 2)), Some(LOGARITHMIC - 2));
    }
}
