//! Permitted magnitudes of quantities.

/// The largest magnitude of any quantity, and the inverse of the smallest positive one. Products of four
/// quantities, such as the discriminants of event detection, then stay finite.
pub(crate) const LARGEST: f64 = 1e50;

/// Whether a quantity that must be positive is in range.
pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
