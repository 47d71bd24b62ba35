//! How far a simulation or a stage of a run goes.

use serde::{Deserialize, Serialize};

/// End of an advance or of a stage: a time, a number of physical events, or whichever comes first. Without both, there
/// is no limit.
///
/// A simulation and a [`Run`](crate::Run) count from their beginning: the time is the simulated time, as
/// [`Simulation::time`](crate::Simulation::time) gives it, and the events are all events so far. A plan of a run, such
/// as [`RunPlan`](crate::model::RunPlan), counts both from the start of its stage.
///
/// ```
/// use carom::Until;
///
/// assert_eq!(Until::time(10.0).or_events(500), Until { time: Some(10.0), events: Some(500) });
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Until {
    /// Simulated time `[time]`.
    pub time: Option<f64>,
    /// Number of physical events (Core, Capture, Release, Bounce, wall).
    pub events: Option<u64>,
}

impl Until {
    /// Ends at a time.
    #[must_use]
    pub fn time(time: f64) -> Self {
        Self { time: Some(time), events: None }
    }

    /// Ends at a number of physical events.
    #[must_use]
    pub fn events(events: u64) -> Self {
        Self { time: None, events: Some(events) }
    }

    /// Ends at a number of physical events if they happen before the time.
    #[must_use]
    pub fn or_events(self, events: u64) -> Self {
        Self { events: Some(events), ..self }
    }

    /// Ends at this end or the other, whichever comes first.
    pub(crate) fn or(self, other: Self) -> Self {
        Self::time(self.last_time().min(other.last_time())).or_events(self.last_event().min(other.last_event()))
    }

    /// The time of the end; infinite without a limit on the time.
    pub(crate) fn last_time(self) -> f64 {
        self.time.unwrap_or(f64::INFINITY)
    }

    /// The number of events at the end; the largest number without a limit on the events.
    pub(crate) fn last_event(self) -> u64 {
        self.events.unwrap_or(u64::MAX)
    }
}
