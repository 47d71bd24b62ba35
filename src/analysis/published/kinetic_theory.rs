//! Kinetic theory of elastic hard particles: collision rates and transport coefficients.

use std::f64::consts::{PI, TAU};

use super::equation_of_state::{hard_disks, hard_spheres, tonks};

/// Ratios of the self-diffusion coefficient, the viscosity and the conductivity to their first Sonine approximations:
/// Chapman and Cowling, *The Mathematical Theory of Non-Uniform Gases* (1970).
const DIFFUSION_SERIES: f64 = 1.018_96;
const VISCOSITY_SERIES: f64 = 1.016;
const CONDUCTIVITY_SERIES: f64 = 1.025;

/// Radial distribution function of hard spheres at contact: `chi = (Z - 1) / (4 phi)`, with `Z` of the mKLM equation.
#[must_use]
pub fn contact_value(packing_fraction: f64) -> f64 {
    if packing_fraction > 0.0 { (hard_spheres(packing_fraction) - 1.0) / (4.0 * packing_fraction) } else { 1.0 }
}

/// Contact value of hard disks, `chi = (Z - 1) / (2 eta)`.
#[must_use]
pub fn contact_value_of_disks(packing_fraction: f64) -> f64 {
    if packing_fraction > 0.0 { (hard_disks(packing_fraction) - 1.0) / (2.0 * packing_fraction) } else { 1.0 }
}

/// Collision rate of a hard disk `[1 / time]`: `G = 2 rho sigma chi sqrt(pi T / m)`, exact given `chi`.
#[must_use]
pub fn collision_rate_of_disks(packing_fraction: f64, diameter: f64, mass: f64, temperature: f64) -> f64 {
    let density = packing_fraction * 4.0 / (PI * diameter * diameter);
    2.0 * density * diameter * contact_value_of_disks(packing_fraction) * (PI * temperature / mass).sqrt()
}

/// Enskog's shear viscosity of hard disks, in the first approximation `[mass / time]`:
/// `eta = sqrt(m T / pi) / (2 sigma) (1 / chi + b rho + (1/4 + 2/pi) (b rho)^2 chi)`, `b rho = 2 phi`.
///
/// D. M. Gass, J. Chem. Phys. 54, 1898 (1971), [doi:10.1063/1.1675116](https://doi.org/10.1063/1.1675116).
#[must_use]
pub fn viscosity_of_disks(packing_fraction: f64, diameter: f64, mass: f64, temperature: f64) -> f64 {
    let dilute = (mass * temperature / PI).sqrt() / (2.0 * diameter);
    let covered = 2.0 * packing_fraction;
    let chi = contact_value_of_disks(packing_fraction);
    dilute * (1.0 / chi + covered + (0.25 + 2.0 / PI) * covered * covered * chi)
}

/// Exact collision rate of a hard rod in equilibrium `[1 / time]`: `G = 2 rho / (1 - rho sigma) sqrt(T / (pi m))`.
#[must_use]
pub fn collision_rate_of_rods(packing_fraction: f64, diameter: f64, mass: f64, temperature: f64) -> f64 {
    2.0 * packing_fraction / diameter * tonks(packing_fraction) * (temperature / (PI * mass)).sqrt()
}

/// Finite-size correction to be added to the diffusion coefficient in a periodic cube of edge `L` `[length^2 / time]`:
/// `2.837297 T / (6 pi eta L) * nu / (nu + D)`, with the kinematic viscosity `nu = eta / rho` and mass density `rho`.
///
/// The first factor is the correction of Yeh and Hummer. The second factor is close to 1 in a liquid. In a gas, a
/// particle diffuses out of the flow that it causes. At a wave vector `k`, velocity correlations decay as `exp(-(nu +
/// D) k^2 t)` (Ernst, Hauge and van Leeuwen). `L / 2 pi` must exceed the mean free path.
///
/// Yeh and Hummer, J. Phys. Chem. B 108, 15873 (2004), [doi:10.1021/jp0477147](https://doi.org/10.1021/jp0477147);
/// Ernst, Hauge and van Leeuwen, Phys. Rev. Lett. 25, 1254 (1970), [doi:10.1103/PhysRevLett.25.1254](https://doi.org/10.1103/PhysRevLett.25.1254).
#[must_use]
pub fn finite_size_of_diffusion(temperature: f64, viscosity: f64, density: f64, diffusion: f64, edge: f64) -> f64 {
    2.837_297 * temperature / (6.0 * PI * (viscosity + density * diffusion) * edge)
}

/// Mean free path of hard spheres from their diffusion coefficient `[length]`: `D = 1.01896 (3 / 8) sqrt(2 pi
/// T / m) l` in Enskog's theory, at all densities. `thermal_speed` is `sqrt(T / m)`.
pub(crate) fn mean_free_path_of_diffusion(diffusion: f64, thermal_speed: f64) -> f64 {
    diffusion / (DIFFUSION_SERIES * 0.375 * TAU.sqrt() * thermal_speed)
}

pub(crate) fn is_hydrodynamic(edge: f64, mean_free_path: f64) -> bool {
    edge / TAU > mean_free_path
}

/// Assumed number of spheres in Speedy's fit. Speedy simulated 256 to 1000 spheres. Larger systems diffuse faster
/// (Sigurgeirsson and Heyes, Mol. Phys. 101, 469, 2003).
pub(crate) const FITTED_SPHERES: f64 = 500.0;

/// A fluid of equal elastic hard spheres in equilibrium, described by Enskog's theory.
///
/// Enskog's theory treats collisions as uncorrelated except for the contact value `chi`. It is exact for dilute gases,
/// and accurate to a few per cent up to `phi = 0.3`. With `y = 4 phi chi = Z - 1` and `b rho = 4 phi`:
///
/// | quantity | Enskog |
/// |---|---|
/// | collision rate (exact given `Z`) | `G = 4 rho sigma^2 chi sqrt(pi T / m) = 6 (Z - 1) / sigma sqrt(T / (pi m))` |
/// | self-diffusion | `D = 1.01896 * 3 / (8 rho sigma^2 chi) sqrt(T / (pi m))` |
/// | shear viscosity | `eta_0 b rho (1 / y + 4/5 + 0.7615 y)`, `eta_0 = 1.016 * 5 / (16 sigma^2) sqrt(m T / pi)` |
/// | bulk viscosity | `4/9 rho^2 sigma^4 chi sqrt(pi m T)` |
/// | thermal conductivity | `lambda_0 b rho (1 / y + 6/5 + 0.7575 y)`, `lambda_0 = 1.025 * 75 / (64 sigma^2) sqrt(T / (pi m))` |
///
/// Chapman and Cowling, chapter 16; Alder, Gass and Wainwright, J. Chem. Phys. 53, 3813 (1970),
/// [doi:10.1063/1.1673845](https://doi.org/10.1063/1.1673845).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardSphereFluid {
    /// Volume fraction of the spheres.
    pub packing_fraction: f64,
    /// Diameter of a sphere `[length]`.
    pub diameter: f64,
    /// Mass of a sphere `[mass]`.
    pub mass: f64,
    /// Temperature `[energy]`.
    pub temperature: f64,
}

impl HardSphereFluid {
    /// A fluid in reduced units: `sigma = m = T = 1`.
    #[must_use]
    pub fn reduced(packing_fraction: f64) -> Self {
        Self { packing_fraction, diameter: 1.0, mass: 1.0, temperature: 1.0 }
    }

    /// Number density `rho = 6 phi / (pi sigma^3)` `[1 / length^3]`.
    #[must_use]
    pub fn number_density(&self) -> f64 {
        6.0 * self.packing_fraction / (PI * self.diameter * self.diameter * self.diameter)
    }

    /// Collisions per particle and unit of time `[1 / time]`. Each collision counts for both particles.
    #[must_use]
    pub fn collision_rate(&self) -> f64 {
        let area = self.diameter * self.diameter;
        4.0 * self.number_density() * area * self.chi() * (PI * self.temperature / self.mass).sqrt()
    }

    /// Mean free path `[length]`: mean speed divided by collision rate.
    #[must_use]
    pub fn mean_free_path(&self) -> f64 {
        (8.0 * self.temperature / (PI * self.mass)).sqrt() / self.collision_rate()
    }

    /// Enskog's self-diffusion coefficient `[length^2 / time]`.
    #[must_use]
    pub fn diffusion_coefficient(&self) -> f64 {
        DIFFUSION_SERIES * self.dilute_diffusion() / self.chi()
    }

    /// Self-diffusion coefficient from a fit to simulations, for `0 < phi < 0.5` `[length^2 / time]`. It is accurate to
    /// a few per cent. Diffusion depends on the size of the system, see [`finite_size_of_diffusion`].
    ///
    /// `D = 3 / (8 rho sigma^2) sqrt(T / (pi m)) (1 - rho / 1.09) (1 + rho^2 (0.4 - 0.83 rho^2))`, `rho` in units of `sigma`.
    ///
    /// Speedy, Mol. Phys. 62, 509 (1987), [doi:10.1080/00268978700102371](https://doi.org/10.1080/00268978700102371).
    #[must_use]
    pub fn simulated_diffusion_coefficient(&self) -> f64 {
        let reduced = 6.0 * self.packing_fraction / PI;
        let square = reduced * reduced;
        self.dilute_diffusion() * (1.0 - reduced / 1.09) * (1.0 + square * (0.4 - 0.83 * square))
    }

    /// Finite-size correction of the diffusion coefficient for `count` spheres in a periodic cube `[length^2 / time]`.
    /// `None` if the cube is too small for [`finite_size_of_diffusion`].
    pub(crate) fn slower_diffusion(&self, count: f64) -> Option<f64> {
        let density = self.number_density();
        let edge = libm::cbrt(count / density);
        let [viscosity, diffusion] = [self.shear_viscosity(), self.diffusion_coefficient()];
        let slower = finite_size_of_diffusion(self.temperature, viscosity, self.mass * density, diffusion, edge);
        is_hydrodynamic(edge, self.mean_free_path()).then_some(slower)
    }

    /// Enskog's shear viscosity `[mass / (length time)]`.
    #[must_use]
    pub fn shear_viscosity(&self) -> f64 {
        let area = self.diameter * self.diameter;
        let dilute = VISCOSITY_SERIES * 5.0 / (16.0 * area) * (self.mass * self.temperature / PI).sqrt();
        dilute * self.enskog_series(0.8, 0.7615)
    }

    /// Enskog's bulk viscosity `[mass / (length time)]`.
    #[must_use]
    pub fn bulk_viscosity(&self) -> f64 {
        let layer = self.number_density() * self.diameter * self.diameter;
        4.0 / 9.0 * layer * layer * self.chi() * (PI * self.mass * self.temperature).sqrt()
    }

    /// Enskog's thermal conductivity `[1 / (length time)]`, with `k_B = 1`.
    #[must_use]
    pub fn thermal_conductivity(&self) -> f64 {
        let area = self.diameter * self.diameter;
        let dilute = CONDUCTIVITY_SERIES * 75.0 / (64.0 * area) * (self.temperature / (PI * self.mass)).sqrt();
        dilute * self.enskog_series(1.2, 0.7575)
    }

    fn chi(&self) -> f64 {
        contact_value(self.packing_fraction)
    }

    /// Self-diffusion coefficient of a dilute gas, in the first Sonine approximation `[length^2 / time]`.
    fn dilute_diffusion(&self) -> f64 {
        let area = self.diameter * self.diameter;
        3.0 / (8.0 * self.number_density() * area) * (self.temperature / (PI * self.mass)).sqrt()
    }

    /// Returns `b rho (1 / y + first + second y)` without dividing by `y`, which is 0 at zero density.
    fn enskog_series(&self, first: f64, second: f64) -> f64 {
        let (covolume, chi) = (4.0 * self.packing_fraction, self.chi());
        1.0 / chi + first * covolume + second * chi * covolume * covolume
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hard_spheres_collide_and_diffuse_as_published() {
        let table = [
            (0.10, 0.19099, 1.76585, 0.8656, 0.9260),
            (0.20, 0.38197, 4.77102, 0.3204, 0.3744),
            (0.30, 0.57296, 10.1012, 0.1513, 0.1825),
            (0.40, 0.76394, 20.1262, 0.0759, 0.0788),
            (0.45, 0.85944, 28.4491, 0.0537, 0.0439),
            (0.49, 0.93583, 37.8132, 0.0404, 0.0228),
        ];
        for (phi, density, rate, enskog, speedy) in table {
            let fluid = HardSphereFluid::reduced(phi);
            assert!((fluid.number_density() - density).abs() < 0.51e-5);
            assert!((fluid.collision_rate() / rate - 1.0).abs() < 5e-6, "{} {rate}", fluid.collision_rate());
            assert!((fluid.diffusion_coefficient() - enskog).abs() < 0.51e-4);
            let simulated = fluid.simulated_diffusion_coefficient();
            assert!((simulated - speedy).abs() < 0.51e-4, "{phi}: {simulated} {speedy}");
        }
    }

    #[test]
    fn transport_coefficients_scale_with_units() {
        let reduced = HardSphereFluid::reduced(0.3);
        // The units are 2 for length, 12 for mass and 3 for energy, so the unit of time is `2 sqrt(12 / 3) = 4`.
        let scaled = HardSphereFluid { diameter: 2.0, mass: 12.0, temperature: 3.0, ..reduced };
        for (a, b, unit) in [
            (scaled.collision_rate(), reduced.collision_rate(), 1.0 / 4.0),
            (scaled.mean_free_path(), reduced.mean_free_path(), 2.0),
            (scaled.diffusion_coefficient(), reduced.diffusion_coefficient(), 1.0),
            (scaled.simulated_diffusion_coefficient(), reduced.simulated_diffusion_coefficient(), 1.0),
            (scaled.shear_viscosity(), reduced.shear_viscosity(), 12.0 / 8.0),
            (scaled.bulk_viscosity(), reduced.bulk_viscosity(), 12.0 / 8.0),
            (scaled.thermal_conductivity(), reduced.thermal_conductivity(), 1.0 / 8.0),
        ] {
            assert!((a / b / unit - 1.0).abs() < 1e-14, "{a} {b} {unit}");
        }
    }

    #[test]
    fn a_dilute_gas_has_the_values_of_chapman_and_cowling() {
        let gas = HardSphereFluid::reduced(0.0);
        assert!((gas.shear_viscosity() - 1.016 * 0.176_308_9).abs() < 1e-6);
        assert!((gas.thermal_conductivity() - 1.025 * 0.661_159_67).abs() < 1e-6);
        // The first Sonine coefficients are `4/25 (1 + 12 / pi)` for the viscosity and `9/25 (1 + 32 / (9 pi))` for the
        // conductivity. Divided by the series factors, they are about 0.7615 and 0.7575.
        assert!((4.0 / 25.0 * (1.0 + 12.0 / PI) / VISCOSITY_SERIES / 0.7615 - 1.0).abs() < 5e-3);
        assert!((9.0 / 25.0 * (1.0 + 32.0 / (9.0 * PI)) / CONDUCTIVITY_SERIES / 0.7575 - 1.0).abs() < 1.3e-2);
        // The bulk viscosity is `1.0025 eta_0 b rho y`, with the shear viscosity `eta_0` of the dilute gas.
        let dense = HardSphereFluid::reduced(0.2);
        let expected = 1.0025 * gas.shear_viscosity() * 0.8 * 0.8 * contact_value(0.2);
        assert!((dense.bulk_viscosity() / expected - 1.0).abs() < 1e-3);
    }

    #[test]
    fn collision_rates_of_disks_and_rods_agree_with_the_virial() {
        // Virial theorem: Z - 1 = sqrt(pi) sigma G / (2 D) / sqrt(T / m) for D axes.
        for (rate, z, axes) in [
            (collision_rate_of_disks(0.5, 2.0, 3.0, 5.0), hard_disks(0.5), 2.0),
            (collision_rate_of_rods(0.5, 2.0, 3.0, 5.0), tonks(0.5), 1.0),
        ] {
            let virial = PI.sqrt() * 2.0 * rate / (2.0 * axes) / (5.0_f64 / 3.0).sqrt();
            assert!((virial / (z - 1.0) - 1.0).abs() < 1e-14, "{virial} {z}");
        }
    }

    #[test]
    fn finite_size_correction_of_diffusion_matches_hand_calculation() {
        // Without diffusion the factor `nu / (nu + D)` is 1, so the result is 2.837297 / (6 pi).
        assert!((finite_size_of_diffusion(1.0, 1.0, 1.0, 0.0, 1.0) - 0.150_524).abs() < 1e-6);
        // By hand for `T = 3`, `eta = 2`, `rho = 0.5`, `D = 6`, `L = 4` and `nu = 4`: `8.511891 / (6 pi * 8) * 0.4`.
        let slower = finite_size_of_diffusion(3.0, 2.0, 0.5, 6.0, 4.0);
        assert!((slower - 0.022_578_49).abs() < 1e-8, "{slower}");
    }

    #[test]
    fn finite_size_correction_needs_enough_free_paths_in_the_box() {
        // At `phi = 0.1`, the mean free path is 0.9037. A cube with `L / 2 pi = 0.9037` holds 34.97 spheres.
        let gas = HardSphereFluid::reduced(0.1);
        assert!((gas.mean_free_path() - 0.9037).abs() < 1e-4, "{}", gas.mean_free_path());
        assert!(gas.slower_diffusion(34.0).is_none() && gas.slower_diffusion(36.0).is_some());
        for phi in [0.01, 0.1, 0.4] {
            let fluid = HardSphereFluid { diameter: 2.0, mass: 3.0, temperature: 5.0, packing_fraction: phi };
            let path = mean_free_path_of_diffusion(fluid.diffusion_coefficient(), (5.0_f64 / 3.0).sqrt());
            assert!((path / fluid.mean_free_path() - 1.0).abs() < 1e-12, "{path}");
        }
    }

    #[test]
    fn dilute_disks_have_the_viscosity_of_kinetic_theory() {
        let expected = (0.7 * 1.9 / PI).sqrt() / 2.6;
        assert!((viscosity_of_disks(1e-9, 1.3, 0.7, 1.9) / expected - 1.0).abs() < 1e-6);
    }
}
