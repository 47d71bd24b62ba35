//! Contact distances: the distance of a discontinuity at a given time, constant or growing.

pub(super) mod growth;

use super::parts::Engine;
use crate::physics::motion::RelativeState;
use growth::GrowingDiameters;
use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, Default, Serialize, Deserialize)]
pub(super) struct Distances {
    growing: Option<GrowingDiameters>,
}

impl Distances {
    #[inline]
    pub fn are_constant(&self) -> bool {
        self.growing.is_none()
    }

    #[inline]
    pub fn growing(&self) -> Option<&GrowingDiameters> {
        self.growing.as_ref()
    }

    /// Returns a contact distance and its growth rate `[length, length / time]` at a time since the epoch. `distance`
    /// is the contact distance before growth.
    #[inline]
    pub fn at(&self, distance: f64, time: f64) -> [f64; 2] {
        self.growing.map_or([distance, 0.0], |growing| [distance * growing.scale(time), growing.rate * distance])
    }

    /// Returns the growth rate of a contact distance.
    pub fn speed_of(&self, distance: f64) -> f64 {
        self.at(distance, 0.0)[1]
    }

    /// Returns the time until two particles reach a discontinuity from outside. `time` is the current time since the
    /// epoch.
    pub fn next_contact(&self, state: &RelativeState, distance: f64, time: f64) -> Option<f64> {
        let [distance, speed] = self.at(distance, time);
        growth::next_contact(state, distance, speed)
    }

    /// Returns the factor by which all ranges of the neighbour search are enlarged.
    pub fn reach_factor(&self) -> f64 {
        self.growing.map_or(1.0, |growing| growing.reach)
    }

    /// Time since the epoch at which contact distances outgrow the neighbour search; infinite if they never do.
    pub fn next_stage(&self) -> f64 {
        self.growing.as_ref().map_or(f64::INFINITY, GrowingDiameters::next_stage)
    }

    pub fn shift(&mut self, shift: f64) {
        if let Some(growing) = &mut self.growing {
            growing.shift(shift);
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Current scale factor of all diameters, relative to the scene.
    pub fn scale(&self) -> f64 {
        self.distances.growing().map_or(1.0, |growing| growing.scale(self.clock.now))
    }
}
