//! Result of a verification.

use super::replay::RunEnd;
use super::violation::Violation;
use crate::engine::{Arrest, InvariantBroken};

/// Margins of the proof: the largest deviations, divided by their round-off bounds. They are at most 1 in a valid run.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Margins {
    /// Distance of the particles from their discontinuity at an event.
    pub distance: f64,
    /// Growth of an overlap after its event was due.
    pub overlap: f64,
    /// Velocities, momenta and energies after an event.
    pub outcome: f64,
    /// Position of a particle after a free flight.
    pub flight: f64,
}

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
    /// The replay ended differently from the recorded run, so the proof does not apply to the recorded run.
    Departed {
        /// Recorded end of the run.
        recorded: RunEnd,
        /// Number of physical events in the replay at its end.
        events: u64,
        /// Simulated time at which the replay ended.
        time: f64,
    },
    /// No further event will ever happen.
    Idle,
    /// The caller stopped the verification.
    Interrupted,
    /// The event rule does not cover the run, because it has a thermostat, a barostat, swap moves, growth, shear, a
    /// thermal wall or surface, an inlet or an outlet.
    Driven,
    /// Surfaces or gravity change after an automatic equilibration, whose end time is unknown to the replay.
    OpenStages,
    /// The run violates the event rule.
    Violated(Violation),
    /// The particles come to rest only after infinitely many events, so the engine stopped.
    Arrested(Arrest),
    /// The engine reached an impossible state.
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
    /// Events that were due slightly before the executed event, within round-off.
    pub ties: u64,
    /// Events whose closing speed is zero within round-off, as at the turning point of a gap.
    pub turning_points: u64,
    /// Events at which the particles were on the invalid side of the discontinuity by more than round-off.
    pub in_invalid_state: u64,
    /// Completed time windows. Each window starts with a search of all pairs.
    pub windows: u64,
    /// Number of evaluations of Algorithm 1.
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
    /// Number of the first event of the range, counted from 1.
    pub first_event: u64,
    /// Simulated time at the start of the range.
    pub start: f64,
    /// Simulated time covered by the range.
    pub duration: f64,
    /// Counts of the verified events.
    pub counts: Counts,
    /// Largest deviations in the proof, each divided by its round-off bound.
    pub margins: Margins,
    /// Largest gap at an event, relative to the distance of the discontinuity, or to the radius at walls and surfaces.
    pub largest_gap: f64,
    /// Deepest overlap at an event, relative to the same length as the largest gap.
    pub deepest_overlap: f64,
    /// Reason why the verification ended.
    pub end: End,
}

impl Certificate {
    pub(super) fn blank(first_event: u64, start: f64) -> Self {
        Self { first_event, start, ..Self::default() }
    }

    /// Whether all verified events are proven.
    #[must_use]
    pub fn is_proven(&self) -> bool {
        !matches!(
            self.end,
            End::Violated(_) | End::Arrested(_) | End::Broken(_) | End::Driven | End::OpenStages | End::Departed { .. }
        )
    }
}
