//! Progress of a run, for its caller.

use super::stage::Stage;
use crate::model::Until;

/// Progress of a run in its current stage.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Progress {
    /// The stage.
    pub stage: Stage,
    /// Current simulated time `[time]`.
    pub time: f64,
    /// Simulated time since the start of the stage `[time]`.
    pub elapsed: f64,
    /// Physical events since the start of the stage.
    pub events: u64,
    /// Limits of the stage, counted from the start of the stage.
    pub limit: Until,
}

impl Progress {
    /// Completed fraction of the stage, from 0 to 1. If the stage has two limits, the larger fraction is returned.
    #[must_use]
    pub fn fraction(&self) -> f64 {
        let by_time = self.limit.time.map_or(0.0, |limit| self.elapsed / limit);
        let by_events = self.limit.events.map_or(0.0, |limit| self.events as f64 / limit as f64);
        by_time.max(by_events).clamp(0.0, 1.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_follows_the_nearer_limit() {
        let limit = Until { time: Some(10.0), events: Some(100) };
        let progress = Progress { stage: Stage::Measurement, time: 7.0, elapsed: 2.0, events: 50, limit };
        assert_eq!(progress.fraction(), 0.5);
        assert_eq!(Progress { elapsed: 9.0, ..progress }.fraction(), 0.9);
        assert_eq!(Progress { limit: Until::default(), ..progress }.fraction(), 0.0);
    }
}
