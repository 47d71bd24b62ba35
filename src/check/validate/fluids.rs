//! Hard spheres and disks in equilibrium, and the hard-sphere crystal.

use super::state_point::{Compared, Watch, build, finish, number, one_species, plan};
use super::{Comparison, Effort, Source};
use crate::analysis::published::finite_size::{FINITE, fewer_contacts, shift_of_contact_value};
use crate::analysis::published::{self, FITTED_SPHERES, HardSphereFluid};
use crate::model::MeasurementPlan;
use crate::model::measurement_plan::{Diffusion, RadialDistribution};
use crate::model::potential::Potential;
use crate::model::space::Boundary;
use crate::run::Finished;
use crate::scene::{Amount, Fill, Lattice};

const MKLM: Source = Source {
    short: "mKLM 2019",
    full: "equation of state of Pieprzyk, Bannerman, Branka, Chudak and Heyes, Phys. Chem. Chem. Phys. 21, 6886 (2019)",
};
const CONTACTS: Source = Source {
    short: "exact given mKLM",
    full: "kinetic theory, exact in equilibrium given Z: G = 6 (Z - 1) / sqrt(pi), g(sigma) = (Z - 1) / (4 phi) for spheres",
};
const SPEEDY_FLUID: Source = Source {
    short: "Speedy 1987",
    full: "fit to simulations of about 500 spheres by Speedy, Mol. Phys. 62, 509 (1987), corrected for the size of this box",
};
const SPEEDY_CRYSTAL: Source =
    Source { short: "Speedy 1998", full: "fit to simulations by Speedy, J. Phys.: Condens. Matter 10, 4387 (1998)" };
const HENDERSON: Source = Source {
    short: "Henderson 1975",
    full: "equation of state of hard disks by Henderson, Mol. Phys. 30, 971 (1975), with two further terms",
};

const YEH_HUMMER: &str = "change of the finite-size correction of Yeh and Hummer, J. Phys. Chem. B 108, 15873 (2004), if the fitted simulations had half or twice as many spheres";
const CRYSTAL_MODES: &str =
    "first order in 1/N: the crystal as a whole moves freely, so only N - 1 of N particles vibrate";

pub(super) const CRYSTAL: &[&str] = &["compressibility factor"];
pub(super) const DISKS: &[&str] = &["compressibility factor", "collision rate"];

/// Packing fractions at which Speedy's fit of the diffusion coefficient is accurate.
const DIFFUSING: std::ops::RangeInclusive<f64> = 0.25..=0.42;

pub(super) fn quantities_of_spheres(packing_fraction: f64) -> &'static [&'static str] {
    const ALL: &[&str] = &["compressibility factor", "collision rate", "contact value", "diffusion coefficient"];
    if DIFFUSING.contains(&packing_fraction) { ALL } else { &ALL[..3] }
}

fn run(
    lattice: Lattice,
    amount: Amount,
    measure: MeasurementPlan,
    effort: Effort,
    seed: u64,
    watch: Watch<'_>,
) -> Result<Finished, super::StatePointError> {
    let is_plane = lattice == Lattice::Hexagonal;
    let third = if is_plane { Boundary::Flat } else { Boundary::Periodic };
    let scene = one_species(seed, Potential::hard_sphere(1.0)?, 1.0)
        .boundary([Boundary::Periodic, Boundary::Periodic, third])
        .fill(Fill { amount: Some(amount), ..Fill::new(lattice, "A").count(effort.particles()) })
        .temperature(1.0)
        .measure(measure)
        .run(plan(effort));
    finish(build(&scene)?, watch)
}

pub(super) fn spheres(packing_fraction: f64, effort: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let has_diffusion = DIFFUSING.contains(&packing_fraction);
    let plan = MeasurementPlan {
        radial_distribution: Some(RadialDistribution { cutoff: Some(2.0), ..RadialDistribution::default() }),
        diffusion: has_diffusion.then(Diffusion::default),
        ..MeasurementPlan::default()
    };
    let amount = Amount::PackingFraction(packing_fraction);
    let finished = run(Lattice::FaceCentredCubic, amount, plan, effort, seed, watch)?;
    let count = effort.particles();
    let mut compared = fluid(&finished, published::hard_spheres, packing_fraction, 3.0, count, MKLM);
    let contact = published::contact_value(packing_fraction);
    let shift = shift_of_contact_value(published::hard_spheres, packing_fraction, count);
    let measured = number(&finished, "contact_value_A_A");
    compared.push(
        Comparison::statistical("contact value", measured, contact, CONTACTS).allow(contact * shift.abs(), FINITE),
    );
    if has_diffusion {
        let (expected, allowance) = diffusion_in_box(packing_fraction, count as f64);
        let measured = number(&finished, "diffusion_coefficient");
        compared.push(
            Comparison::statistical("diffusion coefficient", measured, expected, SPEEDY_FLUID)
                .allow(allowance, YEH_HUMMER),
        );
    }
    Ok(compared)
}

/// Returns the diffusion coefficient in a periodic cube with `count` spheres, and its uncertainty.
///
/// Speedy's fit is converted to `count` spheres by the finite-size term of Yeh and Hummer, with Enskog's coefficients.
/// The number of spheres in Speedy's simulations is known within a factor of two, so the result is uncertain by 3 %.
fn diffusion_in_box(packing_fraction: f64, count: f64) -> (f64, f64) {
    let theory = HardSphereFluid::reduced(packing_fraction);
    let slower = |count: f64| theory.slower_diffusion(count).unwrap_or(0.0);
    let expected = theory.simulated_diffusion_coefficient() + slower(FITTED_SPHERES) - slower(count);
    (expected, slower(0.5 * FITTED_SPHERES) - slower(FITTED_SPHERES))
}

pub(super) fn disks(packing_fraction: f64, effort: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let amount = Amount::PackingFraction(packing_fraction);
    let finished = run(Lattice::Hexagonal, amount, MeasurementPlan::default(), effort, seed, watch)?;
    Ok(fluid(&finished, published::hard_disks, packing_fraction, 2.0, effort.particles(), HENDERSON))
}

/// Compares the compressibility factor `Z` and the collision rate `2 D (Z - 1) / sqrt(pi)` at a temperature of 1.
fn fluid(
    finished: &Finished,
    compressibility: fn(f64) -> f64,
    packing_fraction: f64,
    dimensions: f64,
    count: u64,
    source: Source,
) -> Vec<Comparison> {
    let z = compressibility(packing_fraction);
    let rate = 2.0 * dimensions * (z - 1.0) / std::f64::consts::PI.sqrt();
    let fewer = fewer_contacts(compressibility, packing_fraction, count).abs();
    // At constant energy, velocities are not exactly Maxwellian: speeds at contacts differ by `1 / (4 D N)`.
    let slower = 0.25 / (dimensions * count as f64);
    let source_of_rate = if source == MKLM { CONTACTS } else { source };
    vec![
        Comparison::statistical(CRYSTAL[0], finished.observable("compressibility_factor"), z, source)
            .allow((z - 1.0) * fewer, FINITE),
        Comparison::statistical(DISKS[1], finished.observable("collision_rate"), rate, source_of_rate)
            .allow(rate * (fewer + slower), FINITE),
    ]
}

pub(super) fn crystal(number_density: f64, effort: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let amount = Amount::NumberDensity(number_density);
    let finished = run(Lattice::FaceCentredCubic, amount, MeasurementPlan::default(), effort, seed, watch)?;
    let z = published::face_centred_cubic(number_density * std::f64::consts::PI / 6.0);
    let measured = finished.observable("compressibility_factor");
    Ok(vec![
        Comparison::statistical(CRYSTAL[0], measured, z, SPEEDY_CRYSTAL)
            .allow((z - 1.0) / effort.particles() as f64, CRYSTAL_MODES),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn diffusion_matches_the_fit_at_its_size_and_grows_with_the_box() {
        for packing_fraction in [*DIFFUSING.start(), 0.3, *DIFFUSING.end()] {
            let fit = HardSphereFluid::reduced(packing_fraction).simulated_diffusion_coefficient();
            let (here, allowance) = diffusion_in_box(packing_fraction, FITTED_SPHERES);
            assert!((here / fit - 1.0).abs() < 4.0 * f64::EPSILON, "{here} {fit}");
            assert!(allowance < 0.04 * fit, "{packing_fraction}: {allowance} of {fit}");
            // In a box with twice the edges, the finite-size term is half as large. The allowance is `2^(1/3) - 1`
            // times the term, so the coefficient changes by `1 / (2 (2^(1/3) - 1)) = 1.924` allowances.
            let (large, _) = diffusion_in_box(packing_fraction, 8.0 * FITTED_SPHERES);
            assert!(((large - fit) / allowance - 1.923_661).abs() < 1e-6, "{large} {fit} {allowance}");
        }
    }
}
