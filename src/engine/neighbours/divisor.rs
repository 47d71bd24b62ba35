//! Fast division by a number of cells.

use serde::{Deserialize, Serialize};

/// A divisor that is used many times. A multiplication replaces the division, because it is several times as fast.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Divisor {
    by: u32,
    /// Inverse of the divisor: `2^64 / by`, rounded up. The value 0 stands for `2^64`.
    inverse: u64,
}

impl Divisor {
    pub fn new(by: u32) -> Self {
        Self { by, inverse: (u64::MAX / u64::from(by)).wrapping_add(1) }
    }

    /// Returns the quotient and the remainder. They are exact, because the relative error of the inverse is positive
    /// and below `2^-32`.
    #[inline]
    pub fn divide(self, x: u32) -> [u32; 2] {
        #[expect(clippy::cast_possible_truncation, reason = "the quotient of an x of 32 bits")]
        let quotient = if self.by == 1 { x } else { ((u128::from(x) * u128::from(self.inverse)) >> 64) as u32 };
        [quotient, x - quotient * self.by]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisor_matches_integer_division() {
        for by in [1, 2, 3, 5, 7, 64, 641, 65_535, 65_536, 65_537, u32::MAX - 1, u32::MAX] {
            for x in [0, 1, 2, by - 1, by, by.saturating_add(1), by.wrapping_mul(3), 1 << 31, u32::MAX - 1, u32::MAX] {
                assert_eq!(Divisor::new(by).divide(x), [x / by, x % by], "{x} / {by}");
            }
        }
    }
}
