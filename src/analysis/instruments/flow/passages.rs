//! Passages over time, in bounded memory.

use serde::{Deserialize, Serialize};

use crate::analysis::statistics::{Estimate, standard_error};

/// Every second row goes when there are this many.
const MOST_ROWS: usize = 1024;

/// What has passed up to a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Row {
    pub time: f64,
    pub total: i64,
}

/// Counts passages and remembers how the count grew.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Passages {
    rows: Vec<Row>,
    /// Of how many samples one is a row, and how many have gone since the last one.
    stride: u64,
    skipped: u64,
    /// The last sample.
    now: Row,
    /// Time of the first and of the last passage, and what the first counted for.
    first: Option<f64>,
    last: f64,
    first_sign: i64,
}

impl Passages {
    pub fn new(start: f64) -> Self {
        let now = Row { time: start, total: 0 };
        Self { rows: vec![now], stride: 1, skipped: 0, now, first: None, last: start, first_sign: 0 }
    }

    /// One passage, not before the last sample. Those between two samples may come in any order.
    pub fn count(&mut self, sign: i64, time: f64) {
        self.now.total += sign;
        if self.first.is_none_or(|first| time < first) {
            (self.first, self.first_sign) = (Some(time), sign);
        }
        self.last = self.last.max(time);
    }

    /// The end of a sample.
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
            // The last row is one of those that went: one sample of the next row has come.
            self.skipped = self.stride;
            self.stride *= 2;
        }
    }

    pub fn total(&self) -> i64 {
        self.now.total
    }

    /// The count at times that are even but for the last one.
    pub fn rows(&self) -> Vec<Row> {
        let mut rows = self.rows.clone();
        if rows.last() != Some(&self.now) {
            rows.push(self.now);
        }
        rows
    }

    /// Passages after the first one by the time that they took; `None` for fewer than two.
    pub fn rate(&self) -> Option<Estimate> {
        let first = self.first?;
        let duration = self.last - first;
        if duration <= 0.0 {
            return None;
        }
        let during: Vec<&Row> = self.rows.iter().filter(|row| (first..=self.last).contains(&row.time)).collect();
        let rate = |pair: &[&Row]| (pair[1].total - pair[0].total) as f64 / (pair[1].time - pair[0].time);
        let rates: Vec<f64> = during.windows(2).map(rate).collect();
        let mean = (self.now.total - self.first_sign) as f64 / duration;
        Some(Estimate { mean, standard_error: standard_error(&rates) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_bounded_even_and_have_the_whole_count() {
        let mut passages = Passages::new(0.0);
        for k in 1..=10_000 {
            passages.count(1, f64::from(k) - 0.5);
            passages.write(f64::from(k));
            assert!(passages.rows.len() < MOST_ROWS);
        }
        let rows = passages.rows();
        assert_eq!(rows.last(), Some(&Row { time: 10_000.0, total: 10_000 }));
        assert!(rows.iter().all(|row| row.time == row.total as f64));
        let stride = rows[1].time - rows[0].time;
        assert!(rows[..rows.len() - 1].windows(2).all(|pair| pair[1].time - pair[0].time == stride), "{stride}");
        let rate = passages.rate().unwrap();
        assert_eq!(rate, Estimate { mean: 1.0, standard_error: Some(0.0) });
    }

    #[test]
    fn the_rate_is_that_of_the_time_in_which_it_flows() {
        let mut passages = Passages::new(0.0);
        assert_eq!(passages.rate(), None);
        for k in 1..=100 {
            if (20..40).contains(&k) {
                passages.count(1, f64::from(k));
            }
            passages.write(f64::from(k));
        }
        // 19 after the first at 20, the last at 39.
        assert_eq!(passages.rate().unwrap().mean, 1.0);
        assert_eq!(passages.rate().unwrap().standard_error, Some(0.0));
    }
}
