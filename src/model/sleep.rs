//! Grains at rest fall asleep, so that they cost no events.

use serde::{Deserialize, Serialize};

/// When grains fall asleep and wake up. A sleeping grain stays where it is, like a static particle.
///
/// A grain that falls asleep loses its kinetic energy, which counts as dissipated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sleep {
    /// Time between two searches for grains at rest `[time]`.
    pub interval: f64,
    /// A grain is at rest if two conditions hold since the previous search: it has moved by at most this distance, and its
    /// contacts were less than [`Self::MOST_CONTACT_TIMES`] contact times apart on average. A grain that has moved farther
    /// wakes its neighbours: the grains whose surfaces were at most this distance away `[length]`.
    pub distance: f64,
    /// A particle that hits a grain at a higher relative speed wakes it. Faster grains do not fall asleep
    /// `[length / time]`.
    pub wake_speed: f64,
}

impl Sleep {
    /// The mean time between the contacts of a grain at rest is less than this number of contact times.
    pub const MOST_CONTACT_TIMES: f64 = 4.0;

    /// A grain with more contacts per contact time than this since the previous search wakes the sleeping grains that
    /// it hits.
    pub const MOST_CONTACTS: f64 = 64.0;

    /// Minimum number of contacts of a grain at rest between two searches.
    #[must_use]
    pub fn fewest_contacts(&self, contact_time: f64) -> f64 {
        (self.interval / (Self::MOST_CONTACT_TIMES * contact_time)).ceil()
    }

    /// Maximum number of contacts between two searches for a grain that does not wake the grains that it hits. A grain
    /// that rattles in a narrow gap between sleeping grains has many more.
    #[must_use]
    pub fn most_contacts(&self, contact_time: f64) -> f64 {
        Self::MOST_CONTACTS * (self.interval / contact_time)
    }

    pub(crate) fn numbers(&self) -> [f64; 3] {
        [self.interval, self.distance, self.wake_speed]
    }
}
