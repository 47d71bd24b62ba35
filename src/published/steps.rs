//! Square wells and stepped potentials.

/// Exact for every downward step in equilibrium: how many pairs bounce at its outer side from within for one that is released,
/// `N_bounce / N_release = exp(eps / T) - 1`, with the depth `eps` of the step.
///
/// Bannerman and Lue, J. Chem. Phys. 133, 124506 (2010), [doi:10.1063/1.3486567](https://doi.org/10.1063/1.3486567).
#[must_use]
#[doc(alias = "bannerman_lue")]
pub fn bounces_per_release(step: f64, temperature: f64) -> f64 {
    libm::expm1(step / temperature)
}

/// Second virial coefficient of a square well, exact, in units of that of its core, `2 pi sigma^3 / 3`:
/// `1 - (lambda^3 - 1) (exp(eps / T) - 1)`, with `lambda` the ratio of well and core, `eps` the depth.
#[must_use]
pub fn second_virial_of_square_well(well_ratio: f64, depth: f64, temperature: f64) -> f64 {
    1.0 - (well_ratio * well_ratio * well_ratio - 1.0) * libm::expm1(depth / temperature)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_second_virial_changes_its_sign_near_a_temperature_of_three() {
        for (temperature, b2) in [(1.0, -3.08092), (2.0, -0.54071), (3.0, 0.06042)] {
            assert!((second_virial_of_square_well(1.5, 1.0, temperature) - b2).abs() < 0.51e-5);
        }
    }

    #[test]
    fn a_step_without_depth_reflects_nobody() {
        assert_eq!(bounces_per_release(0.0, 1.0), 0.0);
        assert!((bounces_per_release(2.0, 1.0) - 6.389_056_098_930_65).abs() < 1e-14);
    }
}
