//! Exact numbers `m 2^e`. All floating-point numbers have this form, and so do their sums and products.

use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;
use std::ops::{Add, Mul, Neg, Sub};

#[derive(Debug, Clone)]
pub struct Dyadic {
    pub mantissa: BigInt,
    pub exponent: i64,
}

impl Dyadic {
    pub fn zero() -> Self {
        Self { mantissa: BigInt::ZERO, exponent: 0 }
    }

    pub fn power_of_two(exponent: i64) -> Self {
        Self { mantissa: BigInt::from(1), exponent }
    }

    /// Returns the integer `n` for which this number is `n 2^exponent`. Requires `exponent <= self.exponent`.
    pub fn in_units_of(&self, exponent: i64) -> BigInt {
        &self.mantissa << (self.exponent - exponent) as u64
    }

    pub fn half(&self) -> Self {
        Self { mantissa: self.mantissa.clone(), exponent: self.exponent - 1 }
    }

    pub fn sign(&self) -> i32 {
        sign(&self.mantissa)
    }

    /// Returns the `k` with `2^(k-1) <= |x| < 2^k`. Requires `x != 0`.
    pub fn magnitude(&self) -> i64 {
        self.mantissa.bits() as i64 + self.exponent
    }

    /// Returns `(m, e)` with `x = m 2^e` and `0.5 <= |m| <= 1`. Rounds `m` towards zero to 53 bits.
    pub fn approximate(&self) -> (f64, i64) {
        let bits = self.mantissa.bits();
        if bits == 0 {
            return (0.0, 0);
        }
        let excess = bits.saturating_sub(53);
        let leading: u64 = (self.mantissa.magnitude() >> excess).try_into().expect("53 bits");
        let kept = bits - excess;
        let m = leading as f64 / (1_u64 << kept) as f64;
        (m * f64::from(self.sign()), bits as i64 + self.exponent)
    }

    /// Converts to a floating-point number, rounded towards zero. Returns infinity or zero out of range.
    pub fn to_f64(&self) -> f64 {
        let (m, e) = self.approximate();
        scaled(m, e)
    }
}

/// Returns `m 2^e` as a floating-point number. Returns infinity or zero out of range.
pub fn scaled(m: f64, e: i64) -> f64 {
    #[expect(clippy::cast_possible_truncation, reason = "3000 at most")]
    let exponent = e.clamp(-3000, 3000) as i32;
    libm::scalbn(m, exponent)
}

pub fn sign(x: &BigInt) -> i32 {
    match x.sign() {
        Sign::Minus => -1,
        Sign::NoSign => 0,
        Sign::Plus => 1,
    }
}

impl From<f64> for Dyadic {
    fn from(x: f64) -> Self {
        assert!(x.is_finite(), "{x} is no number");
        if x == 0.0 {
            return Self::zero();
        }
        let (bits, biased) = (x.to_bits() & ((1 << 52) - 1), (x.to_bits() >> 52) & 0x7ff);
        let (m, e) = if biased == 0 { (bits, -1074) } else { (bits | 1 << 52, biased as i64 - 1075) };
        let zeros = m.trailing_zeros();
        let magnitude = BigInt::from(m >> zeros);
        Self { mantissa: if x < 0.0 { -magnitude } else { magnitude }, exponent: e + i64::from(zeros) }
    }
}

impl Add for &Dyadic {
    type Output = Dyadic;
    fn add(self, other: &Dyadic) -> Dyadic {
        if self.sign() == 0 {
            return other.clone();
        }
        if other.sign() == 0 {
            return self.clone();
        }
        let exponent = self.exponent.min(other.exponent);
        Dyadic { mantissa: self.in_units_of(exponent) + other.in_units_of(exponent), exponent }
    }
}

impl Neg for &Dyadic {
    type Output = Dyadic;
    fn neg(self) -> Dyadic {
        Dyadic { mantissa: -&self.mantissa, exponent: self.exponent }
    }
}

impl Sub for &Dyadic {
    type Output = Dyadic;
    fn sub(self, other: &Dyadic) -> Dyadic {
        self + &-other
    }
}

impl Mul for &Dyadic {
    type Output = Dyadic;
    fn mul(self, other: &Dyadic) -> Dyadic {
        Dyadic { mantissa: &self.mantissa * &other.mantissa, exponent: self.exponent + other.exponent }
    }
}

impl PartialEq for Dyadic {
    fn eq(&self, other: &Self) -> bool {
        (self - other).sign() == 0
    }
}

impl PartialOrd for Dyadic {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some((self - other).sign().cmp(&0))
    }
}
