//! Magnitudes that quantities of a scene and of a simulation may have.

/// The largest magnitude of any quantity and, inverted, the smallest of those that must be positive: products of four, such
/// as the discriminants of event detection, stay finite.
pub(crate) const LARGEST: f64 = 1e50;

/// Whether a quantity that has to be positive is in range.
pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
