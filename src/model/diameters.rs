//! Diameters of the particles of a species: distributions, and the masses that follow from them.
//!
//! A distribution is divided into classes. With `n` classes, class `k` covers the quantiles from `k/n` to `(k+1)/n`, so
//! all classes have equal shares. The diameter of a class is the mean over its quantiles. The mean diameter is therefore
//! exact. The variance is too small, because the spread within the classes is lost.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use serde::{Deserialize, Serialize};

use super::{Species, SpeciesId};

/// A distribution of diameters `[length]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum DiameterDistribution {
    /// All diameters between two limits are equally likely.
    Uniform {
        /// The smallest diameter.
        lower: f64,
        /// The largest diameter.
        upper: f64,
    },
    /// A Gaussian distribution, truncated at 0.
    Gaussian {
        /// Mean before the truncation.
        mean: f64,
        /// Standard deviation before the truncation.
        deviation: f64,
    },
    /// The logarithms have a Gaussian distribution.
    Lognormal {
        /// Mean of the diameter.
        mean: f64,
        /// Standard deviation of the diameter.
        deviation: f64,
    },
    /// The probability density is proportional to `d^-exponent` between two limits.
    PowerLaw {
        /// The exponent.
        exponent: f64,
        /// The smallest diameter.
        lower: f64,
        /// The largest diameter.
        upper: f64,
    },
    /// A list of diameters.
    List {
        /// The diameters.
        diameters: Vec<f64>,
        /// Relative number of particles of each diameter.
        shares: Vec<f64>,
    },
}

/// Number of equal shares of a distribution, for means and for new particles of an inlet.
const SHARES: usize = 1024;

impl DiameterDistribution {
    /// Divides the distribution among a number of particles. Each particle has the mean diameter of an equal share of the
    /// distribution `[length]`.
    #[must_use]
    pub fn divided(&self, particles: usize) -> Vec<f64> {
        match self {
            Self::Uniform { lower, upper } => uniform(*lower, *upper, particles),
            Self::Gaussian { mean, deviation } => gaussian(*mean, *deviation, particles),
            Self::Lognormal { mean, deviation } => lognormal(*mean, *deviation, particles),
            Self::PowerLaw { exponent, lower, upper } => power_law(*exponent, [*lower, *upper], particles),
            Self::List { diameters, shares } => listed(diameters, shares, particles),
        }
    }

    /// The kind and the parameters as numbers, for a hash.
    pub(crate) fn numbers(&self) -> Vec<f64> {
        match self {
            Self::Uniform { lower, upper } => vec![0.0, *lower, *upper],
            Self::Gaussian { mean, deviation } => vec![1.0, *mean, *deviation],
            Self::Lognormal { mean, deviation } => vec![2.0, *mean, *deviation],
            Self::PowerLaw { exponent, lower, upper } => vec![3.0, *exponent, *lower, *upper],
            Self::List { diameters, shares } => [&[4.0], diameters.as_slice(), shares].concat(),
        }
    }

    /// Mean of a function of the diameter.
    #[must_use]
    pub fn mean_of(&self, function: impl Fn(f64) -> f64) -> f64 {
        self.shares().into_iter().map(|(diameter, share)| share * function(diameter)).sum()
    }

    /// Returns the mean diameters of 1,024 equal shares of the distribution, or the diameters of a list, each with its
    /// share. The shares sum to 1.
    pub(crate) fn shares(&self) -> Vec<(f64, f64)> {
        if let Self::List { diameters, shares } = self {
            let all: f64 = shares.iter().sum();
            return diameters.iter().zip(shares).map(|(diameter, share)| (*diameter, share / all)).collect();
        }
        self.divided(SHARES).into_iter().map(|diameter| (diameter, 1.0 / SHARES as f64)).collect()
    }
}

/// Mass of a particle with an individual diameter. A particle with the diameter of the species has the mass of the
/// species.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum MassRule {
    /// All particles of the species have the same mass.
    Constant,
    /// The mass is proportional to the volume, `d^D` in `D` dimensions.
    Volume,
}

/// Individual diameters of the particles of a species.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IndividualDiameters {
    /// How the mass of a particle depends on its diameter.
    pub masses: MassRule,
    /// The distribution of the diameters in fills and inlets; `None` if each diameter is given.
    pub distribution: Option<DiameterDistribution>,
}

/// Diameters of the particles of each species.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Diameters {
    /// The smallest diameter `[length]`.
    pub smallest: f64,
    /// The largest diameter `[length]`.
    pub largest: f64,
}

/// Returns the range of diameters of each species. `particles` are the species and individual diameters of particles.
pub(crate) fn ranges_of_diameters(
    species: &[Species],
    particles: impl Iterator<Item = (SpeciesId, f64)>,
) -> Vec<Diameters> {
    let own = |species: &Species| Diameters { smallest: species.diameter, largest: species.diameter };
    let mut all: Vec<Diameters> = species.iter().map(own).collect();
    let mut is_new = vec![true; all.len()];
    for (species, diameter) in particles {
        let range = &mut all[species.0 as usize];
        if std::mem::take(&mut is_new[species.0 as usize]) {
            *range = Diameters { smallest: diameter, largest: diameter };
        }
        range.smallest = range.smallest.min(diameter);
        range.largest = range.largest.max(diameter);
    }
    all
}

/// Returns the smallest and the largest individual diameter of the particles that inlets let in, with their species.
/// `entering` are the species of the inlets.
pub(crate) fn diameters_of_newcomers(
    species: &[Species],
    entering: impl Iterator<Item = SpeciesId>,
) -> impl Iterator<Item = (SpeciesId, f64)> {
    let individual = |id: SpeciesId| Some((id, species[id.0 as usize].individual.as_ref()?.distribution.as_ref()?));
    entering.filter_map(individual).flat_map(|(id, distribution)| {
        let all = distribution.shares().into_iter().map(|(diameter, _)| diameter);
        let [smallest, largest] = all.fold([f64::INFINITY, 0.0], |[a, b], diameter| [diameter.min(a), diameter.max(b)]);
        [(id, smallest), (id, largest)]
    })
}

/// Distance of a discontinuity of two particles `[length]`. `distance` applies to the diameters of the two species.
/// `of_species` is the sum of the radii of the species, and `of_pair` is the sum of the radii of the particles.
#[inline]
pub(crate) fn scaled_distance(distance: f64, of_species: f64, of_pair: f64) -> f64 {
    distance / of_species * of_pair
}

/// Divides listed diameters among particles. The number of particles of each diameter agrees with its share to within
/// one particle.
fn listed(diameters: &[f64], shares: &[f64], particles: usize) -> Vec<f64> {
    let Some(last) = diameters.len().checked_sub(1) else { return Vec::new() };
    let all: f64 = shares.iter().sum();
    let mut passed = 0.0;
    let ends = shares.iter().map(|share| {
        passed += share;
        passed / all
    });
    let ends: Vec<f64> = ends.collect();
    let of = |particle: usize| {
        let at = (particle as f64 + 0.5) / particles as f64;
        diameters[ends.partition_point(|end| *end < at).min(last)]
    };
    (0..particles).map(of).collect()
}

/// Class diameters of a uniform distribution `[length]`.
fn uniform(lower: f64, upper: f64, classes: usize) -> Vec<f64> {
    let width = (upper - lower) / classes as f64;
    (0..classes).map(|k| lower + (k as f64 + 0.5) * width).collect()
}

/// Computes a value for each class from the values at its two edges.
fn between(edge: impl Fn(usize) -> f64, classes: usize, of_class: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let edges: Vec<f64> = (0..=classes).map(edge).collect();
    edges.windows(2).map(|pair| of_class(pair[0], pair[1])).collect()
}

/// Class diameters of a Gaussian distribution truncated at 0 `[length]`.
///
/// A class between `mean + a deviation` and `mean + b deviation` has the mean `mean + deviation (g(a) - g(b)) / w`.
/// Here `g` is the standard normal density, and `w` is the integral of `g` from `a` to `b`.
fn gaussian(mean: f64, deviation: f64, classes: usize) -> Vec<f64> {
    let cut = normal_distribution(-mean / deviation);
    let share = (1.0 - cut) / classes as f64;
    let edge = |k: usize| match k {
        0 => normal_density(mean / deviation),
        k if k == classes => 0.0,
        k => normal_density(normal_quantile(cut + k as f64 * share)),
    };
    between(edge, classes, |a, b| mean + deviation * (a - b) / share)
}

/// Class diameters of a lognormal distribution `[length]`.
///
/// `mean` and `deviation` describe the diameter. The logarithm of the diameter has the variance `s^2 = ln(1 +
/// deviation^2 / mean^2)`. A class between the quantiles `a` and `b` of the standard normal distribution has the mean
/// `n mean [P(b - s) - P(a - s)]`. Here `P` is the standard normal distribution function, and `n` is the number of
/// classes.
fn lognormal(mean: f64, deviation: f64, classes: usize) -> Vec<f64> {
    let width = libm::log1p((deviation / mean) * (deviation / mean)).sqrt();
    let edge = |k: usize| match k {
        0 => 0.0,
        k if k == classes => 1.0,
        k => normal_distribution(normal_quantile(k as f64 / classes as f64) - width),
    };
    between(edge, classes, |a, b| classes as f64 * mean * (b - a))
}

/// Class diameters of a distribution with a density proportional to `d^-exponent`, between two limits `[length]`.
///
/// With `q = 1 - exponent`, the quantile `u` is `(lower^q + u (upper^q - lower^q))^(1 / q)`. A class between the
/// diameters `a` and `b` has the mean `n I(a, b, 1 - exponent) / I(lower, upper, -exponent)`. Here `I(a, b, p)` is the
/// integral of `d^p` from `a` to `b`, and `n` is the number of classes.
fn power_law(exponent: f64, [lower, upper]: [f64; 2], classes: usize) -> Vec<f64> {
    let (ratio, q) = (libm::log(upper / lower), 1.0 - exponent);
    // Diameters are divided by the limit where most particles are, so that powers do not overflow. `first` and `last` are
    // the logarithms of the limits.
    let (unit, first, last) = if q > 0.0 { (upper, -ratio, 0.0) } else { (lower, 0.0, ratio) };
    let edge = |k: usize| {
        let quantile = k as f64 / classes as f64;
        match k {
            0 => first,
            k if k == classes => last,
            _ if q == 0.0 => quantile * ratio,
            _ if q > 0.0 => libm::log1p((1.0 - quantile) * libm::expm1(-q * ratio)) / q,
            _ => libm::log1p(quantile * libm::expm1(q * ratio)) / q,
        }
    };
    let all = power_integral(first, last, q);
    between(edge, classes, |a, b| unit * (classes as f64 * power_integral(a, b, q + 1.0) / all))
}

/// Integral of `exp(p x)` from `a` to `b`, which is the integral of `d^(p - 1)` from `exp(a)` to `exp(b)`.
fn power_integral(a: f64, b: f64, p: f64) -> f64 {
    match p {
        0.0 => b - a,
        _ if p > 0.0 => -libm::exp(p * b) * libm::expm1(p * (a - b)) / p,
        _ => libm::exp(p * a) * libm::expm1(p * (b - a)) / p,
    }
}

/// Quantiles of shares that a 64-bit number can express are smaller than this.
const FARTHEST: f64 = 40.0;

/// In the far tails, Newton's method is slow. After this number of steps, bisection does the rest.
const NEWTON_STEPS: usize = 20;

/// Density of the standard normal distribution.
fn normal_density(z: f64) -> f64 {
    libm::exp(-0.5 * z * z) / (2.0 * PI).sqrt()
}

/// Standard normal distribution function.
fn normal_distribution(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// Inverse of [`normal_distribution`]. Newton's method finds it up to round-off, and bisection finds the last bits, so that
/// the result does not depend on the path of the iteration.
fn normal_quantile(share: f64) -> f64 {
    // The distribution is convex below 0 and concave above 0. Therefore the iteration approaches the quantile from one
    // side and does not overshoot.
    let mut start: f64 = 0.0;
    for _ in 0..NEWTON_STEPS {
        let step = (share - normal_distribution(start)) / normal_density(start);
        start += step;
        if step.abs() < 1e-9 {
            break;
        }
    }
    let (mut lower, mut upper) = (start, start);
    let mut width = 1e-15 * (1.0 + start.abs());
    while normal_distribution(lower) >= share && lower > -FARTHEST {
        lower = (start - width).max(-FARTHEST);
        width *= 4.0;
    }
    while normal_distribution(upper) < share && upper < FARTHEST {
        upper = (start + width).min(FARTHEST);
        width *= 4.0;
    }
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
        assert_eq!(normal_quantile(0.0), -FARTHEST);
        assert!((8.0..9.0).contains(&normal_quantile(1.0)));
        for share in [1e-300, 1e-20, 1e-6, 0.3, 0.7, 1.0 - 1e-6, 1.0 - 1e-15] {
            let z = normal_quantile(share);
            let round_off = 4.0 * f64::EPSILON * (share + z.abs() * normal_density(z));
            assert!((normal_distribution(z) - share).abs() <= round_off, "{share} {z}");
        }
        assert!((normal_quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-14);
        assert!((normal_quantile(0.001) + 3.090_232_306_167_813_5).abs() < 1e-14);
    }

    #[test]
    fn class_mean_is_exact_and_variance_lacks_spread_within_classes() {
        let (mean, deviation) = mean_and_deviation(&uniform(0.8, 1.4, 10));
        assert!((mean - 1.1).abs() < 1e-15);
        // The variance of `n` class diameters over a range of width `w` is `(w^2 - (w/n)^2) / 12`.
        assert!((deviation - (0.6_f64.powi(2) * 0.99 / 12.0).sqrt()).abs() < 1e-15);
        for (of, width) in [(gaussian as fn(f64, f64, usize) -> Vec<f64>, 0.0), (lognormal, 0.1)] {
            let diameters = of(2.0, 0.2, 64);
            assert!(diameters.windows(2).all(|pair| pair[0] < pair[1]));
            let (mean, deviation) = mean_and_deviation(&diameters);
            assert!((mean - 2.0).abs() < 1e-13, "{mean}");
            // Upper bound of the variance within the `n` classes, relative to the total variance. The two outermost
            // classes start at `z` standard deviations and have a variance of at most `1 / z^2`. The other classes have
            // the mean width `2 z / n`. A lognormal distribution has wider tails, hence the last factor.
            let z: f64 = 2.15;
            let within = (2.0 / 64.0 / (z * z) + (2.0 * z / 64.0).powi(2) / 12.0) * libm::exp(2.0 * width * z);
            let lost = 1.0 - (deviation / 0.2) * (deviation / 0.2);
            assert!(lost > 0.0 && lost < within, "{lost} {within}");
        }
    }

    #[test]
    fn power_laws_have_exact_means() {
        let (lower, upper) = (0.73, 1.62);
        let moment = |p: f64| {
            let steps = 20_000;
            let step = (upper - lower) / f64::from(steps);
            (0..steps).map(|k| libm::pow(lower + (f64::from(k) + 0.5) * step, p) * step).sum::<f64>()
        };
        for exponent in [3.0, 2.0, 1.0, 0.0, -1.5] {
            let diameters = power_law(exponent, [lower, upper], 64);
            assert!(diameters.windows(2).all(|pair| pair[0] < pair[1]), "{exponent}");
            assert!(diameters[0] > lower && diameters[63] < upper, "{exponent}");
            let (mean, deviation) = mean_and_deviation(&diameters);
            let expected = moment(1.0 - exponent) / moment(-exponent);
            // The midpoint rule has a relative error of about 1e-8.
            assert!((mean / expected - 1.0).abs() < 1e-7, "{exponent}: {mean} {expected}");
            let square = moment(2.0 - exponent) / moment(-exponent);
            let lost = 1.0 - deviation * deviation / (square - expected * expected);
            // Spread within 64 classes; equal widths would lose 1 / 64^2.
            assert!(lost > 0.0 && lost < 1e-3, "{exponent}: {lost}");
        }
        assert!((power_law(0.0, [1.0, 2.0], 1)[0] - 1.5).abs() < 1e-15);
        // Steep and wide distributions: nearly all particles are at one end.
        for (exponent, end) in [(100.0, 1.0), (-100.0, 1e6)] {
            let diameters = power_law(exponent, [1.0, 1e6], 8);
            assert!(diameters.windows(2).all(|pair| pair[0] < pair[1]), "{diameters:?}");
            assert!(diameters.iter().all(|diameter| (diameter / end - 1.0).abs() < 0.1), "{diameters:?}");
        }
        // With an exponent of 3, the mean is 2 / (1 / lower + 1 / upper).
        let harmonic = 2.0 / (1.0 / lower + 1.0 / upper);
        assert!((power_law(3.0, [lower, upper], 1)[0] / harmonic - 1.0).abs() < 1e-14);
    }

    #[test]
    fn single_class_is_the_mean() {
        assert_eq!(uniform(1.0, 2.0, 1), [1.5]);
        assert_eq!(lognormal(1.5, 0.3, 1), [1.5]);
        assert!((gaussian(1.5, 0.1, 1)[0] - 1.5).abs() < 1e-15);
    }

    #[test]
    fn a_gaussian_is_cut_at_zero() {
        // The upper half of a Gaussian distribution has the mean `sqrt(2 / pi)` and the variance `1 - 2 / pi`.
        let diameters = gaussian(1e-9, 1.0, 64);
        let (mean, deviation) = mean_and_deviation(&diameters);
        assert!((mean - (2.0 / PI).sqrt()).abs() < 1e-8, "{mean}");
        assert!(diameters[0] > 0.0 && diameters[0] < 0.02);
        assert!((deviation - (1.0 - 2.0 / PI).sqrt()).abs() < 0.01);
    }
}
