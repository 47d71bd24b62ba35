//! Permitted magnitudes of quantities.

/// Largest magnitude of a quantity; the smallest is its inverse. Products of four quantities then stay finite.
pub(crate) const LARGEST: f64 = 1e50;

/// Maximum number of particles. A particle can need up to eight cells and eight slots in the blocks of neighbour lists,
/// and all of them must be numbered with 32 bits.
pub(crate) const MOST_PARTICLES: u64 = 500_000_000;

pub(crate) fn is_positive(value: f64) -> bool {
    (1.0 / LARGEST..=LARGEST).contains(&value)
}
