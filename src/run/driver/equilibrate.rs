//! Equilibration that ends when nothing drifts any more.

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::analysis::observables::{Answer, Equilibrium, Observer};
use crate::run::Recorder;
use crate::run::progress::Stage;

/// Events per particle from one look to the next.
const EVENTS_PER_LOOK: u64 = 2;

/// Looks after which it is first asked whether something drifts: each particle has had some four hundred events, which melt most lattices.
const FEWEST_LOOKS: u32 = 100;

/// From one question to the next the number of looks grows by this part, so that the second half of them, which is asked about, is a new one after
/// three questions.
const GROWTH: u32 = 4;

/// The course of the observables in an equilibration that ends by itself: looked at after numbers of events, whatever is written meanwhile.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::run) struct Monitor {
    observer: Observer,
    /// Physical events at the next look.
    pub(super) next: u64,
    /// Events from one look to the next.
    step: u64,
    /// Looks so far, and at the next question.
    looks: u32,
    asked_at: u32,
}

impl Monitor {
    /// Events before it is first asked whether something drifts.
    pub fn shortest(&self) -> u64 {
        u64::from(FEWEST_LOOKS).saturating_mul(self.step)
    }
}

impl<R: Recorder> Driver<'_, R> {
    /// Watches the observables from now on, if the equilibration ends by them.
    pub(super) fn begin_monitor(&mut self) {
        let is_watched =
            self.course.stage.stage == Stage::Equilibration && self.simulation.scene().run.until_stationary;
        self.course.monitor = is_watched.then(|| {
            let mut observer = Observer::new(self.simulation.scene());
            observer.row(&self.simulation);
            let step = (EVENTS_PER_LOOK * observer.meaning().moving as u64).max(1);
            let next = self.simulation.tally().physical().saturating_add(step);
            Monitor { observer, next, step, looks: 0, asked_at: FEWEST_LOOKS }
        });
    }

    /// Whether the present stage is an equilibration that ends when nothing drifts, and that is so.
    pub(super) fn is_stationary(&mut self) -> bool {
        let events = self.simulation.tally().physical();
        let Some(monitor) = self.course.monitor.as_mut().filter(|monitor| events >= monitor.next) else { return false };
        monitor.observer.row(&self.simulation);
        monitor.next = events.saturating_add(monitor.step);
        monitor.looks += 1;
        if monitor.looks < monitor.asked_at {
            return false;
        }
        monitor.asked_at = monitor.looks + monitor.looks / GROWTH;
        Equilibrium::of(&monitor.observer.stationarity_of_second_half()).verdict == Answer::Yes
    }
}
