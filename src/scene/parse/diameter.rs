//! Parses the distribution of the diameters of a species.

use super::Keys;
use crate::base::numbers::index;
use crate::model::{DiameterDistribution, IndividualDiameters, MassRule};
use crate::prepare::polydispersity::Class;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, SceneErrorKind, refuse, unknown};
use crate::scene::file::{DiameterFile, DistributionFile};
use crate::scene::limits::positive;
use crate::scene::validate::diameters::{MOST_CLASSES, check_distribution};

const DEFAULT_CLASSES: u64 = 16;

pub(crate) const DISTRIBUTIONS: [(&str, &[&str]); 5] = [
    ("uniform", &["lower", "upper", "classes"]),
    ("gaussian", &["mean", "deviation", "classes"]),
    ("lognormal", &["mean", "deviation", "classes"]),
    ("power-law", &["exponent", "lower", "upper", "classes"]),
    ("list", &["diameters", "shares"]),
];

/// Value of the key `diameters`.
pub(crate) const INDIVIDUAL: &str = "individual";

pub(crate) const MASSES: [(&str, MassRule); 2] = [("volume", MassRule::Volume), ("constant", MassRule::Constant)];

/// Parses a distribution that is divided into classes.
pub(super) fn parse_classes(file: DistributionFile, at: &ConfigPath) -> Result<Vec<Class>, SceneError> {
    let classes = file.classes.unwrap_or(DEFAULT_CLASSES);
    let parsed = parse_distribution(file, at)?;
    let count = match &parsed {
        DiameterDistribution::List { diameters, shares } => {
            let total: f64 = shares.iter().sum();
            let class = |(&diameter, share): (&f64, &f64)| Class { diameter, share: share / total };
            return Ok(diameters.iter().zip(shares).map(class).collect());
        }
        _ if !(1..=MOST_CLASSES as u64).contains(&classes) => {
            let expected = format!("a number of classes from 1 to {MOST_CLASSES}: each class is a species");
            return refuse(at.key("classes"), classes, expected);
        }
        _ => index(classes),
    };
    let share = 1.0 / count as f64;
    // The diameters of a very wide distribution may overflow.
    let class = |diameter| Ok(Class { diameter: positive(diameter, at.clone())?, share });
    parsed.divided(count).into_iter().map(class).collect()
}

pub(super) fn parse_distribution(file: DistributionFile, at: &ConfigPath) -> Result<DiameterDistribution, SceneError> {
    let (word, keys) = Keys::of_kind(&DISTRIBUTIONS, "distribution", &file.distribution, at, &file)?;
    let distribution = match word {
        "list" => listed(keys.need("diameters")?, file.shares),
        "uniform" => DiameterDistribution::Uniform { lower: keys.need("lower")?, upper: keys.need("upper")? },
        "power-law" => DiameterDistribution::PowerLaw {
            exponent: keys.need("exponent")?,
            lower: keys.need("lower")?,
            upper: keys.need("upper")?,
        },
        "gaussian" => DiameterDistribution::Gaussian { mean: keys.need("mean")?, deviation: keys.need("deviation")? },
        _ => DiameterDistribution::Lognormal { mean: keys.need("mean")?, deviation: keys.need("deviation")? },
    };
    check_distribution(&distribution, at)?;
    Ok(distribution)
}

/// Parses the keys `diameters` and `masses` of a species.
pub(super) fn parse_individual(
    diameters: Option<String>,
    masses: Option<String>,
    diameter: &DiameterFile,
    at: &ConfigPath,
) -> Result<Option<IndividualDiameters>, SceneError> {
    let Some(word) = diameters else {
        if masses.is_none() {
            return Ok(None);
        }
        let context = "a species without `diameters = \"individual\"`".to_owned();
        let known = vec!["name", "diameter", "mass", "material", "static", "acceleration", "moment_of_inertia"];
        return Err(SceneError::new(at.key("masses"), SceneErrorKind::Misplaced { key: "masses", context, known }));
    };
    if word != INDIVIDUAL {
        return Err(unknown(&at.key("diameters"), "kind of diameters", &word, [INDIVIDUAL]));
    }
    let masses = match masses {
        None => MassRule::Volume,
        Some(word) => match MASSES.iter().find(|(name, _)| *name == word) {
            Some((_, rule)) => *rule,
            None => return Err(unknown(&at.key("masses"), "rule for masses", &word, MASSES.map(|(name, _)| name))),
        },
    };
    let at = at.key("diameter");
    let distribution = match diameter {
        DiameterFile::Number(_) => None,
        DiameterFile::Distribution(DistributionFile { classes: Some(classes), .. }) => {
            return refuse(
                at.key("classes"),
                *classes,
                "no such key: with `diameters = \"individual\"`, there are no classes",
            );
        }
        DiameterFile::Distribution(file) => Some(parse_distribution(file.clone(), &at)?),
    };
    Ok(Some(IndividualDiameters { masses, distribution }))
}

fn listed(diameters: Vec<f64>, shares: Option<Vec<f64>>) -> DiameterDistribution {
    let shares = shares.unwrap_or_else(|| vec![1.0; diameters.len()]);
    DiameterDistribution::List { diameters, shares }
}
