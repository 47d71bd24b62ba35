//! Permitted magnitudes of quantities.

/// Largest magnitude of a quantity. The product of four such quantities is finite.
pub(crate) const LARGEST: f64 = 1e50;

/// Maximum number of particles. Each particle may need eight cells or neighbour-list slots, which have 32-bit numbers.
pub(crate) const MOST_PARTICLES: u64 = 500_000_000;

pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
