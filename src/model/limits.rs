//! Permitted magnitudes of quantities.

/// The largest magnitude of any quantity. The smallest positive magnitude is its inverse. Products of four quantities,
/// such as the discriminants of event detection, then stay finite.
pub(crate) const LARGEST: f64 = 1e50;

pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
