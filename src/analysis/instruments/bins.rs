use crate::base::numbers::{index, trunc_to_usize};
use crate::model::measurement_plan::MOST_BINS;

/// Bins of equal width along a line, for distributions and profiles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bins {
    from: f64,
    /// The whole extent, or the width of one bin.
    length: f64,
    per_length: f64,
    pub count: usize,
}

impl Bins {
    pub fn over(from: f64, extent: f64, count: usize) -> Self {
        Self { from, length: extent, per_length: count as f64, count }
    }

    pub fn of_width(from: f64, width: f64, count: usize) -> Self {
        Self { from, length: width, per_length: 1.0, count }
    }

    pub fn planned(given: Option<u64>, default: u64) -> usize {
        index(given.unwrap_or(default).clamp(1, MOST_BINS))
    }

    pub fn width(&self) -> f64 {
        self.length / self.per_length
    }

    /// Distance of a value from the lower end, in bins.
    pub fn place(&self, value: f64) -> f64 {
        (value - self.from) / self.length * self.per_length
    }

    /// Index of the bin that contains a value. A bin includes the lower edge, but not the upper edge.
    pub fn index(&self, value: f64) -> Option<usize> {
        let place = self.place(value);
        (place >= 0.0 && place < self.count as f64).then(|| trunc_to_usize(place))
    }

    /// Index of the bin nearest to a value that may lie outside of all bins because of round-off.
    pub fn nearest(&self, value: f64) -> usize {
        trunc_to_usize(self.place(value)).min(self.count - 1)
    }

    /// Probability density in a bin that contains a fraction of all values.
    pub fn density(&self, fraction: f64) -> f64 {
        fraction * self.per_length / self.length
    }

    pub fn edge(&self, bin: usize) -> f64 {
        self.at(bin as f64)
    }

    pub fn centre(&self, bin: usize) -> f64 {
        self.at(bin as f64 + 0.5)
    }

    pub fn centres(&self) -> Vec<f64> {
        (0..self.count).map(|bin| self.centre(bin)).collect()
    }

    fn at(&self, place: f64) -> f64 {
        self.from + self.length * (place / self.per_length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_of_an_extent_and_of_a_width_agree() {
        for bins in [Bins::over(-1.0, 2.0, 4), Bins::of_width(-1.0, 0.5, 4)] {
            assert_eq!(bins.width(), 0.5);
            assert_eq!(bins.centres(), [-0.75, -0.25, 0.25, 0.75]);
            assert_eq!([0, 1, 4].map(|bin| bins.edge(bin)), [-1.0, -0.5, 1.0]);
            assert_eq!(bins.density(0.25), 0.5);
            let values = [(-1.0_f64).next_down(), -1.0, -0.5, 0.0, 1.0 - f64::EPSILON, 1.0, f64::NAN];
            let expected = [None, Some(0), Some(1), Some(2), Some(3), None, None];
            assert_eq!(values.map(|value| bins.index(value)), expected);
            assert_eq!([-1.1, 0.6, 1.1].map(|value| bins.nearest(value)), [0, 3, 3]);
        }
    }

    #[test]
    fn planned_numbers_of_bins_are_limited() {
        assert_eq!([None, Some(0), Some(7), Some(1 << 40)].map(|given| Bins::planned(given, 9)), [9, 1, 7, 2000]);
    }
}
