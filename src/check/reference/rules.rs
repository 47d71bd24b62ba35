//! The discontinuities that a pair in a given state can reach (paper, figures 1 and 2).

use crate::model::potential::Potential;

/// The side of a discontinuity on which the valid states of a pair lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Side {
    /// Valid states are at larger distances. The overlap function is `f+`, and the outcomes are Core and Capture.
    Positive,
    /// Valid states are at smaller distances. The overlap function is `f-`, and the outcomes are Bounce and Release.
    Negative,
}

impl Side {
    /// Returns 1 for the positive side and -1 for the negative side. The overlap function is `f+` times this sign.
    #[must_use]
    pub fn sign(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

/// A discontinuity of a potential, approached from one side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Discontinuity {
    pub distance: f64,
    /// `dU`, the energy needed to cross the discontinuity `[energy]`.
    pub energy_step: f64,
}

/// Returns a discontinuity of a pair in state `k`, with the energy `U_k`. A pair on the positive side sees the
/// discontinuity at the smaller distance `s_{k+1}`. A pair on the negative side sees the discontinuity at the larger
/// distance `s_k`.
pub(super) fn seen(potential: &Potential, k: usize, side: Side) -> Option<Discontinuity> {
    let (s, u) = (potential.radii(), potential.energies());
    // The lists count from 0: `s_1` is `s[0]`, and `U_0` is `u[0]`.
    let (radius, beyond) = match side {
        Side::Positive => (k, k + 1),
        Side::Negative => (k.checked_sub(1)?, k - 1),
    };
    Some(Discontinuity { distance: *s.get(radius)?, energy_step: u.get(beyond)? - u.get(k)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(potential: &Potential) -> Vec<[Option<(f64, f64)>; 2]> {
        let of = |k, side| seen(potential, k, side).map(|seen| (seen.distance, seen.energy_step));
        (0..=potential.radii().len()).map(|k| [of(k, Side::Negative), of(k, Side::Positive)]).collect()
    }

    #[test]
    fn a_pair_in_state_k_sees_radius_k_from_inside_and_the_next_from_outside() {
        let inf = f64::INFINITY;
        let well = Potential::square_well(2.0, 1.5, 0.5).unwrap();
        assert_eq!(
            all(&well),
            [[None, Some((3.0, -0.5))], [Some((3.0, 0.5)), Some((2.0, inf))], [Some((2.0, -inf)), None]]
        );
        let bond = Potential::bond(1.0, 1.5).unwrap();
        assert_eq!(all(&bond)[1], [Some((1.5, inf)), Some((1.0, inf))]);
        let steps = Potential::new(vec![4.0, 2.0, 1.0], vec![0.0, 0.25, -1.0, 3.0]).unwrap();
        assert_eq!(all(&steps)[2], [Some((2.0, 1.25)), Some((1.0, 4.0))]);
        assert_eq!(all(&steps)[3], [Some((1.0, -4.0)), None]);
    }
}
