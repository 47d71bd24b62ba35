//! Rates of events by kind and species.

use serde::{Deserialize, Serialize};

use crate::engine::Simulation;
use crate::engine::event::EventCountsBySpecies;

/// Event rate: number of events of one kind per time of the measurement. The events are between particles of
/// two species, or between particles of one species and a wall or a thermostat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// `core`, `capture`, `release`, `bounce` (by a finite step), `bond` (by its far end), `wall` or
    /// `thermostat`.
    pub kind: String,
    /// One species for walls and thermostats, otherwise two.
    pub species: Vec<String>,
    /// Number of such events.
    pub events: u64,
    /// Number of such events per time `[1 / time]`; `None` if no time passed.
    pub per_time: Option<f64>,
    /// Number of these events per particle of each species and time `[1 / time]`. In an event of two
    /// particles of one species, both particles count. `None` for static particles.
    pub per_particle: Vec<Option<f64>>,
}

/// The rates of all kinds of events that occurred in a measurement of some duration `[time]`.
#[must_use]
pub fn rates(simulation: &Simulation, counts: &EventCountsBySpecies, duration: f64) -> Vec<Rate> {
    let (numbers, scene) = (simulation.population(), simulation.scene());
    let by_time = |count: f64| (duration > 0.0).then(|| count / duration);
    let rate = |(kind, species, events): (crate::engine::event::CountedKind, Vec<u32>, u64)| {
        let taking_part = |id: &u32| species.iter().filter(|other| *other == id).count() as f64 * events as f64;
        let per_particle = |id: &u32| {
            let index = *id as usize;
            by_time(taking_part(id) / numbers[index] as f64).filter(|_| !scene.species[index].is_static())
        };
        Rate {
            kind: kind.name().to_owned(),
            species: species.iter().map(|id| scene.species[*id as usize].name.clone()).collect(),
            events,
            per_time: by_time(events as f64),
            per_particle: species.iter().map(per_particle).collect(),
        }
    };
    counts.entries().into_iter().map(rate).collect()
}

impl Rate {
    /// Kind and species of the events, in words: `core, A and B`.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}, {}", self.kind, self.species.join(" and "))
    }

    /// The rates per particle, in words: `0.57 per A, 0.11 per B`; two particles of one species have a single
    /// rate.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words: Vec<String> = Vec::new();
        for (species, rate) in self.species.iter().zip(&self.per_particle) {
            let word = rate.map(|rate| format!("{} per {species}", crate::base::text::digits(rate)));
            words.extend(word.filter(|word| !words.contains(word)));
        }
        words.join(", ")
    }
}

/// The rates to print in addition to the collision rate of a run: all rates, or none if only core events of a
/// single species occurred.
#[must_use]
pub fn told_apart(rates: &[Rate]) -> Vec<&Rate> {
    let is_core = |rate: &Rate| rate.kind == "core";
    let is_alone = rates.iter().filter(|rate| is_core(rate)).count() == 1;
    let has_all = |one: &Rate| rates.iter().flat_map(|rate| &rate.species).all(|name| one.species.contains(name));
    rates.iter().filter(|rate| !(is_core(rate) && is_alone && has_all(rate))).collect()
}
