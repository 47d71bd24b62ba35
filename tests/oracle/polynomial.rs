//! Polynomials with exact coefficients.

use super::dyadic::{Dyadic, sign};
use num_bigint::BigInt;

/// `2^exponent (c_0 + c_1 t + ...)` with integers `c_k`. The last integer is not zero.
#[derive(Debug, Clone)]
pub struct Polynomial {
    pub coefficients: Vec<BigInt>,
    pub exponent: i64,
}

impl Polynomial {
    pub fn new(coefficients: &[Dyadic]) -> Self {
        let exponent = coefficients.iter().filter(|c| c.sign() != 0).map(|c| c.exponent).min().unwrap_or(0);
        let integer = |c: &Dyadic| if c.sign() == 0 { BigInt::ZERO } else { c.in_units_of(exponent) };
        Self::of_integers(coefficients.iter().map(integer).collect(), exponent)
    }

    pub fn from_floats(coefficients: &[f64]) -> Self {
        Self::new(&coefficients.iter().map(|&c| Dyadic::from(c)).collect::<Vec<_>>())
    }

    pub fn of_integers(mut coefficients: Vec<BigInt>, exponent: i64) -> Self {
        while coefficients.last().is_some_and(|c| sign(c) == 0) {
            coefficients.pop();
        }
        Self { coefficients, exponent }
    }

    pub fn is_zero(&self) -> bool {
        self.coefficients.is_empty()
    }

    pub fn degree(&self) -> usize {
        self.coefficients.len().saturating_sub(1)
    }

    pub fn derivative(&self) -> Self {
        let coefficients = self.coefficients.iter().enumerate().skip(1).map(|(k, c)| c * k as u64).collect();
        Self { coefficients, exponent: self.exponent }
    }

    /// Returns the value at `x = m 2^k`, by Horner's rule in integers. If `k < 0`, all terms are multiplied by `2^(-k
    /// degree)`.
    pub fn value(&self, x: &Dyadic) -> Dyadic {
        let mut value = BigInt::ZERO;
        for scaled in self.scaled(x.exponent).iter().rev() {
            value = value * &x.mantissa + scaled;
        }
        Dyadic { mantissa: value, exponent: self.scaled_exponent(x.exponent) }
    }

    pub fn sign_at(&self, x: &Dyadic) -> i32 {
        match x.sign() {
            0 => self.coefficients.first().map_or(0, sign),
            _ => self.value(x).sign(),
        }
    }

    /// Returns the sign just after `x`. This is the sign of the first derivative that is not zero at `x`.
    pub fn sign_after(&self, x: &Dyadic) -> i32 {
        if self.is_zero() {
            return 0;
        }
        match self.sign_at(x) {
            0 => self.derivative().sign_after(x),
            sign => sign,
        }
    }

    /// Returns the sign for large positive arguments.
    pub fn sign_far_away(&self) -> i32 {
        self.coefficients.last().map_or(0, sign)
    }

    /// Expands the polynomial around `x = m 2^e` as `f((m + y) 2^e) = 2^exponent (d_0 + d_1 y + ...)`.
    pub fn around(&self, x: &Dyadic) -> Self {
        let mut d = self.scaled(x.exponent);
        for first in 0..d.len() {
            for k in (first..d.len() - 1).rev() {
                let carried = &d[k + 1] * &x.mantissa;
                d[k] += carried;
            }
        }
        Self { coefficients: d, exponent: self.scaled_exponent(x.exponent) }
    }

    /// Returns the coefficients as a function of `y = x / 2^e`, scaled to integers.
    fn scaled(&self, e: i64) -> Vec<BigInt> {
        let n = self.degree();
        let shift = |k: usize| if e < 0 { e.unsigned_abs() * (n - k) as u64 } else { e as u64 * k as u64 };
        self.coefficients.iter().enumerate().map(|(k, c)| c << shift(k)).collect()
    }

    fn scaled_exponent(&self, e: i64) -> i64 {
        self.exponent + e.min(0) * self.degree() as i64
    }

    /// Returns the number of sign changes between coefficients. By Descartes' rule, this is the number of positive
    /// roots with multiplicity, or larger by an even number.
    pub fn variations(&self) -> usize {
        count_variations(self.coefficients.iter().map(sign))
    }

    /// Returns a `k` such that all real roots are below `2^k`. Fujiwara's bound is twice the largest `|c_{n-i} /
    /// c_n|^(1/i)`.
    pub fn bound_of_roots(&self) -> i64 {
        let n = self.degree();
        let bits = |k: usize| self.coefficients[k].bits() as i64;
        let nonzero = (0..n).filter(|&k| sign(&self.coefficients[k]) != 0);
        // If `c_k` has `bits_k` bits, then `|c_k / c_n| < 2^(bits_k - bits_n + 1)`. The quotient is rounded up.
        let exponents = nonzero.map(|k| (bits(k) - bits(n) + 1).div_euclid((n - k) as i64) + 1);
        exponents.max().unwrap_or(0) + 1
    }

    /// Returns a `k` such that no positive root is below `2^k`.
    pub fn bound_of_positive_roots_below(&self) -> i64 {
        let reversed: Vec<_> = self.coefficients.iter().rev().cloned().collect();
        -Self::of_integers(reversed, 0).bound_of_roots()
    }
}

pub fn count_variations(signs: impl Iterator<Item = i32>) -> usize {
    let (mut count, mut last) = (0, 0);
    for sign in signs.filter(|&s| s != 0) {
        count += usize::from(sign == -last);
        last = sign;
    }
    count
}
