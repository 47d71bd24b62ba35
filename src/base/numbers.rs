//! Numbers from others that hold more: the one place where a conversion may cut something off, and what it does then.
//!
//! From a floating-point number, those to integers cut towards zero, as a histogram bin or a grid cell wants it. What is beyond the
//! integers of the type becomes the nearest of them, and what is not a number becomes zero.
#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "casts from floating-point numbers saturate, as is said above"
)]

/// The whole part of a number: an index.
#[inline]
pub(crate) fn trunc_to_usize(x: impl Into<f64>) -> usize {
    x.into() as usize
}

/// The whole part of a number: a count.
#[inline]
pub(crate) fn trunc_to_u64(x: impl Into<f64>) -> u64 {
    x.into() as u64
}

/// The whole part of a number: a count or an index that is kept in few bytes.
#[inline]
pub(crate) fn trunc_to_u32(x: impl Into<f64>) -> u32 {
    x.into() as u32
}

/// The whole part of a number: a step of a scale.
#[inline]
pub(crate) fn trunc_to_u16(x: impl Into<f64>) -> u16 {
    x.into() as u16
}

/// The whole part of a number: a step of a coarse scale.
#[inline]
pub(crate) fn trunc_to_u8(x: impl Into<f64>) -> u8 {
    x.into() as u8
}

/// The whole part of a number of either sign: a cell of a grid without ends.
#[inline]
pub(crate) fn trunc_to_i64(x: impl Into<f64>) -> i64 {
    x.into() as i64
}

/// The whole part of a number of either sign: a power, or a number of periods.
#[inline]
pub(crate) fn trunc_to_i32(x: impl Into<f64>) -> i32 {
    x.into() as i32
}

/// In single precision, rounded to the nearest; beyond its largest number infinite.
#[inline]
pub(crate) fn single(x: f64) -> f32 {
    x as f32
}

/// The number that stands for an index in a scene: of its particles there are at most `MOST_PARTICLES` (`scene/limits.rs`), of all else fewer.
///
/// # Panics
/// If the index is not one of a scene.
#[inline]
#[cfg_attr(not(test), expect(clippy::expect_used, reason = "scenes with more are refused"))]
pub(crate) fn id(index: usize) -> u32 {
    u32::try_from(index).expect("a scene numbers what it holds with 32 bits")
}

/// The largest index stands for all counts beyond it: of more there cannot be any.
#[inline]
pub(crate) fn index(count: u64) -> usize {
    usize::try_from(count).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_parts_saturate() {
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
    fn single_precision_is_the_nearest() {
        assert_eq!([single(0.1), single(1e39), single(-1e-60)], [0.1, f32::INFINITY, -0.0]);
    }

    #[test]
    fn the_last_id_is_that_of_32_bits() {
        assert_eq!(id(0xffff_ffff), u32::MAX);
        assert!(std::panic::catch_unwind(|| id(0x1_0000_0000)).is_err());
    }
}
