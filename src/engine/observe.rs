//! Observers: what is called with each event.

use super::event::Event;
use super::{EngineError, Reason, Simulation, Until};
use std::ops::ControlFlow;

/// A callback of the event loop, if there is one.
pub(super) type Observe<'a> = Option<&'a mut dyn FnMut(&Event) -> ControlFlow<()>>;

/// Shows an event to the callback, and puts it together only if there is one.
#[inline]
pub(super) fn show(observe: &mut Observe<'_>, event: impl FnOnce() -> Event) -> ControlFlow<()> {
    match observe {
        Some(observe) => observe(&event()),
        None => ControlFlow::Continue(()),
    }
}

/// Result of an observer: nothing, or a [`ControlFlow`] whose `Break` ends the run after the event.
#[doc(alias = "callback")]
#[doc(alias = "stop condition")]
pub trait Flow: sealed::Sealed {
    /// Whether the run goes on.
    fn control(self) -> ControlFlow<()>;
}

impl Flow for () {
    #[inline]
    fn control(self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl Flow for ControlFlow<()> {
    #[inline]
    fn control(self) -> ControlFlow<()> {
        self
    }
}

impl Simulation {
    /// Goes on, and shows every event to `observe` with the simulation as it is at its time: energies, positions, pair states.
    ///
    /// The result of `observe` is as in [`Self::advance_with`], which is faster where the event itself says enough. Neither changes a bit of
    /// the trajectory.
    ///
    /// # Errors
    /// [`EngineError`] as [`Self::advance_with`].
    #[doc(alias = "callback")]
    #[doc(alias = "observer")]
    pub fn advance_with_state<F: Flow>(
        &mut self,
        until: Until,
        mut observe: impl FnMut(&Event, &Self) -> F,
    ) -> Result<Reason, EngineError> {
        loop {
            let mut executed = None;
            let reason = self.advance_with(until, |event| {
                executed = Some(*event);
                ControlFlow::Break(())
            });
            let Some(event) = executed else { return reason };
            let flow = observe(&event, self).control();
            // An arrest comes with the event that shows it.
            reason?;
            if flow.is_break() {
                return Ok(Reason::Observer);
            }
        }
    }
}

mod sealed {
    use std::ops::ControlFlow;

    pub trait Sealed {}
    impl Sealed for () {}
    impl Sealed for ControlFlow<()> {}
}

#[cfg(test)]
mod tests {
    use crate::engine::event::EventKind;
    use crate::engine::{Reason, Simulation, Until};
    use crate::model::potential::Potential;
    use crate::model::thermostat::Thermostat;
    use crate::scene::{Amount, Lattice, SceneBuilder};
    use std::ops::ControlFlow;

    fn fluid() -> Simulation {
        let scene = SceneBuilder::new("fluid")
            .species("A", 1.0, 1.0)
            .interaction("A", "A", Potential::hard_sphere(1.0).unwrap(), 1.0)
            .fill(Lattice::FaceCentredCubic, "A", 108, Amount::PackingFraction(0.3))
            .temperature(1.0)
            .build()
            .unwrap();
        let mut simulation = Simulation::without_plan(scene);
        let bath = Thermostat::Andersen { temperature: 1.0, rate: 0.5, axes: [true; 3] };
        simulation.set_thermostat(Some(&bath), 0).unwrap();
        simulation
    }

    #[test]
    fn an_observer_ends_a_run_at_its_event_and_changes_nothing() {
        let until = Until::events(2_000);
        let mut whole = fluid();
        let mut expected = Vec::new();
        assert_eq!(whole.advance_with(until, |event| expected.push(*event)), Ok(Reason::Events));
        let is_bath = |kind| kind == EventKind::Thermostat;
        assert!(expected.iter().filter(|event| is_bath(event.kind)).count() > 20);

        let mut stopped = fluid();
        let mut events = Vec::new();
        let mut ends = 0;
        loop {
            let reason = stopped.advance_with(until, |event| {
                events.push(*event);
                // Every seventh collision, and every second one with the bath.
                let of_kind = events.iter().filter(|other| is_bath(other.kind) == is_bath(event.kind)).count();
                let period = if is_bath(event.kind) { 2 } else { 7 };
                if of_kind % period == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            });
            match reason.unwrap() {
                Reason::Observer => {
                    ends += 1;
                    assert_eq!(Some(stopped.time()), events.last().map(|event| event.time));
                }
                Reason::Events => break,
                other => panic!("{other:?}"),
            }
        }
        assert!(ends > 250, "{ends}");
        assert_eq!(events, expected);
        assert_eq!(stopped.snapshot(), whole.snapshot());
    }

    #[test]
    fn a_stop_at_the_last_event_is_the_observers() {
        let mut simulation = fluid();
        simulation.set_thermostat(None, 0).unwrap();
        let until = Until::events(5);
        let mut seen = 0;
        let reason = simulation.advance_with(until, |_| {
            seen += 1;
            if seen == 5 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!((reason, seen, simulation.event_counts().physical()), (Ok(Reason::Observer), 5, 5));
        assert_eq!(simulation.advance_with(until, |_| seen += 1), Ok(Reason::Events));
        assert_eq!(seen, 5);
    }

    #[test]
    fn an_observer_of_the_state_sees_that_of_the_event_and_changes_nothing() {
        let until = Until::events(1_000);
        let (mut plain, mut watched) = (fluid(), fluid());
        let mut expected = Vec::new();
        plain.advance_with(until, |event| expected.push(*event)).unwrap();
        let mut events = Vec::new();
        let reason = watched.advance_with_state(until, |event, simulation| {
            events.push(*event);
            let snapshot = simulation.snapshot();
            assert_eq!(snapshot.time, event.time);
            for (k, id) in [Some(event.particle), event.partner()].into_iter().flatten().enumerate() {
                let (position, velocity) = (snapshot.positions[id.0 as usize], snapshot.velocities[id.0 as usize]);
                assert_eq!((position, velocity), (event.positions[k], event.after[k]));
            }
            assert_eq!(
                simulation.event_counts().core,
                events.iter().filter(|it| it.kind != EventKind::Thermostat).count() as u64
            );
        });
        assert_eq!((reason, events), (Ok(Reason::Events), expected));
        assert_eq!(watched.snapshot(), plain.snapshot());

        let mut stopped = fluid();
        let limit = 0.9 * stopped.energy().kinetic;
        let reason = stopped.advance_with_state(Until::events(100_000), |_, simulation| {
            if simulation.energy().kinetic < limit { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        assert_eq!(reason, Ok(Reason::Observer));
        assert!(stopped.energy().kinetic < limit);
    }
}
