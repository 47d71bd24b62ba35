//! Distances of contact: what the discontinuity of a pair is at a time, constant or growing.

mod growth;

use super::parts::Engine;
use crate::physics::motion::RelativeState;
use growth::GrowingDiameters;
use serde::{Deserialize, Serialize};

/// How distances of contact change.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Distances {
    growing: Option<GrowingDiameters>,
}

impl Distances {
    /// Whether they are those of the scene, at any time.
    #[inline]
    pub fn are_constant(&self) -> bool {
        self.growing.is_none()
    }

    #[inline]
    pub fn growing(&self) -> Option<&GrowingDiameters> {
        self.growing.as_ref()
    }

    /// A distance of the scene at a time since the epoch, and how fast it grows `[length, length / time]`.
    #[inline]
    pub fn at(&self, distance: f64, time: f64) -> [f64; 2] {
        self.growing.map_or([distance, 0.0], |growing| [distance * growing.scale(time), growing.rate * distance])
    }

    /// How fast a distance grows that is `distance` in the scene.
    pub fn speed_of(&self, distance: f64) -> f64 {
        self.at(distance, 0.0)[1]
    }

    /// Time from now, at a time since the epoch, until two particles are as far apart as a distance of the scene is then, from outside.
    pub fn next_contact(&self, state: &RelativeState, distance: f64, time: f64) -> Option<f64> {
        let [distance, speed] = self.at(distance, time);
        growth::next_contact(state, distance, speed)
    }

    /// The factor of the distances that a search has to reach.
    pub fn reach_factor(&self) -> f64 {
        self.growing.map_or(1.0, |growing| growing.reach)
    }

    /// When distances outgrow the search, since the epoch; infinite for never.
    pub fn next_stage(&self) -> f64 {
        self.growing.as_ref().map_or(f64::INFINITY, GrowingDiameters::next_stage)
    }

    /// Counts times from an epoch that is later by `shift`.
    pub fn shift(&mut self, shift: f64) {
        if let Some(growing) = &mut self.growing {
            growing.shift(shift);
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// The factor of all diameters now.
    pub fn scale(&self) -> f64 {
        self.distances.growing().map_or(1.0, |growing| growing.scale(self.clock.now))
    }
}
