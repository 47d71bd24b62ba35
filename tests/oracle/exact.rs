use super::dyadic::Dyadic;
use super::polynomial::Polynomial;
use carom::Vector;
use carom::physics::overlap::Side;

/// Unit round-off: half the distance from 1 to the next floating-point number.
const ROUND_OFF: f64 = 0.5 * f64::EPSILON;

#[derive(Debug, Clone, Copy)]
pub struct State {
    pub position: Vector,
    pub velocity: Vector,
    pub acceleration: Vector,
    pub distance: f64,
}

/// An exact overlap function, in a box around the coefficients. The box contains every polynomial that a floating-point
/// evaluation may have used instead.
#[derive(Debug, Clone)]
pub struct Overlap {
    pub coefficients: Vec<Dyadic>,
    /// Half the width of the box for each coefficient.
    pub rounding: Vec<f64>,
}

impl Overlap {
    /// The overlap function `f+` or `f-` of a pair. `rounding[k]` is the product of three numbers: the number of
    /// roundings of a term with `t^k`, the unit round-off, and the sum of the absolute values of all terms (Higham,
    /// *Accuracy and Stability of Numerical Algorithms*, section 3.1).
    pub fn of_pair(state: &State, side: Side, roundings: [u32; 5]) -> Self {
        let State { position: r, velocity: v, acceleration: a, distance: s } = state;
        let (rr, vr, ar) = (dot(r, r), dot(v, r), dot(a, r));
        let (vv, av, aa) = (dot(v, v), dot(a, v), dot(a, a));
        let square = &Dyadic::from(*s) * &Dyadic::from(*s);
        let exact = [&rr.0 - &square, &vr.0 + &vr.0, &ar.0 + &vv.0, av.0, aa.0.half().half()];
        let sizes = [rr.1 + s * s, 2.0 * vr.1, ar.1 + vv.1, av.1, 0.25 * aa.1];
        let coefficients = exact.iter().map(|c| if side == Side::Positive { c.clone() } else { -c }).collect();
        Self { coefficients, rounding: boxes(&sizes, &roundings) }
    }

    /// The signed distance from a plane. The coefficients are exact.
    pub fn of_plane(height: f64, velocity: f64, acceleration: f64) -> Self {
        let coefficients = vec![Dyadic::from(height), Dyadic::from(velocity), Dyadic::from(acceleration).half()];
        let sizes = [height.abs(), velocity.abs(), 0.5 * acceleration.abs()];
        Self { coefficients, rounding: boxes(&sizes, &ROUNDINGS_OF_PLANE) }
    }

    pub fn polynomial(&self) -> Polynomial {
        Polynomial::new(&self.coefficients)
    }

    /// Returns a polynomial in the box. Coefficient `k` is shifted by `signs[k] rounding[k]`, with signs from -1 to 1.
    pub fn shifted(&self, signs: &[f64]) -> Polynomial {
        Polynomial::new(&self.moved(signs))
    }

    pub fn moved(&self, signs: &[f64]) -> Vec<Dyadic> {
        let moved = self.coefficients.iter().zip(&self.rounding).zip(signs);
        moved.map(|((c, d), s)| c + &(&Dyadic::from(*d) * &Dyadic::from(*s))).collect()
    }

    /// Returns the largest rounding error of `f` at `t >= 0`, `sum rounding_k t^k`.
    pub fn error_at(&self, t: f64) -> f64 {
        self.rounding.iter().rev().fold(0.0, |sum, d| sum * t + d)
    }

    pub fn error_of_derivative_at(&self, t: f64) -> f64 {
        let terms = self.rounding.iter().enumerate().skip(1);
        terms.rev().fold(0.0, |sum, (k, d)| sum * t + k as f64 * d)
    }
}

/// Roundings of each coefficient in Algorithms 2 and 3. A dot product of three terms has one multiplication and two
/// additions. `R2` has one more rounding for the subtraction of `s^2`. The discriminant `D = B^2 - V2 R2` rounds two
/// products, which adds half a rounding of `B` and one rounding of `R2`.
pub const ROUNDINGS_OF_QUADRATIC: [u32; 5] = [5, 4, 4, 0, 0];

/// Roundings of each coefficient in Algorithms 4 to 6. The coefficients `r.r - s^2` and `a.r + V2` have 4 roundings,
/// the others 3. Horner's rule adds `2 k + 1` roundings to the coefficient of `t^k`, but `2 k` to the coefficient of
/// `t^4`. The factor 3 in `f'` adds one rounding to the coefficient of `t^3`.
pub const ROUNDINGS_OF_QUARTIC: [u32; 5] = [4 + 1, 3 + 3, 4 + 5, 3 + 8, 3 + 8];

/// Roundings of each coefficient in Algorithm 1. It has more roundings than Algorithms 4 to 6: Horner's rule starts
/// from zero, and the integer factors of three more derivatives are rounded.
pub const ROUNDINGS_OF_GENERAL: [u32; 5] = [4 + 1, 3 + 3, 4 + 5 + 1, 3 + 7 + 2, 3 + 10 + 3];

/// Roundings of each coefficient for a plane. In `D = v^2 - 2 a h`, each product is rounded once.
const ROUNDINGS_OF_PLANE: [u32; 3] = [1, 1, 1];

/// Covers the rounding of the bounds.
const SLACK: f64 = 1.0 + 64.0 * f64::EPSILON;

fn boxes(sizes: &[f64], roundings: &[u32]) -> Vec<f64> {
    sizes.iter().zip(roundings).map(|(size, &n)| f64::from(n) * ROUND_OFF * size * SLACK).collect()
}

/// Returns the exact dot product, and the sum of the absolute values of the terms.
fn dot(a: &Vector, b: &Vector) -> (Dyadic, f64) {
    let mut sum = Dyadic::zero();
    for k in 0..3 {
        sum = &sum + &(&Dyadic::from(a[k]) * &Dyadic::from(b[k]));
    }
    (sum, (0..3).map(|k| (a[k] * b[k]).abs()).sum())
}
