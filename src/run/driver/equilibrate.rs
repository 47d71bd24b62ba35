//! Equilibration that ends when nothing drifts any more.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::analysis::observables::{Observer, is_settled};
use crate::model::Limit;
use crate::run::progress::Stage;
use crate::run::{Ending, Recorder};

/// Events per particle from one look to the next.
const EVENTS_PER_LOOK: u64 = 2;

/// Looks after which it is first asked whether something drifts: each particle has had some four hundred events, which melt most lattices.
const FEWEST_LOOKS: u32 = 100;

/// So many times that, without a limit in the scene, it gives up: what still drifts then, such as a gas that cools, does not end, nor what cannot be told, such
/// as a single particle between walls.
const PATIENCE: u32 = 1000;

/// Events per particle after which an equilibration without a limit gives up.
pub const MOST_EVENTS_PER_PARTICLE: u64 = EVENTS_PER_LOOK * FEWEST_LOOKS as u64 * PATIENCE as u64;

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
        let is_watched = self.state.stage.stage == Stage::Equilibration && self.simulation.scene().run.until_stationary;
        self.state.monitor = is_watched.then(|| {
            let mut observer = Observer::new(self.simulation.scene());
            observer.row(&self.simulation);
            let step = (EVENTS_PER_LOOK * observer.applicable().moving as u64).max(1);
            let next = self.simulation.tally().physical().saturating_add(step);
            Monitor { observer, next, step, looks: 0, asked_at: FEWEST_LOOKS }
        });
    }

    /// Ends an equilibration that goes on until nothing drifts where that is so, and the run where it never will be.
    pub(super) fn look_at_equilibrium(&mut self) -> ControlFlow<Option<Ending>> {
        let events = self.simulation.tally().physical();
        let is_limited = self.state.stage.limit != Limit::default();
        let Some(monitor) = self.state.monitor.as_mut().filter(|monitor| events >= monitor.next) else {
            return ControlFlow::Continue(());
        };
        monitor.observer.row(&self.simulation);
        monitor.next = events.saturating_add(monitor.step);
        monitor.looks += 1;
        if monitor.looks < monitor.asked_at {
            return ControlFlow::Continue(());
        }
        let last = FEWEST_LOOKS.saturating_mul(PATIENCE);
        let next = monitor.looks.saturating_add(monitor.looks / GROWTH);
        monitor.asked_at = if is_limited { next } else { next.min(last) };
        if is_settled(&monitor.observer.stationarity_of_second_half()) {
            ControlFlow::Break(None)
        } else if !is_limited && monitor.looks >= last {
            ControlFlow::Break(Some(Ending::Unsettled))
        } else {
            ControlFlow::Continue(())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;
    use crate::model::potential::Potential;
    use crate::model::space::{Boundary, Face, Space};
    use crate::model::{RunPlan, Scene};
    use crate::run;
    use crate::scene::SceneBuilder;

    /// Two particles that go to and fro between two walls, past each other.
    fn to_and_fro(restitution: f64, equilibration: Limit) -> Scene {
        let mut space = Space::periodic_cube(5.0);
        let wall = Face::Wall { restitution };
        space.boundary[0] = Boundary::Bounded { lower: wall, upper: wall };
        let run = RunPlan { equilibration, until_stationary: true, limit: Limit::events(10), ..RunPlan::default() };
        SceneBuilder::new("ball")
            .space(space)
            .species("A", 1.0, 1.0)
            .interaction("A", "A", Potential::hard_sphere(1.0).unwrap(), 1.0)
            .particle("A", Vector::new(2.0, 1.0, 1.0), Vector::new(1.0, 0.0, 0.0))
            .particle("A", Vector::new(2.0, 3.5, 3.5), Vector::new(-1.0, 0.0, 0.0))
            .run(run)
            .build()
            .unwrap()
    }

    /// How it ends, and after how many events; what goes on after `most` is interrupted.
    fn ending(scene: Scene, most: u64) -> (Ending, u64) {
        let go_on = |progress: &run::Progress| {
            if progress.events > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let finished = run::run(scene, &mut (), &mut |progress| go_on(progress)).unwrap();
        (finished.ending, finished.simulation.tally().physical())
    }

    #[test]
    fn what_is_constant_is_in_equilibrium() {
        let (ending, events) = ending(to_and_fro(1.0, Limit::default()), 100_000);
        assert_eq!(ending, Ending::Events);
        assert!(events < 1_000, "{events}");
    }

    #[test]
    fn what_loses_energy_for_ever_is_given_up_unless_the_scene_has_a_limit() {
        let most = 2 * MOST_EVENTS_PER_PARTICLE;
        assert_eq!(ending(to_and_fro(0.9999, Limit::default()), 2 * most), (Ending::Unsettled, most));
        assert_eq!(ending(to_and_fro(0.9999, Limit::events(most + 1_000)), 2 * most), (Ending::Events, most + 1_010));
    }
}
