//! Values over time, in bounded memory.

use crate::analysis::statistics::Estimate;
use serde::{Deserialize, Serialize};

/// Maximum number of rows. When it is reached, every second row is dropped.
const MOST_ROWS: usize = 1024;

/// Rows of values at increasing times.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct RowsOverTime {
    rows: Vec<Row>,
    /// Number of samples per row, and number of samples since the latest row.
    stride: u64,
    skipped: u64,
}

/// Values at one time; `None` for values that do not exist at this time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Row {
    time: f64,
    values: Vec<Option<f64>>,
}

impl RowsOverTime {
    pub fn new() -> Self {
        Self { rows: Vec::new(), stride: 1, skipped: 0 }
    }

    pub fn add(&mut self, time: f64, values: Vec<Option<f64>>) {
        self.skipped += 1;
        if self.skipped < self.stride {
            return;
        }
        self.skipped = 0;
        self.rows.push(Row { time, values });
        if self.rows.len() > MOST_ROWS {
            // The first and the last row remain, because the number of rows is odd.
            let mut index = 0;
            self.rows.retain(|_| {
                index += 1;
                index % 2 == 1
            });
            self.stride *= 2;
        }
    }

    pub fn times(&self) -> Vec<f64> {
        self.rows.iter().map(|row| row.time).collect()
    }

    /// Returns the values of one column at all times.
    pub fn column(&self, index: usize) -> Vec<Option<Estimate>> {
        let value = |row: &Row| row.values.get(index).copied().flatten();
        self.rows.iter().map(|row| value(row).map(|mean| Estimate { mean, standard_error: None })).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_keep_the_first_and_cover_all_times_in_bounded_memory() {
        let mut rows = RowsOverTime::new();
        for k in 0..=10_000 {
            rows.add(f64::from(k), vec![Some(2.0 * f64::from(k))]);
        }
        let times = rows.times();
        assert!((MOST_ROWS / 2..=MOST_ROWS).contains(&times.len()), "{}", times.len());
        assert!(times[0] == 0.0 && *times.last().unwrap() > 9_980.0, "{times:?}");
        assert!(times.windows(2).all(|pair| pair[1] - pair[0] == times[1]), "{times:?}");
        let column = rows.column(0);
        assert!(times.iter().zip(column).all(|(time, value)| value.unwrap().mean == 2.0 * time));
    }
}
