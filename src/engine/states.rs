//! Positions and velocities at one time, exactly as the engine computes them. Verification of trajectories needs them.

use super::parts::Engine;
use crate::Vector;
use crate::model::ParticleId;

/// Simulated time since the start, in two parts.
///
/// The sum of the parts has the round-off of the total time. The difference of two times, [`Self::after`], is more
/// accurate: it has only the round-off of the time between them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Elapsed {
    /// Simulated time from the start of the simulation to the epoch `[time]`.
    pub epoch: f64,
    /// Time from the epoch to now `[time]`.
    pub since_epoch: f64,
    /// Number of epochs that have ended. At the end of an epoch, the state of a particle without events for two epochs
    /// is moved to the new epoch. This rounds the state once more.
    pub epochs: u64,
}

impl Elapsed {
    /// Returns the time from `earlier` to this time `[time]`.
    #[must_use]
    pub fn after(&self, earlier: &Self) -> f64 {
        // Epochs are multiples of a power of two, so their difference is exact.
        ((self.epoch - earlier.epoch) - earlier.since_epoch) + self.since_epoch
    }

    /// Returns the time since the start `[time]`.
    #[must_use]
    pub fn total(&self) -> f64 {
        self.epoch + self.since_epoch
    }
}

/// Positions and velocities of all particles at one time, in the order of their ids.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct States {
    /// The time of these states.
    pub elapsed: Elapsed,
    /// Ids of the particles, ascending. They differ from indices if particles have left.
    pub ids: Vec<ParticleId>,
    /// Positions `[length]`, `N x 3`. Along periodic axes, they are inside the box within round-off.
    pub positions: Vec<Vector>,
    /// Velocities `[length / time]`, `N x 3`.
    pub velocities: Vec<Vector>,
    /// Spins `[1 / time]`, `N x 3`; empty if the scene has no spins.
    pub spins: Vec<Vector>,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub(super) fn states(&self, states: &mut States) {
        states.elapsed = Elapsed { epoch: self.clock.epoch, since_epoch: self.clock.now, epochs: self.clock.epochs };
        states.ids.clear();
        states.positions.clear();
        states.velocities.clear();
        states.spins.clear();
        for &particle in &self.state.numbers {
            let (position, velocity) = self.state_at(particle, self.clock.now);
            states.ids.push(self.id(particle));
            states.positions.push(position);
            states.velocities.push(velocity);
            states.spins.extend(self.state.spins.get(particle as usize));
        }
    }

    pub(super) fn captured_pairs(&self) -> Vec<([ParticleId; 2], u16)> {
        let mut pairs = Vec::new();
        for particle in self.particles().filter(|_| TABLE) {
            for captured in self.pairs.states.of(particle).iter().filter(|captured| captured.state > 0) {
                // Two mobile particles both store the state of the pair. A static particle stores no states.
                if particle < captured.partner || self.is_static(captured.partner) {
                    let [a, b] = [particle, captured.partner].map(|number| self.id(number));
                    pairs.push(([a.min(b), a.max(b)], captured.state));
                }
            }
        }
        pairs.sort_unstable();
        pairs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_short_time_across_epochs_keeps_its_digits() {
        let earlier = Elapsed { epoch: 0.0, since_epoch: 384.0_f64.next_down(), epochs: 0 };
        let later = Elapsed { epoch: 384.0, since_epoch: 1e-15, epochs: 1 };
        assert_eq!(later.after(&earlier), (384.0 - 384.0_f64.next_down()) + 1e-15);
        assert_eq!(later.total(), 384.0);
    }
}
