//! Grains at rest fall asleep, so that they cost no events.

use serde::{Deserialize, Serialize};

/// When grains fall asleep and wake up. A sleeping grain stays where it is, like a static particle.
///
/// A grain that falls asleep loses its kinetic energy, which counts as dissipated.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Sleep {
    /// Time between two searches for grains at rest `[time]`.
    pub interval: f64,
    /// A grain is at rest if it has moved by at most this distance since the previous search, and if its contacts follow
    /// each other in less than [`Self::MOST_CONTACT_TIMES`] contact times on average `[length]`. If a grain has moved by
    /// more, all grains wake up that were within this distance of touching it.
    pub distance: f64,
    /// A grain wakes up if a particle hits it with a higher relative speed `[length / time]`. Grains with a higher speed
    /// do not fall asleep.
    pub wake_speed: f64,
}

impl Sleep {
    /// The mean time between the contacts of a grain at rest is less than this number of contact times.
    pub const MOST_CONTACT_TIMES: f64 = 4.0;

    /// The smallest number of contacts between two searches of a grain at rest.
    #[must_use]
    pub fn fewest_contacts(&self, contact_time: f64) -> f64 {
        (self.interval / (Self::MOST_CONTACT_TIMES * contact_time)).ceil()
    }

    pub(crate) fn numbers(&self) -> [f64; 3] {
        [self.interval, self.distance, self.wake_speed]
    }
}
