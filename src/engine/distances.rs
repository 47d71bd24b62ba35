//! Contact distances: the distance of a discontinuity at a given time, constant or growing.

mod growth;

use super::parts::Engine;
use crate::physics::motion::RelativeState;
use growth::GrowingDiameters;
use serde::{Deserialize, Serialize};

/// How contact distances change with time.
#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Distances {
    growing: Option<GrowingDiameters>,
}

impl Distances {
    /// Returns whether all distances keep their values of the scene at all times.
    #[inline]
    pub fn are_constant(&self) -> bool {
        self.growing.is_none()
    }

    #[inline]
    pub fn growing(&self) -> Option<&GrowingDiameters> {
        self.growing.as_ref()
    }

    /// A distance of the scene at a time since the epoch, and its growth rate `[length, length / time]`.
    #[inline]
    pub fn at(&self, distance: f64, time: f64) -> [f64; 2] {
        self.growing.map_or([distance, 0.0], |growing| [distance * growing.scale(time), growing.rate * distance])
    }

    /// Returns the growth rate of a distance whose value in the scene is `distance`.
    pub fn speed_of(&self, distance: f64) -> f64 {
        self.at(distance, 0.0)[1]
    }

    /// Returns the time until two particles outside a discontinuity reach it. `distance` is its distance in
    /// the scene, and `time`, since the epoch, is the present time.
    pub fn next_contact(&self, state: &RelativeState, distance: f64, time: f64) -> Option<f64> {
        let [distance, speed] = self.at(distance, time);
        growth::next_contact(state, distance, speed)
    }

    /// Returns the factor by which the range of the neighbour search has to exceed the distances of the
    /// scene.
    pub fn reach_factor(&self) -> f64 {
        self.growing.map_or(1.0, |growing| growing.reach)
    }

    /// Time since the epoch at which distances outgrow the neighbour search; infinite if they never do.
    pub fn next_stage(&self) -> f64 {
        self.growing.as_ref().map_or(f64::INFINITY, GrowingDiameters::next_stage)
    }

    /// Shifts times to an epoch that is later by `shift`.
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
