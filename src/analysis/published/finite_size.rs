//! Corrections for a fixed, finite number of particles.
//!
//! A periodic system has a fixed number of particles `N`, which would fluctuate in an equal volume of an infinite
//! fluid. To first order in `1 / N`, any mean `A` becomes `A_N = A - (1/2) <dN^2> d^2A/dN^2`, with
//! `<dN^2> = N T drho/dP` (Lebowitz and Percus, Phys. Rev. 122, 1675, 1961). For the virial part of the pressure,
//! `A = rho (Z - 1)`, the result is `Z_N = Z - rho P'' / (2 N P')`, where primes are derivatives with respect to `rho`.
//! For a dilute gas, `Z_N - 1 = (1 - 1 / N) B_2 rho` is exact.

/// Returns `rho P'' / (2 P')` of an equation of state, where `P = phi Z(phi)`.
fn curvature(compressibility: fn(f64) -> f64, packing_fraction: f64) -> f64 {
    // With a relative step of 1e-3, the relative error is about 1e-6.
    let step = 1e-3 * packing_fraction;
    let [below, here, above] =
        [-step, 0.0, step].map(|d| (packing_fraction + d) * compressibility(packing_fraction + d));
    let first = (above - below) / (2.0 * step);
    let second = (above - 2.0 * here + below) / (step * step);
    packing_fraction * second / (2.0 * first)
}

/// Relative reduction of `Z - 1`, and of the number of contacts, in a finite system. It is 0 at zero density.
pub(crate) fn fewer_contacts(compressibility: fn(f64) -> f64, packing_fraction: f64, count: u64) -> f64 {
    let fewer =
        curvature(compressibility, packing_fraction) / (count as f64 * (compressibility(packing_fraction) - 1.0));
    if fewer.is_finite() { fewer } else { 0.0 }
}

/// Relative difference between the contact values `g` of a finite and of an infinite fluid. A finite system has fewer
/// contacts, but also fewer pairs, by which `g` is divided.
pub(crate) fn shift_of_contact_value(compressibility: fn(f64) -> f64, packing_fraction: f64, count: u64) -> f64 {
    1.0 / count as f64 - fewer_contacts(compressibility, packing_fraction, count)
}

pub(crate) const FINITE: &str = "first order in 1/N, by Lebowitz and Percus, Phys. Rev. 122, 1675 (1961)";

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::published;

    #[test]
    fn dilute_gas_has_one_part_in_n_fewer_contacts() {
        let fewer = fewer_contacts(published::hard_spheres, 1e-4, 100);
        assert!((fewer - 0.01).abs() < 0.01 * 1e-3, "{fewer}");
        assert!(shift_of_contact_value(published::hard_spheres, 1e-4, 100).abs() < 1e-5);
    }

    #[test]
    fn the_curvature_is_that_of_carnahan_and_starling() {
        // By hand at `phi = 0.4`: `P' = 3.0096 / 0.6^4` and `P'' phi = 0.4 (5.536 / 0.6^4 + 4 P' / 0.6)`.
        let first = 3.0096 / 0.1296;
        let second = 0.4 * (5.536 / 0.1296 + 4.0 * first / 0.6);
        let by_hand = second / (2.0 * first);
        assert!((curvature(published::carnahan_starling, 0.4) / by_hand - 1.0).abs() < 1e-5);
    }
}
