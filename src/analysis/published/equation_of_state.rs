//! Compressibility factors `Z = P / (rho T)` of hard particles.

/// Coefficients of the mKLM equation, by powers of `x = phi / (1 - phi)`.
const MKLM: [(i32, f64); 12] = [
    (0, 1.0),
    (1, 4.0),
    (2, 6.0),
    (3, 2.364_768_4),
    (4, -0.869_855_1),
    (5, 1.106_280_3),
    (6, -1.101_422_1),
    (7, 0.666_058_66),
    (8, -0.036_334_31),
    (10, -0.209_651_64),
    (14, 0.105_555_69),
    (22, -0.008_723_80),
];

/// Hard-sphere fluid: the mKLM equation, for `phi < 0.53`. It is as accurate as the simulations to which it was fitted.
///
/// `Z = 1 + 4 x + 6 x^2 + 2.3647684 x^3 - ...`, `x = phi / (1 - phi)`: Pieprzyk, Bannerman, Branka, Chudak and
/// Heyes, Phys. Chem. Chem. Phys. 21, 6886 (2019), [doi:10.1039/C9CP00903E](https://doi.org/10.1039/C9CP00903E).
#[must_use]
#[doc(alias = "mKLM")]
pub fn hard_spheres(packing_fraction: f64) -> f64 {
    let x = packing_fraction / (1.0 - packing_fraction);
    MKLM.iter().map(|&(power, coefficient)| coefficient * whole_power(x, power)).sum()
}

/// Hard-sphere fluid: `Z = (1 + phi + phi^2 - phi^3) / (1 - phi)^3`, within 0.3 % for stable densities.
///
/// Carnahan and Starling, J. Chem. Phys. 51, 635 (1969), [doi:10.1063/1.1672048](https://doi.org/10.1063/1.1672048).
#[must_use]
pub fn carnahan_starling(packing_fraction: f64) -> f64 {
    let phi = packing_fraction;
    let free = 1.0 - phi;
    (1.0 + phi + phi * phi - phi * phi * phi) / (free * free * free)
}

/// Hard-sphere crystal, face-centred cubic: `Z = 3 / (1 - z) - 0.5921 (z - 0.7072) / (z - 0.601)`,
/// `z = rho sigma^3 / sqrt(2)`.
///
/// Speedy, J. Phys.: Condens. Matter 10, 4387 (1998),
/// [doi:10.1088/0953-8984/10/20/006](https://doi.org/10.1088/0953-8984/10/20/006).
#[must_use]
pub fn face_centred_cubic(packing_fraction: f64) -> f64 {
    let z = packing_fraction * (6.0 / std::f64::consts::PI) / std::f64::consts::SQRT_2;
    3.0 / (1.0 - z) - 0.5921 * (z - 0.7072) / (z - 0.601)
}

/// Hard-disk fluid: `Z = (1 + eta^2/8 + eta^3/18 - 4 eta^4/21) / (1 - eta)^2`, `eta = pi rho sigma^2 / 4`.
///
/// The form of Henderson, Mol. Phys. 30, 971 (1975),
/// [doi:10.1080/00268977500102511](https://doi.org/10.1080/00268977500102511), with two more terms.
#[must_use]
pub fn hard_disks(packing_fraction: f64) -> f64 {
    let eta = packing_fraction;
    let square = eta * eta;
    let free = 1.0 - eta;
    (1.0 + square / 8.0 + square * eta / 18.0 - 4.0 * square * square / 21.0) / (free * free)
}

/// Hard rods on a line, exact: `Z = 1 / (1 - rho sigma)`.
///
/// Tonks, Phys. Rev. 50, 955 (1936), [doi:10.1103/PhysRev.50.955](https://doi.org/10.1103/PhysRev.50.955).
#[must_use]
pub fn tonks(packing_fraction: f64) -> f64 {
    1.0 / (1.0 - packing_fraction)
}

/// Repeated multiplication rounds the same way on all machines, unlike the powers of the standard library.
fn whole_power(x: f64, power: i32) -> f64 {
    (0..power).fold(1.0, |product, _| product * x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(value: f64, expected: f64, digits: i32) {
        assert!((value - expected).abs() < 0.51 * 0.1_f64.powi(digits), "{value} instead of {expected}");
    }

    #[test]
    fn hard_spheres_have_their_published_pressure() {
        let table = [(0.1, 1.52165), (0.2, 2.40940), (0.3, 3.98398), (0.4, 6.94546), (0.45, 9.40411), (0.49, 12.17036)];
        for (phi, z) in table {
            assert_near(hard_spheres(phi), z, 5);
            assert!((carnahan_starling(phi) / z - 1.0).abs() < 0.003, "phi = {phi}");
        }
        assert_eq!((hard_spheres(0.0), carnahan_starling(0.0)), (1.0, 1.0));
    }

    #[test]
    fn crystal_and_fluid_coexist_at_one_pressure() {
        let sixth = std::f64::consts::PI / 6.0;
        let (melting, freezing) = (1.0376, 0.9392);
        assert_near(melting * face_centred_cubic(melting * sixth), 11.566, 3);
        // The published freezing density is rounded to 1e-4, and the slope dP/drho is about 50.
        let fluid = freezing * hard_spheres(freezing * sixth);
        assert!((fluid - 11.566).abs() < 0.5e-4 * 50.0, "{fluid}");
    }

    #[test]
    fn hard_disk_and_rod_pressures_match_published_values() {
        for (eta, z) in [(0.3, 2.06369), (0.5, 4.10516), (0.6, 6.45196)] {
            assert_near(hard_disks(eta), z, 5);
        }
        assert_eq!(tonks(0.75), 4.0);
    }
}
