//! Means of all values of a curve with their standard errors, in bounded memory.

use super::{BlockAverage, Estimate, standard_error};
use serde::{Deserialize, Serialize};

/// When an element has this many bins, neighbouring bins are merged. With 32 bins, errors are uncertain by 13 %.
const MOST_BINS: usize = 64;

/// Block averages of all elements of a curve: the bins of a histogram or the lags of a correlation function. Elements
/// may have different numbers of values. For [`Self::combination`], elements must receive values together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CurveAverage {
    elements: Vec<BlockAverage>,
}

impl CurveAverage {
    /// A curve of `length` elements without values.
    #[must_use]
    pub fn new(length: usize) -> Self {
        Self { elements: vec![BlockAverage::with_most_bins(MOST_BINS, 1.0); length] }
    }

    /// Number of elements.
    #[must_use]
    pub fn len(&self) -> usize {
        self.elements.len()
    }

    /// Whether the curve has no elements.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.elements.is_empty()
    }

    /// Adds one value to one element. Ignores values that are not finite and elements that do not exist.
    pub fn add(&mut self, element: usize, value: f64) {
        if let Some(average) = self.elements.get_mut(element) {
            average.add(value, 1.0);
        }
    }

    /// Adds one value to each element, starting with the first element.
    pub fn add_all(&mut self, values: impl IntoIterator<Item = f64>) {
        self.elements.iter_mut().zip(values).for_each(|(average, value)| average.add(value, 1.0));
    }

    /// Adds one value with the same weight to each element, starting with the first element.
    pub(crate) fn add_weighted(&mut self, values: impl IntoIterator<Item = f64>, weight: f64) {
        self.elements.iter_mut().zip(values).for_each(|(average, value)| average.add(value, weight));
    }

    /// Returns a histogram with bins twice as wide, padded with zeros. All elements must have received values together.
    #[must_use]
    pub(crate) fn joined_in_pairs(&self) -> Self {
        let length = self.elements.len();
        let pair = |k: usize| {
            let mut average = self.elements[if 2 * k < length { 2 * k } else { 0 }].clone();
            if 2 * k >= length {
                average.scale(0.0);
            } else if let Some(other) = self.elements.get(2 * k + 1) {
                average.add_series(other);
            }
            average
        };
        Self { elements: (0..length).map(pair).collect() }
    }

    /// Number of values of an element; 0 if the element does not exist.
    #[must_use]
    pub fn count(&self, element: usize) -> f64 {
        self.elements.get(element).map_or(0.0, |average| average.weight)
    }

    /// Largest number of values of any element.
    #[must_use]
    pub fn most(&self) -> f64 {
        self.elements.iter().map(|average| average.weight).fold(0.0, f64::max)
    }

    /// The mean of one element and its standard error; `None` without values.
    #[must_use]
    pub fn estimate(&self, element: usize) -> Option<Estimate> {
        self.elements.get(element)?.estimate()
    }

    pub(crate) fn estimates(&self, elements: impl IntoIterator<Item = usize>) -> Vec<Option<Estimate>> {
        elements.into_iter().map(|element| self.estimate(element)).collect()
    }

    /// The mean of one element; `None` without values.
    #[must_use]
    pub fn mean(&self, element: usize) -> Option<f64> {
        self.elements.get(element)?.mean()
    }

    /// The means of all elements; `None` for an element without values.
    #[must_use]
    pub fn means(&self) -> Vec<Option<f64>> {
        self.elements.iter().map(BlockAverage::mean).collect()
    }

    /// The standard errors of all means; `None` for a mean of too few values.
    #[must_use]
    pub fn standard_errors(&self) -> Vec<Option<f64>> {
        self.elements.iter().map(|average| average.estimate()?.standard_error).collect()
    }

    /// Returns the mean of `sum c_k x_k` with a standard error that includes all correlations between the elements.
    /// `terms` lists pairs of an element `k` and its coefficient `c_k`.
    ///
    /// The error of a function `f` of several means follows from its derivatives at the means, `c_k = df / dx_k`. For a
    /// ratio `R = x_a / x_b`, the terms are `[(a, 1 / x_b), (b, -R / x_b)]`.
    ///
    /// Returns `None` if there are no terms or an element has no values. The standard error is unknown if the elements
    /// have different numbers of values.
    #[must_use]
    pub fn combination(&self, terms: &[(usize, f64)]) -> Option<Estimate> {
        let mut mean = 0.0;
        let mut parts = Vec::with_capacity(terms.len());
        for &(element, coefficient) in terms {
            let average = self.elements.get(element)?;
            mean += coefficient * average.mean()?;
            parts.push((average, coefficient));
        }
        let (first, _) = parts.first()?;
        let is_together = parts.iter().all(|(average, _)| average.weight == first.weight);
        let sum = |bin: usize| parts.iter().map(|(average, coefficient)| coefficient * average.bins[bin]).sum();
        let bins: Option<Vec<f64>> = is_together.then(|| (0..first.bins.len()).map(sum).collect());
        Some(Estimate { mean, standard_error: bins.and_then(|bins| standard_error(&bins)) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    fn measured(seed: u64, samples: usize) -> CurveAverage {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut next = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let mut curve = CurveAverage::new(3);
        for _ in 0..samples {
            let (x, y) = (next(), next());
            curve.add_all([x, 1.0 - x, 2.0 * x * y]);
        }
        curve
    }

    #[test]
    fn curve_errors_of_independent_values_are_correct() {
        let curve = measured(1, 20_000);
        let error = curve.standard_errors()[0].unwrap();
        let exact = (1.0 / 12.0 / 20_000.0_f64).sqrt();
        // The error is uncertain by at most 13 %. The bound is a little more than three times as large.
        assert!((error / exact - 1.0).abs() < 0.45, "{error} but {exact}");
        assert!((curve.means()[0].unwrap() - 0.5).abs() < 4.0 * exact);
        assert!(curve.elements.iter().all(|average| average.bins.len() < MOST_BINS));
    }

    #[test]
    fn combined_elements_include_correlations() {
        let curve = measured(2, 5_000);
        let one = curve.combination(&[(0, 1.0), (1, 1.0)]).unwrap();
        assert!((one.mean - 1.0).abs() < 1e-12 && one.standard_error.unwrap() < 1e-12, "x and 1 - x: {one:?}");
        let difference = curve.combination(&[(0, 1.0), (1, -1.0)]).unwrap().standard_error.unwrap();
        assert!((difference / (2.0 * curve.standard_errors()[0].unwrap()) - 1.0).abs() < 1e-9, "2 x - 1");
        // The ratio `R = <2 x y> / <x>` is 1. The values `(2 x y - R x) / <x> = 2 x (2 y - 1)` have the variance 4 / 9.
        let (a, b) = (curve.means()[2].unwrap(), curve.means()[0].unwrap());
        let ratio = curve.combination(&[(2, 1.0 / b), (0, -a / (b * b))]).unwrap();
        assert!(ratio.mean.abs() < 1e-12, "derivatives of a ratio");
        let exact = (4.0 / 9.0 / 5_000.0_f64).sqrt();
        let of_seed = |seed: u64| {
            let curve = measured(seed, 5_000);
            let (a, b) = (curve.means()[2].unwrap(), curve.means()[0].unwrap());
            curve.combination(&[(2, 1.0 / b), (0, -a / (b * b))]).unwrap().standard_error.unwrap() / exact
        };
        let mean = (10..50).map(of_seed).sum::<f64>() / 40.0;
        // The mean of forty errors is uncertain by 4 %. The bounds also allow for the bias of the estimate.
        assert!((0.88..1.25).contains(&mean), "{mean}");
    }

    #[test]
    fn joined_bins_are_those_of_a_coarser_histogram() {
        for length in [4, 5] {
            let (mut fine, mut coarse) = (CurveAverage::new(length), CurveAverage::new(length));
            for k in 0..1000_u32 {
                let values: Vec<f64> = (3..3 + length).map(|bin| (k as usize * bin % 17) as f64).collect();
                let at = |bin: usize| values.get(bin).copied().unwrap_or(0.0);
                fine.add_all(values.iter().copied());
                coarse.add_all((0..length).map(|bin| at(2 * bin) + at(2 * bin + 1)));
            }
            // Integers add up without rounding, so means agree exactly. Errors differ, because bin means are rounded.
            assert_eq!(fine.joined_in_pairs().means(), coarse.means());
            let errors = fine.joined_in_pairs().standard_errors();
            for (error, expected) in errors.into_iter().zip(coarse.standard_errors()) {
                assert!((error.unwrap() - expected.unwrap()).abs() < 1e-9 * (1.0 + expected.unwrap()));
            }
        }
    }

    #[test]
    fn elements_may_have_different_numbers_of_values() {
        let mut curve = CurveAverage::new(2);
        (0..100).for_each(|k| curve.add(0, f64::from(k)));
        assert_eq!(curve.means(), [Some(49.5), None]);
        assert_eq!(curve.combination(&[(0, 1.0), (1, 1.0)]), None);
        assert_eq!(curve.combination(&[]), None);
        curve.add(1, 0.5);
        curve.add(7, 0.5);
        assert_eq!(curve.combination(&[(0, 1.0), (1, 1.0)]), Some(Estimate { mean: 50.0, standard_error: None }));
    }

    #[test]
    fn curve_average_survives_serialization() {
        let curve = measured(3, 1_000);
        let record = serde_json::to_string(&curve).unwrap();
        assert_eq!(serde_json::from_str::<CurveAverage>(&record).unwrap(), curve);
    }
}
