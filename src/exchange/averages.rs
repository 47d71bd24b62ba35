//! Averages of observables at each temperature, and of swaps between neighbouring temperatures.

use serde::{Deserialize, Serialize};

use super::populations::Populations;
use super::results::{NeighbouringTemperatures, TemperatureResult};
use crate::analysis::instruments::Measured;
use crate::analysis::observables::{ApplicableObservables, Observer};
use crate::analysis::statistics::{BlockAverage, Estimate};
use crate::engine::Simulation;
use crate::model::{ExchangePlan, Scene};

/// The observable that is sampled at the attempts. Other observables are averaged over the time between attempts.
const POTENTIAL: &str = "potential_energy_per_particle";

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct AtTemperature {
    observer: Observer,
    /// Averages of `U - U_0` and `(U - U_0)^2`, where `U_0` is the first potential energy.
    energy: BlockAverage,
    square: BlockAverage,
    first: Option<f64>,
    others: Vec<BlockAverage>,
}

impl AtTemperature {
    pub fn new(scene: &Scene) -> Self {
        let empty = BlockAverage::new(1.0);
        Self { observer: Observer::new(scene), energy: empty.clone(), square: empty, first: None, others: Vec::new() }
    }

    pub fn begin(&mut self, simulation: &Simulation) {
        self.observer.interrupt();
        self.observer.row(simulation);
    }

    pub fn end(&mut self, simulation: &Simulation) {
        self.observer.row(simulation);
    }

    fn add(&mut self, energy: f64, others: &[f64]) {
        self.others.resize(others.len(), BlockAverage::new(1.0));
        self.others.iter_mut().zip(others).for_each(|(average, value)| average.add(*value, 1.0));
        let deviation = energy - *self.first.get_or_insert(energy);
        self.energy.add(deviation, 1.0);
        self.square.add(deviation * deviation, 1.0);
    }

    fn measured(&self, temperature: f64, names: &[&'static str]) -> Vec<(&'static str, Estimate)> {
        let applicable = self.observer.applicable();
        let (particles, dimensions) = (applicable.moving as f64, applicable.dimensions);
        let all = self.observer.estimates().into_iter().filter(|(name, _)| *name != POTENTIAL);
        let mut all: Vec<(&'static str, Estimate)> = all.collect();
        let shifted = self.energy.estimate().zip(self.first).map(|(energy, first)| {
            let energy = Estimate { mean: energy.mean + first, ..energy };
            (POTENTIAL, energy.over(particles))
        });
        all.extend(shifted);
        let heat_capacity = self.energy.variance(&self.square).map(|variance| {
            let of_positions = variance.over(particles * temperature * temperature);
            let heat_capacity = Estimate { mean: 0.5 * dimensions + of_positions.mean, ..of_positions };
            ("heat_capacity_per_particle", heat_capacity)
        });
        all.extend(heat_capacity);
        all.extend(names.iter().zip(&self.others).filter_map(|(name, average)| Some((*name, average.estimate()?))));
        all
    }
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Averages {
    pub temperatures: Vec<AtTemperature>,
    /// Populations of the energy levels. `None` for an exchange between windows.
    populations: Option<Populations>,
    /// Fraction of accepted attempts for each pair of neighbouring temperatures or windows.
    swaps: Vec<BlockAverage>,
    /// Number of attempts and number of swaps for each pair.
    counts: Vec<[u64; 2]>,
}

impl Averages {
    pub fn new(scene: &Scene, plan: &ExchangePlan) -> Self {
        let temperatures = plan.replicas();
        Self {
            temperatures: vec![AtTemperature::new(scene); temperatures],
            populations: plan.umbrella.is_none().then(|| Populations::new(scene, temperatures)),
            swaps: vec![BlockAverage::new(1.0); temperatures - 1],
            counts: vec![[0, 0]; temperatures - 1],
        }
    }

    pub fn applicable(&self) -> &ApplicableObservables {
        self.temperatures[0].observer.applicable()
    }

    pub fn attempt(&mut self, pair: usize, is_swapped: bool) {
        self.swaps[pair].add(if is_swapped { 1.0 } else { 0.0 }, 1.0);
        self.counts[pair][0] += 1;
        self.counts[pair][1] += u64::from(is_swapped);
    }

    /// Adds samples to all temperatures. `others` holds further quantities, one temperature after the next.
    pub fn sample(&mut self, energies: &[f64], others: &[f64]) {
        let each = others.len() / energies.len().max(1);
        for (place, (at, energy)) in self.temperatures.iter_mut().zip(energies).enumerate() {
            at.add(*energy, &others[place * each..(place + 1) * each]);
        }
        if let Some(populations) = &mut self.populations {
            populations.add(energies);
        }
    }

    pub fn results(&self, temperatures: &[f64], names: &[&'static str]) -> Vec<TemperatureResult> {
        let result = |(place, (temperature, at)): (usize, (&f64, &AtTemperature))| TemperatureResult {
            temperature: *temperature,
            observables: at.measured(*temperature, names).into_iter().map(|(name, it)| (name.to_owned(), it)).collect(),
            populations: self.populations.as_ref().map_or_else(Vec::new, |populations| populations.at(place)),
            measured: Measured::default(),
            window: None,
        };
        temperatures.iter().zip(&self.temperatures).enumerate().map(result).collect()
    }

    pub fn neighbours(&self, temperatures: &[f64]) -> Vec<NeighbouringTemperatures> {
        let swaps = self.swaps.iter().zip(&self.counts);
        let neighbours =
            |(pair, (swaps, [attempts, accepted])): (&[f64], (&BlockAverage, &[u64; 2]))| NeighbouringTemperatures {
                temperatures: [pair[0], pair[1]],
                attempts: *attempts,
                accepted: *accepted,
                acceptance: swaps.estimate(),
            };
        temperatures.windows(2).zip(swaps).map(neighbours).collect()
    }
}
