//! Sums of harmonic functions over the directions to neighbours.

use crate::Vector;

const MOST_DEGREE: usize = 8;

/// The functions of degree `l`: spherical harmonics `Y_lm` in space, `exp(i l phi)` in a plane.
///
/// The functions are real, and their squares add up to 1 in any direction. The means over the neighbours of a particle
/// form a vector of length `q_l = sqrt(4 pi / (2 l + 1) sum_m |q_lm|^2)`, or `|psi_l|` in a plane.
#[derive(Debug, Clone)]
pub(super) struct Harmonics {
    degree: usize,
    plane: Option<[usize; 2]>,
    /// For each `m`, the coefficients of `sqrt((2 - delta_m0) (l - m)! / (l + m)!) d^m P_l / dz^m` as a polynomial in
    /// `z`.
    polynomials: Vec<Vec<f64>>,
}

impl Harmonics {
    /// Returns `None` in one dimension, or if the degree is not from 1 to 8.
    pub fn new(degree: usize, axes: &[usize]) -> Option<Self> {
        let plane = match *axes {
            [a, b] => Some([a, b]),
            [_, _, _] => None,
            _ => return None,
        };
        (1..=MOST_DEGREE).contains(&degree).then(|| Self { degree, plane, polynomials: polynomials(degree) })
    }

    pub fn count(&self) -> usize {
        if self.plane.is_some() { 2 } else { 2 * self.degree + 1 }
    }

    /// Adds the values of all functions in the direction of `separation` to `sums`.
    pub fn add(&self, separation: &Vector, sums: &mut [f64]) {
        let length = separation.norm();
        if length <= 0.0 {
            return;
        }
        let unit = separation / length;
        match self.plane {
            Some([a, b]) => {
                let power = (0..self.degree).fold([1.0, 0.0], |power, _| times(power, unit[a], unit[b]));
                sums.iter_mut().zip(power).for_each(|(sum, part)| *sum += part);
            }
            None => self.add_spherical(&unit, sums),
        }
    }

    fn add_spherical(&self, unit: &Vector, sums: &mut [f64]) {
        let mut power = [1.0, 0.0];
        for (m, polynomial) in self.polynomials.iter().enumerate() {
            let value = polynomial.iter().rev().fold(0.0, |value, coefficient| value * unit.z + coefficient);
            if m == 0 {
                sums[0] += value;
                continue;
            }
            // For a unit vector, (x + i y)^m = sin^m(theta) exp(i m phi).
            power = times(power, unit.x, unit.y);
            sums[2 * m - 1] += value * power[0];
            sums[2 * m] += value * power[1];
        }
    }
}

fn times([re, im]: [f64; 2], x: f64, y: f64) -> [f64; 2] {
    [re * x - im * y, re * y + im * x]
}

fn polynomials(degree: usize) -> Vec<Vec<f64>> {
    // Recurrence of the Legendre polynomials: n P_n = (2 n - 1) z P_(n-1) - (n - 1) P_(n-2).
    let (mut before, mut legendre) = (vec![0.0; degree + 1], vec![0.0; degree + 1]);
    legendre[0] = 1.0;
    for n in 1..=degree {
        let order = n as f64;
        let higher = |k: usize| if k == 0 { 0.0 } else { legendre[k - 1] };
        let term = |k: usize| ((2.0 * order - 1.0) * higher(k) - (order - 1.0) * before[k]) / order;
        let next = (0..=degree).map(term).collect();
        before = std::mem::replace(&mut legendre, next);
    }
    let mut derivative = legendre;
    let mut all = Vec::with_capacity(degree + 1);
    for m in 0..=degree {
        let factorials: f64 = (degree - m + 1..=degree + m).map(|k| k as f64).product();
        let scale = ((if m == 0 { 1.0 } else { 2.0 }) / factorials).sqrt();
        all.push(derivative.iter().map(|coefficient| scale * coefficient).collect());
        derivative = derivative.iter().enumerate().skip(1).map(|(k, coefficient)| k as f64 * coefficient).collect();
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_obey_the_addition_theorem() {
        // In this normalisation, the addition theorem is sum_m Y_lm(a) Y_lm(b) = P_l(a.b).
        let a = Vector::new(0.3, -0.8, 0.52).normalize();
        let b = Vector::new(-0.6, 0.1, 0.7).normalize();
        let x = a.dot(&b);
        let exact = [(4, (35.0 * x.powi(4) - 30.0 * x * x + 3.0) / 8.0), (2, 1.5 * x * x - 0.5), (1, x)];
        let sixth = (231.0 * x.powi(6) - 315.0 * x.powi(4) + 105.0 * x * x - 5.0) / 16.0;
        for (degree, exact) in exact.into_iter().chain([(6, sixth)]) {
            let harmonics = Harmonics::new(degree, &[0, 1, 2]).unwrap();
            let values = |direction: Vector| {
                let mut sums = vec![0.0; harmonics.count()];
                harmonics.add(&(3.0 * direction), &mut sums);
                sums
            };
            let (at_a, at_b) = (values(a), values(b));
            let sum = |p: &[f64], q: &[f64]| p.iter().zip(q).map(|(p, q)| p * q).sum::<f64>();
            // Some coefficients are large, such as 315/16, so round-off is larger.
            assert!((sum(&at_a, &at_a) - 1.0).abs() < 1e-13, "{degree}");
            assert!((sum(&at_a, &at_b) - exact).abs() < 1e-13, "{degree}");
        }
    }

    #[test]
    fn planar_harmonics_are_powers_of_a_phase() {
        let harmonics = Harmonics::new(6, &[0, 2]).unwrap();
        let mut sums = [0.0; 2];
        harmonics.add(&Vector::new(0.4_f64.cos(), 0.0, 0.4_f64.sin()), &mut sums);
        assert!((sums[0] - 2.4_f64.cos()).abs() < 1e-14 && (sums[1] - 2.4_f64.sin()).abs() < 1e-14);
        harmonics.add(&Vector::zeros(), &mut sums);
        assert!(sums.iter().all(|sum| sum.is_finite()));
        assert!(Harmonics::new(6, &[1]).is_none());
    }
}
