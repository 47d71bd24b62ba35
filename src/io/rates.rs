//! Rates of events by kind and species.

use serde::{Deserialize, Serialize};

use crate::engine::Simulation;
use crate::engine::event::EventCountsBySpecies;

/// Rate of one kind of event between two species, or between one species and walls or a thermostat.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Kind of the events: `core`, `capture`, `release`, `bounce`, `bond`, `wall`, `thermostat`, `exit` or `entry`.
    pub kind: String,
    /// Names of the two species. Events with walls and thermostats have only one species.
    pub species: Vec<String>,
    /// Number of events of this kind.
    pub events: u64,
    /// Number of events per simulated time `[1 / time]`; `None` for a duration of zero.
    pub per_time: Option<f64>,
    /// Number of events per particle and simulated time `[1 / time]`, for each species. `None` for static species, and
    /// if particles enter or leave. An event between two particles of one species counts twice.
    pub per_particle: Vec<Option<f64>>,
}

/// Returns the rates of all kinds of events. `duration` is the length of the measurement `[time]`.
#[must_use]
pub fn rates(simulation: &Simulation, counts: &EventCountsBySpecies, duration: f64) -> Vec<Rate> {
    let (numbers, scene) = (simulation.population(), simulation.scene());
    let by_time = |count: f64| (duration > 0.0).then(|| count / duration);
    let rate = |(kind, species, events): (crate::engine::event::CountedKind, Vec<u32>, u64)| {
        let taking_part = |id: &u32| species.iter().filter(|other| *other == id).count() as f64 * events as f64;
        let per_particle = |id: &u32| {
            let index = *id as usize;
            let is_counted = !scene.has_flow() && !scene.species[index].is_static();
            by_time(taking_part(id) / numbers[index] as f64).filter(|_| is_counted)
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
    /// Describes the kind and the species of the events, such as `core, A and B`.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}, {}", self.kind, self.species.join(" and "))
    }

    /// Describes the rates per particle, such as `0.57 per A, 0.11 per B`. Without such rates, gives the rate of all
    /// events.
    #[must_use]
    pub fn words(&self) -> String {
        let mut words: Vec<String> = Vec::new();
        for (species, rate) in self.species.iter().zip(&self.per_particle) {
            let word = rate.map(|rate| format!("{} per {species}", crate::base::text::digits(rate)));
            words.extend(word.filter(|word| !words.contains(word)));
        }
        match self.per_time {
            Some(rate) if words.is_empty() => crate::base::text::digits(rate),
            _ => words.join(", "),
        }
    }
}

/// Returns the rates to print beside the collision rate. Omits a core rate that equals the collision rate.
#[must_use]
pub fn told_apart(rates: &[Rate]) -> Vec<&Rate> {
    let is_core = |rate: &Rate| rate.kind == "core";
    let is_alone = rates.iter().filter(|rate| is_core(rate)).count() == 1;
    let has_all = |one: &Rate| rates.iter().flat_map(|rate| &rate.species).all(|name| one.species.contains(name));
    rates.iter().filter(|rate| !(is_core(rate) && is_alone && has_all(rate))).collect()
}
