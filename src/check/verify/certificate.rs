//! Result of a verification.

use super::replay::RunEnd;
use super::violation::Violation;
use crate::engine::{Arrest, InvariantBroken};

/// Margins of the proof: the largest deviations relative to their round-off bounds; 1 is the limit.
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
    /// All events that were asked for are proven.
    #[default]
    Asked,
    /// All events up to the end that the scene plans for the run are proven.
    RunEnded,
    /// The replay has come to another end than the run that it should be: what was proven belongs to another run.
    Departed {
        /// The end of the run, by its record.
        recorded: RunEnd,
        /// Physical events of the replay when the end was due, or one more than the run had.
        events: u64,
        /// Simulated time of the replay then.
        time: f64,
    },
    /// Nothing will ever happen again: no pair, in any image, and no particle and wall or surface has an event in all the time to come.
    Idle,
    /// The caller wanted no more.
    Interrupted,
    /// Something acts from outside: a thermostat, a growth, a sheared box, a thermal wall or surface. The rule that is proven does not cover that.
    Driven,
    /// Surfaces come or go, or gravity turns, when a stage has ended that ends by what it measures: the replay cannot tell when.
    OpenStages,
    /// An event is wrong.
    Violated(Violation),
    /// The dynamics came to rest in a way that needs infinitely many events.
    Arrested(Arrest),
    /// The engine met an impossible state.
    Broken(InvariantBroken),
}

/// Numbers of events that were proven, by kind.
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
    /// Events before which another one was due by less than round-off.
    pub ties: u64,
    /// Events without a closing speed, beyond round-off: turning points.
    pub turning_points: u64,
    /// Events in an invalid state, beyond round-off.
    pub in_invalid_state: u64,
    /// Windows of simulated time that have passed: searches of all pairs.
    pub windows: u64,
    /// Number of calls of Algorithm 1.
    pub asked: u64,
}

impl Counts {
    /// Events that were proven.
    #[must_use]
    pub fn events(&self) -> u64 {
        self.core + self.capture + self.release + self.bounce + self.wall + self.surface
    }
}

/// The certificate of a verified range of events.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Certificate {
    /// Number of the first event that was verified, from 1.
    pub first_event: u64,
    /// Simulated time at the start of the range.
    pub start: f64,
    /// Simulated time that the range takes.
    pub duration: f64,
    /// Counts of the verified events.
    pub counts: Counts,
    /// How close to the bounds.
    pub margins: Margins,
    /// Largest distance from the discontinuity at an event in a valid state, relative to the discontinuity's distance.
    pub largest_gap: f64,
    /// Deepest overlap at an event, relative to the discontinuity's distance.
    pub deepest_overlap: f64,
    /// Why it ended.
    pub end: End,
}

impl Certificate {
    /// The certificate before any event.
    pub(super) fn blank(first_event: u64, start: f64) -> Self {
        Self { first_event, start, ..Self::default() }
    }

    /// Whether every event that was verified is proven, and the simulation could go on.
    #[must_use]
    pub fn is_proven(&self) -> bool {
        !matches!(
            self.end,
            End::Violated(_) | End::Arrested(_) | End::Broken(_) | End::Driven | End::OpenStages | End::Departed { .. }
        )
    }
}
