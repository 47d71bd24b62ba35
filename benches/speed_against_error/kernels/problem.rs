use crate::oracle::exact::{Overlap, ROUNDINGS_OF_QUADRATIC, ROUNDINGS_OF_QUARTIC, State};
use carom::physics::motion::RelativeState;
use carom::physics::overlap::{Quadratic, Quartic, Side};

/// A detection problem of the paper.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Problem {
    pub is_accelerated: bool,
    pub side: Side,
}

impl Problem {
    pub const ALL: [Self; 4] = [
        Self { is_accelerated: false, side: Side::Positive },
        Self { is_accelerated: false, side: Side::Negative },
        Self { is_accelerated: true, side: Side::Positive },
        Self { is_accelerated: true, side: Side::Negative },
    ];

    pub fn name(self) -> &'static str {
        match (self.is_accelerated, self.side) {
            (false, Side::Positive) => "inertial from outside",
            (false, Side::Negative) => "inertial from inside",
            (true, Side::Positive) => "accelerated from outside",
            (true, Side::Negative) => "accelerated from inside",
        }
    }

    /// The overlap function that the oracle evaluates.
    pub fn overlap(self, state: &State) -> Overlap {
        let roundings = if self.is_accelerated { ROUNDINGS_OF_QUARTIC } else { ROUNDINGS_OF_QUADRATIC };
        Overlap::of_pair(state, self.side, roundings)
    }
}

/// A pair in the form that the compared methods use.
pub struct Pair {
    pub problem: Problem,
    pub side: Side,
    pub state: State,
    pub quadratic: Quadratic,
    pub quartic: Quartic,
}

impl Pair {
    pub fn new(problem: Problem, state: State) -> Self {
        let relative = RelativeState { position: state.position, velocity: state.velocity };
        let squared = state.distance * state.distance;
        let quadratic = Quadratic::new(&relative, squared);
        let quartic = Quartic::new(&relative, &state.acceleration, squared);
        Self { problem, side: problem.side, state, quadratic, quartic }
    }

    /// The overlap function at time `t`, positive for a valid pair.
    pub fn value(&self, t: f64) -> f64 {
        let positive = if self.problem.is_accelerated { self.quartic.value(t) } else { self.quadratic.value(t) };
        self.side.sign() * positive
    }

    pub fn slope(&self, t: f64) -> f64 {
        let positive = if self.problem.is_accelerated {
            let c = self.quartic.derivative();
            ((c[3] * t + c[2]) * t + c[1]) * t + c[0]
        } else {
            self.quadratic.derivative(t)
        };
        self.side.sign() * positive
    }
}
