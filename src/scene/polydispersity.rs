//! Distributions of diameters, cut into classes: each class is a species of its own.
//!
//! A class is a range of quantiles, `[k/n, (k+1)/n]` of `n`, and its diameter is the mean of that range. So all classes have the same
//! share, and their mean is exactly that of the distribution; their variance lacks the one within the classes.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind};
use crate::scene::file::DistributionFile;
use crate::scene::limits::{finite, positive};
use crate::scene::parse::Keys;

/// The most classes of one species.
const MOST_CLASSES: usize = 64;

const DEFAULT_CLASSES: u64 = 16;

/// Spheres of one size among those of a distribution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Class {
    pub diameter: f64,
    /// Of the number of particles; the shares add up to 1 but for rounding.
    pub share: f64,
}

/// The distributions, and the keys that each one takes.
pub(crate) const DISTRIBUTIONS: [(&str, &[&str]); 4] = [
    ("uniform", &["lower", "upper", "classes"]),
    ("gaussian", &["mean", "deviation", "classes"]),
    ("lognormal", &["mean", "deviation", "classes"]),
    ("list", &["diameters", "shares"]),
];

/// The classes of a distribution, smallest first.
pub(crate) fn parse(file: DistributionFile, at: &ConfigPath) -> Result<Vec<Class>, SceneError> {
    let Some((word, known)) = DISTRIBUTIONS.into_iter().find(|(word, _)| *word == file.distribution) else {
        let known = DISTRIBUTIONS.map(|(word, _)| word);
        let kind = SceneErrorKind::unknown_word("distribution", &file.distribution, known);
        return Err(SceneError::new(at.key("distribution"), kind));
    };
    let given = [
        ("lower", file.lower.is_some()),
        ("upper", file.upper.is_some()),
        ("mean", file.mean.is_some()),
        ("deviation", file.deviation.is_some()),
        ("diameters", file.diameters.is_some()),
        ("shares", file.shares.is_some()),
        ("classes", file.classes.is_some()),
    ];
    let keys = Keys { at, context: format!("distribution = \"{word}\""), given: &given };
    keys.allow(known)?;
    if word == "list" {
        return listed(keys.need(file.diameters, "diameters")?, file.shares, at);
    }
    let classes = file.classes.unwrap_or(DEFAULT_CLASSES);
    if !(1..=MOST_CLASSES as u64).contains(&classes) {
        let expected = format!("a number of classes from 1 to {MOST_CLASSES}: each is a species");
        return Err(SceneError::new(at.key("classes"), SceneErrorKind::value(classes, expected)));
    }
    let given = |value: Option<f64>, key| positive(keys.need(value, key)?, at.key(key));
    let diameters = match word {
        "uniform" => {
            let (lower, upper) = (given(file.lower, "lower")?, given(file.upper, "upper")?);
            if upper <= lower {
                let kind = SceneErrorKind::value(upper, format!("more than the lower end, {lower}"));
                return Err(SceneError::new(at.key("upper"), kind));
            }
            uniform(lower, upper, classes)
        }
        "gaussian" => gaussian(given(file.mean, "mean")?, given(file.deviation, "deviation")?, classes),
        _ => lognormal(given(file.mean, "mean")?, given(file.deviation, "deviation")?, classes),
    };
    let share = 1.0 / classes as f64;
    // What is too wide for the numbers of a computer is too wide for a simulation.
    diameters.into_iter().map(|diameter| Ok(Class { diameter: positive(diameter, at.clone())?, share })).collect()
}

fn listed(diameters: Vec<f64>, shares: Option<Vec<f64>>, at: &ConfigPath) -> Result<Vec<Class>, SceneError> {
    let count = diameters.len();
    if !(1..=MOST_CLASSES).contains(&count) {
        let kind = SceneErrorKind::value(format!("a list of {count}"), format!("1 to {MOST_CLASSES} diameters"));
        return Err(SceneError::new(at.key("diameters"), kind));
    }
    let shares = shares.unwrap_or_else(|| vec![1.0; count]);
    if shares.len() != count {
        let expected = format!("{count}, one for each diameter");
        let kind = SceneErrorKind::value(format!("a list of {}", shares.len()), expected);
        return Err(SceneError::new(at.key("shares"), kind));
    }
    for (index, (&diameter, &share)) in diameters.iter().zip(&shares).enumerate() {
        positive(diameter, at.key("diameters").index(index))?;
        positive(share, at.key("shares").index(index))?;
    }
    let total = finite(shares.iter().sum(), at.key("shares"))?;
    Ok(diameters.into_iter().zip(shares).map(|(diameter, share)| Class { diameter, share: share / total }).collect())
}

fn uniform(lower: f64, upper: f64, classes: u64) -> Vec<f64> {
    let width = (upper - lower) / classes as f64;
    (0..classes).map(|k| lower + (k as f64 + 0.5) * width).collect()
}

/// Cut at 0: the part of the Gaussian above it, in classes of equal share of that part.
///
/// The mean between the quantiles `a` and `b` of a part `w` is `mean + deviation (g(a) - g(b)) / w` with the density `g`.
fn gaussian(mean: f64, deviation: f64, classes: u64) -> Vec<f64> {
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

/// `mean` and `deviation` are those of the diameter. Its logarithm has the variance `s^2 = ln(1 + deviation^2 / mean^2)`, and the mean between
/// the quantiles `a` and `b` of a share `1/n` is `n mean [P(b - s) - P(a - s)]` with the normal distribution `P`.
fn lognormal(mean: f64, deviation: f64, classes: u64) -> Vec<f64> {
    let width = libm::log1p((deviation / mean) * (deviation / mean)).sqrt();
    let edge = |k: u64| match k {
        0 => 0.0,
        k if k == classes => 1.0,
        k => normal_distribution(normal_quantile(k as f64 / classes as f64) - width),
    };
    (0..classes).map(|k| classes as f64 * mean * (edge(k + 1) - edge(k))).collect()
}

/// The share of a Gaussian of mean 0 and deviation 1 below `z`.
fn normal_distribution(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// Where that share is `share`, by bisection down to neighbouring numbers.
fn normal_quantile(share: f64) -> f64 {
    // Beyond, nothing is left in double precision.
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
    fn quantiles_are_those_of_the_tables() {
        assert!(normal_quantile(0.5).abs() < 1e-15);
        assert!((normal_quantile(0.975) - 1.959_963_984_540_054).abs() < 1e-14);
        assert!((normal_quantile(0.001) + 3.090_232_306_167_813_5).abs() < 1e-14);
    }

    #[test]
    fn the_mean_is_exact_and_the_variance_lacks_the_one_within_the_classes() {
        let (mean, deviation) = mean_and_deviation(&uniform(0.8, 1.4, 10));
        assert!((mean - 1.1).abs() < 1e-15);
        // (w^2 - (w/n)^2) / 12
        assert!((deviation - (0.6_f64.powi(2) * 0.99 / 12.0).sqrt()).abs() < 1e-15);
        for (of, width) in [(gaussian as fn(f64, f64, u64) -> Vec<f64>, 0.0), (lognormal, 0.1)] {
            let diameters = of(2.0, 0.2, 64);
            assert!(diameters.windows(2).all(|pair| pair[0] < pair[1]));
            let (mean, deviation) = mean_and_deviation(&diameters);
            // Of sums of 64 differences of numbers up to 64.
            assert!((mean - 2.0).abs() < 1e-13, "{mean}");
            // The outermost two of n classes hold most of what is within: a tail beyond z has the variance 1 / z^2 about its mean, or
            // less, here z = 2.15; the others share a range of 2 z, so that theirs is (2 z / n)^2 / 12. Of a lognormal, the tails are
            // stretched by up to exp(2 * 0.1 * z).
            let z: f64 = 2.15;
            let within = (2.0 / 64.0 / (z * z) + (2.0 * z / 64.0).powi(2) / 12.0) * libm::exp(2.0 * width * z);
            let lost = 1.0 - (deviation / 0.2) * (deviation / 0.2);
            assert!(lost > 0.0 && lost < within, "{lost} {within}");
        }
    }

    #[test]
    fn one_class_has_the_mean() {
        assert_eq!(uniform(1.0, 2.0, 1), [1.5]);
        assert_eq!(lognormal(1.5, 0.3, 1), [1.5]);
        assert!((gaussian(1.5, 0.1, 1)[0] - 1.5).abs() < 1e-15);
    }

    #[test]
    fn a_gaussian_is_cut_at_zero() {
        // Half of it, whose mean is sqrt(2 / pi) deviations; nothing is below 0.
        let diameters = gaussian(1e-9, 1.0, 64);
        let (mean, deviation) = mean_and_deviation(&diameters);
        assert!((mean - (2.0 / PI).sqrt()).abs() < 1e-8, "{mean}");
        assert!(diameters[0] > 0.0 && diameters[0] < 0.02);
        assert!((deviation - (1.0 - 2.0 / PI).sqrt()).abs() < 0.01);
    }
}
