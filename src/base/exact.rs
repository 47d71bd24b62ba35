//! Sums that do not depend on the order of addition.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Bits per digit. Successive digits differ by a factor of `2^32`.
const BITS: u32 = 32;

/// Number of digits that hold every sum of finite numbers: from `2^-1074` to beyond `2^1024`.
const DIGITS: usize = 68;

/// Number of additions before carries are propagated. A digit below `2^63` changes by less than `2^32` per addition.
const MOST: u32 = 1 << 30;

/// Exact sum of floating-point numbers (a long accumulator; Kulisch and Miranker, SIAM Rev. 28, 1, 1986).
///
/// Terms are added as integers in units of the smallest number, so their order and grouping do not matter. If any terms
/// are not finite, the result is the sum of these terms.
#[derive(Debug, Clone, Copy)]
pub struct ExactSum {
    /// The value of the sum is `sum over k of digits[k] 2^(32 k - 1074)`.
    digits: [i64; DIGITS],
    additions: u32,
    infinite: f64,
}

impl Default for ExactSum {
    fn default() -> Self {
        Self { digits: [0; DIGITS], additions: 0, infinite: 0.0 }
    }
}

impl ExactSum {
    /// Adds a term.
    #[inline]
    pub fn add(&mut self, x: f64) {
        if x == 0.0 {
            return;
        }
        let bits = x.to_bits();
        let exponent = (bits >> 52) & 0x7ff;
        if exponent == 0x7ff {
            self.infinite += x;
            return;
        }
        // A subnormal number has the exponent of the smallest normal number, without the implicit leading bit.
        let place = exponent.max(1) - 1;
        let magnitude = (bits & ((1 << 52) - 1)) | u64::from(exponent > 0) << 52;
        #[expect(clippy::cast_possible_truncation, reason = "less than 2046")]
        let (first, shift) = (place as usize / BITS as usize, place as u32 % BITS);
        let (low, high) = (magnitude << shift, (magnitude >> 1) >> (63 - shift));
        // For a negative number, `sign` is -1 and `(digit ^ -1) + 1 = -digit`.
        let sign = bits.cast_signed() >> 63;
        let of = |digit: u64| (digit.cast_signed() ^ sign) - sign;
        if let Some([one, two, three]) = self.digits.get_mut(first..first + 3) {
            *one += of(low & u64::from(u32::MAX));
            *two += of(low >> BITS);
            *three += of(high);
        }
        self.additions += 1;
        if self.additions == MOST {
            self.carry();
        }
    }

    /// Adds a sum.
    pub fn merge(&mut self, other: &Self) {
        self.carry();
        let mut other = *other;
        other.carry();
        self.digits.iter_mut().zip(&other.digits).for_each(|(digit, more)| *digit += more);
        self.infinite += other.infinite;
        self.carry();
    }

    /// Subtracts a sum.
    pub fn subtract(&mut self, other: &Self) {
        self.carry();
        let mut other = *other;
        other.carry();
        self.digits.iter_mut().zip(&other.digits).for_each(|(digit, less)| *digit -= less);
        self.infinite -= other.infinite;
        self.carry();
    }

    /// Returns the sum, rounded once.
    #[must_use]
    pub fn total(&self) -> f64 {
        if self.infinite != 0.0 {
            return self.infinite;
        }
        let mut sum = *self;
        sum.carry();
        let is_negative = sum.digits[DIGITS - 1] < 0;
        if is_negative {
            sum.digits.iter_mut().for_each(|digit| *digit = -*digit);
            sum.carry();
        }
        let Some(last) = sum.digits.iter().rposition(|digit| *digit != 0) else { return 0.0 };
        let first = last.saturating_sub(2);
        let leading =
            sum.digits[first..=last].iter().rev().fold(0, |number, digit| (number << BITS) | i128::from(*digit));
        // Lower digits matter only for ties, so a single bit represents them.
        let is_more = sum.digits[..first].iter().any(|digit| *digit != 0);
        let rounded = (leading | i128::from(is_more)) as f64;
        #[expect(clippy::cast_possible_wrap, clippy::cast_possible_truncation, reason = "at most 68 digits")]
        let exponent = first as i32 * BITS as i32 - 1074;
        let total = libm::ldexp(rounded, exponent);
        if is_negative { -total } else { total }
    }

    /// Brings all digits but the last into the range from 0 to `2^32`, so that equal sums have equal digits.
    #[cold]
    fn carry(&mut self) {
        let mut carry = 0;
        for digit in &mut self.digits[..DIGITS - 1] {
            let whole = *digit + carry;
            carry = whole >> BITS;
            *digit = whole & ((1 << BITS) - 1);
        }
        self.digits[DIGITS - 1] += carry;
        self.additions = 0;
    }
}

impl PartialEq for ExactSum {
    fn eq(&self, other: &Self) -> bool {
        let (mut a, mut b) = (*self, *other);
        a.carry();
        b.carry();
        a.digits == b.digits && a.infinite.to_bits() == b.infinite.to_bits()
    }
}

impl From<f64> for ExactSum {
    fn from(x: f64) -> Self {
        let mut sum = Self::default();
        sum.add(x);
        sum
    }
}

impl Serialize for ExactSum {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut sum = *self;
        sum.carry();
        let digits: Vec<(u8, i64)> = (0..).zip(sum.digits).filter(|(_, digit)| *digit != 0).collect();
        (digits, sum.infinite).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for ExactSum {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let (digits, infinite) = <(Vec<(u8, i64)>, f64)>::deserialize(deserializer)?;
        let mut sum = Self { infinite, ..Self::default() };
        for (at, digit) in digits {
            *sum.digits.get_mut(usize::from(at)).ok_or_else(|| D::Error::custom("a sum has no such digit"))? = digit;
        }
        Ok(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::sum::Sum;
    use proptest::prelude::*;

    fn sum(terms: &[f64]) -> ExactSum {
        let mut sum = ExactSum::default();
        terms.iter().for_each(|x| sum.add(*x));
        sum
    }

    #[test]
    fn sums_are_rounded_once() {
        let tiny = f64::from_bits(1);
        for (terms, total) in [
            (vec![], 0.0),
            (vec![1e300, 1.0, -1e300], 1.0),
            (vec![1e308, 1e308, -1e308, -1e308, tiny], tiny),
            (vec![f64::MAX, f64::MAX, -f64::MAX], f64::MAX),
            (vec![f64::MAX, f64::MAX], f64::INFINITY),
            (vec![-f64::MAX, -f64::MAX], f64::NEG_INFINITY),
            // Exactly half a unit in the last place of 1 rounds to even; more rounds up, less rounds down.
            (vec![1.0, f64::EPSILON / 2.0], 1.0),
            (vec![1.0, f64::EPSILON / 2.0, tiny], 1.0 + f64::EPSILON),
            (vec![-1.0, -f64::EPSILON / 2.0, -tiny], -1.0 - f64::EPSILON),
            (vec![1.0, f64::EPSILON / 2.0, -tiny], 1.0),
            (vec![-0.1; 10], -1.0),
            (vec![tiny, f64::MIN_POSITIVE, -tiny], f64::MIN_POSITIVE),
            (vec![1.0, f64::INFINITY, -5.0], f64::INFINITY),
        ] {
            assert_eq!(sum(&terms).total(), total, "{terms:?}");
        }
        assert!(sum(&[f64::INFINITY, f64::NEG_INFINITY]).total().is_nan());
    }

    #[test]
    fn carries_are_propagated_before_overflow() {
        let mut one = sum(&[0.1; 1000]);
        one.additions = MOST - 3;
        let mut other = one;
        other.carry();
        for _ in 0..10 {
            one.add(-1e-7);
            other.add(-1e-7);
        }
        assert!(one == other && one.additions < 10);
    }

    proptest! {
        #[test]
        fn exact_sum_is_independent_of_order_and_grouping(
            terms in prop::collection::vec((-1.0..1.0_f64, -300..300_i32), 1..60),
            turned in 0..60_usize,
        ) {
            let terms: Vec<f64> = terms.into_iter().map(|(x, exponent)| libm::ldexp(x, exponent)).collect();
            let mut other = terms.clone();
            other.reverse();
            other.rotate_left(turned % terms.len());
            let whole = sum(&terms);
            prop_assert!(whole == sum(&other));
            prop_assert_eq!(whole.total().to_bits(), sum(&other).total().to_bits());
            let (first, second) = terms.split_at(turned % terms.len());
            let mut rest = whole;
            rest.subtract(&sum(first));
            prop_assert!(rest == sum(second));
            let mut compensated = Sum::default();
            terms.iter().for_each(|x| compensated.add(*x));
            let largest = terms.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
            let bound = f64::EPSILON * (whole.total().abs() + terms.len() as f64 * f64::EPSILON * largest * 60.0);
            prop_assert!((compensated.total() - whole.total()).abs() <= bound);
            let text = serde_json::to_string(&whole).unwrap();
            prop_assert!(serde_json::from_str::<ExactSum>(&text).unwrap() == whole);
        }
    }
}
