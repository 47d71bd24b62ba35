//! A Lennard-Jones liquid with successively finer steps, compared with the smooth potential.
//!
//! The difference between averages over the stepped and the smooth potential is proportional to the square of the step
//! width. Two widths determine the difference.

use super::state_point::{Compared, Watch, build, finish, one_species};
use super::{Comparison, Effort, Source};
use crate::analysis::statistics::Estimate;
use crate::model::error::PotentialError;
use crate::model::potential::Potential;
use crate::model::{RunPlan, Thermostat, Until};
use crate::scene::{Fill, Lattice};

pub(super) const COUNT: u64 = 256;
const NUMBER_DENSITY: f64 = 0.75;
const TEMPERATURE: f64 = 1.0;
const CUTOFF: f64 = 2.5;
const STEPS: [usize; 2] = [24, 48];
/// Simulated times for melting the lattice with the heat bath, and for the measurement.
const TIMES: [f64; 2] = [20.0, 200.0];
/// Rate at which the heat bath gives a particle a new velocity `[1 / time]`, far below the collision rate.
const BATH_RATE: f64 = 0.5;

pub(super) const QUANTITIES: &[&str] = &["energy per particle", "pressure"];

const ALLEN_TILDESLEY: Source = Source {
    short: "Allen, Tildesley",
    full: "Allen and Tildesley, Computer Simulation of Liquids, 2nd ed. (2017): Lennard-Jones potential, cut at 2.5 and shifted",
};
const WIDTH: &str = "the change caused by extrapolation to steps of zero width";

/// Published energy per particle and pressure, at a density of 0.75 and a temperature of 1.
const PUBLISHED: [f64; 2] = [-2.9280, 0.9909];

pub(super) fn compare(_: f64, _: Effort, seed: u64, watch: Watch<'_>) -> Compared {
    let [wide, narrow] = STEPS;
    let wide = liquid(wide, seed, watch)?;
    let narrow = liquid(narrow, seed, watch)?;
    let compared = QUANTITIES.iter().zip(PUBLISHED).zip(wide.into_iter().zip(narrow));
    Ok(compared.map(|((quantity, published), (wide, narrow))| finest(quantity, wide, narrow, published)).collect())
}

/// Extrapolates to zero step width: `(4 narrow - wide) / 3`. The narrow steps are half as wide as the wide steps.
fn finest(quantity: &'static str, wide: Option<Estimate>, narrow: Option<Estimate>, published: f64) -> Comparison {
    let pair = wide.zip(narrow);
    let extrapolated = pair.map(|(wide, narrow)| Estimate {
        mean: (4.0 * narrow.mean - wide.mean) / 3.0,
        standard_error: wide
            .standard_error
            .zip(narrow.standard_error)
            .map(|(wide, narrow)| libm::hypot(4.0 * narrow, wide) / 3.0),
    });
    let change = pair.map_or(0.0, |(wide, narrow)| (narrow.mean - wide.mean).abs() / 3.0);
    Comparison::statistical(quantity, extrapolated, published, ALLEN_TILDESLEY).allow(change, WIDTH)
}

fn liquid(steps: usize, seed: u64, watch: Watch<'_>) -> Result<[Option<Estimate>; 2], super::StatePointError> {
    let bath = Thermostat::Andersen { temperature: TEMPERATURE, rate: BATH_RATE, axes: [true; 3] };
    let scene = one_species(seed, shifted(steps)?, 1.0)
        .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(COUNT).number_density(NUMBER_DENSITY))
        .temperature(TEMPERATURE)
        .run(RunPlan {
            equilibration: Until::time(TIMES[0]),
            limit: Until::time(TIMES[1]),
            thermostat: Some(bath),
            ..RunPlan::default()
        });
    let finished = finish(build(&scene)?, watch)?;
    let energy = finished
        .observable("potential_energy_per_particle")
        .map(|potential| Estimate { mean: 1.5 * TEMPERATURE + potential.mean, ..potential });
    Ok([energy, finished.observable("pressure")])
}

/// The stepped Lennard-Jones potential, shifted by the value of the smooth potential at the cut-off.
fn shifted(steps: usize) -> Result<Potential, PotentialError> {
    let cut = Potential::stepped_lennard_jones(1.0, 1.0, CUTOFF, steps, 50.0)?;
    let s6 = (CUTOFF * CUTOFF * CUTOFF * CUTOFF * CUTOFF * CUTOFF).recip();
    let at_cutoff = 4.0 * (s6 * s6 - s6);
    let energies = cut.energies().iter().enumerate();
    let raised = energies.map(|(state, energy)| if state == 0 { 0.0 } else { energy - at_cutoff });
    Potential::new(cut.radii().to_vec(), raised.collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quadratic_step_width_error_is_extrapolated() {
        let estimate = |mean| Some(Estimate { mean, standard_error: Some(3e-3) });
        let compared = finest("energy", estimate(-2.0 + 0.04), estimate(-2.0 + 0.01), -2.0);
        assert!((compared.measured.unwrap() + 2.0).abs() < 1e-15);
        assert!((compared.standard_error.unwrap() - 1e-3 * 17.0_f64.sqrt()).abs() < 1e-15);
        assert!((compared.allowance.amount - 0.01).abs() < 1e-15);
    }

    #[test]
    fn the_last_step_is_a_small_one() {
        let potential = shifted(100).unwrap();
        // The last step ends within 0.017 of the cut-off, where the smooth potential has a slope of 0.039.
        assert!(potential.energies()[1] < 0.0 && potential.energies()[1] > -0.039 * 0.017);
    }
}
