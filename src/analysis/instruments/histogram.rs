use crate::analysis::instruments::bins::Bins;
use crate::analysis::statistics::Estimate;
use serde::{Deserialize, Serialize};

/// The bin width is chosen after this number of values.
const FIRST: usize = 1000;

/// Upper end of the last bin, divided by the mean of the first values.
const MEANS: f64 = 8.0;

/// A histogram of positive values that chooses the bin width, unless the width is given. `count` includes values above
/// the last bin.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Histogram {
    /// The first values, before the bin width is chosen.
    first: Vec<f64>,
    /// Bin width; 0 before it is chosen.
    width: f64,
    counts: Vec<u64>,
    pub count: u64,
    sum: f64,
}

impl Histogram {
    pub fn new(bins: usize) -> Self {
        Self { first: Vec::new(), width: 0.0, counts: vec![0; bins], count: 0, sum: 0.0 }
    }

    /// A histogram whose last bin ends at `longest`, if it is given.
    pub fn up_to(longest: Option<f64>, bins: usize) -> Self {
        Self { width: longest.map_or(0.0, |longest| longest / bins as f64), ..Self::new(bins) }
    }

    pub fn add(&mut self, value: f64) {
        self.count += 1;
        self.sum += value;
        if self.width > 0.0 {
            self.put(value);
            return;
        }
        self.first.push(value);
        if self.first.len() >= FIRST {
            self.choose();
        }
    }

    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// Returns the bin width and the density of each bin: the fraction of values in the bin, divided by the width.
    /// Standard errors assume independent values. There are no bins if there are no values, or only a few zeros.
    pub fn density(&self) -> (f64, Vec<Option<Estimate>>) {
        let mut binned = self.clone();
        if binned.width == 0.0 {
            binned.choose();
        }
        if binned.width == 0.0 {
            return (0.0, Vec::new());
        }
        let scale = 1.0 / (binned.count as f64 * binned.width);
        let density = |&count: &u64| {
            let standard_error = (count > 0).then(|| (count as f64).sqrt() * scale);
            Some(Estimate { mean: count as f64 * scale, standard_error })
        };
        (binned.width, binned.counts.iter().map(density).collect())
    }

    fn put(&mut self, value: f64) {
        if let Some(bin) = Bins::of_width(0.0, self.width, self.counts.len()).index(value) {
            self.counts[bin] += 1;
        }
    }

    fn choose(&mut self) {
        let width = self.mean().unwrap_or(0.0) * MEANS / self.counts.len() as f64;
        // If all values are zero, any positive width is suitable. With a width of 0, all values would be kept.
        let is_full = self.first.len() >= FIRST;
        self.width = if width > 0.0 || !is_full { width } else { f64::MIN_POSITIVE };
        if self.width > 0.0 {
            for value in std::mem::take(&mut self.first) {
                self.put(value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_value_is_counted_whenever_the_bins_were_chosen() {
        let mut histogram = Histogram::new(16);
        assert_eq!((histogram.mean(), histogram.density()), (None, (0.0, Vec::new())));
        for k in 0..4000_u32 {
            histogram.add(f64::from(k % 8) + 0.5);
            if [0, 10, 998, 999, 1500, 3999].contains(&k) {
                let (width, bins) = histogram.density();
                let sum: f64 = bins.iter().flatten().map(|density| density.mean * width).sum();
                assert!((sum - 1.0).abs() < 1e-12, "{k}: {sum}");
            }
        }
        assert_eq!(histogram.mean(), Some(4.0));
        let (width, bins) = histogram.density();
        assert_eq!(width, 2.0, "16 bins from 0 to eight times the mean, which is 4");
        let full = Estimate { mean: 0.125, standard_error: Some(1000.0_f64.sqrt() / 8000.0) };
        assert_eq!(bins[3], Some(full));
        assert_eq!(bins[4], Some(Estimate { mean: 0.0, standard_error: None }));
        assert!(histogram.first.is_empty());
    }

    #[test]
    fn values_beyond_the_last_bin_count_in_the_mean_and_zeros_need_no_memory() {
        let mut histogram = Histogram::new(8);
        (0..1000).for_each(|_| histogram.add(1.0));
        (0..1000).for_each(|_| histogram.add(100.0));
        assert_eq!(histogram.mean(), Some(50.5));
        assert_eq!(histogram.density().1[1].unwrap().mean, 0.5);
        let mut zeros = Histogram::new(8);
        (0..5000).for_each(|_| zeros.add(0.0));
        assert!(zeros.first.is_empty());
        assert!(zeros.density().1.iter().flatten().all(|density| density.mean.is_finite()));
    }
}
