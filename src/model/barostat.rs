//! Settings of the barostat, which controls the pressure by volume moves.

use serde::{Deserialize, Serialize};

use super::limits::{Invalid, is_positive};

/// Barostat of the isothermal-isobaric ensemble. Monte Carlo moves change the volume at regular times.
///
/// A move proposes `ln V' = ln V + a (2 u - 1)`, with `u` uniform in `[0, 1)`. It scales the centres of all molecules.
/// Velocities, bonds and the shapes of molecules stay the same. A move is accepted with the probability `min(1,
/// exp(-(dU + P dV) / T + (N + 1) ln(V' / V)))`. `N` is the number of molecules, including single particles. `V` is the
/// volume of the box, or its area or length.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Barostat {
    /// Pressure `P` `[energy / length^D]`.
    pub pressure: f64,
    /// Time between two moves `[time]`.
    pub interval: f64,
    /// Largest change `a` of `ln V` in a move. `None` adjusts `a` in equilibrations and in stages without measurement.
    pub amplitude: Option<f64>,
}

/// Largest amplitude of volume moves. It changes the volume by a factor of 7.4.
pub(crate) const LARGEST_AMPLITUDE: f64 = 2.0;

impl Barostat {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        let number = "a number from 1e-50 to 1e50";
        let pressure = "a number from 1e-50 to 1e50: without an external pressure the volume grows for ever";
        for (name, value, number) in [("pressure", self.pressure, pressure), ("interval", self.interval, number)] {
            if !is_positive(value) {
                return Err((name, value, number));
            }
        }
        match self.amplitude {
            Some(value) if !(is_positive(value) && value <= LARGEST_AMPLITUDE) => {
                Err(("amplitude", value, "a number above 0, at most 2"))
            }
            _ => Ok(()),
        }
    }
}

/// Statistics of the volume moves of a stage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct VolumeMoves {
    /// Number of proposed moves.
    pub attempted: u64,
    /// Number of accepted moves.
    pub accepted: u64,
    /// Number of moves rejected because a particle would interact with two images of another particle.
    pub too_small: u64,
    /// Largest change of `ln V` in a move at the end of the stage.
    pub amplitude: f64,
}

impl VolumeMoves {
    /// Fraction of accepted moves; `None` without moves.
    #[must_use]
    pub fn acceptance(&self) -> Option<f64> {
        (self.attempted > 0).then(|| self.accepted as f64 / self.attempted as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_barostat_parameters_are_rejected() {
        let good = Barostat { pressure: 1.3, interval: 0.5, amplitude: None };
        assert_eq!(good.check(), Ok(()));
        assert_eq!(Barostat { amplitude: Some(2.0), ..good }.check(), Ok(()));
        for (name, wrong) in [
            ("pressure", Barostat { pressure: 0.0, ..good }),
            ("pressure", Barostat { pressure: -1.0, ..good }),
            ("pressure", Barostat { pressure: f64::NAN, ..good }),
            ("interval", Barostat { interval: f64::INFINITY, ..good }),
            ("amplitude", Barostat { amplitude: Some(0.0), ..good }),
            ("amplitude", Barostat { amplitude: Some(2.0_f64.next_up()), ..good }),
            ("amplitude", Barostat { amplitude: Some(f64::NAN), ..good }),
        ] {
            assert_eq!(wrong.check().unwrap_err().0, name, "{wrong:?}");
        }
    }
}
