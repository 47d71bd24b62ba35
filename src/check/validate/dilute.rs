//! Compares the pressure of a dilute square-well gas with exact virial coefficients.

use super::state_point::{Compared, Watch, build, finish, one_species, plan};
use super::{Comparison, Effort, Source};
use crate::analysis::published::{second_virial_of_square_well, third_virial_of_square_well};
use crate::analysis::statistics::Estimate;
use crate::model::potential::Potential;
use crate::model::{RunPlan, Until};
use crate::scene::{Fill, Lattice};

pub(super) const NUMBER_DENSITY: f64 = 0.01;
const WELL_RATIO: f64 = 1.5;
const DEPTH: f64 = 1.0;

pub(super) const QUANTITIES: &[&str] = &["second virial"];

const EXACT: Source = Source {
    short: "exact",
    full: "exact B_2 of a square well; the B_3 term of the virial series, an integral over three particles, is subtracted from the measured value",
};

pub(super) fn compare(temperature: f64, effort: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    // For a standard error below 5 %, a brief comparison needs more events here than at other state points.
    let events = effort.events() * if effort == Effort::Brief { 4 } else { 1 };
    let scene = one_species(seed, Potential::square_well(1.0, WELL_RATIO, DEPTH)?, 1.0)
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(effort.particles()).number_density(NUMBER_DENSITY))
        .temperature(temperature)
        .run(RunPlan { limit: Until::events(events), ..plan(effort) });
    let finished = finish(build(&scene)?, watch)?;
    let z = finished.observable("compressibility_factor");
    let warmed = finished.observable("temperature").map_or(f64::NAN, |estimate| estimate.mean);
    Ok(vec![coefficient(z, warmed, effort.particles() as f64)])
}

/// Calculates the second virial coefficient `B_2`, in units of the hard-core value, from
/// `Z = 1 + (1 - 1 / N) (B_2 rho + B_3 rho^2 + ...)`. Each of `N` particles has `N - 1` partners.
fn coefficient(z: Option<Estimate>, temperature: f64, count: f64) -> Comparison {
    let (freedom, partners) = (3.0 * (count - 1.0), 1.0 - 1.0 / count);
    let density = 2.0 * std::f64::consts::PI / 3.0 * NUMBER_DENSITY;
    let second = |temperature: f64| second_virial_of_square_well(WELL_RATIO, DEPTH, temperature);
    let third = third_virial_of_square_well(WELL_RATIO, DEPTH, temperature) * density;
    let measured = z.map(|z| Estimate {
        mean: (z.mean - 1.0) / (density * partners) - third,
        standard_error: z.standard_error.map(|error| error / (density * partners)),
    });
    let expected = second(temperature);
    // At constant energy, the temperature has a variance of at most `2 T^2 / f` with `f` degrees of freedom. This
    // shifts the mean of `B_2(T)` by half the variance times the curvature of `B_2`.
    let step = 1e-3 * temperature;
    let curvature = (second(temperature + step) + second(temperature - step) - 2.0 * expected) / (step * step);
    let fluctuation = curvature.abs() * temperature * temperature / freedom;
    // Estimate of the fourth virial term, if the terms form a geometric series.
    let rest = third * third / expected.abs();
    Comparison::statistical(QUANTITIES[0], measured, expected, EXACT).allow(fluctuation + rest, FINITE_AND_REST)
}

const FINITE_AND_REST: &str =
    "first order in 1 / (3 N - 3): the energy is fixed, not the temperature; and the fourth virial coefficient";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::validate::Verdict;

    #[test]
    fn virial_series_pressure_passes_and_that_of_another_depth_fails() {
        let density = 2.0 * std::f64::consts::PI / 3.0 * NUMBER_DENSITY;
        let z = |depth: f64| {
            let second = second_virial_of_square_well(WELL_RATIO, depth, 2.0);
            let third = third_virial_of_square_well(WELL_RATIO, depth, 2.0);
            let mean = 1.0 + (second * density + third * density * density) * (1.0 - 1.0 / 1000.0);
            // This is the standard error after three million contacts.
            Some(Estimate { mean, standard_error: Some(4e-5) })
        };
        assert_eq!(coefficient(z(1.0), 2.0, 1000.0).verdict(), Verdict::Pass);
        assert_eq!(coefficient(z(1.02), 2.0, 1000.0).verdict(), Verdict::Fail);
        assert_eq!(coefficient(None, 2.0, 1000.0).verdict(), Verdict::Unresolved);
    }
}
