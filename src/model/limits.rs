//! Permitted magnitudes of quantities.

/// Largest magnitude of a quantity; the smallest is its inverse. Products of four quantities then stay finite.
pub(crate) const LARGEST: f64 = 1e50;

pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
