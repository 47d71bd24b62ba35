//! Event storms: spheres that rest in contact under gravity bounce by next to nothing, and the TC model makes
//! all of these contacts elastic.
//!
//! Dissipative particles under gravity come to rest with contacts at intervals of about the contact time,
//! several per particle. Ten thousand times as many are a storm, in which time hardly advances.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::engine::Simulation;
use crate::model::Scene;
use crate::run::Ending;

/// Number of events per particle within a contact time above which the events are a storm. In small systems,
/// a storm has at least [`FEWEST`] events in all.
const MOST: u64 = 10_000;
const FEWEST: u64 = 1_000_000;

/// Event count since a time, for a system that may have storms.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::run) struct StormWatch {
    /// Simulated time at which the count began.
    since: f64,
    /// Number of physical events, since the start of the simulation, at the next check of the time.
    next: u64,
    /// Number of events that are a storm within this time.
    most: u64,
    within: f64,
}

impl StormWatch {
    /// For a simulation with gravity and a contact time.
    pub fn of(scene: &Scene, simulation: &Simulation, moving: u64) -> Option<Self> {
        let fall = |species: &crate::model::Species| {
            let acceleration = species.acceleration.norm();
            (!species.is_static() && acceleration > 0.0).then(|| (species.diameter / acceleration).sqrt())
        };
        let fall = scene.species.iter().filter_map(fall).reduce(f64::min)?;
        // A longer contact time makes all contacts elastic.
        let within = scene.contact_time?.min(fall);
        let most = FEWEST + MOST * moving;
        let events = simulation.event_counts().physical();
        Some(Self { since: simulation.time(), next: events.saturating_add(most), most, within })
    }
}

impl Driver<'_> {
    /// Number of physical events at the next check for a storm.
    pub(super) fn next_storm_check(&self) -> u64 {
        self.state.storm_watch.map_or(u64::MAX, |watch| watch.next)
    }

    /// Ends the run if there is a storm.
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
