//! Limits of a simulation or of a stage of a run.

use serde::{Deserialize, Serialize};

/// Limit of a simulation or a stage: a time, a number of physical events, both, or neither. The limit that is reached
/// first ends the simulation or stage.
///
/// In a simulation and a [`Run`](crate::Run), the limits are compared with
/// [`Simulation::time`](crate::Simulation::time) and the number of all events so far. In a plan of a run, such as
/// [`RunPlan`](crate::model::RunPlan), time and events are counted from the start of the stage.
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
    /// Ends when the simulated time reaches `time`.
    #[must_use]
    pub fn time(time: f64) -> Self {
        Self { time: Some(time), events: None }
    }

    /// Ends when the number of physical events reaches `events`.
    #[must_use]
    pub fn events(events: u64) -> Self {
        Self { time: None, events: Some(events) }
    }

    /// Adds a limit on the number of physical events. The limit that is reached first ends the simulation or stage.
    #[must_use]
    pub fn or_events(self, events: u64) -> Self {
        Self { events: Some(events), ..self }
    }

    /// Combines two limits. The limit that is reached first ends the simulation.
    pub(crate) fn or(self, other: Self) -> Self {
        Self::time(self.last_time().min(other.last_time())).or_events(self.last_event().min(other.last_event()))
    }

    pub(crate) fn last_time(self) -> f64 {
        self.time.unwrap_or(f64::INFINITY)
    }

    pub(crate) fn last_event(self) -> u64 {
        self.events.unwrap_or(u64::MAX)
    }
}
