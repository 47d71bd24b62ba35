//! Permitted magnitudes of quantities.

/// Largest magnitude of a quantity. The product of four such quantities is finite.
pub(crate) const LARGEST: f64 = 1e50;

/// Maximum number of particles. Each particle may need eight cells or neighbour-list slots, which have 32-bit numbers.
pub(crate) const MOST_PARTICLES: u64 = 500_000_000;

/// Reason why a setting is rejected: its name, its value, and what is expected.
pub(crate) type Invalid = (&'static str, f64, &'static str);

pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
