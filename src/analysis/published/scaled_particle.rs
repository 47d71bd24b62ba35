//! Scaled-particle theory of hard rods, disks and spheres.

use crate::model::scene::own_volume;

/// A fluid mixture of additive hard particles in one to three dimensions. J. L. Lebowitz, E. Helfand and E. Praestgaard,
/// J. Chem. Phys. 43, 774 (1965), [doi:10.1063/1.1696842](https://doi.org/10.1063/1.1696842).
///
/// With the moments `x_k = v sum_i n_i d_i^k` over particles of diameter `d_i` and number density `n_i`, `v d^D` is the
/// volume of a particle, and `x_D` is the packing fraction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HardMixture {
    dimensions: usize,
    moments: [f64; 4],
}

impl HardMixture {
    /// Creates a mixture from pairs of a diameter `[length]` and a number density `[length^-D]`. `None` if the particles
    /// fill the box, or if the number of dimensions is not 1 to 3.
    pub fn new(dimensions: usize, particles: impl Iterator<Item = [f64; 2]>) -> Option<Self> {
        let volume = own_volume(1.0, dimensions);
        let mut moments = [0.0; 4];
        for [diameter, density] in particles {
            let mut term = volume * density;
            for moment in &mut moments[..=dimensions.min(3)] {
                *moment += term;
                term *= diameter;
            }
        }
        let is_fluid = (1..=3).contains(&dimensions) && (0.0..1.0).contains(&moments[dimensions]);
        is_fluid.then_some(Self { dimensions, moments })
    }

    /// Returns the excess chemical potential of a particle, divided by the temperature. It is the work to insert the
    /// particle at a fixed position.
    #[must_use]
    pub fn excess_chemical_potential(&self, diameter: f64) -> f64 {
        let [x0, x1, x2, _] = self.moments;
        let free = 1.0 - self.moments[self.dimensions];
        let (linear, square) = match self.dimensions {
            1 => (x0 / free, 0.0),
            2 => (2.0 * x1 / free, self.pressure()),
            _ => (3.0 * x2 / free, 3.0 * x1 / free + 4.5 * x2 * x2 / (free * free)),
        };
        let cube = if self.dimensions == 3 { self.pressure() } else { 0.0 };
        -libm::log(free) + diameter * (linear + diameter * (square + diameter * cube))
    }

    /// The packing fraction.
    #[must_use]
    pub fn packing_fraction(&self) -> f64 {
        self.moments[self.dimensions]
    }

    /// Compressibility factor `Z = P / (n T)` of a fluid of hard spheres; `None` in fewer than three dimensions.
    ///
    /// `Z = 1 / f + 3 x_1 x_2 / (x_0 f^2) + (3 - x_3) x_2^3 / (x_0 f^3)` with `f = 1 - x_3`. For equal spheres, this is
    /// the equation of Carnahan and Starling. T. Boublik, J. Chem. Phys. 53, 471 (1970),
    /// [doi:10.1063/1.1673824](https://doi.org/10.1063/1.1673824); G. A. Mansoori, N. F. Carnahan, K. E. Starling and T.
    /// W. Leland, J. Chem. Phys. 54, 1523 (1971), [doi:10.1063/1.1675048](https://doi.org/10.1063/1.1675048).
    #[must_use]
    pub fn compressibility_factor(&self) -> Option<f64> {
        let [x0, x1, x2, x3] = self.moments;
        let free = 1.0 - x3;
        let factor = 1.0 / free + (3.0 * x1 * x2 + (3.0 - x3) * x2 * x2 * x2 / free) / (x0 * free * free);
        (self.dimensions == 3 && x0 > 0.0).then_some(factor)
    }

    /// The pressure multiplied by `v / T`.
    fn pressure(&self) -> f64 {
        let [x0, x1, x2, _] = self.moments;
        let free = 1.0 - self.moments[self.dimensions];
        match self.dimensions {
            1 => x0 / free,
            2 => x0 / free + x1 * x1 / (free * free),
            _ => x0 / free + 3.0 * x1 * x2 / (free * free) + 3.0 * x2 * x2 * x2 / (free * free * free),
        }
    }

    /// The probability that two particles can exchange their diameters without overlap. The larger diameter must fit into
    /// the place of the smaller one.
    #[must_use]
    pub fn acceptance_of_exchange(&self, diameters: [f64; 2]) -> f64 {
        let [one, other] = diameters.map(|diameter| self.excess_chemical_potential(diameter));
        libm::exp(-(one - other).abs())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Without further approximation, chemical potentials and pressure obey `dp = sum_i n_i dmu_i`.
    #[test]
    fn chemical_potentials_and_pressure_are_consistent() {
        let species = [[0.6, 0.31], [1.0, 0.17], [1.7, 0.04]];
        for dimensions in 1..=3 {
            let at = |extra: f64| {
                let particles =
                    species.map(|[diameter, density]| [diameter, density + if diameter == 1.0 { extra } else { 0.0 }]);
                let mixture = HardMixture::new(dimensions, particles.into_iter()).unwrap();
                let potential =
                    |[diameter, density]: [f64; 2]| libm::log(density) + mixture.excess_chemical_potential(diameter);
                (mixture.pressure() / own_volume(1.0, dimensions), particles.map(potential))
            };
            let step = 1e-6;
            let ((below, before), (above, after)) = (at(-step), at(step));
            let gained: f64 = (0..3).map(|k| species[k][1] * (after[k] - before[k])).sum();
            assert!(((above - below) / gained - 1.0).abs() < 1e-7, "{dimensions}: {} {gained}", above - below);
        }
    }

    #[test]
    fn rods_are_exact_and_dense_mixtures_have_no_theory() {
        // Tonks' gas of equal rods: p = n T / (1 - n d), and mu = -ln(1 - n d) + p d / T.
        let rods = HardMixture::new(1, [[0.7, 0.9]].into_iter()).unwrap();
        let pressure = 0.9 / (1.0 - 0.63);
        assert!((rods.excess_chemical_potential(0.7) - (0.7 * pressure - libm::log(1.0 - 0.63))).abs() < 1e-14);
        assert!((rods.acceptance_of_exchange([0.7, 1.0]) - libm::exp(-0.3 * pressure)).abs() < 1e-14);
        assert_eq!(HardMixture::new(1, [[1.0, 1.0]].into_iter()), None);
        assert_eq!(HardMixture::new(0, std::iter::empty()), None);
    }

    #[test]
    fn equal_spheres_have_the_equation_of_carnahan_and_starling() {
        for phi in [0.0_f64, 0.1, 0.3, 0.49] {
            let density = phi / own_volume(1.3, 3);
            // Half of the spheres are counted in a second entry of the same diameter.
            let halves = [[1.3, 0.5 * density], [1.3, 0.5 * density]];
            let mixture = HardMixture::new(3, halves.into_iter()).unwrap();
            let Some(factor) = mixture.compressibility_factor() else {
                assert_eq!(phi, 0.0);
                continue;
            };
            assert!((factor / crate::analysis::published::carnahan_starling(phi) - 1.0).abs() < 1e-14);
        }
    }

    /// The second virial coefficient of additive spheres is `2 pi / 3 <((d_1 + d_2) / 2)^3>`.
    #[test]
    fn a_dilute_mixture_has_the_exact_second_virial_coefficient() {
        let (small, large, density) = (0.7_f64, 1.9_f64, 1e-7);
        let mixture = HardMixture::new(3, [[small, 0.75 * density], [large, 0.25 * density]].into_iter()).unwrap();
        let cube = |a: f64, b: f64| (0.5 * (a + b)).powi(3);
        let mean = 0.5625 * cube(small, small) + 0.375 * cube(small, large) + 0.0625 * cube(large, large);
        let expected = 2.0 * std::f64::consts::PI / 3.0 * mean;
        let found = (mixture.compressibility_factor().unwrap() - 1.0) / density;
        assert!((found / expected - 1.0).abs() < 1e-5, "{found} {expected}");
        assert_eq!(HardMixture::new(2, [[1.0, 0.1]].into_iter()).unwrap().compressibility_factor(), None);
    }
}
