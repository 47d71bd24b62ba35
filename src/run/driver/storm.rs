//! Detects event storms. Spheres at rest under gravity make tiny bounces, which are elastic in the TC model. If
//! simulated time hardly advances during many bounces, this is a storm.
//!
//! Particles at rest normally have a few contacts within one contact time. A storm has thousands of times as many.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::engine::Simulation;
use crate::model::{Scene, Species, SpeciesId};
use crate::run::Ending;

/// A storm has `MOST` events per moving particle, plus `FEWEST` events, within one contact time.
const MOST: u64 = 10_000;
const FEWEST: u64 = 1_000_000;

#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::run) struct StormWatch {
    since: f64,
    next: u64,
    /// A storm has at least `most` events within the simulated time `within`.
    most: u64,
    within: f64,
}

impl StormWatch {
    /// Returns `None` for a scene without gravity or without a contact time.
    pub fn of(scene: &Scene, simulation: &Simulation, moving: u64) -> Option<Self> {
        let fall = |(id, species): (u32, &Species)| {
            let acceleration = species.acceleration.norm();
            let smallest = || *simulation.range_of_diameters(SpeciesId(id)).start();
            (!species.is_static() && acceleration > 0.0).then(|| (smallest() / acceleration).sqrt())
        };
        let fall = (0..).zip(&scene.species).filter_map(fall).reduce(f64::min)?;
        // If the contact time is longer than the fall by one diameter, all contacts are elastic.
        let within = scene.contact_time?.min(fall);
        let most = FEWEST + MOST * moving;
        let events = simulation.event_counts().physical();
        Some(Self { since: simulation.time(), next: events.saturating_add(most), most, within })
    }
}

impl Driver<'_> {
    pub(super) fn next_storm_check(&self) -> u64 {
        self.state.storm_watch.map_or(u64::MAX, |watch| watch.next)
    }

    pub(super) fn check_storm(&mut self) -> ControlFlow<Option<Ending>> {
        let events = self.simulation.event_counts().physical();
        let now = self.simulation.time();
        let Some(watch) = self.state.storm_watch.as_mut().filter(|watch| events >= watch.next) else {
            return ControlFlow::Continue(());
        };
        let advance = now - watch.since;
        (watch.since, watch.next) = (now, events.saturating_add(watch.most));
        let (most, is_storm) = (watch.most, advance < watch.within);
        self.simulation.complete();
        let arrest = is_storm.then(|| self.simulation.storm(most, advance)).flatten();
        arrest.map_or(ControlFlow::Continue(()), |arrest| ControlFlow::Break(Some(Ending::Arrested(arrest))))
    }
}
