//! Storms of events: spheres that rest in contact under gravity bounce by next to nothing, and the TC model makes all of these contacts elastic.
//!
//! What loses energy under gravity comes to rest with contacts at intervals of about the contact time, some for each particle. Ten thousand times as many are
//! a storm, in which the time hardly advances.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::engine::Simulation;
use crate::model::Scene;
use crate::run::Ending;

/// More events of each particle within a contact time are a storm; in small systems more than [`FEWEST`] of all.
const MOST: u64 = 10_000;
const FEWEST: u64 = 1_000_000;

/// Events since a time, of a system that storms can come to.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::run) struct StormWatch {
    /// Simulated time from which they are counted.
    since: f64,
    /// Physical events, since the start of the simulation, at which the time is looked at.
    next: u64,
    /// Number of events that make a storm within this time.
    most: u64,
    within: f64,
}

impl StormWatch {
    /// For a simulation of a scene with gravity and a contact time.
    pub fn of(scene: &Scene, simulation: &Simulation, moving: u64) -> Option<Self> {
        let fall = |species: &crate::model::Species| {
            let acceleration = species.acceleration.norm();
            (!species.is_static() && acceleration > 0.0).then(|| (species.diameter / acceleration).sqrt())
        };
        let fall = scene.species.iter().filter_map(fall).reduce(f64::min)?;
        // A longer contact time makes everything elastic.
        let within = scene.contact_time?.min(fall);
        let most = FEWEST + MOST * moving;
        let events = simulation.event_counts().physical();
        Some(Self { since: simulation.time(), next: events.saturating_add(most), most, within })
    }
}

impl Driver<'_> {
    /// Physical events at which it is looked for a storm next.
    pub(super) fn next_storm_check(&self) -> u64 {
        self.state.storm_watch.map_or(u64::MAX, |watch| watch.next)
    }

    /// Ends the run in a storm.
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
