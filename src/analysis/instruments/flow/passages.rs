use serde::{Deserialize, Serialize};

use crate::analysis::statistics::{Estimate, error_of_ends, standard_error};

/// Maximum number of rows of the table. When it is reached, every second row is dropped.
const MOST_ROWS: usize = 1024;

/// Net passages and displacements since the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub time: f64,
    /// Net number and mass of the particles that have passed the plane.
    pub passed: [f64; 2],
    /// Net displacement of all particles in the counted direction, in periods. The second sum is weighted by mass. Zero
    /// if the plane has no periodic image.
    pub gone: [f64; 2],
}

pub(super) const NUMBER: usize = 0;
pub(super) const MASS: usize = 1;

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Passages {
    rows: Vec<Row>,
    /// Number of samples per row, and number of samples since the last row.
    stride: u64,
    skipped: u64,
    now: Row,
    /// Times of the first and the last passage, and the number and mass of the particles in the first passage.
    first: Option<f64>,
    last: f64,
    first_share: [f64; 2],
    /// Time window for rates, and the number and mass of the particles that passed in this window.
    window: Option<[f64; 2]>,
    in_window: [f64; 2],
    /// True if the plane covers a whole cross-section, and its axis is periodic or ends at two walls. Particles cannot
    /// bypass such a plane.
    is_closed: bool,
}

impl Passages {
    pub fn new(start: f64, window: Option<[f64; 2]>, is_closed: bool) -> Self {
        let now = Row { time: start, passed: [0.0; 2], gone: [0.0; 2] };
        Self {
            rows: vec![now],
            stride: 1,
            skipped: 0,
            now,
            first: None,
            last: start,
            first_share: [0.0; 2],
            window,
            in_window: [0.0; 2],
            is_closed,
        }
    }

    /// Adds the distance that a particle travelled in the counted direction, in periods.
    pub fn go(&mut self, periods: f64, mass: f64) {
        self.now.gone[0] += periods;
        self.now.gone[1] += periods * mass;
    }

    /// Counts one passage since the last sample. Passages between two samples may be counted in any order.
    pub fn count(&mut self, sign: i64, mass: f64, time: f64) {
        let share = [sign as f64, sign as f64 * mass];
        (0..2).for_each(|of| self.now.passed[of] += share[of]);
        if self.first.is_none_or(|first| time < first) {
            (self.first, self.first_share) = (Some(time), share);
        }
        self.last = self.last.max(time);
        if self.window.is_some_and(|[from, to]| (from..to).contains(&time)) {
            (0..2).for_each(|of| self.in_window[of] += share[of]);
        }
    }

    pub fn write(&mut self, time: f64) {
        self.now.time = time;
        self.skipped += 1;
        if self.skipped < self.stride {
            return;
        }
        self.skipped = 0;
        self.rows.push(self.now);
        if self.rows.len() >= MOST_ROWS {
            let mut index = 0;
            self.rows.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            // The newest row was removed, because the number of rows was even. The next row includes its passages.
            self.skipped = self.stride;
            self.stride *= 2;
        }
    }

    pub fn has_window(&self) -> bool {
        self.window.is_some()
    }

    pub fn now(&self) -> Row {
        self.now
    }

    /// Returns the counts at evenly spaced times, and the current count at the end.
    pub fn rows(&self) -> Vec<Row> {
        let mut rows = self.rows.clone();
        if rows.last() != Some(&self.now) {
            rows.push(self.now);
        }
        rows
    }

    /// Returns the rate of passages, by number or by mass. In a window, the rate is the count divided by the elapsed
    /// part of the window. Without a window, it is the count after the first passage, divided by the time from the
    /// first to the last passage. `None` if this time is zero or the window has not begun.
    ///
    /// In a closed system, the net passages equal the net displacement, `sum dx / L`, minus the increase in the number
    /// of particles beyond the plane. If this number fluctuates, the error follows from the net displacement and the
    /// two ends of the run. If this number grows, as when grains fall through a hole, the error follows from the
    /// passages.
    pub fn rate(&self, of: usize) -> Option<Estimate> {
        let (passed, [from, to]) = match self.window {
            Some([from, to]) => (self.in_window[of], [from, to.min(self.now.time)]),
            None => (self.now.passed[of] - self.first_share[of], [self.first?, self.last]),
        };
        if to <= from {
            return None;
        }
        let during: Vec<&Row> = self.rows.iter().filter(|row| (from..=to).contains(&row.time)).collect();
        let passed_at = |row: &Row| row.passed[of];
        let gone_at = |row: &Row| row.gone[of];
        let rates = |value: &dyn Fn(&Row) -> f64| -> Vec<f64> {
            let rate = |pair: &[&Row]| (value(pair[1]) - value(pair[0])) / (pair[1].time - pair[0].time);
            during.windows(2).map(rate).collect()
        };
        let ends = || error_of_ends(&rates(&|row| passed_at(row) - gone_at(row)));
        let standard_error = match self.is_closed.then(ends).flatten() {
            Some(ends) => standard_error(&rates(&gone_at)).map(|gone| libm::hypot(ends, gone)),
            None => standard_error(&rates(&passed_at)),
        };
        Some(Estimate { mean: passed / (to - from), standard_error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_bounded_evenly_spaced_and_complete() {
        let mut passages = Passages::new(0.0, None, false);
        for k in 1..=10_000 {
            passages.count(1, 0.5, f64::from(k) - 0.5);
            passages.write(f64::from(k));
            assert!(passages.rows.len() < MOST_ROWS);
        }
        let rows = passages.rows();
        assert_eq!(rows.last(), Some(&Row { time: 10_000.0, passed: [10_000.0, 5_000.0], gone: [0.0; 2] }));
        assert!(rows.iter().all(|row| row.time == row.passed[NUMBER]));
        let stride = rows[1].time - rows[0].time;
        assert!(rows[..rows.len() - 1].windows(2).all(|pair| pair[1].time - pair[0].time == stride), "{stride}");
        let rate = passages.rate(NUMBER).unwrap();
        assert_eq!(rate, Estimate { mean: 1.0, standard_error: Some(0.0) });
    }

    #[test]
    fn discharge_error_is_the_same_in_closed_and_open_boxes() {
        let noise = crate::analysis::statistics::tests::correlated(0.0, 1000, 3);
        let error = |is_closed: bool, of: fn(usize, f64) -> i64| {
            let mut passages = Passages::new(0.0, None, is_closed);
            for (k, x) in noise.iter().enumerate() {
                let sign = of(k, *x);
                (0..sign.abs()).for_each(|_| passages.count(sign.signum(), 1.0, k as f64 + 0.5));
                passages.write(k as f64 + 1.0);
            }
            passages.rate(NUMBER).unwrap().standard_error.unwrap()
        };
        // One or two particles pass in each time unit, at random. The standard error is 1 / 2 / sqrt(1000).
        let discharge = |_: usize, x: f64| 1 + i64::from(x > 0.0);
        assert_eq!(error(true, discharge), error(false, discharge));
        assert!((error(true, discharge) / 0.0158 - 1.0).abs() < 0.2);
        // Passages alternate in direction, so the number of particles on one side has the variance `s^2 = 1/4`.
        let swing = |k: usize, _: f64| if k.is_multiple_of(2) { 1 } else { -1 };
        assert!((error(true, swing) / (0.5_f64.sqrt() / 1000.0) - 1.0).abs() < 0.2, "{}", error(true, swing));
    }

    #[test]
    fn rate_covers_only_the_time_with_flow() {
        let mut passages = Passages::new(0.0, None, false);
        assert_eq!(passages.rate(NUMBER), None);
        for k in 1..=100 {
            if (20..40).contains(&k) {
                passages.count(1, 1.5, f64::from(k));
            }
            passages.write(f64::from(k));
        }
        // After the first passage at t = 20, there are 19 passages until t = 39.
        assert_eq!(passages.rate(NUMBER).unwrap().mean, 1.0);
        assert_eq!(passages.rate(NUMBER).unwrap().standard_error, Some(0.0));
        assert_eq!(passages.rate(MASS).unwrap().mean, 1.5);
    }

    #[test]
    fn the_rate_in_a_window_counts_what_passes_in_it() {
        let rate = |window, of| {
            let mut passages = Passages::new(10.0, Some(window), false);
            for k in 1..=100 {
                // Particles pass one by one from t = 40 on, and in pairs from t = 60 on.
                let sign = [0, 1, 2][usize::from(k >= 30) + usize::from(k >= 50)];
                (0..sign).for_each(|_| passages.count(1, 2.5, 10.0 + f64::from(k) - 0.25));
                passages.write(10.0 + f64::from(k));
            }
            passages.rate(of).map(|rate| rate.mean)
        };
        assert_eq!(rate([40.0, 59.0], NUMBER), Some(1.0));
        assert_eq!(rate([60.0, 80.0], MASS), Some(5.0));
        assert_eq!(rate([15.0, 30.0], NUMBER), Some(0.0));
        // The measurement ends at t = 110, before the end of the window.
        assert_eq!(rate([100.0, 1e9], NUMBER), Some(2.0));
        assert_eq!(rate([110.0, 120.0], NUMBER), None);
    }
}
