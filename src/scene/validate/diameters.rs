//! Checks distributions of diameters.

use crate::base::text::shortest;
use crate::model::DiameterDistribution;
use crate::scene::config_path::ConfigPath;
use crate::scene::diagnostic::{SceneError, refuse};
use crate::scene::limits::{finite, positive};

/// Largest number of diameters in a list, and of classes of a distribution.
pub(crate) const MOST_CLASSES: usize = 64;

/// Largest absolute value of the exponent of a power law.
const LARGEST_EXPONENT: f64 = 100.0;

/// Checks the parameters of a distribution.
pub(crate) fn check_distribution(distribution: &DiameterDistribution, at: &ConfigPath) -> Result<(), SceneError> {
    match distribution {
        DiameterDistribution::Uniform { lower, upper } => check_limits([*lower, *upper], at),
        DiameterDistribution::PowerLaw { exponent, lower, upper } => {
            check_limits([*lower, *upper], at)?;
            if !(-LARGEST_EXPONENT..=LARGEST_EXPONENT).contains(exponent) {
                let expected = format!("a number from -{LARGEST_EXPONENT} to {LARGEST_EXPONENT}");
                return refuse(at.key("exponent"), shortest(*exponent), expected);
            }
            Ok(())
        }
        DiameterDistribution::Gaussian { mean, deviation } | DiameterDistribution::Lognormal { mean, deviation } => {
            positive(*mean, at.key("mean"))?;
            positive(*deviation, at.key("deviation")).map(drop)
        }
        DiameterDistribution::List { diameters, shares } => check_list(diameters, shares, at),
    }
}

fn check_limits([lower, upper]: [f64; 2], at: &ConfigPath) -> Result<(), SceneError> {
    positive(lower, at.key("lower"))?;
    positive(upper, at.key("upper"))?;
    if upper <= lower {
        return refuse(at.key("upper"), upper, format!("more than the lower end, {lower}"));
    }
    Ok(())
}

fn check_list(diameters: &[f64], shares: &[f64], at: &ConfigPath) -> Result<(), SceneError> {
    let count = diameters.len();
    if !(1..=MOST_CLASSES).contains(&count) {
        return refuse(at.key("diameters"), format!("a list of {count}"), format!("1 to {MOST_CLASSES} diameters"));
    }
    if shares.len() != count {
        let expected = format!("{count}, one for each diameter");
        return refuse(at.key("shares"), format!("a list of {}", shares.len()), expected);
    }
    for (index, (&diameter, &share)) in diameters.iter().zip(shares).enumerate() {
        positive(diameter, at.key("diameters").index(index))?;
        positive(share, at.key("shares").index(index))?;
    }
    finite(shares.iter().sum(), at.key("shares")).map(drop)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Arrangement, Fill, InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    #[test]
    fn wrong_distributions_of_the_library_are_refused() {
        let wrong = [
            DiameterDistribution::List { diameters: vec![], shares: vec![] },
            DiameterDistribution::List { diameters: vec![1.0, 2.0], shares: vec![1.0] },
            DiameterDistribution::List { diameters: vec![1.0], shares: vec![0.0] },
            DiameterDistribution::Uniform { lower: 1.3, upper: 0.7 },
            DiameterDistribution::Uniform { lower: f64::NAN, upper: 0.7 },
            DiameterDistribution::Gaussian { mean: -1.0, deviation: 0.1 },
            DiameterDistribution::Lognormal { mean: 1.0, deviation: f64::INFINITY },
            DiameterDistribution::PowerLaw { exponent: 1e3, lower: 0.7, upper: 1.3 },
        ];
        for distribution in wrong {
            let name = format!("{distribution:?}");
            let scene = SceneBuilder::new("wrong")
                .species(SpeciesDraft::new("A").mass(0.7).distributed(distribution))
                .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
                .fill(Fill::new(Arrangement::Random, "A").count(10).packing_fraction(0.1))
                .temperature(1.0);
            let error = scene.build().unwrap_err().to_string();
            assert!(error.contains("species") && error.contains("diameter"), "{name}: {error}");
        }
    }
}
