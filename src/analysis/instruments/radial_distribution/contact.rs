//! The radial distribution function at the contact of two cores, extrapolated from just outside.

use crate::analysis::instruments::bins::Bins;
use crate::analysis::statistics::{CurveAverage, Estimate};
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

pub(super) const CONTACT_BINS: usize = 20;

/// Width of the shell divided by the contact distance, if the potential has no step within the shell.
const WIDTH: f64 = 0.1;

/// With fewer bins near contact, a parabola is poorly determined.
const FEWEST_BINS: usize = 8;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Shell {
    /// Distance at which the two cores are in contact `[length]`.
    pub core: f64,
    /// Upper end of the bins `[length]`. It is at most the next step of the potential, because `g` jumps there.
    pub end: f64,
}

impl Shell {
    pub fn new(core: f64, step: Option<f64>) -> Self {
        let end = core * (1.0 + WIDTH);
        Self { core, end: step.map_or(end, |step| end.min(step)) }
    }

    pub fn bins(&self) -> Bins {
        Bins::over(self.core, self.end - self.core, CONTACT_BINS)
    }

    /// Round-off may put a pair in contact slightly inside the core. Such a pair is put into the first bin.
    pub fn bin(&self, distance: f64) -> Option<usize> {
        let is_in = distance > self.core * (1.0 - 1e-7);
        is_in.then(|| self.bins().index(distance.max(self.core))).flatten()
    }
}

/// Returns `g` at contact, `exp a`. The parabola `ln g = a + b x + c x^2` is fitted to the bins from element `first`
/// on. Each bin is weighted by its number of pairs. In dense systems `g` falls within a small fraction of a diameter,
/// so the fit ends where `g` has fallen to half. `None` if `g` falls to half within the first bin, as near jamming.
///
/// The error follows from the errors of the bins and their correlations, by `d ln g = dg / g`.
pub(super) fn extrapolate(curve: &CurveAverage, ideal: &[f64], first: usize) -> Option<Estimate> {
    let values: Vec<f64> = (first..first + CONTACT_BINS).map(|k| curve.mean(k)).collect::<Option<_>>()?;
    if values[1] < 0.5 * values[0] {
        return None;
    }
    let half = 0.25 * (values[0] + values[1]);
    let used = values.iter().position(|&value| value < half).unwrap_or(CONTACT_BINS).max(FEWEST_BINS);
    if values[..used].iter().any(|&value| value <= 0.0) {
        return None;
    }
    let row = |k: usize| {
        let x = (k as f64 + 0.5) / CONTACT_BINS as f64;
        Vector3::new(1.0, x, x * x)
    };
    let weight = |k: usize| values[k] * ideal[first + k];
    let normal: Matrix3<f64> = (0..used).map(|k| row(k) * row(k).transpose() * weight(k)).sum();
    let inverse = normal.try_inverse()?;
    let share = |k: usize| (inverse.row(0) * row(k))[0] * weight(k);
    let logarithm: f64 = (0..used).map(|k| share(k) * libm::log(values[k])).sum();
    let mean = libm::exp(logarithm);
    let terms: Vec<(usize, f64)> = (0..used).map(|k| (first + k, mean * share(k) / values[k])).collect();
    let standard_error = curve.combination(&terms)?.standard_error;
    mean.is_finite().then_some(Estimate { mean, standard_error })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_exponential_is_extrapolated_exactly() {
        for decay in [0.1, 1.0, 5.0] {
            let mut curve = CurveAverage::new(CONTACT_BINS + 3);
            let value = |k: usize| 3.0 * (-decay * (k as f64 + 0.5) / CONTACT_BINS as f64).exp();
            // Noise that raises or lowers all bins by a tenth, in irregular order.
            let noise: Vec<f64> = (0..32_u32).map(|k| if k * k * 7 % 13 < 6 { 1.1 } else { 0.9 }).collect();
            for factor in &noise {
                (0..CONTACT_BINS).for_each(|k| curve.add(k + 3, factor * value(k)));
            }
            let Estimate { mean, standard_error } = extrapolate(&curve, &[1.0; CONTACT_BINS + 3], 3).unwrap();
            // The condition number of the normal equations is about 1e5.
            let average = noise.iter().sum::<f64>() / 32.0;
            assert!((mean - 3.0 * average).abs() < 1e-9, "{mean}");
            // Each noise factor multiplies all bins, and therefore the contact value.
            let expected = 3.0 * crate::analysis::statistics::standard_error(&noise).unwrap();
            assert!((standard_error.unwrap() / expected - 1.0).abs() < 1e-6, "{standard_error:?}");
        }
    }

    #[test]
    fn value_halving_within_a_bin_is_not_extrapolated() {
        for (ratio, is_known) in [(0.501_f64, true), (0.499, false)] {
            let mut curve = CurveAverage::new(CONTACT_BINS);
            (0..32).for_each(|_| curve.add_all((0..).take(CONTACT_BINS).map(|k| 100.0 * ratio.powi(k))));
            assert_eq!(extrapolate(&curve, &[1.0; CONTACT_BINS], 0).is_some(), is_known, "{ratio}");
        }
    }

    #[test]
    fn contact_bins_run_from_contact_to_the_next_step() {
        let shell = Shell::new(2.0, None);
        assert_eq!(shell.bin(2.0), Some(0));
        assert_eq!(shell.bin(2.0_f64.next_down()), Some(0));
        assert_eq!(shell.bin(1.99), None);
        assert_eq!(shell.bin(2.199), Some(19));
        assert_eq!(shell.bin(2.2001), None);
        assert_eq!(Shell::new(2.0, Some(2.3)), shell);
        let narrow = Shell::new(2.0, Some(2.1));
        assert_eq!([2.001, 2.0999, 2.1].map(|distance| narrow.bin(distance)), [Some(0), Some(19), None]);
    }

    #[test]
    fn empty_bins_are_insufficient_data() {
        let mut curve = CurveAverage::new(CONTACT_BINS);
        assert_eq!(extrapolate(&curve, &[1.0; CONTACT_BINS], 0), None);
        curve.add_all([0.0; CONTACT_BINS]);
        assert_eq!(extrapolate(&curve, &[1.0; CONTACT_BINS], 0), None);
    }
}
