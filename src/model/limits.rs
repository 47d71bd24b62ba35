//! Permitted magnitudes of quantities.

/// Largest magnitude of a quantity. The product of four such quantities is finite.
pub(crate) const LARGEST: f64 = 1e50;

/// Maximum number of particles. Up to eight cells and neighbour-list slots per particle are numbered with 32 bits.
pub(crate) const MOST_PARTICLES: u64 = 500_000_000;

pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
