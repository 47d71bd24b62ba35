//! The proof itself, event by event, from nothing but events and states.

use super::approach::{Approach, Boundary};
use super::bounds::{Bounds, Flight};
use super::certificate::{Counts, Margins, note};
use super::contact::Contact;
use super::outcome::Encounter;
use super::pace::Pace;
use super::pairs::Pairs;
use super::violation::Fault;
use super::window::{Due, Window, wall_approach};
use super::world::World;
use crate::Vector;
use crate::event::{Event, EventKind};
use crate::interaction::rules::Discontinuity;
use crate::motion::{RelativeState, stream_position};
use crate::overlap::Side;
use crate::response::Outcome;
use crate::scene::{ParticleId, Scene};
use crate::simulation::{Elapsed, States};
use std::collections::BTreeMap;

/// Proves a sequence of events.
///
/// It is shown each event with the states after it, [`Verifier::witness`], and knows nothing of what an engine predicts,
/// remembers or sorts into cells.
#[derive(Debug)]
pub struct Verifier {
    pub(super) world: World,
    pub(super) pairs: Pairs,
    /// States at the last event, as they were shown.
    states: States,
    /// States at the time of the event in hand, along the flights before it.
    before: States,
    last_event: Vec<Elapsed>,
    pub(super) window: Window,
    /// Due already, but deeper in the invalid side by no more than round-off.
    overdue: Vec<Due>,
    pub(super) pace: Pace,
    start_time: f64,
    pub(super) counts: Counts,
    pub(super) margins: Margins,
    pub(super) largest_gap: f64,
    pub(super) deepest_overlap: f64,
}

impl Verifier {
    /// From the first states of a scene. Pair states follow from the distances, this one time.
    #[must_use]
    pub fn new(scene: &Scene, states: &States) -> Self {
        let world = World::new(scene);
        let pairs = Pairs::from_distances(&world, states);
        Self::with_pairs(scene, world, pairs, states)
    }

    /// From states within a run, with the pairs that are not in state 0 then.
    #[must_use]
    pub fn resume(scene: &Scene, states: &States, captured: &[([ParticleId; 2], u16)]) -> Self {
        let world = World::new(scene);
        let pairs = Pairs::told(&world, states, captured);
        Self::with_pairs(scene, world, pairs, states)
    }

    fn with_pairs(scene: &Scene, world: World, pairs: Pairs, states: &States) -> Self {
        let pace = Pace::new(&world, states);
        let window = Window::open(&world, &pairs, states, pace.length(&world, states, 0.0));
        Self {
            window,
            pace,
            pairs,
            states: states.clone(),
            before: states.clone(),
            // Where the last event is not known, no later than the start.
            last_event: vec![Elapsed::default(); states.positions.len()],
            overdue: Vec::new(),
            start_time: scene.start_time,
            counts: Counts::default(),
            margins: Margins::default(),
            largest_gap: 0.0,
            deepest_overlap: 0.0,
            world,
        }
    }

    /// Proves that an event is the next one and comes out as it should. `after` are the states at its time, after it.
    ///
    /// # Errors
    /// The first [`Fault`].
    pub fn witness(&mut self, event: &Event, after: &States) -> Result<(), Fault> {
        let contact = Contact::of(event);
        self.pass_to(&after.elapsed, Some(contact))?;
        let flights = self.flights(&contact);
        match event.kind {
            EventKind::Pair(outcome) => self.check_pair(event, contact, outcome, after, flights)?,
            EventKind::Wall { axis, is_upper } => self.check_wall(event, contact, axis, is_upper, after, flights)?,
        }
        self.check_flights(&contact, after)?;
        self.states.clone_from(after);
        let mut changed = Vec::new();
        for particle in contact.particles() {
            self.last_event[particle as usize] = after.elapsed;
            if !self.world.is_static(particle) {
                changed.push(particle);
            }
        }
        self.window.events += 1;
        self.window.forget(changed.iter().copied());
        self.window.look_again(&self.world, &self.pairs, &self.states, &changed);
        Ok(())
    }

    /// Proves that nothing was due up to a time at which no event was executed, and that the flights led there.
    ///
    /// # Errors
    /// The first [`Fault`].
    pub fn witness_quiet(&mut self, now: &States) -> Result<(), Fault> {
        self.pass_to(&now.elapsed, None)?;
        self.check_flights_of(now, |_| false)
    }

    /// Goes on to a time, and proves that everything due before it has taken place.
    fn pass_to(&mut self, elapsed: &Elapsed, executed: Option<Contact>) -> Result<(), Fault> {
        let since = elapsed.after(&self.states.elapsed);
        if since.is_nan() || since < 0.0 {
            return Err(Fault::Backwards { by: -since });
        }
        while self.window.time(elapsed) > self.window.length {
            self.settle(self.window.length, None)?;
            self.next_window(elapsed);
        }
        self.stream(since, *elapsed);
        self.settle(self.window.time(elapsed), executed)
    }

    /// A window from the end of this one on.
    fn next_window(&mut self, elapsed: &Elapsed) {
        let end = Elapsed { since_epoch: self.window.origin.since_epoch + self.window.length, ..self.window.origin };
        self.stream(end.after(&self.states.elapsed).max(0.0), end);
        self.counts.asked += self.window.asked;
        self.counts.windows += 1;
        self.pace.learn(&self.window, &self.world);
        let length = self.pace.length(&self.world, &self.before, elapsed.after(&end));
        // What is overdue is found again.
        self.overdue.clear();
        self.window = Window::open(&self.world, &self.pairs, &self.before, length);
    }

    /// Moves all particles along their flights since the last event.
    fn stream(&mut self, dt: f64, elapsed: Elapsed) {
        self.before.elapsed = elapsed;
        for i in 0..self.states.positions.len() {
            let (position, velocity) = (&self.states.positions[i], &self.states.velocities[i]);
            let acceleration = &self.world.accelerations[i];
            self.before.positions[i] = stream_position(position, velocity, acceleration, dt);
            self.before.velocities[i] = velocity + acceleration * dt;
        }
    }

    /// Looks at everything that was due before a time in the window: nothing may have gone deeper since then.
    fn settle(&mut self, time: f64, executed: Option<Contact>) -> Result<(), Fault> {
        let overdue = std::mem::take(&mut self.overdue);
        let known = overdue.len();
        for (number, due) in overdue.into_iter().chain(self.window.due_before(time)).enumerate() {
            if !self.window.is_valid(&due) {
                continue;
            }
            let contact = due.claim.contact;
            let bound = self.bounds(&contact, &due.approach, &self.flights(&contact)).distance;
            // What round-off explains is no depth to start from, or many steps could lead down.
            let from = due.approach.gap(due.time);
            let from = if from.abs() <= bound { 0.0 } else { from };
            let deeper = from - due.approach.lowest(due.time, time);
            if deeper.is_nan() || deeper > bound {
                let due = self.start_time + (self.window.origin.total() + due.time);
                return Err(Fault::Missed { contact, due, deeper, bound });
            }
            note(&mut self.margins.overlap, deeper, bound);
            if executed == Some(contact) {
                continue;
            }
            self.counts.ties += u64::from(number >= known && executed.is_some());
            self.wait(due, time);
        }
        Ok(())
    }

    /// Keeps what is overdue by round-off; if it has turned, it may be due again later.
    fn wait(&mut self, due: Due, time: f64) {
        if due.approach.closing(time) > 0.0 {
            self.overdue.push(due);
        } else {
            self.window.ask_again(&due, time);
        }
    }

    fn flights(&self, contact: &Contact) -> [Flight; 2] {
        let of = |i: u32| Flight::new(&self.world, &self.before, i, &self.last_event[i as usize]);
        match contact {
            Contact::Pair(pair) => pair.map(|id| of(id.0)),
            Contact::Wall { particle, .. } => [of(particle.0), Flight::NONE],
        }
    }

    fn bounds(&self, contact: &Contact, approach: &Approach, flights: &[Flight; 2]) -> Bounds {
        match (contact, approach.boundary) {
            (Contact::Pair(_), Boundary::Sphere { distance, .. }) => {
                Bounds::pair(&self.world, &flights[0], &flights[1], distance)
            }
            (contact, _) => {
                let radius = contact.particles().next().map_or(0.0, |i| self.world.radius(i));
                Bounds::wall(&flights[0], self.world.farthest_wall, radius)
            }
        }
    }

    fn check_pair(
        &mut self,
        event: &Event,
        contact: Contact,
        outcome: Outcome,
        after: &States,
        flights: [Flight; 2],
    ) -> Result<(), Fault> {
        let Contact::Pair([a, b]) = contact else { return Err(self.unknown(event, contact, 0)) };
        let (i, j) = (event.particle.0, event.partner.unwrap_or(event.particle).0);
        let state = self.pairs.get(a.0, b.0).unwrap_or(0);
        let interaction = self.world.interaction(a.0, b.0).filter(|_| i != j);
        let Some(steps) = interaction.map(|interaction| self.world.steps(interaction)) else {
            return Err(self.unknown(event, contact, state));
        };
        let sides: &[Side] = match outcome {
            Outcome::Core | Outcome::Capture => &[Side::Positive],
            Outcome::Release => &[Side::Negative],
            Outcome::Bounce => &[Side::Positive, Side::Negative],
        };
        let visible = sides.iter().filter_map(|&side| Some((side, steps.seen_from(state, side)?)));
        let at_distance = |(_, seen): &(Side, Discontinuity)| seen.distance == event.distance;
        // An outcome that its distance contradicts is told as such, where the pair sees that distance from its other side.
        let any =
            [Side::Positive, Side::Negative].into_iter().filter_map(|side| Some((side, steps.seen_from(state, side)?)));
        let Some((side, seen)) = visible.chain(any).find(at_distance) else {
            return Err(self.unknown(event, contact, state));
        };
        let restitution = steps.restitution;
        let approach = self.approach(i, j, side, seen.distance);
        // The order of the flights is that of the event.
        let flights = if event.particle == a { flights } else { [flights[1], flights[0]] };
        let bounds = self.bounds(&contact, &approach, &flights);
        self.check_contact(contact, &approach, &bounds, seen.distance)?;
        self.encounter(event, after, bounds, flights).check_pair(j, side, &seen, restitution, outcome)?;
        match outcome {
            Outcome::Core => self.counts.core += 1,
            Outcome::Bounce => self.counts.bounce += 1,
            Outcome::Capture => {
                self.counts.capture += 1;
                self.pairs.set(i, j, state + 1);
            }
            Outcome::Release => {
                self.counts.release += 1;
                self.pairs.set(i, j, state - 1);
            }
        }
        if self.pairs.get(i, j) == Some(0) && !self.world.is_bonded(i, j) {
            self.pairs.forget(i, j);
        }
        Ok(())
    }

    fn check_wall(
        &mut self,
        event: &Event,
        contact: Contact,
        axis: u8,
        is_upper: bool,
        after: &States,
        flights: [Flight; 2],
    ) -> Result<(), Fault> {
        let i = event.particle.0;
        let wall = self.world.walls.iter().find(|wall| wall.axis == axis && wall.is_upper == is_upper).copied();
        let radius = self.world.radius(i);
        let Some(wall) = wall.filter(|_| event.distance == radius && !self.world.is_static(i)) else {
            return Err(self.unknown(event, contact, 0));
        };
        let now = self.window.time(&self.before.elapsed);
        let Some(approach) = wall_approach(&self.world, &self.before, i, &wall, now) else {
            return Err(self.unknown(event, contact, 0));
        };
        let bounds = self.bounds(&contact, &approach, &flights);
        // A point has no length of its own to compare with.
        self.check_contact(contact, &approach, &bounds, if radius > 0.0 { radius } else { 1.0 })?;
        self.encounter(event, after, bounds, flights).check_wall(&wall)?;
        self.counts.wall += 1;
        Ok(())
    }

    fn encounter<'a>(
        &'a mut self,
        event: &'a Event,
        after: &'a States,
        bounds: Bounds,
        flights: [Flight; 2],
    ) -> Encounter<'a> {
        let (world, before, margins) = (&self.world, &self.before, &mut self.margins);
        Encounter { world, event, before, after, bounds, flights, margins }
    }

    /// The event was due: at its discontinuity, and closing.
    fn check_contact(
        &mut self,
        contact: Contact,
        approach: &Approach,
        bounds: &Bounds,
        unit: f64,
    ) -> Result<(), Fault> {
        let now = approach.since;
        let (gap, closing, bound) = (approach.gap(now), approach.closing(now), bounds.distance);
        if gap.is_nan() || gap > bound {
            return Err(Fault::Early { contact, gap, bound });
        }
        // How deep a pair was that now leaves, or how far it will still come back: from the turning point that the event
        // missed by round-off.
        let missed = closing * closing / (2.0 * approach.curvature());
        if closing < -bounds.normal_velocity && !(missed <= bound) {
            return Err(Fault::NotClosing { contact, speed: -closing });
        }
        self.counts.turning_points += u64::from(closing <= bounds.normal_velocity);
        self.counts.in_invalid_state += u64::from(gap < -bound);
        // Deeper than that, it was in an invalid state before it was due: what it did since then was looked at already.
        if gap.abs() <= bound {
            note(&mut self.margins.distance, gap.abs(), bound);
        }
        self.largest_gap = self.largest_gap.max(gap / unit);
        self.deepest_overlap = self.deepest_overlap.max(-gap / unit);
        Ok(())
    }

    fn approach(&self, i: u32, j: u32, side: Side, distance: f64) -> Approach {
        let states = &self.before;
        Approach {
            since: self.window.time(&states.elapsed),
            state: RelativeState {
                position: self.world.nearest(states, i, j),
                velocity: states.velocities[i as usize] - states.velocities[j as usize],
            },
            acceleration: self.world.accelerations[i as usize] - self.world.accelerations[j as usize],
            boundary: Boundary::Sphere { distance, side },
        }
    }

    fn unknown(&self, event: &Event, contact: Contact, state: u16) -> Fault {
        Fault::Unknown { contact, distance: event.distance, state }
    }

    /// All others fly on, and nobody jumps.
    fn check_flights(&mut self, contact: &Contact, after: &States) -> Result<(), Fault> {
        let taking_part: Vec<u32> = contact.particles().collect();
        self.check_flights_of(after, |i| taking_part.contains(&i))
    }

    fn check_flights_of(&mut self, after: &States, takes_part: impl Fn(u32) -> bool) -> Result<(), Fault> {
        for i in 0..self.before.positions.len() as u32 {
            let at = i as usize;
            let jump = self.world.shortest(after.positions[at] - self.before.positions[at]).norm();
            let change = (after.velocities[at] - self.before.velocities[at]).norm();
            if jump == 0.0 && (change == 0.0 || takes_part(i)) && self.world.is_in_box(&after.positions[at]) {
                continue;
            }
            let flight = Flight::new(&self.world, &self.before, i, &self.last_event[at]);
            let bound = flight.position(&self.world);
            if !(jump <= bound && self.world.is_in_box(&after.positions[at])) {
                return Err(Fault::Jumped { particle: ParticleId(i), by: jump, bound });
            }
            note(&mut self.margins.flight, jump, bound);
            let falls = self.world.accelerations[at] != Vector::zeros();
            let bound = if falls { flight.velocity() } else { 0.0 };
            if !(change <= bound || takes_part(i)) {
                return Err(Fault::Disturbed { particle: ParticleId(i), by: change });
            }
        }
        Ok(())
    }

    /// Compares the pair states with those that an engine remembers.
    ///
    /// # Errors
    /// [`Fault::PairState`] with the first pair that differs.
    pub fn compare_pairs(&self, captured: &[([ParticleId; 2], u16)]) -> Result<(), Fault> {
        let own: BTreeMap<_, _> = self.pairs.captured().into_iter().collect();
        let theirs: BTreeMap<_, _> = captured.iter().copied().collect();
        for &pair in own.keys().chain(theirs.keys()) {
            let state = |of: &BTreeMap<_, u16>| of.get(&pair).copied().unwrap_or(0);
            let (events, engine) = (state(&own), state(&theirs));
            if events != engine {
                return Err(Fault::PairState { pair, events, engine });
            }
        }
        Ok(())
    }
}
