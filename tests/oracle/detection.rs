//! Calls the detection functions as the engine does.

use crate::exact::{Overlap, ROUNDINGS_OF_GENERAL, ROUNDINGS_OF_QUADRATIC, ROUNDINGS_OF_QUARTIC, State};
use carom::check::reference::{self, Polynomial};
use carom::physics::detection::{accelerated, inertial, plane};
use carom::physics::motion::RelativeState;
use carom::physics::overlap::{Quadratic, Quartic, Side};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Algorithm {
    /// Algorithm 2.
    InertialPositive,
    /// Algorithm 3.
    InertialNegative,
    /// Algorithm 4.
    AcceleratedPositive,
    /// Algorithms 5 and 6.
    AcceleratedNegative,
    /// The detection function for planes. The height is the first coordinate of the separation.
    Plane,
    /// Algorithm 1, as used by the reference engine.
    General(Side),
}

impl Algorithm {
    pub const ALL: [Self; 7] = [
        Self::InertialPositive,
        Self::InertialNegative,
        Self::AcceleratedPositive,
        Self::AcceleratedNegative,
        Self::Plane,
        Self::General(Side::Positive),
        Self::General(Side::Negative),
    ];

    pub fn name(self) -> &'static str {
        match self {
            Self::InertialPositive => "2 (inertial, f+)",
            Self::InertialNegative => "3 (inertial, f-)",
            Self::AcceleratedPositive => "4 (accelerated, f+)",
            Self::AcceleratedNegative => "5, 6 (accelerated, f-)",
            Self::Plane => "plane",
            Self::General(Side::Positive) => "1 (reference, f+)",
            Self::General(Side::Negative) => "1 (reference, f-)",
        }
    }

    /// `Some(true)` requires a relative acceleration, and `Some(false)` excludes it.
    pub fn takes_acceleration(self) -> Option<bool> {
        match self {
            Self::InertialPositive | Self::InertialNegative => Some(false),
            Self::AcceleratedPositive | Self::AcceleratedNegative => Some(true),
            Self::Plane | Self::General(_) => None,
        }
    }

    pub fn side(self) -> Side {
        match self {
            Self::InertialNegative | Self::AcceleratedNegative => Side::Negative,
            Self::General(side) => side,
            _ => Side::Positive,
        }
    }

    pub fn ask(self, state: &State) -> Option<f64> {
        match self {
            Self::InertialPositive => inertial::positive(&quadratic(state)),
            Self::InertialNegative => inertial::negative(&quadratic(state)),
            Self::AcceleratedPositive | Self::AcceleratedNegative => {
                accelerated::next_event(&quartic(state), self.side())
            }
            Self::Plane => {
                let [height, velocity, acceleration] = height(state);
                plane::next_event(height, velocity, acceleration)
            }
            Self::General(side) => {
                let side = if side == Side::Positive { reference::Side::Positive } else { reference::Side::Negative };
                let State { position, velocity, acceleration, distance } = state;
                reference::next_event(&Polynomial::overlap(side, *distance, position, velocity, acceleration))
            }
        }
    }

    pub fn overlap(self, state: &State) -> Overlap {
        match self {
            Self::Plane => {
                let [height, velocity, acceleration] = height(state);
                Overlap::of_plane(height, velocity, acceleration)
            }
            _ => Overlap::of_pair(state, self.side(), self.roundings()),
        }
    }

    fn roundings(self) -> [u32; 5] {
        match self {
            Self::InertialPositive | Self::InertialNegative => ROUNDINGS_OF_QUADRATIC,
            Self::General(_) => ROUNDINGS_OF_GENERAL,
            _ => ROUNDINGS_OF_QUARTIC,
        }
    }
}

fn relative(state: &State) -> RelativeState {
    RelativeState { position: state.position, velocity: state.velocity }
}

pub fn quadratic(state: &State) -> Quadratic {
    Quadratic::new(&relative(state), state.distance * state.distance)
}

pub fn quartic(state: &State) -> Quartic {
    Quartic::new(&relative(state), &state.acceleration, state.distance * state.distance)
}

fn height(state: &State) -> [f64; 3] {
    [state.position.x - state.distance, state.velocity.x, state.acceleration.x]
}
