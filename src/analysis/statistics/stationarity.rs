//! Tests whether a time series is stationary, that is, whether it began in equilibrium.

use super::{ROUNDING, halved, spectrum};
use serde::{Deserialize, Serialize};

/// The numbers `a` and `b` of a limit. A series drifts if the means of its first quarter and of its second half differ
/// by more than `a + b / n` standard errors, where `n` is the number of independent values.
///
/// In tests, fewer than one in 300 stationary series seem to drift, or one in 25 if noise hides slow motion.
const LIMIT: (f64, f64) = (4.5, 10.0);

/// Limit for errors from residuals about a straight line. These errors are too small.
const LIMIT_BESIDE_A_LINE: (f64, f64) = (6.0, 12.0);

/// Minimum number of independent values in the second half for the verdict `Stationary`.
const FEWEST: f64 = 10.0;

/// Minimum number of independent values for a test with residuals about a line through most of the series.
const FEWEST_BESIDE_A_LINE: f64 = 5.0;

const FEWEST_VALUES: usize = 20;

/// In a longer series, neighbouring values are averaged first.
const MOST_VALUES: usize = 512;

/// Stationarity of a time series, by Geweke's test.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "verdict", content = "by")]
pub enum Stationarity {
    /// The series is stationary, as far as the data show.
    Stationary,
    /// All values are equal.
    Constant,
    /// The series drifts. The value is the mean of the second half minus the mean of the first quarter.
    Drifting(f64),
    /// The series is too short to estimate its correlation, or has values that are not finite.
    Unknown,
}

/// Tests whether the means of the first quarter and of the second half of an evenly weighted series differ by more than
/// chance: J. Geweke, in Bayesian Statistics 4 (Oxford University Press, 1992), p. 169. The spectral density at
/// frequency zero is taken from the second half, which is closer to equilibrium.
///
/// The second half may drift itself, so the test is repeated with the residuals of the second half about a straight
/// line. If the second half has too few independent values, the residuals of the whole series are used.
///
/// A drift must be confirmed by the residuals of the last three quarters. Other errors may be too small by chance.
#[must_use]
pub fn stationarity(series: &[f64]) -> Stationarity {
    if series.len() > MOST_VALUES {
        return stationarity(&halved(series));
    }
    let n = series.len();
    if n < FEWEST_VALUES || !series.iter().all(|x| x.is_finite()) {
        return Stationarity::Unknown;
    }
    let (first, second) = (&series[..n / 4], &series[n / 2..]);
    let drift = mean(second) - mean(first);
    let scale = series.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    if series.iter().all(|x| (x - series[0]).abs() <= ROUNDING * scale) {
        return Stationarity::Constant;
    }
    let is_far = |noise: &Noise, limit: (f64, f64)| {
        let error = (noise.density * (1.0 / first.len() as f64 + 1.0 / second.len() as f64)).sqrt();
        drift.abs() > (limit.0 + limit.1 / noise.independent) * error
    };
    let is_far_beside_a_line = |part: &[f64], fewest: f64, limit: (f64, f64)| {
        Noise::of(part, true).is_some_and(|noise| noise.independent >= fewest && is_far(&noise, limit))
    };
    let known = Noise::of(second, false).filter(|noise| noise.independent >= FEWEST);
    let is_seen = known.as_ref().is_some_and(|noise| is_far(noise, LIMIT))
        || is_far_beside_a_line(second, FEWEST, LIMIT_BESIDE_A_LINE)
        || (known.is_none() && is_far_beside_a_line(series, FEWEST_BESIDE_A_LINE, LIMIT_BESIDE_A_LINE));
    if !is_seen {
        return if known.is_some() { Stationarity::Stationary } else { Stationarity::Unknown };
    }
    if is_far_beside_a_line(&series[n / 4..], FEWEST_BESIDE_A_LINE, LIMIT) {
        Stationarity::Drifting(drift)
    } else {
        Stationarity::Unknown
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Noise of a series about its mean, or about a straight line through it.
struct Noise {
    /// Spectral density of the noise at frequency zero.
    density: f64,
    independent: f64,
}

impl Noise {
    /// `None` if the series is too short for its correlations, or if its mean and all deviations are zero.
    fn of(series: &[f64], is_beside_a_line: bool) -> Option<Self> {
        let n = series.len() as f64;
        let (middle, mean) = (0.5 * (n - 1.0), mean(series));
        let mut deviations: Vec<f64> = series.iter().map(|x| x - mean).collect();
        if is_beside_a_line {
            let product: f64 = deviations.iter().enumerate().map(|(k, x)| (k as f64 - middle) * x).sum();
            let slope = 12.0 * product / (n * (n * n - 1.0));
            deviations.iter_mut().enumerate().for_each(|(k, x)| *x -= slope * (k as f64 - middle));
        }
        let variance = deviations.iter().map(|x| x * x).sum::<f64>() / (n - 1.0);
        if variance.sqrt() <= ROUNDING * mean.abs() {
            // There is no noise: the series is a straight line, or its second half is constant.
            return (variance > 0.0 || mean != 0.0).then_some(Self { density: variance, independent: n });
        }
        let relative = spectrum::density_at_zero(&deviations, variance)?.at_zero;
        Some(Self { density: relative * variance, independent: n / relative })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::statistics::tests::{correlated, under_noise};

    fn is_drifting(series: &[f64]) -> bool {
        matches!(stationarity(series), Stationarity::Drifting(_))
    }

    #[test]
    fn stationary_series_are_seldom_called_drifting() {
        for (rho, n) in [(0.0, 200), (0.5, 200), (0.8, 200), (0.9, 200), (0.9, 400), (-0.5, 200), (0.0, 40), (0.5, 60)]
        {
            let count = 300;
            let series = |seed: &u64| correlated(rho, n, 50_000 + seed);
            let drifting = (0..count).filter(|seed| is_drifting(&series(seed))).count();
            // In 300 stationary series, one false alarm is expected. Five or more false alarms occur once in 270 tests.
            assert!(drifting <= 4, "rho {rho}, {n} values: {drifting} of {count}");
        }
    }

    #[test]
    fn noisy_slow_stationary_series_rarely_count_as_drifting() {
        for (rho, n, noise, most) in
            [(0.98, 300, 6.0, 15), (0.98, 400, 12.0, 13), (0.95, 300, 4.0, 9), (0.95, 600, 4.0, 4)]
        {
            let count = 300;
            let series = |seed: &u64| under_noise(rho, n, noise, 60_000 + seed);
            let drifting = (0..count).filter(|seed| is_drifting(&series(seed))).count();
            println!("rho {rho}, {n} values, noise {noise}: {drifting} of {count}");
            // The four cases have about 10, 7, 3 and 1 false alarms. A test of the second half alone would have 30, 26,
            // 14 and 2.
            assert!(drifting <= most, "rho {rho}, {n} values, noise {noise}: {drifting} of {count}");
        }
    }

    #[test]
    fn relaxing_or_rising_series_is_drifting() {
        // One series relaxes from ten standard deviations, and the other drifts by three standard deviations.
        let relaxing = |k: usize| 3.0 * libm::exp(-(k as f64) / 40.0);
        let rising = |k: usize| 1.0 * k as f64 / 200.0;
        for (seed, rho) in [(1, 0.0), (2, 0.0), (3, 0.5), (4, 0.5), (5, 0.7)] {
            let series = |drift: &dyn Fn(usize) -> f64| -> Vec<f64> {
                correlated(rho, 200, seed).iter().enumerate().map(|(k, x)| x + drift(k)).collect()
            };
            assert!(is_drifting(&series(&relaxing)), "{seed}");
            assert!(rho > 0.0 || is_drifting(&series(&rising)), "{seed}");
        }
        let Stationarity::Drifting(by) = stationarity(&(0..200).map(f64::from).collect::<Vec<_>>()) else {
            panic!("a straight line");
        };
        assert_eq!(by, 125.0);
    }

    #[test]
    fn a_constant_does_not_drift_and_too_little_is_unknown() {
        assert_eq!(stationarity(&[1.5; 100]), Stationarity::Constant);
        assert_eq!(stationarity(&[0.0; 100]), Stationarity::Constant);
        assert_eq!(stationarity(&correlated(0.0, 19, 1)), Stationarity::Unknown);
        assert_eq!(stationarity(&correlated(0.99, 100, 1)), Stationarity::Unknown);
    }

    #[test]
    fn nonfinite_series_is_unknown() {
        for odd in [f64::NAN, f64::INFINITY] {
            let mut series = correlated(0.0, 100, 1);
            assert_eq!(stationarity(&series), Stationarity::Stationary);
            series[70] = odd;
            assert_eq!(stationarity(&series), Stationarity::Unknown);
        }
    }
}
