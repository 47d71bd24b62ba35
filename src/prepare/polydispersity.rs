//! Distributions of diameters, divided into classes. Each class is a species.
//!
//! With `n` classes, the class `k` covers the quantiles from `k/n` to `(k+1)/n`, and its diameter is the mean over this
//! range. So all classes have equal shares, and their mean is exactly the mean of the distribution. Their variance is
//! too small, because it lacks the variance within the classes.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Class {
    pub diameter: f64,
    /// The shares of all classes add up to 1 within round-off.
    pub share: f64,
}

/// Diameters of the classes of a uniform distribution `[length]`.
pub(crate) fn uniform(lower: f64, upper: f64, classes: u64) -> Vec<f64> {
    let width = (upper - lower) / classes as f64;
    (0..classes).map(|k| lower + (k as f64 + 0.5) * width).collect()
}

/// Diameters of the classes of a Gaussian distribution that is truncated at 0 `[length]`. The classes are equal shares
/// of the part above 0. The mean between the quantiles `a` and `b`, which enclose a share `w`, is `mean + deviation
/// (g(a) - g(b)) / w` with the density `g`.
pub(crate) fn gaussian(mean: f64, deviation: f64, classes: u64) -> Vec<f64> {
    let cut = normal_distribution(-mean / deviation);
    let share = (1.0 - cut) / classes as f64;
    let density = |z: f64| libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt();
    let edge = |k: u64| match k {
        0 => density(mean / deviation),
        k if k == classes => 0.0,
        k => density(normal_quantile(cut + k as f64 * share)),
    };
    (0..classes).map(|k| mean + deviation * (edge(k) - edge(k + 1)) / share).collect()
}

/// Diameters of the classes of a lognormal distribution `[length]`.
///
/// `mean` and `deviation` describe the diameter. Its logarithm has the variance `s^2 = ln(1 + deviation^2 / mean^2)`. A
/// class between the quantiles `a` and `b` of the standard normal distribution has the mean `n mean [P(b - s) - P(a -
/// s)]`, with the normal distribution function `P` and the number of classes `n`.
pub(crate) fn lognormal(mean: f64, deviation: f64, classes: u64) -> Vec<f64> {
    let width = libm::log1p((deviation / mean) * (deviation / mean)).sqrt();
    let edge = |k: u64| match k {
        0 => 0.0,
        k if k == classes => 1.0,
        k => normal_distribution(normal_quantile(k as f64 / classes as f64) - width),
    };
    (0..classes).map(|k| classes as f64 * mean * (edge(k + 1) - edge(k))).collect()
}

pub(crate) fn mean_diameter(classes: &[Class]) -> f64 {
    classes.iter().map(|class| class.share * class.diameter).sum()
}

/// The mass of a particle of a class, in proportion to its volume. A particle of the mean diameter has the mass `mass`.
pub(crate) fn mass_of(class: &Class, mean_diameter: f64, mass: f64, dimensions: usize) -> f64 {
    mass * libm::pow(class.diameter / mean_diameter, dimensions as f64)
}

/// Returns the order in which `count` classes of diameters receive the particles that remain after an equal division.
/// Classes at equal distances from the middle class follow each other, so that the mean diameter hardly changes.
pub(crate) fn spread(count: usize) -> impl Iterator<Item = usize> {
    let bits = count.next_power_of_two().trailing_zeros();
    let reversed =
        (0..1_usize << bits).map(move |k| if bits == 0 { 0 } else { k.reverse_bits() >> (usize::BITS - bits) });
    let half = count.div_ceil(2);
    reversed.filter(move |&k| k < half).flat_map(move |k| {
        let mirror = count - 1 - k;
        std::iter::once(k).chain((mirror != k).then_some(mirror))
    })
}

/// Fraction of a Gaussian distribution of mean 0 and standard deviation 1 that is below `z`.
fn normal_distribution(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// Inverse of [`normal_distribution`], by bisection down to adjacent floats.
fn normal_quantile(share: f64) -> f64 {
    // Beyond 40 standard deviations, double precision cannot resolve the fraction.
    let (mut lower, mut upper) = (-40.0, 40.0);
    loop {
        let middle = 0.5 * (lower + upper);
        if middle <= lower || middle >= upper {
            return middle;
        }
        if normal_distribution(middle) < share { lower = middle } else { upper = middle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mean_and_deviation(diameters: &[f64]) -> (f64, f64) {
        let count = diameters.len() as f64;
        let mean = diameters.iter().sum::<f64>() / count;
        (mean, (diameters.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / count).sqrt())
    }

    #[test]
    fn normal_quantiles_match_tables() {
        assert!(normal_quantile(0.5).abs() < 1e-15);
        assert!((normal_quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-14);
        assert!((normal_quantile(0.001) + 3.090_232_306_167_813_5).abs() < 1e-14);
    }

    #[test]
    fn class_mean_is_exact_and_variance_lacks_spread_within_classes() {
        let (mean, deviation) = mean_and_deviation(&uniform(0.8, 1.4, 10));
        assert!((mean - 1.1).abs() < 1e-15);
        // The variance of `n` class diameters over a range of width `w` is `(w^2 - (w/n)^2) / 12`.
        assert!((deviation - (0.6_f64.powi(2) * 0.99 / 12.0).sqrt()).abs() < 1e-15);
        for (of, width) in [(gaussian as fn(f64, f64, u64) -> Vec<f64>, 0.0), (lognormal, 0.1)] {
            let diameters = of(2.0, 0.2, 64);
            assert!(diameters.windows(2).all(|pair| pair[0] < pair[1]));
            let (mean, deviation) = mean_and_deviation(&diameters);
            // The mean has the rounding errors of a sum of 64 terms.
            assert!((mean - 2.0).abs() < 1e-13, "{mean}");
            // Upper bound of the variance within the `n` classes, relative to the total variance. The two outermost
            // classes contribute most: a tail beyond `z` has at most the variance `1 / z^2` about its mean. All others
            // share a range of `2 z`, with the variance `(2 z / n)^2 / 12`. The tails of a lognormal distribution are
            // stretched by up to `exp(2 * 0.1 * z)`.
            let z: f64 = 2.15;
            let within = (2.0 / 64.0 / (z * z) + (2.0 * z / 64.0).powi(2) / 12.0) * libm::exp(2.0 * width * z);
            let lost = 1.0 - (deviation / 0.2) * (deviation / 0.2);
            assert!(lost > 0.0 && lost < within, "{lost} {within}");
        }
    }

    #[test]
    fn single_class_is_the_mean() {
        assert_eq!(uniform(1.0, 2.0, 1), [1.5]);
        assert_eq!(lognormal(1.5, 0.3, 1), [1.5]);
        assert!((gaussian(1.5, 0.1, 1)[0] - 1.5).abs() < 1e-15);
    }

    #[test]
    fn a_gaussian_is_cut_at_zero() {
        // With a mean near 0, truncation leaves half of the distribution, with a mean of sqrt(2 / pi) standard
        // deviations.
        let diameters = gaussian(1e-9, 1.0, 64);
        let (mean, deviation) = mean_and_deviation(&diameters);
        assert!((mean - (2.0 / PI).sqrt()).abs() < 1e-8, "{mean}");
        assert!(diameters[0] > 0.0 && diameters[0] < 0.02);
        assert!((deviation - (1.0 - 2.0 / PI).sqrt()).abs() < 0.01);
    }

    #[test]
    fn first_classes_are_spread_around_the_middle() {
        let first = |count: usize| spread(count).collect::<Vec<_>>();
        assert_eq!(first(1), [0]);
        assert_eq!(first(2), [0, 1]);
        assert_eq!(first(3), [0, 2, 1]);
        assert_eq!(first(8), [0, 7, 2, 5, 1, 6, 3, 4]);
        for count in 1..=64 {
            let mut all = first(count);
            all.sort_unstable();
            assert_eq!(all, (0..count).collect::<Vec<_>>());
        }
    }
}
