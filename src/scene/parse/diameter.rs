//! Parses the distribution of the diameters of a species.

use super::Keys;
use crate::base::text::shortest;
use crate::prepare::polydispersity::{Class, gaussian, lognormal, power_law, uniform};
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::file::DistributionFile;
use crate::scene::limits::{finite, positive};

const MOST_CLASSES: usize = 64;

const DEFAULT_CLASSES: u64 = 16;

/// Largest absolute value of the exponent of a power law.
const LARGEST_EXPONENT: f64 = 100.0;

pub(crate) const DISTRIBUTIONS: [(&str, &[&str]); 5] = [
    ("uniform", &["lower", "upper", "classes"]),
    ("gaussian", &["mean", "deviation", "classes"]),
    ("lognormal", &["mean", "deviation", "classes"]),
    ("power-law", &["exponent", "lower", "upper", "classes"]),
    ("list", &["diameters", "shares"]),
];

pub(super) fn parse_distribution(file: DistributionFile, at: &ConfigPath) -> Result<Vec<Class>, SceneError> {
    let (word, keys) = Keys::of_kind(&DISTRIBUTIONS, "distribution", &file.distribution, at, &file)?;
    if word == "list" {
        return listed(keys.need("diameters")?, file.shares, at);
    }
    let classes = file.classes.unwrap_or(DEFAULT_CLASSES);
    if !(1..=MOST_CLASSES as u64).contains(&classes) {
        let expected = format!("a number of classes from 1 to {MOST_CLASSES}: each is a species");
        return refuse(at.key("classes"), classes, expected);
    }
    let given = |key| positive(keys.need(key)?, at.key(key));
    let diameters = match word {
        "uniform" | "power-law" => {
            let (lower, upper) = (given("lower")?, given("upper")?);
            if upper <= lower {
                return refuse(at.key("upper"), upper, format!("more than the lower end, {lower}"));
            }
            if word == "uniform" {
                uniform(lower, upper, classes)
            } else {
                let exponent = keys.need("exponent")?;
                if !(-LARGEST_EXPONENT..=LARGEST_EXPONENT).contains(&exponent) {
                    let expected = format!("a number from -{LARGEST_EXPONENT} to {LARGEST_EXPONENT}");
                    return refuse(at.key("exponent"), shortest(exponent), expected);
                }
                power_law(exponent, [lower, upper], classes)
            }
        }
        "gaussian" => gaussian(given("mean")?, given("deviation")?, classes),
        _ => lognormal(given("mean")?, given("deviation")?, classes),
    };
    let share = 1.0 / classes as f64;
    // The diameters of a very wide distribution may overflow.
    diameters.into_iter().map(|diameter| Ok(Class { diameter: positive(diameter, at.clone())?, share })).collect()
}

fn listed(diameters: Vec<f64>, shares: Option<Vec<f64>>, at: &ConfigPath) -> Result<Vec<Class>, SceneError> {
    let count = diameters.len();
    if !(1..=MOST_CLASSES).contains(&count) {
        return refuse(at.key("diameters"), format!("a list of {count}"), format!("1 to {MOST_CLASSES} diameters"));
    }
    let shares = shares.unwrap_or_else(|| vec![1.0; count]);
    if shares.len() != count {
        let expected = format!("{count}, one for each diameter");
        return refuse(at.key("shares"), format!("a list of {}", shares.len()), expected);
    }
    for (index, (&diameter, &share)) in diameters.iter().zip(&shares).enumerate() {
        positive(diameter, at.key("diameters").index(index))?;
        positive(share, at.key("shares").index(index))?;
    }
    let total = finite(shares.iter().sum(), at.key("shares"))?;
    Ok(diameters.into_iter().zip(shares).map(|(diameter, share)| Class { diameter, share: share / total }).collect())
}
