//! What is measured along a run: rows at even times, and means with standard errors.
//!
//! An observer only reads: a run that is watched has the same trajectory, bit for bit, as one that is not.

mod meaning;

pub use meaning::Meaning;

use crate::Vector;
use crate::event::Tally;
use crate::scene::Scene;
use crate::simulation::{Energy, Simulation};
use crate::statistics::{BlockAverage, Estimate};
use serde::{Deserialize, Serialize};

/// The state of a simulation at one time, and what happened since the row before.
///
/// What means nothing for the scene, or cannot be known yet, is `None`.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Simulated time `[time]`.
    pub time: f64,
    /// Physical events since the start of the simulation.
    pub events: u64,
    /// Kinetic temperature now `[energy]`.
    pub temperature: Option<f64>,
    /// Kinetic energy now `[energy]`.
    pub kinetic: f64,
    /// Potential energy now, of pairs and of weight `[energy]`.
    pub potential: f64,
    /// Energy that thermostats, walls, growth and shear have supplied so far, less what they took `[energy]`.
    pub supplied: f64,
    /// Kinetic and potential energy, and what was dissipated so far, less what was supplied: constant but for round-off `[energy]`.
    pub ledger: f64,
    /// Pressure since the row before `[energy / length^D]`.
    pub pressure: Option<f64>,
    /// Core contacts per particle and time since the row before `[1 / time]`.
    pub collision_rate: Option<f64>,
    /// Height of the centre of mass against gravity `[length]`.
    pub height: Option<f64>,
    /// Number of moving particles in each of the regions that the scene counts in.
    pub counts: Vec<usize>,
}

/// The quantities with a mean over a run, by name, in the order of `summary.json`.
pub const OBSERVABLES: [(&str, &str); 5] = [
    ("temperature", "energy"),
    ("pressure", "energy / length^D"),
    ("compressibility_factor", "1"),
    ("collision_rate", "1 / time"),
    ("potential_energy_per_particle", "energy"),
];

/// Measures a simulation between the times at which it is asked for a row.
///
/// | quantity | measured as |
/// |---|---|
/// | temperature `T` | `2 K / (D N)`; where momentum is conserved `2 (K - P^2 / 2M) / (D (N - 1))` |
/// | compressibility factor `Z` | `1 + W / (D (N - 1) T t)`, `W` the sum of `r_ij . J` over the events of a time `t` |
/// | pressure | `Z rho T`, `rho = N / V` |
/// | collision rate | `2 n / (N t)` with `n` Core events |
/// | potential energy per particle | energy of the pairs over `N` |
///
/// `N` counts the particles that move, `D` is the number of axes that are not flat. `T` in `Z` is the mean of its values at
/// both ends of the interval, as are the means of `T` and of the potential energy over it.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Observer {
    meaning: Meaning,
    before: Option<Reading>,
    averages: Vec<BlockAverage>,
}

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct Reading {
    time: f64,
    tally: Tally,
    temperature: Option<f64>,
    pair_energy: f64,
}

impl Observer {
    /// An observer that has seen nothing yet.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self { meaning: Meaning::of(scene), before: None, averages: Vec::new() }
    }

    /// What can be measured in this scene.
    #[must_use]
    pub fn meaning(&self) -> &Meaning {
        &self.meaning
    }

    /// Measures now, and the interval since the last time.
    pub fn row(&mut self, simulation: &Simulation) -> Row {
        let energy = simulation.energy();
        let reading = self.read(simulation, &energy);
        let interval = self.before.and_then(|before| self.interval(&before, &reading));
        if let Some(interval) = &interval {
            self.averages.resize(OBSERVABLES.len(), BlockAverage::new(interval.duration));
            let values = [
                interval.temperature,
                interval.pressure,
                interval.compressibility_factor,
                interval.collision_rate,
                interval.potential_energy,
            ];
            for (average, value) in self.averages.iter_mut().zip(values) {
                average.add(value.unwrap_or(f64::NAN), interval.duration);
            }
        }
        self.before = Some(reading);
        let (height, counts) = self.meaning.positions(simulation);
        Row {
            time: reading.time,
            events: reading.tally.physical(),
            temperature: reading.temperature,
            kinetic: energy.kinetic,
            potential: energy.potential,
            supplied: reading.tally.supplied.total(),
            ledger: energy.kinetic + energy.potential + reading.tally.dissipated.total()
                - reading.tally.supplied.total(),
            pressure: interval.and_then(|interval| interval.pressure),
            collision_rate: interval.and_then(|interval| interval.collision_rate),
            height,
            counts,
        }
    }

    /// The means over all intervals so far, by name; absent if they mean nothing for the scene.
    #[must_use]
    pub fn estimates(&self) -> Vec<(&'static str, Estimate)> {
        let estimates = OBSERVABLES.iter().zip(&self.averages);
        estimates.filter_map(|((name, _), average)| Some((*name, average.estimate()?))).collect()
    }

    fn read(&self, simulation: &Simulation, energy: &Energy) -> Reading {
        Reading {
            time: simulation.time(),
            tally: *simulation.tally(),
            temperature: self.meaning.temperature(energy.thermal, &energy.momentum),
            pair_energy: energy.pair,
        }
    }

    fn interval(&self, from: &Reading, to: &Reading) -> Option<Interval> {
        let duration = to.time - from.time;
        if duration <= 0.0 {
            return None;
        }
        let meaning = &self.meaning;
        let moving = meaning.moving as f64;
        let temperature = from.temperature.zip(to.temperature).map(|(a, b)| 0.5 * (a + b));
        let compressibility_factor = temperature.filter(|&t| meaning.has_pressure && t > 0.0).map(|temperature| {
            let virial = to.tally.virial - from.tally.virial;
            1.0 + virial / (meaning.degrees_of_freedom * temperature * duration)
        });
        Some(Interval {
            duration,
            temperature,
            pressure: compressibility_factor.zip(temperature).map(|(z, t)| z * meaning.number_density * t),
            compressibility_factor,
            collision_rate: meaning
                .has_core
                .then(|| 2.0 * (to.tally.core - from.tally.core) as f64 / (moving * duration)),
            potential_energy: meaning.has_wells.then(|| 0.5 * (from.pair_energy + to.pair_energy) / moving),
        })
    }
}

#[derive(Debug, Clone, Copy)]
struct Interval {
    duration: f64,
    temperature: Option<f64>,
    pressure: Option<f64>,
    compressibility_factor: Option<f64>,
    collision_rate: Option<f64>,
    potential_energy: Option<f64>,
}

/// The direction against gravity: that of the mean acceleration, reversed.
fn upwards(scene: &Scene) -> Option<Vector> {
    let sum: Vector = scene
        .particles
        .iter()
        .map(|particle| &scene.species[particle.species.0 as usize])
        .filter(|species| !species.is_static())
        .map(|species| species.acceleration)
        .sum();
    (-sum).try_normalize(0.0)
}
