//! Heat flux through a gas of hard spheres between two plates.

use std::f64::consts::PI;

use super::equation_of_state::hard_spheres;
use super::kinetic_theory::HardSphereFluid;

/// Coefficient `zeta = 2.4001 sqrt(pi) / 2` of the temperature jump at a thermal wall, from the linearised Boltzmann
/// equation of hard spheres (Y. Sone, T. Ohwada and K. Aoki, Phys. Fluids A 1, 363 (1989),
/// [doi:10.1063/1.857457](https://doi.org/10.1063/1.857457)).
const JUMP: f64 = 2.4001 * 0.886_226_925_452_758;

/// A gas of equal elastic hard spheres at rest between two parallel thermal plates.
///
/// The heat flux in the gas is `q = - lambda(T, phi) dT/dx`, where `lambda` is Enskog's conductivity. The pressure
/// `p = rho T Z(phi)` is uniform. At a plate of temperature `T_w`, the gas has the temperature `T_w + zeta l dT/dn`.
/// Here `l = 1 / (sqrt(2) pi rho sigma^2 chi)` is the local mean free path, `dT/dn` is the derivative into the gas, and
/// `zeta = 2.127`. The temperatures of the plates and the number of particles determine `q` and `p`.
///
/// The result is exact to first order in the density and in `l / L`, where `L` is the distance. It neglects terms of
/// second order in `l / L` times the relative temperature difference. It also neglects the transfer of energy over a
/// diameter in a collision, which changes each jump by about the diameter times the gradient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GasBetweenPlates {
    /// Distance between the plates minus the diameter of a sphere `[length]`.
    pub distance: f64,
    /// Particles per area of a plate `[length^-2]`.
    pub particles_per_area: f64,
    /// Diameter of a sphere `[length]`.
    pub diameter: f64,
    /// Mass of a sphere `[mass]`.
    pub mass: f64,
    /// Temperatures of the lower and of the upper plate `[energy]`.
    pub temperatures: [f64; 2],
}

impl GasBetweenPlates {
    /// Heat flux from the lower to the upper plate `[energy / (length^2 time)]`.
    #[must_use]
    pub fn heat_flux(&self) -> f64 {
        let [lower, upper] = self.temperatures;
        let mut pressure = self.particles_per_area / self.distance * 0.5 * (lower + upper);
        let (mut at, mut flux) = ([lower, upper], 0.0);
        // Each step at least halves the error.
        for _ in 0..100 {
            let (conducted, held) = self.integrals(at, pressure);
            flux = conducted / self.distance;
            if flux == 0.0 {
                break;
            }
            pressure *= (self.particles_per_area * flux / held).sqrt();
            let jump = |temperature: f64| {
                let gas = self.gas(temperature, pressure);
                JUMP * gas.mean_free_path() * flux / gas.thermal_conductivity()
            };
            let jumped = [lower - jump(at[0]), upper + jump(at[1])];
            at = [0, 1].map(|plate| 0.5 * (at[plate] + jumped[plate]));
        }
        flux
    }

    /// Returns two integrals over temperature: of the conductivity, and of the conductivity times the number density.
    fn integrals(&self, [lower, upper]: [f64; 2], pressure: f64) -> (f64, f64) {
        const STEPS: u32 = 64;
        let width = (lower - upper) / f64::from(STEPS);
        let (mut conducted, mut held) = (0.0, 0.0);
        for step in 0..STEPS {
            let gas = self.gas(upper + (f64::from(step) + 0.5) * width, pressure);
            let part = gas.thermal_conductivity() * width;
            (conducted, held) = (conducted + part, held + part * gas.number_density());
        }
        (conducted, held)
    }

    fn gas(&self, temperature: f64, pressure: f64) -> HardSphereFluid {
        let ideal = PI / 6.0 * self.diameter * self.diameter * self.diameter * pressure / temperature;
        let packing_fraction = (0..30).fold(ideal, |phi, _| ideal / hard_spheres(phi));
        HardSphereFluid { packing_fraction, diameter: self.diameter, mass: self.mass, temperature }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plates(phi: f64, distance: f64, temperatures: [f64; 2]) -> GasBetweenPlates {
        let particles_per_area = 6.0 / PI * phi * distance;
        GasBetweenPlates { distance, particles_per_area, diameter: 1.0, mass: 1.0, temperatures }
    }

    #[test]
    fn heat_flux_has_the_fourier_and_temperature_jump_limits() {
        // For a dilute gas, lambda = lambda_0 sqrt(T), with the integral 2/3 lambda_0 T^(3/2).
        let lambda = HardSphereFluid { temperature: 1.0, ..HardSphereFluid::reduced(1e-9) }.thermal_conductivity();
        let far = plates(1e-6, 1e9, [2.0, 1.0]).heat_flux();
        let fourier = 2.0 / 3.0 * lambda * (2.0_f64.powf(1.5) - 1.0) / 1e9;
        // The mean free path is about 1e-4 of the distance, so the jumps reduce the flux by about 2 * 2.127 * 1e-4.
        assert!((far / fourier - 1.0).abs() < 1e-3, "{far} {fourier}");
        // For a small temperature difference over four mean free paths, the flux is `lambda dT / (L + 2 zeta l)`.
        let (phi, distance) = (1e-5, 50_000.0);
        let gas = HardSphereFluid::reduced(phi);
        let near = plates(phi, distance, [1.0005, 0.9995]).heat_flux();
        let expected = gas.thermal_conductivity() * 1e-3 / (distance + 2.0 * 2.127 * gas.mean_free_path());
        assert!((near / expected - 1.0).abs() < 1e-3, "{near} {expected}");
    }

    #[test]
    fn heat_flux_scales_with_units_and_reverses_with_temperatures() {
        let hot_below = plates(0.03, 60.0, [2.0, 1.0]);
        let flux = hot_below.heat_flux();
        assert!((plates(0.03, 60.0, [1.0, 2.0]).heat_flux() / flux + 1.0).abs() < 1e-12);
        assert_eq!(plates(0.03, 60.0, [1.5, 1.5]).heat_flux(), 0.0);
        // The units of length, mass and energy are changed. The flux is energy / (length^2 time).
        let scaled = GasBetweenPlates {
            distance: 120.0,
            particles_per_area: 0.25 * hot_below.particles_per_area,
            diameter: 2.0,
            mass: 3.0,
            temperatures: [10.0, 5.0],
        };
        let time = (3.0_f64 * 4.0 / 5.0).sqrt();
        assert!((scaled.heat_flux() / flux * 4.0 * time / 5.0 - 1.0).abs() < 1e-12);
    }

    #[test]
    fn heat_conductivity_agrees_with_the_temperature_jump_theory() {
        // With `k_B = 1`, the conductivity of Sone and others is `5 sqrt(pi) / 4 gamma_2` in units of
        // `p l / sqrt(2 T / m)`, where `gamma_2 = 1.922284`.
        let gas = HardSphereFluid::reduced(1e-9);
        let unit = gas.number_density() * gas.mean_free_path() / 2.0_f64.sqrt();
        let theirs = 1.25 * PI.sqrt() * 1.922_284 * unit;
        // The factor 1.025 in the conductivity is rounded to four digits.
        assert!((gas.thermal_conductivity() / theirs - 1.0).abs() < 5e-4, "{}", gas.thermal_conductivity() / theirs);
    }
}
