//! Volume moves at regular times, which simulate the constant pressure of a barostat.

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::engine::Scaling;
use crate::model::barostat::LARGEST_AMPLITUDE;
use crate::model::random::{Purpose, Random};
use crate::model::state_point::StatePoint;
use crate::model::{Barostat, Thermostat, VolumeMoves};

/// Target fraction of accepted volume moves.
const ACCEPTANCE: f64 = 0.4;

/// Speed of tuning: forty rejected moves multiply the amplitude by `exp(-40 STEP ACCEPTANCE)`, about a fifth.
const STEP: f64 = 0.1;

/// Minimum number of volume moves needed to tune the amplitude.
pub(in crate::run) const FEWEST_MOVES: u32 = 40;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::run) struct Moves {
    pub(super) next: f64,
    random: Random,
    pub(in crate::run) done: VolumeMoves,
}

impl Moves {
    fn note(&mut self, is_accepted: bool, is_too_small: bool) {
        self.done.attempted += 1;
        self.done.too_small += u64::from(is_too_small);
        self.done.accepted += u64::from(is_accepted);
    }

    fn adapt(&mut self, is_accepted: bool) {
        let excess = f64::from(u8::from(is_accepted)) - ACCEPTANCE;
        self.done.amplitude = (self.done.amplitude * libm::exp(STEP * excess)).min(LARGEST_AMPLITUDE);
    }
}

impl Driver<'_> {
    pub(super) fn begin_moves(&mut self, barostat: Option<Barostat>, seed: u64, stream: usize) {
        self.state.moves = barostat.map(|barostat| {
            let particles: usize = self.simulation.population().iter().sum();
            // In an ideal gas, the logarithm of the volume has the standard deviation `1 / sqrt(N + 1)`.
            let guess = (1.0 / (particles as f64 + 1.0)).sqrt();
            let seed = StatePoint::new(seed).with(&[barostat.pressure, barostat.interval]);
            let amplitude = barostat.amplitude.or(self.state.amplitude).unwrap_or(guess);
            Moves {
                next: self.simulation.time() + barostat.interval,
                random: Random::new(seed.number(), Purpose::Volume, stream),
                done: VolumeMoves { attempted: 0, accepted: 0, too_small: 0, amplitude },
            }
        });
    }

    /// Simulated time of the next volume move; infinite if there is none.
    pub(super) fn next_move(&self) -> f64 {
        self.state.moves.as_ref().map_or(f64::INFINITY, |moves| moves.next)
    }

    /// Proposes another volume, and accepts or rejects it. The simulation has reached `time` within round-off.
    ///
    /// With the centres of the `N` molecules in units of the box, the probability density of a state is proportional to
    /// `V^N exp(-(U + P V + K) / T)`. The proposal is uniform in `ln V`, which adds a factor `V`. A move to the volume
    /// `V'` is therefore accepted with the probability
    /// `min(1, exp(-(dU + P dV) / T + (N + 1) ln(V' / V)))`.
    pub(super) fn move_volume(&mut self, time: f64) {
        let settings = self.settings();
        let (Some(barostat), Some(Thermostat::Andersen { temperature, .. })) = (settings.barostat, settings.thermostat)
        else {
            return;
        };
        let Some(mut moves) = self.state.moves.take() else { return };
        let scaling = self.scaling.take().unwrap_or_else(|| Scaling::of(&self.simulation));
        // Both random numbers are always drawn, so that later random numbers do not depend on the outcome of this move.
        let (change, threshold) = (moves.done.amplitude * (2.0 * moves.random.uniform() - 1.0), moves.random.uniform());
        let volume = self.simulation.volume();
        let space = self.simulation.scaled_box(&scaling, change);
        let is_too_small = space.is_none();
        let accepted = space.and_then(|space| self.simulation.scaled(&scaling, space)).filter(|scaled| {
            let work = scaled.energy_change + barostat.pressure * (scaled.space.volume() - volume);
            let exponent = (scaling.molecules() as f64 + 1.0) * change - work / temperature;
            threshold < libm::exp(exponent)
        });
        moves.note(accepted.is_some(), is_too_small);
        if !self.state.stage.stage.is_measured() && barostat.amplitude.is_none() {
            moves.adapt(accepted.is_some());
            self.state.amplitude = Some(moves.done.amplitude);
        }
        if let Some(scaled) = accepted {
            self.simulation.take_scaled(scaled);
            self.integrate();
            self.resize_system();
        }
        moves.next = self.next_multiple(barostat.interval, time);
        (self.state.moves, self.scaling) = (Some(moves), Some(scaling));
    }

    /// Ends an interval of constant volume for all averages.
    fn integrate(&mut self) {
        let energy = self.simulation.energy();
        self.state.observer.integrate(&self.simulation, &energy);
        if let Some(monitor) = &mut self.state.monitor {
            monitor.observer.integrate(&self.simulation, &energy);
        }
    }

    fn resize_system(&mut self) {
        if let Some(system) = self.system.as_mut().filter(|_| !self.is_pilot) {
            system.space = self.simulation.scene().space.clone();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volume_move_amplitude_adapts_to_40_percent_acceptance() {
        let done = VolumeMoves { attempted: 0, accepted: 0, too_small: 0, amplitude: 0.1 };
        let mut moves = Moves { next: 0.0, random: Random::new(1, Purpose::Volume, 0), done };
        let mut after = |accepted: &[bool]| {
            for is_accepted in accepted {
                moves.note(*is_accepted, false);
                moves.adapt(*is_accepted);
            }
            moves.done.amplitude
        };
        let even = [false, true, false, true, false].repeat(20);
        assert!((after(&even) / 0.1 - 1.0).abs() < 1e-12);
        assert!((after(&[false; 40]) / (0.1 * libm::exp(-1.6)) - 1.0).abs() < 1e-12);
        assert_eq!(after(&[true; 200]), LARGEST_AMPLITUDE);
        assert_eq!((moves.done.attempted, moves.done.accepted), (340, 240));
    }
}
