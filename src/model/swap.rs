//! Settings and statistics of swap moves, which exchange the diameters of two particles.

use serde::{Deserialize, Serialize};

use super::limits::{Invalid, is_positive};

/// Monte Carlo moves of a mixture of hard spheres, at regular times between the events.
///
/// A move picks two different moving particles at random. It exchanges their species or their individual diameters. In
/// both cases, the particles exchange diameters and masses. The move is accepted if it causes no overlap. Positions do
/// not change. If the masses are equal, velocities do not change either. Otherwise, velocities are exchanged together
/// with the masses, so that momentum and energy are constant. Moves are symmetric, so they do not change averages in
/// equilibrium. A. Ninarello, L. Berthier and D. Coslovich, Phys. Rev. X 7, 021039 (2017),
/// [doi:10.1103/PhysRevX.7.021039](https://doi.org/10.1103/PhysRevX.7.021039).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Swap {
    /// Time between two sets of moves `[time]`.
    pub interval: f64,
    /// Number of moves in a set; the number of moving particles if not given.
    pub attempts: Option<u64>,
    /// Largest ratio of two diameters that are exchanged; no limit if not given. Moves beyond it are rejected.
    pub largest_ratio: Option<f64>,
}

/// Largest number of moves in a set. A set is not interrupted, and takes about a second for a million moves.
pub(crate) const MOST_ATTEMPTS: u64 = 10_000_000;

impl Swap {
    pub(crate) fn check(&self) -> Result<(), Invalid> {
        if !is_positive(self.interval) {
            return Err(("interval", self.interval, "a number from 1e-50 to 1e50"));
        }
        match (self.attempts, self.largest_ratio) {
            (Some(attempts), _) if !(1..=MOST_ATTEMPTS).contains(&attempts) => {
                Err(("attempts", attempts as f64, "an integer from 1 to 10,000,000"))
            }
            (_, Some(ratio)) if !(is_positive(ratio) && ratio >= 1.0) => {
                Err(("largest_ratio", ratio, "a number from 1 to 1e50"))
            }
            _ => Ok(()),
        }
    }

    /// Number of moves in a set, with a given number of moving particles.
    pub(crate) fn attempts(&self, moving: usize) -> u64 {
        self.attempts.unwrap_or(moving as u64)
    }

    /// Whether two diameters may be exchanged. The first is the smaller one.
    pub(crate) fn allows(&self, [small, large]: [f64; 2]) -> bool {
        self.largest_ratio.is_none_or(|ratio| large <= ratio * small)
    }
}

/// Statistics of the swap moves of a stage.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct SwapMoves {
    /// Number of moves.
    pub attempted: u64,
    /// Number of moves between equal particles, which change nothing.
    pub alike: u64,
    /// Number of moves that were rejected because of the ratio of the diameters.
    pub too_unlike: u64,
    /// Number of accepted moves of unlike particles.
    pub accepted: u64,
}

impl SwapMoves {
    /// Accepted moves divided by all moves of unlike particles; `None` if no unlike particles were drawn.
    #[must_use]
    pub fn acceptance(&self) -> Option<f64> {
        let unlike = self.attempted - self.alike;
        (unlike > 0).then(|| self.accepted as f64 / unlike as f64)
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.attempted += other.attempted;
        self.alike += other.alike;
        self.too_unlike += other.too_unlike;
        self.accepted += other.accepted;
    }
}

/// The swap moves of a stage that has made any.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct StageSwaps {
    /// Name of the stage: of a `[[stage]]`, `equilibration` or `measurement`.
    pub stage: String,
    /// Statistics of its moves.
    pub moves: SwapMoves,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_settings_are_rejected() {
        let good = Swap { interval: 0.5, attempts: Some(1), largest_ratio: Some(1.0) };
        assert_eq!(good.check(), Ok(()));
        assert_eq!(Swap { attempts: None, largest_ratio: None, ..good }.check(), Ok(()));
        for (name, wrong) in [
            ("interval", Swap { interval: 0.0, ..good }),
            ("interval", Swap { interval: f64::NAN, ..good }),
            ("attempts", Swap { attempts: Some(0), ..good }),
            ("attempts", Swap { attempts: Some(MOST_ATTEMPTS + 1), ..good }),
            ("largest_ratio", Swap { largest_ratio: Some(1.0_f64.next_down()), ..good }),
            ("largest_ratio", Swap { largest_ratio: Some(f64::INFINITY), ..good }),
        ] {
            assert_eq!(wrong.check().unwrap_err().0, name, "{wrong:?}");
        }
    }

    #[test]
    fn acceptance_leaves_out_particles_of_one_species() {
        let moves = SwapMoves { attempted: 10, alike: 2, too_unlike: 3, accepted: 4 };
        assert_eq!(moves.acceptance(), Some(0.5));
        assert_eq!(SwapMoves { attempted: 5, alike: 5, ..SwapMoves::default() }.acceptance(), None);
    }
}
