//! Renumbers the particles along a curve, so that particles close in space are close in memory.
//!
//! The ids of the scene do not change, and no output depends on the new numbers.

use crate::Vector;
use crate::base::numbers::trunc_to_u32;
use crate::model::space::Space;

/// Bits of a cell index along one axis.
const BITS: u32 = 10;

/// Returns the ids of the particles in the order of Morton's space-filling curve through the box.
pub(super) fn along_curve(space: &Space, positions: &[Vector]) -> Vec<u32> {
    let (mut lower, mut upper) = (space.lower, space.upper());
    for position in positions {
        lower = lower.inf(position);
        upper = upper.sup(position);
    }
    // The cells of the curve are cubes.
    let per_cell = f64::from(1_u32 << BITS) / (upper - lower).max();
    let key = |position: &Vector| {
        let index = |k: usize| trunc_to_u32((position[k] - lower[k]) * per_cell).min((1 << BITS) - 1);
        spread(index(0)) | spread(index(1)) << 1 | spread(index(2)) << 2
    };
    let mut keyed: Vec<(u32, u32)> = positions.iter().zip(0..).map(|(position, id)| (key(position), id)).collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, id)| id).collect()
}

/// Inserts two zero bits after each of the lowest ten bits.
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spread_puts_two_zero_bits_between_bits() {
        assert_eq!(spread(0b11_1111_1111), 0b1001_0010_0100_1001_0010_0100_1001);
        assert_eq!(spread(0b101), 0b100_0001);
    }

    #[test]
    fn the_curve_visits_one_octant_after_the_other() {
        let space = Space::periodic_cube(8.0);
        let at = |k: u32| f64::from(k) + 0.5;
        let positions: Vec<_> = (0..512).map(|k| Vector::new(at(k % 8), at(k / 8 % 8), at(k / 64))).collect();
        let order = along_curve(&space, &positions);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..512).collect::<Vec<_>>());
        for octant in order.chunks(64) {
            let half = |id: &u32| positions[*id as usize].map(|x| x > 4.0);
            assert!(octant.iter().all(|id| half(id) == half(&octant[0])));
        }
    }
}
