//! Exact results for square wells and stepped potentials.

use std::f64::consts::PI;

/// Ratio of bounces to releases at a step of depth `eps`: `N_bounce / N_release = exp(eps / T) - 1`, exact in
/// equilibrium. Pairs reach the step from inside, where the potential energy is lower.
///
/// Bannerman and Lue, J. Chem. Phys. 133, 124506 (2010), [doi:10.1063/1.3486567](https://doi.org/10.1063/1.3486567).
#[must_use]
#[doc(alias = "bannerman_lue")]
pub fn bounces_per_release(step: f64, temperature: f64) -> f64 {
    libm::expm1(step / temperature)
}

/// Exact second virial coefficient of a square well, in units of `2 pi sigma^3 / 3`:
/// `1 - (lambda^3 - 1) (exp(eps / T) - 1)` for a well of diameter `lambda sigma` and depth `eps`.
#[must_use]
pub fn second_virial_of_square_well(well_ratio: f64, depth: f64, temperature: f64) -> f64 {
    1.0 - (well_ratio * well_ratio * well_ratio - 1.0) * libm::expm1(depth / temperature)
}

/// Third virial coefficient of a square well, exact, in units of `(2 pi sigma^3 / 3)^2`: `-(1/3) int int f(r12) f(r13)
/// f(r23)`, with Mayer's `f = exp(-u / T) - 1`.
///
/// The inner integral is a sum of volumes that two spheres share, and the outer integrand is a piecewise polynomial (T.
/// Kihara, Rev. Mod. Phys. 25, 831, 1953, gives the closed form).
#[must_use]
pub fn third_virial_of_square_well(well_ratio: f64, depth: f64, temperature: f64) -> f64 {
    let x = libm::expm1(depth / temperature);
    let inner = |r: f64| {
        let (core, mixed, well) = (lens(1.0, 1.0, r), lens(well_ratio, 1.0, r), lens(well_ratio, well_ratio, r));
        (1.0 + x) * (1.0 + x) * core - 2.0 * x * (1.0 + x) * mixed + x * x * well
    };
    // Between neighbouring distances of this list, the integrand is a polynomial.
    let mut ends = [0.0, well_ratio - 1.0, 1.0, 2.0, well_ratio].map(|end: f64| end.min(well_ratio));
    ends.sort_by(f64::total_cmp);
    let mut sum = 0.0;
    for piece in ends.windows(2) {
        let (middle, half) = (0.5 * (piece[0] + piece[1]), 0.5 * (piece[1] - piece[0]));
        // Gauss-Legendre quadrature with three points is exact for polynomials of at most degree five.
        for (node, weight) in [(-0.6_f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6_f64.sqrt(), 5.0 / 9.0)] {
            let r = middle + half * node;
            let mayer = if middle < 1.0 { -1.0 } else { x };
            sum += half * weight * mayer * 4.0 * PI * r * r * inner(r);
        }
    }
    let unit = 2.0 * PI / 3.0;
    -sum / 3.0 / (unit * unit)
}

/// Volume shared by two spheres of radii `large >= small` at a distance `r`.
fn lens(large: f64, small: f64, r: f64) -> f64 {
    let (sum, difference) = (large + small, large - small);
    if r >= sum {
        0.0
    } else if r <= difference {
        4.0 / 3.0 * PI * small * small * small
    } else {
        PI * (sum - r) * (sum - r) * (r * r + 2.0 * r * sum - 3.0 * difference * difference) / (12.0 * r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};

    #[test]
    fn the_third_virial_of_spheres_is_five_eighths() {
        // A well of depth 0 leaves a hard core. A shoulder that no particle climbs is a larger hard sphere.
        for lambda in [1.2, 1.5, 1.9, 2.5] {
            assert!((third_virial_of_square_well(lambda, 0.0, 1.0) - 0.625).abs() < 1e-14);
            let large = third_virial_of_square_well(lambda, -800.0, 1.0);
            assert!((large / (0.625 * f64::powi(lambda, 6)) - 1.0).abs() < 1e-13, "{lambda}: {large}");
        }
    }

    #[test]
    fn the_third_virial_is_the_integral_over_random_triangles() {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut uniform = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let (lambda, temperature, count) = (1.5_f64, 2.0, 400_000);
        let mayer = |square: f64| match square {
            square if square < 1.0 => -1.0,
            square if square < lambda * lambda => libm::expm1(1.0 / temperature),
            _ => 0.0,
        };
        let mut point = || [0; 3].map(|_| lambda * (2.0 * uniform() - 1.0));
        let square = |a: [f64; 3]| a.iter().map(|x| x * x).sum::<f64>();
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..count {
            let (a, b) = (point(), point());
            let value = mayer(square(a)) * mayer(square(b)) * mayer(square([0, 1, 2].map(|k| a[k] - b[k])));
            sum += value;
            squares += value * value;
        }
        let (n, volume) = (f64::from(count), libm::pow(2.0 * lambda, 6.0));
        let scale = -volume / 3.0 / (2.0 * PI / 3.0 * 2.0 * PI / 3.0);
        let error = scale.abs() * ((squares / n - (sum / n) * (sum / n)) / n).sqrt();
        let found = third_virial_of_square_well(lambda, 1.0, temperature);
        assert!(
            (found - scale * sum / n).abs() < 4.0 * error,
            "found {found}, expected {} +- {error}",
            scale * sum / n
        );
    }

    #[test]
    fn the_second_virial_changes_its_sign_near_a_temperature_of_three() {
        for (temperature, b2) in [(1.0, -3.08092), (2.0, -0.54071), (3.0, 0.06042)] {
            assert!((second_virial_of_square_well(1.5, 1.0, temperature) - b2).abs() < 0.51e-5);
        }
    }

    #[test]
    fn step_without_height_reflects_no_pairs() {
        assert_eq!(bounces_per_release(0.0, 1.0), 0.0);
        assert!((bounces_per_release(2.0, 1.0) - 6.389_056_098_930_65).abs() < 1e-14);
    }
}
