//! Lossy conversions between number types, with a defined result.
//!
//! Floating-point numbers are truncated towards zero. Numbers out of range become the smallest or largest integer, and
//! NaN becomes zero.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts from floating-point numbers saturate, as described above"
)]

#[inline]
pub(crate) fn trunc_to_usize(x: impl Into<f64>) -> usize {
    x.into() as usize
}

#[inline]
pub(crate) fn trunc_to_u64(x: impl Into<f64>) -> u64 {
    x.into() as u64
}

#[inline]
pub(crate) fn trunc_to_u32(x: impl Into<f64>) -> u32 {
    x.into() as u32
}

#[inline]
pub(crate) fn trunc_to_u16(x: impl Into<f64>) -> u16 {
    x.into() as u16
}

#[inline]
pub(crate) fn trunc_to_u8(x: impl Into<f64>) -> u8 {
    x.into() as u8
}

#[inline]
pub(crate) fn trunc_to_i8(x: impl Into<f64>) -> i8 {
    x.into() as i8
}

#[inline]
pub(crate) fn trunc_to_i64(x: impl Into<f64>) -> i64 {
    x.into() as i64
}

#[inline]
pub(crate) fn trunc_to_i32(x: impl Into<f64>) -> i32 {
    x.into() as i32
}

/// Whole numbers below this bound, `2^53`, are exact as floating-point numbers.
pub(crate) const MOST_EXACT: f64 = 9_007_199_254_740_992.0;

/// Rounds to single precision. Numbers out of range become infinite.
#[inline]
pub(crate) fn single(x: f64) -> f32 {
    x as f32
}

/// Converts an index to an id. Scenes have at most `MOST_PARTICLES` particles (`scene/limits.rs`).
#[inline]
#[cfg_attr(not(test), expect(clippy::expect_used, reason = "scenes with more are refused"))]
pub(crate) fn id(index: usize) -> u32 {
    u32::try_from(index).expect("a scene has fewer than 2^32 entries of each kind")
}

/// Counts beyond the largest index saturate; no array has more elements.
#[inline]
pub(crate) fn index(count: u64) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conversion_to_integers_saturates() {
        let beyond = [-1e300, -0.9, f64::NAN, 0.0, 254.9999, 1e300];
        assert_eq!(beyond.map(trunc_to_u8), [0, 0, 0, 0, 254, 255]);
        assert_eq!(beyond.map(trunc_to_u16), [0, 0, 0, 0, 254, u16::MAX]);
        assert_eq!(beyond.map(trunc_to_u32), [0, 0, 0, 0, 254, u32::MAX]);
        assert_eq!(beyond.map(trunc_to_u64), [0, 0, 0, 0, 254, u64::MAX]);
        assert_eq!(beyond.map(trunc_to_usize), [0, 0, 0, 0, 254, usize::MAX]);
        assert_eq!(beyond.map(trunc_to_i32), [i32::MIN, 0, 0, 0, 254, i32::MAX]);
        assert_eq!(beyond.map(trunc_to_i64), [i64::MIN, 0, 0, 0, 254, i64::MAX]);
    }

    #[test]
    fn single_rounds_to_nearest_f32() {
        assert_eq!([single(0.1), single(1e39), single(-1e-60)], [0.1, f32::INFINITY, -0.0]);
    }

    #[test]
    fn largest_id_is_the_largest_u32() {
        assert_eq!(id(0xffff_ffff), u32::MAX);
        assert!(std::panic::catch_unwind(|| id(0x1_0000_0000)).is_err());
    }
}
