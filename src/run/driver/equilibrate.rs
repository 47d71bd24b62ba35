//! Automatic equilibration, which ends when no observable drifts any more.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::Driver;
use crate::analysis::observables::{Observer, is_settled};
use crate::model::Until;
use crate::run::Ending;

/// Number of events per particle between two samples of the observables.
const EVENTS_PER_SAMPLE: u64 = 2;

/// Number of samples before the first test for drift. By then, each particle has taken part in about 400 events, which
/// melts most lattices.
const FEWEST_SAMPLES: u32 = 100;

/// An equilibration without a limit gives up after `PATIENCE` times [`FEWEST_SAMPLES`] samples. Some systems always
/// drift, such as a cooling gas. Some cannot be tested, such as a single particle between walls.
const PATIENCE: u32 = 1000;

/// Number of events per particle after which an equilibration without a limit gives up.
pub const MOST_EVENTS_PER_PARTICLE: u64 = EVENTS_PER_SAMPLE * FEWEST_SAMPLES as u64 * PATIENCE as u64;

/// The number of samples grows by `1 / GROWTH` between two tests. A test uses the second half of the samples.
const GROWTH: u32 = 4;

/// Time series of the observables during an automatic equilibration, sampled after fixed numbers of events.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::run) struct Monitor {
    pub(super) observer: Observer,
    pub(super) next: u64,
    step: u64,
    samples: u32,
    next_test: u32,
}

impl Monitor {
    pub fn shortest(&self) -> u64 {
        u64::from(FEWEST_SAMPLES).saturating_mul(self.step)
    }
}

impl Driver<'_> {
    pub(super) fn begin_monitor(&mut self) {
        let is_watched = self.settings().until_stationary;
        self.state.monitor = is_watched.then(|| {
            let mut observer = self.state.observer.clone();
            observer.begin();
            observer.row(&self.simulation);
            let step = (EVENTS_PER_SAMPLE * observer.applicable().moving as u64).max(1);
            let next = self.simulation.event_counts().physical().saturating_add(step);
            Monitor { observer, next, step, samples: 0, next_test: FEWEST_SAMPLES }
        });
    }

    /// Ends the equilibration if no observable drifts. Ends the run if an equilibration without a limit takes too long.
    pub(super) fn check_equilibrium(&mut self) -> ControlFlow<Option<Ending>> {
        let events = self.simulation.event_counts().physical();
        let is_limited = self.state.stage.limit != Until::default();
        let Some(monitor) = self.state.monitor.as_mut().filter(|monitor| events >= monitor.next) else {
            return ControlFlow::Continue(());
        };
        monitor.observer.row(&self.simulation);
        monitor.next = events.saturating_add(monitor.step);
        monitor.samples += 1;
        if monitor.samples < monitor.next_test {
            return ControlFlow::Continue(());
        }
        let last = FEWEST_SAMPLES.saturating_mul(PATIENCE);
        let next = monitor.samples.saturating_add(monitor.samples / GROWTH);
        monitor.next_test = if is_limited { next } else { next.min(last) };
        if is_settled(&monitor.observer.stationarity_of_second_half()) {
            ControlFlow::Break(None)
        } else if !is_limited && monitor.samples >= last {
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
    use crate::model::space::{Boundary, Face, Space};
    use crate::model::{ContactLaw, RunPlan, Scene};
    use crate::run;
    use crate::scene::{InteractionDraft, Model, SceneBuilder, SpeciesDraft};

    fn to_and_fro(restitution: f64, equilibration: Until) -> Scene {
        let mut space = Space::periodic_cube(5.0);
        let wall = Face::Wall(ContactLaw::smooth(restitution));
        space.boundary[0] = Boundary::Bounded { lower: wall, upper: wall };
        let run = RunPlan { equilibration, until_stationary: true, limit: Until::events(10), ..RunPlan::default() };
        SceneBuilder::new("ball")
            .space(space)
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::new(2.0, 1.0, 1.0), Vector::new(1.0, 0.0, 0.0))
            .particle("A", Vector::new(2.0, 3.5, 3.5), Vector::new(-1.0, 0.0, 0.0))
            .run(run)
            .build()
            .unwrap()
    }

    fn ending(scene: Scene, most: u64) -> (Ending, u64) {
        let go_on = |progress: &run::Progress| {
            if progress.events > most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        let finished = run::run(scene, &mut (), &mut |progress| go_on(progress)).unwrap();
        (finished.ending, finished.simulation.event_counts().physical())
    }

    #[test]
    fn constant_energy_counts_as_equilibrium() {
        let (ending, events) = ending(to_and_fro(1.0, Until::default()), 100_000);
        assert_eq!(ending, Ending::Events);
        assert!(events < 1_000, "{events}");
    }

    #[test]
    fn cooling_run_is_given_up_unless_it_has_a_limit() {
        let most = 2 * MOST_EVENTS_PER_PARTICLE;
        assert_eq!(ending(to_and_fro(0.9999, Until::default()), 2 * most), (Ending::Unsettled, most));
        assert_eq!(ending(to_and_fro(0.9999, Until::events(most + 1_000)), 2 * most), (Ending::Events, most + 1_010));
    }
}
