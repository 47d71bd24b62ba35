//! The discontinuities of potentials, read directly from the scene without any tables of an engine.

use crate::Vector;
use crate::model::potential::Potential;

/// The side of a discontinuity on which a pair is valid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Side {
    /// Valid pairs have larger distances.
    Positive,
    /// Valid pairs have smaller distances.
    Negative,
}

impl Side {
    pub fn sign(self) -> f64 {
        match self {
            Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    pub distance: f64,
    /// `dU`, the change of the potential energy in a crossing `[energy]`.
    pub energy: f64,
}

impl Step {
    /// Returns the inner ([`Side::Positive`]) or the outer ([`Side::Negative`]) discontinuity of a pair in a state.
    pub fn seen(potential: &Potential, state: usize, side: Side) -> Option<Self> {
        let (radii, energies) = (potential.radii(), potential.energies());
        let (radius, beyond) = match side {
            Side::Positive => (state, state + 1),
            Side::Negative => (state.checked_sub(1)?, state - 1),
        };
        Some(Self { distance: *radii.get(radius)?, energy: energies.get(beyond)? - energies.get(state)? })
    }

    pub fn is_barrier(&self) -> bool {
        self.energy == f64::INFINITY
    }
}

/// Returns position and velocity after a free flight: `r + v t + a t^2 / 2` and `v + a t`.
pub(super) fn fly(position: &Vector, velocity: &Vector, acceleration: &Vector, dt: f64) -> (Vector, Vector) {
    (position + velocity * dt + acceleration * (0.5 * dt * dt), velocity + acceleration * dt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pair_in_a_well_sees_its_edge_from_inside_and_the_core_from_outside() {
        let well = Potential::square_well(2.0, 1.5, 0.5).unwrap();
        let seen = |state, side| Step::seen(&well, state, side).map(|step| (step.distance, step.energy));
        assert_eq!(seen(0, Side::Positive), Some((3.0, -0.5)));
        assert_eq!(seen(0, Side::Negative), None);
        assert_eq!(seen(1, Side::Negative), Some((3.0, 0.5)));
        assert_eq!(seen(1, Side::Positive), Some((2.0, f64::INFINITY)));
        assert_eq!(seen(9, Side::Positive), None);
        assert_eq!(seen(9, Side::Negative), None);
    }
}
