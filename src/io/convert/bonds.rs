use std::collections::HashMap;

use super::FrameError;
use crate::trajectory::Frame;

/// Returns the indices of the two particles of each bond in `frame.particles`.
pub(in crate::io) fn bond_ends(frame: &Frame) -> Result<Vec<[u32; 2]>, FrameError> {
    if frame.bonds.is_empty() {
        return Ok(Vec::new());
    }
    let mut place_of = HashMap::with_capacity(frame.particles.len());
    for (place, particle) in (0_u32..).zip(&frame.particles) {
        if place_of.insert(particle.id, place).is_some() {
            return Err(FrameError::RepeatedId(particle.id));
        }
    }
    let place = |id| place_of.get(id).copied().ok_or(FrameError::NoBondEnd(*id));
    frame.bonds.iter().map(|[a, b]| Ok([place(a)?, place(b)?])).collect()
}
