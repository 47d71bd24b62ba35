//! Bins of equal width, for distributions and profiles.

use crate::base::numbers::{index, trunc_to_usize};
use crate::model::measurement_plan::MOST_BINS;

/// Bins of equal width along a line. Positions and widths have the dimension of the values.
///
/// Bins are given by their whole extent or by the width of one of them. All positions are computed from the given
/// length, so that it has no round-off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bins {
    from: f64,
    /// The given length, and the number of bins in it.
    length: f64,
    per_length: f64,
    pub count: usize,
}

impl Bins {
    /// Divides the range from `from` to `from + extent`.
    pub fn over(from: f64, extent: f64, count: usize) -> Self {
        Self { from, length: extent, per_length: count as f64, count }
    }

    pub fn of_width(from: f64, width: f64, count: usize) -> Self {
        Self { from, length: width, per_length: 1.0, count }
    }

    /// Number of bins in a plan: the given number, or the default.
    pub fn planned(given: Option<u64>, default: u64) -> usize {
        index(given.unwrap_or(default).clamp(1, MOST_BINS))
    }

    pub fn width(&self) -> f64 {
        self.length / self.per_length
    }

    /// Position of a value, in bins from the lower end. It may lie outside of the bins.
    pub fn place(&self, value: f64) -> f64 {
        (value - self.from) / self.length * self.per_length
    }

    /// Index of the bin that contains a value. The lower edge belongs to a bin, the upper edge to the next bin.
    pub fn index(&self, value: f64) -> Option<usize> {
        let place = self.place(value);
        (place >= 0.0 && place < self.count as f64).then(|| trunc_to_usize(place))
    }

    /// Index of the bin that is nearest to a value, which may lie outside of the bins by round-off.
    pub fn nearest(&self, value: f64) -> usize {
        trunc_to_usize(self.place(value)).min(self.count - 1)
    }

    /// Density of a fraction of all values that lies in one bin.
    pub fn density(&self, fraction: f64) -> f64 {
        fraction * self.per_length / self.length
    }

    /// Lower edge of a bin, or upper edge of the bin before it.
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
