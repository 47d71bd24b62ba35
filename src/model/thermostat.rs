//! Settings of thermostats.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::limits::is_positive;
use super::space::{Boundary, Space};

/// A thermostat, which controls the temperature.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Thermostat {
    /// Particles get new velocities from the Maxwell distribution at random times: H. C. Andersen, J. Chem.
    /// Phys. 72, 2384 (1980), [doi:10.1063/1.439486](https://doi.org/10.1063/1.439486).
    Andersen {
        /// Temperature `[energy]`.
        temperature: f64,
        /// Mean rate of collisions of a particle with the heat bath `[1 / time]`.
        rate: f64,
        /// Axes along which a collision changes the velocity.
        axes: [bool; 3],
    },
    /// All velocities are scaled to the temperature at regular times.
    Rescaling {
        /// Temperature `[energy]`.
        temperature: f64,
        /// Interval between two scalings `[time]`.
        interval: f64,
    },
}

/// Reason why a thermostat is invalid.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum ThermostatError {
    /// A parameter is not positive, or is out of range.
    #[error("the {name} of the thermostat is {value}, expected a number from 1e-50 to 1e50")]
    Number {
        /// Name of the parameter: temperature, rate or interval.
        name: &'static str,
        /// The value.
        value: f64,
    },
    /// The heat bath acts along no axis.
    #[error("the heat bath has no axes, expected at least one")]
    NoAxis,
    /// The heat bath acts only along flat axes, along which nothing moves.
    #[error("the heat bath has flat axes only, expected an axis along which particles move")]
    FlatAxes,
    /// The heat bath has no moving particle to act on.
    #[error("the heat bath needs moving particles, and there are none")]
    NothingMoves,
    /// The system has no temperature that can be scaled: particles accelerate, or fewer than two particles move.
    #[error(
        "velocities cannot be scaled without a temperature; a temperature needs two or more moving particles without gravity"
    )]
    NoTemperature,
    /// A simulation does not rescale velocities by itself. The caller, such as `run::Run`, must rescale them.
    #[error(
        "a simulation does not scale velocities by itself: call Simulation::scale_velocities at each interval, or use run::Run"
    )]
    Rescaling,
}

impl Thermostat {
    /// Temperature of the thermostat `[energy]`.
    pub(crate) fn temperature(&self) -> f64 {
        let (Self::Andersen { temperature, .. } | Self::Rescaling { temperature, .. }) = *self;
        temperature
    }

    pub(crate) fn check(&self) -> Result<(), ThermostatError> {
        let number =
            |name, value| if is_positive(value) { Ok(()) } else { Err(ThermostatError::Number { name, value }) };
        match *self {
            Self::Andersen { temperature, rate, axes } => {
                number("temperature", temperature)?;
                number("rate", rate)?;
                if axes.contains(&true) { Ok(()) } else { Err(ThermostatError::NoAxis) }
            }
            Self::Rescaling { temperature, interval } => {
                number("temperature", temperature)?;
                number("interval", interval)
            }
        }
    }

    /// Checks the thermostat for a system, and removes flat axes from a heat bath.
    pub(crate) fn settled(self, space: &Space, moving: usize, is_accelerated: bool) -> Result<Self, ThermostatError> {
        self.check()?;
        match self {
            Self::Andersen { .. } if moving == 0 => Err(ThermostatError::NothingMoves),
            Self::Andersen { temperature, rate, axes } => {
                let axes = std::array::from_fn(|axis| axes[axis] && space.boundary[axis] != Boundary::Flat);
                if axes == [false; 3] {
                    return Err(ThermostatError::FlatAxes);
                }
                Ok(Self::Andersen { temperature, rate, axes })
            }
            Self::Rescaling { .. } if is_accelerated || moving < 2 => Err(ThermostatError::NoTemperature),
            Self::Rescaling { .. } => Ok(self),
        }
    }
}
