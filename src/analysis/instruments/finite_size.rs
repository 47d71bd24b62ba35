//! Corrects diffusion coefficients for the finite box and the finite span of lags.

use super::free_time;
use super::quantity::{Measured, Number};
use super::slope::straight_part;
use super::system::SystemDescription;
use crate::analysis::published::{
    VelocityTail, finite_size_of_diffusion, is_hydrodynamic, mean_free_path_of_diffusion,
};
use crate::analysis::statistics::Estimate;

const COEFFICIENT: &str = "diffusion_coefficient";
const GREEN_KUBO: &str = "diffusion_coefficient_green_kubo";
const DISPLACEMENT: &str = "mean_squared_displacement";
const CORRELATION: &str = "velocity_autocorrelation";
const VISCOSITY: &str = "shear_viscosity";
/// The name of a species follows.
const INFINITE: &str = "diffusion_coefficient_infinite";

/// Largest relative error of a viscosity `eta`. The mean of `1 / eta` is too large by at most the square, a ninth.
const LARGEST_ERROR: f64 = 1.0 / 3.0;

/// Largest correction for times beyond the span, as a fraction of the coefficient. The theory is of leading order.
const LARGEST_TAIL: f64 = 0.1;

/// Corrects each diffusion coefficient of a fluid that conserves momentum in a periodic box.
///
/// [`VelocityTail`] estimates `D_tail`, the part of the coefficient from times beyond the span. `D_tail` is added to
/// the error in quadrature. In a cube with measured viscosity, the coefficient of an infinite system follows from
/// [`finite_size_of_diffusion`]: `(1 - m / M) (D + D_tail) + xi T / (6 pi eta L) * nu / (nu + D + D_tail)`, with
/// `xi = 2.837297` and `nu = eta / rho`. This coefficient is undefined if `L / 2 pi` is below the mean free path, or if
/// `D_tail` is more than a tenth of `D`.
///
/// The finite-size term includes the effect of a centre of mass at rest. The measured `D` was divided by `1 - m / M`
/// for the same effect, so this division is undone. For all particles together, the factor is `1 - 1 / N`.
///
/// The errors propagate as if they were independent. The error of the temperature is negligible.
///
/// Yeh and Hummer, J. Phys. Chem. B 108, 15873 (2004), [doi:10.1021/jp0477147](https://doi.org/10.1021/jp0477147).
pub(super) fn complete_diffusion(measured: &mut Measured, system: &SystemDescription) {
    let Some(fluid) = Fluid::of(measured, system) else { return };
    let mut completed = Vec::with_capacity(measured.numbers.len() + 1);
    for mut number in std::mem::take(&mut measured.numbers) {
        if number.name.starts_with(COEFFICIENT) {
            let tail = fluid.tail(&number);
            let infinite = fluid.infinite(&number, tail);
            if let Some(tail) = tail {
                number.standard_error = number.standard_error.map(|error| libm::hypot(error, tail));
            }
            completed.push(number);
            completed.extend(infinite);
        } else {
            completed.push(number);
        }
    }
    measured.numbers = completed;
}

struct Fluid<'s> {
    system: &'s SystemDescription,
    /// Mean temperature during the measurement `[energy]`.
    temperature: f64,
    /// True if `L / 2 pi` is longer than the mean free path, which follows from the diffusion coefficient.
    is_hydrodynamic: bool,
    has_viscosity: bool,
    /// The measured viscosity `[mass / (length^(D - 2) time)]`, if its error is small enough.
    viscosity: Option<Estimate>,
    /// Shortest and longest lag of the straight part of the mean squared displacement `[time]`.
    span: [f64; 2],
}

impl<'s> Fluid<'s> {
    /// Returns `None` if momentum is not conserved, if the box has walls or shear, or if diffusion was not measured.
    fn of(measured: &Measured, system: &'s SystemDescription) -> Option<Self> {
        if system.shear_rate != 0.0 || system.obstacle_to_transport().is_some() {
            return None;
        }
        let times = &measured.curve(DISPLACEMENT)?.variables.first()?.values;
        let span = [*times.get(*straight_part(times.len().checked_sub(1)?).start())?, *times.last()?];
        // In `d` dimensions, `<v(0) . v(0)>` is `d T / m`, averaged over all particles.
        let squares = measured.curve(CORRELATION)?.series.first()?.values.first().copied().flatten()?;
        let inverse_mass: f64 = system.moving.iter().map(|id| 1.0 / system.masses[*id as usize]).sum();
        let temperature = squares * system.moving.len() as f64 / (inverse_mass * system.space.dimensions() as f64);
        let thermal_speed = libm::sqrt(squares / system.space.dimensions() as f64);
        let diffusion = measured.number(COEFFICIENT).and_then(|number| number.mean);
        let is_hydrodynamic = diffusion.is_some_and(|diffusion| {
            is_hydrodynamic(system.space.size.max(), mean_free_path_of_diffusion(diffusion, thermal_speed))
        });
        let is_known = |it: &Estimate| it.standard_error.is_some_and(|error| error <= LARGEST_ERROR * it.mean);
        let viscosity = measured.number(VISCOSITY);
        let has_viscosity = viscosity.is_some();
        Some(Self {
            system,
            temperature,
            is_hydrodynamic,
            has_viscosity,
            viscosity: viscosity.and_then(Number::estimate).filter(is_known),
            span,
        })
    }

    /// Returns the part of a diffusion coefficient from times beyond the span `[length^2 / time]`. Uses the measured
    /// viscosity if there is one, otherwise Enskog's.
    fn tail(&self, number: &Number) -> Option<f64> {
        let mass = self.system.moving_mass();
        let measured = self.viscosity.map(|it| it.mean);
        let viscosity = measured.or_else(|| free_time::viscosity(self.system, self.temperature))?;
        let periods: Vec<f64> = self.system.axes().map(|axis| self.system.space.size[axis]).collect();
        let spreading = viscosity * self.system.space.volume() / mass + number.mean?.max(0.0);
        let tail = VelocityTail { temperature_by_mass: self.temperature / mass, spreading, periods: &periods };
        let [first, last] = self.span;
        let is_slope = !number.name.starts_with(GREEN_KUBO);
        let missed = if is_slope { tail.beyond_slope([first, last]) } else { tail.beyond(last) };
        Some(missed).filter(|missed| missed.is_finite())
    }

    /// Converts a coefficient in the box into the coefficient of an infinite system. Returns `None` for Green-Kubo
    /// coefficients, if the box is not a cube, or if the viscosity was not requested.
    fn infinite(&self, number: &Number, tail: Option<f64>) -> Option<Number> {
        let species = number.name.strip_prefix(COEFFICIENT).filter(|_| !number.name.starts_with(GREEN_KUBO))?;
        if !self.has_viscosity || !self.system.space.is_cube() {
            return None;
        }
        let sum = || {
            let (of_box, viscosity, tail) = (number.estimate()?, self.viscosity?, tail?);
            let part = free_part(species, self.system);
            let (density, edge) =
                (self.system.moving_mass() / self.system.space.volume(), self.system.space.size.max());
            let diffusion = of_box.mean + tail;
            let term = finite_size_of_diffusion(self.temperature, viscosity.mean, density, diffusion, edge);
            // The finite-size term is proportional to 1 / (eta + rho D).
            let by_viscosity = -term / (viscosity.mean + density * diffusion);
            let of_viscosity = by_viscosity * viscosity.standard_error?;
            let of_diffusion = |error: f64| (part + by_viscosity * density) * error;
            let standard_error = of_box.standard_error.map(|error| libm::hypot(of_diffusion(error), of_viscosity));
            let is_small = tail <= LARGEST_TAIL * of_box.mean;
            (is_small && self.is_hydrodynamic).then_some(Estimate { mean: part * diffusion + term, standard_error })
        };
        let title = format!("{}, infinite system", number.title);
        Some(Number::estimated(&format!("{INFINITE}{species}"), &title, &number.unit, sum(), METHOD))
    }
}

/// Returns `1 - m / M`, where `m` is the mass of a particle of the species `_NAME`, or the mean mass.
fn free_part(species: &str, system: &SystemDescription) -> f64 {
    let is_one =
        |id: &u32| Some(&*system.species_names[system.species[*id as usize] as usize]) == species.strip_prefix('_');
    let one = system.moving.iter().copied().find(is_one);
    let mean = system.moving_mass() / system.moving.len() as f64;
    system.free_part(one.map_or(mean, |id| system.masses[id as usize]), 0)
}

const METHOD: &str = "(1 - m / M) (D + D_tail) + 2.837297 T / (6 pi eta L) * nu / (nu + D + D_tail), with the \
    Einstein coefficient D, the shear viscosity eta, nu = eta / rho and the edge L of the cubic box: Yeh and Hummer, J. \
    Phys. Chem. B 108, 15873 (2004), doi:10.1021/jp0477147. The factor 1 - m / M converts D to displacements relative to \
    the centre of mass; M is the total moving mass. D_tail is the contribution of long times that the fitted slope \
    misses: an integral of (2 / 3) (T / M) sum_k exp(-(nu + D) k^2 t) over these times (Ernst, Hauge and van Leeuwen, \
    Phys. Rev. Lett. 25, 1254, 1970, doi:10.1103/PhysRevLett.25.1254). The errors of D and eta are combined as if they \
    were independent. Withheld if the error of eta is more than a third of eta, if D_tail is more than a tenth of D, or \
    if L / 2 pi is below the mean free path.";

#[cfg(test)]
mod tests;
