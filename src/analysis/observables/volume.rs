//! Means over a changing volume: the isothermal-isobaric ensemble.

use serde::{Deserialize, Serialize};

use super::ApplicableObservables;
use crate::analysis::statistics::{BlockAverage, Estimate};
use crate::engine::Simulation;
use crate::model::scene::own_volume;
use crate::model::{Barostat, Scene, Thermostat};

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Isobaric {
    pressure: f64,
    temperature: f64,
    filled: f64,
}

impl Isobaric {
    pub fn of(acting: Option<(&Barostat, &Thermostat)>, filled: f64) -> Option<Self> {
        let (barostat, thermostat) = acting?;
        Some(Self { pressure: barostat.pressure, temperature: thermostat.temperature(), filled })
    }

    /// The compressibility factor `P V / (N T)` of `N` particles in a volume.
    pub fn factor(&self, volume: f64, moving: f64) -> f64 {
        self.pressure * volume / (moving * self.temperature)
    }

    /// The isothermal compressibility `(<V^2> - <V>^2) / (<V> T)` `[length^D / energy]`.
    pub fn compressibility(&self, volume: &BlockAverage, square: &BlockAverage) -> Option<Estimate> {
        let mean = volume.mean().filter(|mean| *mean > 0.0)?;
        Some(volume.variance(square)?.over(mean * self.temperature))
    }

    /// The series `(V^2 - 2 <V> V) / (<V> T)`. The mean of this series is the compressibility minus `<V> / T`.
    pub fn fluctuation(&self, volume: &BlockAverage, square: &BlockAverage) -> Option<BlockAverage> {
        let mean = volume.mean().filter(|mean| *mean > 0.0)?;
        volume.with(square, |volume, square| (square - 2.0 * mean * volume) / (mean * self.temperature))
    }
}

/// Total volume of the moving particles of a scene `[length^D]`.
pub(super) fn filled(scene: &Scene) -> f64 {
    scene.moving().map(|particle| own_volume(scene.diameter(particle), scene.space.dimensions())).sum()
}

/// Time integrals from the first sample to the latest one. Between samples the volume is constant.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct VolumePiece {
    volume: f64,
    /// Virial since the start of the simulation `[energy]`.
    virial: f64,
    /// Time integrals of `V`, `1 / V`, `V^2` and the pressure.
    integrals: [f64; 4],
}

impl VolumePiece {
    pub fn of(simulation: &Simulation) -> Self {
        Self { volume: simulation.volume(), virial: simulation.event_counts().virial.total(), integrals: [0.0; 4] }
    }

    /// Advances by a time `duration`. The argument `heat` is the time integral of the temperature. The mean pressure is
    /// `(N T + W / (D t)) / V`, where `W` is the virial of the events.
    pub fn next(&self, simulation: &Simulation, duration: f64, heat: f64, applicable: &ApplicableObservables) -> Self {
        let next = Self::of(simulation);
        let volume = self.volume;
        let work = applicable.moving as f64 * heat + (next.virial - self.virial) / applicable.dimensions;
        let more = [volume * duration, duration / volume, volume * volume * duration, work / volume];
        Self { integrals: std::array::from_fn(|k| self.integrals[k] + more[k]), ..next }
    }

    pub fn since(&self, earlier: &Self, duration: f64) -> VolumeMeans {
        let [volume, inverse, square, pressure] =
            std::array::from_fn(|k| (self.integrals[k] - earlier.integrals[k]) / duration);
        VolumeMeans { volume, inverse, square, pressure }
    }
}

#[derive(Debug, Clone, Copy)]
pub(super) struct VolumeMeans {
    pub volume: f64,
    inverse: f64,
    square: f64,
    pub pressure: f64,
}

impl VolumeMeans {
    /// Volume, number density, packing fraction, and squared volume, in the order of the observables.
    pub fn values(&self, ensemble: &Isobaric, moving: f64) -> [f64; 4] {
        [self.volume, moving * self.inverse, ensemble.filled * self.inverse, self.square]
    }
}
