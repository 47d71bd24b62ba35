//! Epochs of a system that runs in domains.

use super::{Domains, Next};
use crate::engine::parts::Engine;
use crate::engine::{Reason, Until};
use std::time::Instant;

impl<const FALLING: bool, const TABLE: bool> Domains<FALLING, TABLE> {
    /// Ends the epoch, in the single engine if it must examine or reorder all particles, otherwise in the domains.
    pub(super) fn move_epoch(&mut self, whole: &mut Engine<FALLING, TABLE>, until: Until) -> Next {
        let is_looked_at = whole.is_layout_looked_at(whole.clock.epochs + 1);
        let is_proof_due = until.last_time() == f64::INFINITY && whole.is_proof_due();
        let Some(cut) = &mut self.cut else { return Next::Done };
        let next = self.team.all(self.team.each(cut.domains.iter().collect(), |domain| domain.next_due()));
        let next = next.into_iter().fold(whole.sources.next_global, f64::min);
        if is_proof_due || next == f64::INFINITY || !whole.schedule.queue.fits(whole.state.moving) {
            return self.move_epoch_of_whole(whole, until);
        }
        if is_looked_at {
            self.settle(whole);
            if whole.is_layout_outdated() {
                return self.move_epoch_of_whole(whole, until);
            }
        }
        let Some(cut) = &mut self.cut else { return Next::Done };
        let begin = Instant::now();
        whole.schedule.queue.resume(cut.now, cut.steps);
        let moved = whole.begin_epoch(next);
        cut.now -= moved.shift;
        cut.latest -= moved.shift;
        (cut.steps, cut.is_settled, cut.is_complete) = (0, false, false);
        whole.clock.now = cut.now;
        cut.follow(whole, moved, &self.team);
        self.work.moving += begin.elapsed();
        Next::Done
    }

    /// Ends the epoch in the single engine. The system is then cut again.
    fn move_epoch_of_whole(&mut self, whole: &mut Engine<FALLING, TABLE>, until: Until) -> Next {
        self.settle(whole);
        self.settle_plans(whole);
        let Some(cut) = &mut self.cut else { return Next::Done };
        // If no event follows, the run ends at the time of the last step.
        whole.clock.now = cut.latest;
        if until.last_time() == f64::INFINITY && whole.is_shown_to_be_over() {
            return Next::Return(Reason::Idle);
        }
        whole.schedule.queue.resume(cut.now, cut.steps);
        if whole.move_epoch().is_some() {
            self.cut = None;
            return Next::Done;
        }
        if until.last_time() == f64::INFINITY {
            return Next::Return(Reason::Idle);
        }
        whole.clock.now = whole.since_epoch(until.last_time());
        Next::Return(Reason::Time)
    }
}
