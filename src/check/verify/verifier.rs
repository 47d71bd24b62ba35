use super::approach::Boundary;
use super::barrier::ContactMemory;
use super::bounds::is_without_digits;
use super::certificate::{Certificate, note};
use super::contact::Contact;
use super::pace::{Pace, round_the_box};
use super::pairs::Pairs;
use super::rest::{SleepWatch, is_sleep};
use super::rules::fly;
use super::violation::Fault;
use super::window::{Due, Window};
use super::world::World;
use crate::Vector;
use crate::engine::event::{Event, EventKind};
use crate::engine::{Elapsed, States};
use crate::model::{ParticleId, Scene};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Proves a sequence of events from the events and the states after them, which [`Verifier::witness`] receives. No
/// other data of an engine are used, except for the initial pair states in [`Verifier::resume`].
#[derive(Debug)]
pub struct Verifier {
    pub(super) world: World,
    pub(super) pairs: Pairs,
    /// Last contact times for the TC model; `None` if the model is off.
    pub(super) contacts: Option<ContactMemory>,
    /// States after the latest event, as received.
    pub(super) states: States,
    /// What decides which grains sleep; `None` if grains never do.
    pub(super) sleep: Option<SleepWatch>,
    /// Grains that fell asleep or woke up at the latest time, and the states after this.
    pending: Vec<Event>,
    pending_states: States,
    /// States just before the current event, after free flights from the states after the previous event.
    pub(super) before: States,
    pub(super) last_event: Vec<Elapsed>,
    pub(super) window: Window,
    /// Predicted events that are due but not yet executed, with overlaps within round-off.
    overdue: Vec<Due>,
    pub(super) pace: Pace,
    pub(super) start_time: f64,
    pub(super) proof: Certificate,
}

impl Verifier {
    /// Starts from the initial states of a scene, where distances decide the pair states.
    ///
    /// # Errors
    /// [`Fault::Incomplete`] if the number of states differs from the number of particles, [`Fault::TooFast`] if speeds
    /// overflow.
    pub fn new(scene: &Scene, states: &States) -> Result<Self, Fault> {
        Self::begin(scene, states, (scene.start_time, None), |world| Ok(Pairs::from_distances(world, states)))
    }

    /// Starts a proof in the middle of a run, from the states at that time and the pairs that are not in state 0.
    ///
    /// # Errors
    /// [`Fault::Incomplete`] if the number of states differs from the number of particles, [`Fault::Unknown`] if a pair
    /// cannot be in the given state.
    pub fn resume(scene: &Scene, states: &States, captured: &[([ParticleId; 2], u16)]) -> Result<Self, Fault> {
        Self::resume_from(scene, states, captured, (scene.start_time, &[]))
    }

    /// Works like [`Self::resume`], for a run whose elapsed time is 0 at the simulated time `start_time`.
    pub(super) fn resume_from(
        scene: &Scene,
        states: &States,
        captured: &[([ParticleId; 2], u16)],
        (start_time, asleep): (f64, &[ParticleId]),
    ) -> Result<Self, Fault> {
        let begin = (start_time, Some(states.elapsed));
        Self::begin(scene, states, begin, |world| {
            asleep.iter().for_each(|id| world.fall_asleep(id.0));
            Pairs::listed(world, states, captured)
        })
    }

    fn begin(
        scene: &Scene,
        states: &States,
        (start_time, unseen_before): (f64, Option<Elapsed>),
        pairs: impl FnOnce(&mut World) -> Result<Pairs, Fault>,
    ) -> Result<Self, Fault> {
        check_count(scene.particles.len(), states)?;
        let mut world = World::new(scene, start_time);
        let pairs = pairs(&mut world)?;
        let count = states.positions.len();
        let pace = Pace::new(&world, states);
        let window = Window::open(&world, &pairs, states, pace.length(&world, states, 0.0))?;
        Ok(Self {
            window,
            pace,
            pairs,
            contacts: scene.contact_time.map(|time| ContactMemory::new(time, count, unseen_before).with(scene.tc_rule)),
            sleep: SleepWatch::new(scene, states, unseen_before.is_none()),
            pending: Vec::new(),
            pending_states: States::default(),
            states: states.clone(),
            before: states.clone(),
            // The times of the last events are unknown. The earliest possible time gives the largest bounds.
            last_event: vec![Elapsed::default(); states.positions.len()],
            overdue: Vec::new(),
            start_time,
            proof: Certificate::blank(1, start_time),
            world,
        })
    }

    /// Proves that an event, which leads to the states `after`, is the next event and has the right outcome.
    ///
    /// Grains that fall asleep or wake up at the same time are proven together, when a later event or a quiet time
    /// follows. All of these events lead to the same states.
    ///
    /// # Errors
    /// The first [`Fault`].
    pub fn witness(&mut self, event: &Event, after: &States) -> Result<(), Fault> {
        let watch = &mut || ControlFlow::Continue(());
        if self.pending.first().is_some_and(|first| first.time != event.time) {
            self.witness_pending(watch)?;
        }
        self.pending.push(*event);
        self.pending_states.clone_from(after);
        if is_sleep(event) { Ok(()) } else { self.witness_pending(watch) }
    }

    /// Proves the events that [`Self::witness`] has received, but not proven yet.
    fn witness_pending(&mut self, watch: &mut dyn FnMut() -> ControlFlow<()>) -> Result<(), Fault> {
        let events = std::mem::take(&mut self.pending);
        let after = std::mem::take(&mut self.pending_states);
        if events.is_empty() { Ok(()) } else { self.witness_all(&events, &after, watch) }
    }

    /// Like [`Self::witness`], but calls `watch` repeatedly. Ends with [`Fault::Interrupted`] if `watch` breaks.
    pub(super) fn witness_watched(
        &mut self,
        event: &Event,
        after: &States,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<(), Fault> {
        let contact = Contact::of(event);
        check_count(self.states.positions.len(), after)?;
        if contact.particles().any(|particle| particle as usize >= self.states.positions.len()) {
            return Err(Fault::Unknown { contact, distance: event.distance, state: 0 });
        }
        self.pass_searches(&after.elapsed)?;
        self.pass_to(&after.elapsed, Some(contact), watch)?;
        self.wake_at(&contact)?;
        match event.kind {
            EventKind::Pair(outcome) => self.check_pair(event, contact, outcome, after)?,
            EventKind::Surface if event.wall().is_some() => self.check_wall(event, contact, after)?,
            EventKind::Surface => self.check_surface(event, contact, after)?,
            // The event rule does not cover thermostats, and the number of particles is constant.
            EventKind::Thermostat | EventKind::Entry | EventKind::Exit | EventKind::Rest | EventKind::Wake => {
                return Err(Fault::Unknown { contact, distance: event.distance, state: 0 });
            }
        }
        self.check_flights(after, |i| contact.particles().any(|particle| particle == i))?;
        let both: Vec<u32> = contact.particles().collect();
        let changed: Vec<u32> = both.iter().copied().filter(|&particle| !self.world.is_static(particle)).collect();
        self.window.events += 1;
        self.go_on(after, &both, &changed)
    }

    /// Goes on from the states after an event, with new flights of the particles `changed`.
    pub(super) fn go_on(&mut self, after: &States, particles: &[u32], changed: &[u32]) -> Result<(), Fault> {
        self.states.clone_from(after);
        for &particle in particles {
            self.last_event[particle as usize] = after.elapsed;
        }
        self.window.forget(changed.iter().copied());
        // An event may make its particles much faster. The window must end before they can travel around the box.
        let now = self.window.time(&self.states.elapsed);
        let left = self.window.length - now;
        self.window.end_by(now + round_the_box(&self.world, &self.states, changed, left));
        self.window.ask_changed(&self.world, &self.pairs, &self.states, changed)
    }

    /// Proves that no event was due up to the time of the states `now`, and that free flights lead to these states.
    /// Calls `watch` repeatedly, and ends with [`Fault::Interrupted`] if `watch` breaks.
    ///
    /// # Errors
    /// The first [`Fault`].
    pub fn witness_quiet(&mut self, now: &States, watch: &mut dyn FnMut() -> ControlFlow<()>) -> Result<(), Fault> {
        check_count(self.states.positions.len(), now)?;
        self.witness_pending(watch)?;
        self.pass_searches(&now.elapsed)?;
        self.pass_to(&now.elapsed, None, watch)?;
        self.check_flights(now, |_| false)
    }

    /// Adds and removes surfaces at the start of a stage, when the particles are in the states `now`.
    ///
    /// # Errors
    /// [`Fault::TooFast`] if a particle is so fast that too many images of a pair would have to be searched. If grains sleep,
    /// [`Fault::Jumped`] or [`Fault::Disturbed`] if free flights do not lead to these states.
    pub fn enter_stage(&mut self, stage: &str, now: &States) -> Result<(), Fault> {
        check_count(self.states.positions.len(), now)?;
        if !self.world.enter_stage(stage) {
            return Ok(());
        }
        self.stream(now.elapsed.after(&self.states.elapsed), now.elapsed);
        if self.world.asleep().next().is_some() {
            // The grains that wake up fall from now on.
            self.check_flights(now, |_| false)?;
            self.states.clone_from(now);
            self.before.clone_from(now);
            self.wake_all();
        }
        self.look_anew()
    }

    /// Changes the acceleration of all moving particles when they are in the states `now`.
    ///
    /// # Errors
    /// [`Fault::Jumped`] or [`Fault::Disturbed`] if free flights do not lead to these states, [`Fault::TooFast`] if a
    /// particle is so fast that too many images of a pair would have to be searched.
    pub fn turn_gravity(&mut self, gravity: &Vector, now: &States) -> Result<(), Fault> {
        check_count(self.states.positions.len(), now)?;
        // Flights up to `now` have the previous acceleration.
        self.stream(now.elapsed.after(&self.states.elapsed), now.elapsed);
        self.check_flights(now, |_| false)?;
        if !self.world.turn_gravity(gravity) {
            return Ok(());
        }
        self.wake_all();
        self.states.clone_from(now);
        self.before.clone_from(now);
        self.last_event.fill(now.elapsed);
        self.look_anew()
    }

    /// Opens a new window at the current time, because surfaces or accelerations have changed.
    fn look_anew(&mut self) -> Result<(), Fault> {
        self.overdue.clear();
        self.proof.counts.asked += self.window.asked;
        let length = self.pace.length(&self.world, &self.before, 0.0);
        self.window = Window::open(&self.world, &self.pairs, &self.before, length)?;
        Ok(())
    }

    /// Advances to a time and proves that no earlier event is missing. `executed` is the contact at this time, if any.
    pub(super) fn pass_to(
        &mut self,
        elapsed: &Elapsed,
        executed: Option<Contact>,
        watch: &mut dyn FnMut() -> ControlFlow<()>,
    ) -> Result<(), Fault> {
        let since = elapsed.after(&self.states.elapsed);
        if !(since.is_finite() && since >= 0.0) {
            return Err(Fault::Backwards { by: -since });
        }
        while self.window.time(elapsed) > self.window.length {
            self.settle(self.window.length, None)?;
            self.next_window(elapsed)?;
            if watch().is_break() {
                return Err(Fault::Interrupted);
            }
        }
        self.stream(since, *elapsed);
        self.settle(self.window.time(elapsed), executed)
    }

    fn next_window(&mut self, elapsed: &Elapsed) -> Result<(), Fault> {
        // The end of the window is measured from the latest epoch, because times far from an epoch are inaccurate.
        let latest = self.states.elapsed;
        let left = self.window.length - self.window.time(&latest);
        let end = Elapsed { since_epoch: latest.since_epoch + left, ..latest };
        self.stream(end.after(&self.states.elapsed).max(0.0), end);
        self.proof.counts.asked += self.window.asked;
        self.proof.counts.windows += 1;
        self.pace.learn(&self.window, &self.world);
        let length = self.pace.length(&self.world, &self.before, elapsed.after(&end));
        // The search at the start of the new window finds overdue contacts again.
        self.overdue.clear();
        self.window = Window::open(&self.world, &self.pairs, &self.before, length)?;
        if end.since_epoch + self.window.length <= end.since_epoch {
            let speed = |i: &u32| self.before.velocities[*i as usize].norm();
            let fastest = self.world.moving.iter().copied().max_by(|a, b| speed(a).total_cmp(&speed(b))).unwrap_or(0);
            return Err(Fault::TooFast { particle: ParticleId(fastest), speed: speed(&fastest) });
        }
        Ok(())
    }

    fn stream(&mut self, dt: f64, elapsed: Elapsed) {
        self.before.elapsed = elapsed;
        self.before.spins.clone_from(&self.states.spins);
        for i in 0..self.states.positions.len() {
            let (position, velocity) = (&self.states.positions[i], &self.states.velocities[i]);
            (self.before.positions[i], self.before.velocities[i]) =
                fly(position, velocity, &self.world.accelerations[i], dt);
        }
    }

    /// Checks the contacts that were due before a time in the window: no overlap has grown since its contact was due.
    fn settle(&mut self, time: f64, executed: Option<Contact>) -> Result<(), Fault> {
        let overdue = std::mem::take(&mut self.overdue);
        let known = overdue.len();
        for (number, due) in overdue.into_iter().chain(self.window.due_before(time)).enumerate() {
            if !self.window.is_valid(&due) {
                continue;
            }
            let contact = due.claim.contact;
            let bound = self.bounds(&contact, &due.approach, &self.flights(&contact)).distance;
            // A gap within round-off is treated as 0. Otherwise, many steps could increase an overlap by round-off.
            let from = due.approach.gap(due.time);
            let from = if from.abs() <= bound { 0.0 } else { from };
            let deeper = from - due.approach.lowest(due.time, time);
            if deeper.is_nan() || deeper > bound {
                let due = self.start_time + (self.window.origin.total() + due.time);
                return Err(Fault::Missed { contact, due, deeper, bound });
            }
            if let Boundary::Sphere { distance, .. } = due.approach.boundary
                && is_without_digits(deeper, distance)
            {
                return Err(Fault::WithoutDigits { contact, by: deeper, distance });
            }
            note(&mut self.proof.margins.overlap, deeper, bound);
            if executed == Some(contact) {
                continue;
            }
            self.proof.counts.ties += u64::from(number >= known && executed.is_some());
            self.wait(due, time);
        }
        Ok(())
    }

    /// Adds the contact to `overdue` if the particles still approach. Otherwise, searches for their next event.
    fn wait(&mut self, due: Due, time: f64) {
        if due.approach.closing(time) > 0.0 && due.approach.is_on(time) {
            self.overdue.push(due);
        } else {
            // The search starts at `time`, so it cannot find this event again.
            self.window.ask(due.claim, due.approach.streamed(time));
        }
    }

    /// Compares the verifier's pair states with the pair states of an engine.
    ///
    /// # Errors
    /// [`Fault::PairState`] with the first pair that differs.
    pub fn compare_pairs(&self, captured: &[([ParticleId; 2], u16)]) -> Result<(), Fault> {
        let own: BTreeMap<_, _> = self.pairs.captured().into_iter().collect();
        let theirs: BTreeMap<_, _> = captured.iter().map(|&(pair, state)| (pair, state.into())).collect();
        for &pair in own.keys().chain(theirs.keys()) {
            let state = |of: &BTreeMap<_, usize>| of.get(&pair).copied().unwrap_or(0);
            let (events, engine) = (state(&own), state(&theirs));
            if events != engine {
                return Err(Fault::PairState { pair, events, engine });
            }
        }
        Ok(())
    }
}

pub(super) fn check_count(particles: usize, states: &States) -> Result<(), Fault> {
    let found = states.positions.len().min(states.velocities.len());
    if found == particles && states.positions.len() == states.velocities.len() {
        Ok(())
    } else {
        Err(Fault::Incomplete { particles, found })
    }
}
