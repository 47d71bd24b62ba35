//! The distribution of speeds in equilibrium.

use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// Maxwell's density of speeds, exact in equilibrium. Each velocity component has the variance `s^2 = T / m`.
///
/// `p(v) = sqrt(2 / pi) / s exp(-v^2 / 2 s^2)` in one dimension, `v / s^2 exp(-v^2 / 2 s^2)` in two, and
/// `sqrt(2 / pi) v^2 / s^3 exp(-v^2 / 2 s^2)` in three.
///
/// J. C. Maxwell, Phil. Mag. 19, 19 (1860), [doi:10.1080/14786446008642818](https://doi.org/10.1080/14786446008642818).
#[must_use]
#[doc(alias = "boltzmann")]
pub fn maxwell_speed_density(speed: f64, variance: f64, dimensions: usize) -> f64 {
    let deviation = variance.sqrt();
    let x = speed / deviation;
    let power = match dimensions {
        1 => (2.0 / PI).sqrt(),
        2 => x,
        _ => (2.0 / PI).sqrt() * x * x,
    };
    power * libm::exp(-0.5 * x * x) / deviation
}

/// Fraction of particles slower than a speed, the integral of [`maxwell_speed_density`].
#[must_use]
pub fn maxwell_speed_below(speed: f64, variance: f64, dimensions: usize) -> f64 {
    let x = speed / variance.sqrt();
    match dimensions {
        1 => libm::erf(x * FRAC_1_SQRT_2),
        2 => -libm::expm1(-0.5 * x * x),
        _ => libm::erf(x * FRAC_1_SQRT_2) - (2.0 / PI).sqrt() * x * libm::exp(-0.5 * x * x),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maxwell_speed_density_has_exact_integral_and_moments() {
        for dimensions in 1..=3 {
            for variance in [0.3, 1.0, 7.0_f64] {
                let step = 1e-4 * variance.sqrt();
                let (mut one, mut square, mut fourth) = (0.0, 0.0, 0.0);
                for k in 0..100_000 {
                    let speed = (f64::from(k) + 0.5) * step;
                    let density = maxwell_speed_density(speed, variance, dimensions);
                    let ends = [speed - 0.5 * step, speed + 0.5 * step];
                    let [low, high] = ends.map(|end| maxwell_speed_below(end, variance, dimensions));
                    // The tolerance covers the error of the midpoint rule and round-off.
                    assert!((density * step - (high - low)).abs() < 1e-8 * step / variance.sqrt() + 4e-16, "{speed}");
                    one += density * step;
                    square += density * step * speed * speed;
                    fourth += density * step * speed.powi(4);
                }
                let d = dimensions as f64;
                assert!((one - 1.0).abs() < 1e-8, "{one}");
                assert!((square / (d * variance) - 1.0).abs() < 1e-8, "{square}");
                assert!((fourth / (d * (d + 2.0) * variance * variance) - 1.0).abs() < 1e-8, "{fourth}");
            }
        }
    }
}
