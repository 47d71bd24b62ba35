//! Result of a verification.

use super::replay::RunEnd;
use super::violation::Violation;
use crate::engine::{Arrest, InvariantBroken};

/// Margins of the proof: the largest deviations relative to their round-off bounds. The limit is 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Margins {
    /// Distances from the discontinuity at events.
    pub distance: f64,
    /// Decrease of overlap functions while negative.
    pub overlap: f64,
    /// Velocities, momenta and energies after events.
    pub outcome: f64,
    /// Flights of particles between events.
    pub flight: f64,
}

/// Keeps the largest ratio.
pub(super) fn note(worst: &mut f64, by: f64, bound: f64) {
    if bound > 0.0 {
        *worst = worst.max(by / bound);
    }
}

/// Why a verification ended.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub enum End {
    /// All requested events are proven.
    #[default]
    Asked,
    /// All events up to the planned end of the run are proven.
    RunEnded,
    /// The replay ended differently from the recorded run, so the proof does not apply to the recorded
    /// run.
    Departed {
        /// The recorded end of the run.
        recorded: RunEnd,
        /// Physical events of the replay at that end, or one more than the run had.
        events: u64,
        /// Simulated time of the replay at that point.
        time: f64,
    },
    /// Nothing will ever happen again: no pair, in any image, and no particle at any wall or surface has
    /// another event.
    Idle,
    /// The caller stopped it.
    Interrupted,
    /// Something acts from outside: a thermostat, growth, a sheared box, or a thermal wall or surface. The
    /// rule does not cover it.
    Driven,
    /// A stage that ends by its measurements changes surfaces or gravity. The replay cannot tell when it
    /// ends.
    OpenStages,
    /// An event is wrong.
    Violated(Violation),
    /// The dynamics came to rest in a way that needs infinitely many events.
    Arrested(Arrest),
    /// The engine met an impossible state.
    Broken(InvariantBroken),
}

/// Numbers of proven events, by kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Counts {
    /// Core events.
    pub core: u64,
    /// Capture events.
    pub capture: u64,
    /// Release events.
    pub release: u64,
    /// Bounce events.
    pub bounce: u64,
    /// Contacts with walls.
    pub wall: u64,
    /// Contacts with surfaces of the scene.
    pub surface: u64,
    /// Events at which another event was due earlier, by less than round-off.
    pub ties: u64,
    /// Events whose closing speed is within round-off: turning points.
    pub turning_points: u64,
    /// Events at which the state was invalid beyond round-off.
    pub in_invalid_state: u64,
    /// Completed windows of simulated time; each starts with a search of all pairs.
    pub windows: u64,
    /// Number of calls of Algorithm 1.
    pub asked: u64,
}

impl Counts {
    /// Total number of proven events.
    #[must_use]
    pub fn events(&self) -> u64 {
        self.core + self.capture + self.release + self.bounce + self.wall + self.surface
    }
}

/// The certificate for a range of events.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Certificate {
    /// Number of the first verified event, counted from 1.
    pub first_event: u64,
    /// Simulated time at the start of the range.
    pub start: f64,
    /// Simulated time covered by the range.
    pub duration: f64,
    /// Counts of the verified events.
    pub counts: Counts,
    /// Margins of the proof.
    pub margins: Margins,
    /// Largest distance from the discontinuity at an event in a valid state, relative to the distance of the
    /// discontinuity.
    pub largest_gap: f64,
    /// Deepest overlap at an event, relative to the distance of the discontinuity.
    pub deepest_overlap: f64,
    /// Reason why the verification ended.
    pub end: End,
}

impl Certificate {
    /// The certificate before any event.
    pub(super) fn blank(first_event: u64, start: f64) -> Self {
        Self { first_event, start, ..Self::default() }
    }

    /// Whether every verified event is proven and the simulation could continue.
    #[must_use]
    pub fn is_proven(&self) -> bool {
        !matches!(
            self.end,
            End::Violated(_) | End::Arrested(_) | End::Broken(_) | End::Driven | End::OpenStages | End::Departed { .. }
        )
    }
}
