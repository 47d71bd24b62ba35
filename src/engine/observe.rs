//! Observers, and iteration over events.

use super::event::Event;
use super::parts::Engine;
use super::{EngineError, Reason, Simulation, Until};
use std::collections::VecDeque;
use std::iter::FusedIterator;
use std::ops::ControlFlow;

/// An optional observer. If the observer breaks, the event loop ends after the event.
pub type Observe<'a> = Option<&'a mut dyn FnMut(&Event) -> ControlFlow<()>>;

#[inline]
pub(super) fn show(observe: &mut Observe<'_>, event: impl FnOnce() -> Event) -> ControlFlow<()> {
    match observe {
        Some(observe) => observe(&event()),
        None => ControlFlow::Continue(()),
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Repeats the next `number` events. An observer has seen them before, and has ended the run after the last one.
    pub(super) fn advance_to_event(&mut self, number: u64, until: Until) -> Result<Reason, EngineError> {
        let mut left = number;
        let mut until_there = |_: &Event| {
            left -= 1;
            if left == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        self.advance(until, &mut Some(&mut until_there))
    }
}

/// Result of an observer: nothing, or a [`ControlFlow`] whose `Break` ends the run after the event.
#[doc(alias = "callback")]
#[doc(alias = "stop condition")]
pub trait ObserverResult: sealed::Sealed {
    /// Returns whether the run continues after the event or ends.
    fn control(self) -> ControlFlow<()>;
}

impl ObserverResult for () {
    #[inline]
    fn control(self) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

impl ObserverResult for ControlFlow<()> {
    #[inline]
    fn control(self) -> ControlFlow<()> {
        self
    }
}

impl Simulation {
    /// Iterates over the events up to a time or a number of physical events. [`EventKind`](super::event::EventKind)
    /// lists the kinds of events.
    ///
    /// The simulation advances to each event before the iterator returns it, see [`EventSequence::simulation`]. If the
    /// caller stops the iteration, the simulation stays at the last event. A later advance then gives the same results,
    /// bit for bit. For very many events, [`Self::advance_with`] is faster.
    ///
    /// Without a limit, the iteration may continue forever. It ends if the engine can prove that no further event
    /// happens.
    ///
    /// ```
    /// use carom::engine::{Simulation, Until};
    /// use carom::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
    ///
    /// let scene = SceneBuilder::new("fluid")
    ///     .species(SpeciesDraft::new("sphere").mass(1.0).diameter(1.0))
    ///     .interaction(InteractionDraft::new(Model::HardSphere).between("sphere", "sphere"))
    ///     .fill(Fill::new(Lattice::FaceCentredCubic, "sphere").count(108).packing_fraction(0.3))
    ///     .temperature(1.0)
    ///     .build()?;
    /// let mut simulation = Simulation::new(scene)?;
    /// let (mut impulses, mut count) = (0.0, 0);
    /// for event in simulation.events(Until::time(0.5)) {
    ///     impulses += event?.normal_impulse();
    ///     count += 1;
    /// }
    /// assert_eq!((count, simulation.time()), (simulation.event_counts().core, 0.5));
    /// assert!(impulses > 0.0);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// The last item is an [`EngineError`] if the simulation cannot continue: [`EngineError::Arrest`] if time stands
    /// still, and [`EngineError::InvariantBroken`] in an impossible state.
    #[doc(alias = "step")]
    pub fn events(&mut self, until: Until) -> EventSequence<'_> {
        EventSequence { simulation: self, until, error: None, reason: None, is_over: false, executed: VecDeque::new() }
    }
}

/// Iterator over the events of a simulation, created by [`Simulation::events`].
#[derive(Debug)]
#[must_use = "a simulation stands still until it is asked for the next event"]
pub struct EventSequence<'s> {
    simulation: &'s mut Simulation,
    until: Until,
    /// An error directly after the last event. The next call of `next` returns it.
    error: Option<EngineError>,
    reason: Option<Reason>,
    is_over: bool,
    /// Events at the time of the latest event that have not been returned yet.
    executed: VecDeque<Event>,
}

impl EventSequence<'_> {
    /// The simulation at the event that was returned last, or at the end of the iteration. If several grains fall
    /// asleep or wake up at the same time, the simulation is after all of these events.
    #[must_use]
    pub fn simulation(&self) -> &Simulation {
        self.simulation
    }

    /// Returns why the iteration ended. Returns `None` before the end of the iteration, and after an error.
    #[must_use]
    pub fn reason(&self) -> Option<Reason> {
        self.reason
    }
}

impl Iterator for EventSequence<'_> {
    type Item = Result<Event, EngineError>;

    fn next(&mut self) -> Option<Self::Item> {
        if let Some(event) = self.executed.pop_front() {
            return Some(Ok(event));
        }
        if self.is_over {
            return self.error.take().map(Err);
        }
        // Several grains may fall asleep or wake up at the same time.
        let executed = &mut self.executed;
        let ended = self.simulation.advance_with(self.until, |event| {
            executed.push_back(*event);
            ControlFlow::Break(())
        });
        match (self.executed.pop_front(), ended) {
            (Some(event), Ok(_)) => Some(Ok(event)),
            (Some(event), Err(error)) => {
                (self.is_over, self.error) = (true, Some(error));
                Some(Ok(event))
            }
            (None, Ok(reason)) => {
                (self.is_over, self.reason) = (true, Some(reason));
                None
            }
            (None, Err(error)) => {
                self.is_over = true;
                Some(Err(error))
            }
        }
    }
}

impl FusedIterator for EventSequence<'_> {}

mod sealed {
    use std::ops::ControlFlow;

    pub trait Sealed {}
    impl Sealed for () {}
    impl Sealed for ControlFlow<()> {}
}

#[cfg(test)]
mod tests {
    use crate::Vector;
    use crate::engine::event::EventKind;
    use crate::engine::{Reason, Simulation, Until};
    use crate::model::space::{Boundary, Space};
    use crate::model::thermostat::Thermostat;
    use crate::scene::{Fill, InteractionDraft, Lattice, Model, SceneBuilder, SpeciesDraft};
    use std::ops::ControlFlow;

    fn fluid() -> Simulation {
        let scene = SceneBuilder::new("fluid")
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .fill(Fill::new(Lattice::FaceCentredCubic, "A").count(108).packing_fraction(0.3))
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
    fn stop_at_the_last_event_is_reported_as_the_observers() {
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
    fn event_iterator_shows_the_state_at_each_event_unchanged() {
        let until = Until::events(1_000);
        let (mut plain, mut watched) = (fluid(), fluid());
        let mut expected = Vec::new();
        plain.advance_with(until, |event| expected.push(*event)).unwrap();
        let mut found = Vec::new();
        let mut events = watched.events(until);
        while let Some(event) = events.next() {
            let event = event.unwrap();
            found.push(event);
            let simulation = events.simulation();
            let snapshot = simulation.snapshot();
            assert_eq!(snapshot.time, event.time);
            for (k, id) in [Some(event.particle), event.partner()].into_iter().flatten().enumerate() {
                let (position, velocity) = (snapshot.positions[id.0 as usize], snapshot.velocities[id.0 as usize]);
                assert_eq!((position, velocity), (event.positions[k], event.after[k]));
            }
            assert_eq!(
                simulation.event_counts().core,
                found.iter().filter(|it| it.kind != EventKind::Thermostat).count() as u64
            );
            assert_eq!(events.reason(), None);
        }
        assert_eq!((events.reason(), events.next()), (Some(Reason::Events), None));
        assert!(found.iter().any(|event| event.kind == EventKind::Thermostat));
        assert_eq!(found, expected);
        assert_eq!(watched.snapshot(), plain.snapshot());

        let mut stopped = fluid();
        let third = stopped.events(until).nth(2).unwrap().unwrap();
        assert_eq!((third, stopped.time()), (expected[2], expected[2].time));
        let time = 0.5 * (expected[5].time + expected[6].time);
        assert_eq!(stopped.events(Until::time(time)).count(), 3);
        assert_eq!(stopped.time(), time);
        assert!(stopped.events(Until::time(0.9 * time)).next().is_none(), "that has passed");
        assert_eq!(stopped.time(), time);
    }

    #[test]
    fn arrest_is_reported_after_its_event_and_ends_the_iterator() {
        // Without the arrest, the ball would bounce infinitely often in a finite time.
        let boundary = [Boundary::OPEN, Boundary::OPEN, Boundary::walls(0.5)];
        let scene = SceneBuilder::new("bounces")
            .space(Space { boundary, ..Space::periodic_cube(10.0) })
            .species(SpeciesDraft::new("A").mass(1.0).diameter(1.0))
            .gravity(Vector::new(0.0, 0.0, -1.0))
            .interaction(InteractionDraft::new(Model::HardSphere).between("A", "A"))
            .particle("A", Vector::new(5.0, 5.0, 2.0), Vector::zeros())
            .build()
            .unwrap();
        let mut plain = Simulation::without_plan(scene.clone());
        let mut shown = 0;
        let arrest = plain.advance_with(Until::time(100.0), |_| shown += 1).unwrap_err();
        let mut simulation = Simulation::without_plan(scene);
        let mut events = simulation.events(Until::time(100.0));
        let all: Vec<_> = events.by_ref().collect();
        assert_eq!((all.len(), all.last()), (shown + 1, Some(&Err(arrest))));
        assert!(shown > 10 && all[..shown].iter().all(Result::is_ok));
        assert_eq!((events.next(), events.reason()), (None, None));
        assert_eq!(simulation.snapshot(), plain.snapshot());
    }
}
