//! Diffusion in an infinite system, where a run has measured what its box makes of it: the coefficient and the shear viscosity.

use super::quantity::{Measured, Number};
use super::system::SystemDescription;
use crate::analysis::published::finite_size_of_diffusion;
use crate::analysis::statistics::Estimate;

const COEFFICIENT: &str = "diffusion_coefficient";
const GREEN_KUBO: &str = "diffusion_coefficient_green_kubo";
const VISCOSITY: &str = "shear_viscosity";
/// Name of the coefficient of an infinite system, before that of the species.
const INFINITE: &str = "diffusion_coefficient_infinite";

/// Largest relative error of a viscosity `eta` that can be divided by: the mean of `1 / eta` is too large by the square of it, a ninth of the term here.
const LARGEST_ERROR: f64 = 1.0 / 3.0;

/// Adds, to each diffusion coefficient of a periodic cube, that of an infinite system, `(1 - m / M) D + xi T / (6 pi eta L)` with `xi = 2.837297`, of the mean temperature
/// of the measurement; nothing where the box is none, or where the viscosity was not asked for.
///
/// The box leaves out all motion that is longer than its edge, by the Oseen tensor of the periodic box; the term is the same for all species, however large their particles are. It is
/// for a fluid that conserves momentum, which is where the viscosity is measured. The term has what is left out with the motion of the centre of mass, so that `D` is without the factor that makes up for that
/// elsewhere: `1 - m / M` takes it back, of all particles together `1 - 1 / N`.
///
/// Errors of both coefficients propagate as if they were independent; that of the temperature is far smaller.
///
/// Yeh and Hummer, J. Phys. Chem. B 108, 15873 (2004), [doi:10.1021/jp0477147](https://doi.org/10.1021/jp0477147).
pub(super) fn add_infinite_diffusion(measured: &mut Measured, system: &SystemDescription, temperature: f64) {
    let Some(edge) = edge_of_cube(system) else { return };
    let Some(viscosity) = measured.number(VISCOSITY).map(estimate) else { return };
    let term = viscosity.and_then(|viscosity| term(temperature, viscosity, edge));
    let mut extended = Vec::with_capacity(measured.numbers.len() + 1);
    for number in std::mem::take(&mut measured.numbers) {
        let infinite = infinite(&number, term, system);
        extended.push(number);
        extended.extend(infinite);
    }
    measured.numbers = extended;
}

/// The edge of a periodic cube without anything in it but the fluid `[length]`.
fn edge_of_cube(system: &SystemDescription) -> Option<f64> {
    let is_free = system.shear_rate == 0.0 && system.obstacle_to_transport().is_none();
    (is_free && system.space.is_cube()).then(|| system.space.size.max())
}

/// The coefficient of an infinite system that belongs to one of a box; `None` for any other number.
fn infinite(number: &Number, term: Option<Estimate>, system: &SystemDescription) -> Option<Number> {
    let species = number.name.strip_prefix(COEFFICIENT).filter(|_| !number.name.starts_with(GREEN_KUBO))?;
    let in_frame = estimate(number).map(|coefficient| coefficient.times(free_part(species, system)));
    let sum = in_frame.zip(term).map(|(coefficient, term)| Estimate {
        mean: coefficient.mean + term.mean,
        standard_error: coefficient.standard_error.zip(term.standard_error).map(|(a, b)| libm::hypot(a, b)),
    });
    let title = format!("{}, infinite system", number.title);
    Some(Number::estimated(&format!("{INFINITE}{species}"), &title, &number.unit, sum, METHOD))
}

/// `1 - m / M` of a species, whose name is behind a `_`, or in the mean over all particles.
fn free_part(species: &str, system: &SystemDescription) -> f64 {
    let is_one =
        |id: &u32| Some(&*system.species_names[system.species[*id as usize] as usize]) == species.strip_prefix('_');
    let one = system.moving.iter().copied().find(is_one);
    let mean = system.moving_mass() / system.moving.len() as f64;
    system.free_part(one.map_or(mean, |id| system.masses[id as usize]), 0)
}

/// How much lower the coefficient is in the box; `None` where the viscosity is not known well enough.
fn term(temperature: f64, viscosity: Estimate, edge: f64) -> Option<Estimate> {
    let relative = viscosity.standard_error? / viscosity.mean;
    let is_known = viscosity.mean > 0.0 && relative <= LARGEST_ERROR;
    let mean = finite_size_of_diffusion(temperature, viscosity.mean, edge);
    is_known.then_some(Estimate { mean, standard_error: Some(mean * relative) })
}

fn estimate(number: &Number) -> Option<Estimate> {
    number.mean.map(|mean| Estimate { mean, standard_error: number.standard_error })
}

const METHOD: &str = "(1 - m / M) D + 2.837297 T / (6 pi eta L) with the Einstein coefficient D and the shear viscosity eta of this run in its cube of edge L; errors of \
    both propagate. The first term is the displacement relative to the centre of mass, M the mass of all. The second is the same for all species. None where the error of eta is more than a third of it. Yeh and Hummer, J. Phys. Chem. B 108, 15873 (2004), doi:10.1021/jp0477147.";

#[cfg(test)]
mod tests;
