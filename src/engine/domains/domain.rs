//! A domain: an engine over the particles that it owns and copies of those around them, which runs alone for a window.

use super::exchange::{Step, Summary, hash};
use super::regions::Regions;
use crate::engine::clock::Moved;
use crate::engine::columns::Order;
use crate::engine::columns::records::Record;
use crate::engine::event::Event;
use crate::engine::hardware::pages::enlarge;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::look_ahead::SELF;
use crate::engine::neighbours::Place;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::observe::Observe;
use crate::engine::parts::{Counts, Engine};
use crate::engine::prediction::{Due, Prediction};
use crate::engine::schedule::Pending;
use std::ops::ControlFlow;

/// Events whose times are kept at the end of a window, to know whether time stands still.
const LAST_EVENTS: usize = 32;

/// An event and when it happened, since the epoch.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub time: f64,
    pub event: Event,
}

/// A particle as a domain has it.
#[derive(Debug, Clone, Copy)]
pub struct Held {
    /// Of one that is owned, all domains that have it, this one included; none of a copy.
    pub known_to: u64,
    /// Its number in the whole.
    pub whole: u32,
    /// The window in which it was last saved.
    saved_in: u32,
}

impl Held {
    /// A particle that has not been saved.
    pub fn new(whole: u32, known_to: u64) -> Self {
        Self { known_to, whole, saved_in: 0 }
    }

    #[inline]
    pub fn is_owned(self) -> bool {
        self.known_to != 0
    }
}

/// An engine over some particles. They have numbers here, and those of the one engine for all: of the whole.
#[derive(Debug, Clone)]
pub struct Domain<const FALLING: bool, const TABLE: bool> {
    pub engine: Engine<FALLING, TABLE>,
    /// The bit of this domain in sets of domains.
    pub bit: u64,
    /// By number here.
    pub held: Vec<Held>,
    /// By number in the whole, that here; [`NO_PARTICLE`] for those that are not here.
    pub here: Vec<u32>,
    /// Counts of events of others, which are not counted here.
    elsewhere: Box<Counts>,
    /// How many particles it began with.
    first: usize,
    /// The number of this window.
    window: u32,
    /// Particles as they were at the beginning of the window, each once, by the numbers here.
    pub saved: Vec<Record>,
    /// Steps of this window of particles that others have, too, and what these are at its end: in the order of their numbers in the whole.
    pub steps: Vec<Step>,
    pub summaries: Vec<Summary>,
    /// Owned particles that have changed their place in this window.
    pub moved: Vec<u32>,
    /// Steps of the queue of owned particles, and of all.
    pub done: u64,
    pub done_in_all: u64,
    /// Events of this window, if they are asked for.
    pub events: Vec<Seen>,
    /// Times of the last events, and of transitions since then.
    pub last: Vec<f64>,
    pub quiet: Vec<f64>,
    /// When something has happened for which this domain alone is not enough.
    pub trouble: Option<f64>,
}

impl<const FALLING: bool, const TABLE: bool> Domain<FALLING, TABLE> {
    /// The domain of a number, cut out of the whole.
    pub fn of(whole: &Engine<FALLING, TABLE>, regions: &Regions, domain: u8) -> Self {
        let bit = 1 << domain;
        let count = whole.particles().len();
        let (mut old, mut held) = (Vec::new(), Vec::new());
        for particle in whole.particles() {
            let column = regions.column(whole, particle);
            if regions.holders[column] & bit != 0 {
                old.push(particle);
                let owns = regions.owner[column] == domain;
                held.push(Held::new(particle, if owns { regions.holders[column] } else { 0 }));
            }
        }
        let mut engine = whole.clone();
        let order = Order::of(old, count);
        engine.permute(&order);
        engine.schedule.predictions.iter_mut().for_each(Prediction::drop_absent);
        *engine.counts = whole.no_counts();
        engine.schedule.queue = whole.schedule.queue.of_part(whole.clock.now, held.len(), count);
        engine.scratch = None;
        engine.enlarge();
        enlarge(&held);
        let mut domain = Self {
            bit,
            first: held.len(),
            held,
            here: order.new,
            elsewhere: engine.counts.clone(),
            window: 0,
            saved: Vec::new(),
            steps: Vec::new(),
            summaries: Vec::new(),
            moved: Vec::new(),
            done: 0,
            done_in_all: 0,
            events: Vec::new(),
            last: Vec::new(),
            quiet: Vec::new(),
            trouble: None,
            engine,
        };
        domain.enqueue_all();
        domain
    }

    fn enqueue_all(&mut self) {
        for particle in self.engine.particles() {
            self.engine.enqueue(particle);
        }
    }

    /// Follows the whole into the next epoch.
    pub fn follow(&mut self, whole: &Engine<FALLING, TABLE>, moved: Moved) {
        self.engine.clock = whole.clock.clone();
        self.engine.shift_columns(moved.shift);
        for particle in self.engine.particles() {
            if self.engine.state.bodies[particle as usize].time < moved.oldest() {
                let mut record = whole.record(self.held[particle as usize].whole);
                self.take_in(&mut record);
                self.engine.write_record(particle, &record);
            }
        }
        self.engine.schedule.queue = whole.schedule.queue.of_part(0.0, self.held.len(), self.here.len());
        self.enqueue_all();
    }

    /// Gives a record of the whole the numbers here.
    pub fn take_in(&self, record: &mut Record) {
        record.renumber(|number| self.here.get(number as usize).copied().filter(|here| *here != NO_PARTICLE));
    }

    /// Whether so many copies have come that it is worth it to leave out those that have gone away.
    pub fn has_grown(&self) -> bool {
        self.held.len() > self.first + self.first / 4 + 64
    }

    /// Forgets the last window.
    pub fn begin_window(&mut self) {
        self.window += 1;
        self.saved.clear();
        self.steps.clear();
        self.moved.clear();
        self.events.clear();
        self.last.clear();
        self.quiet.clear();
        (self.done, self.done_in_all, self.trouble) = (0, 0, None);
    }

    /// Runs alone up to a time, that included.
    pub fn run(&mut self, regions: &Regions, stop: f64, is_observed: bool) {
        while self.trouble.is_none() {
            let due = Due { predictions: &self.engine.schedule.predictions, bodies: &self.engine.state.bodies };
            let Some(entry) = self.engine.schedule.queue.peek(&due) else { break };
            if due.entry(entry.particle) != entry {
                self.engine.schedule.queue.discard();
                continue;
            }
            if entry.time > stop {
                break;
            }
            if self.engine.hardware.looks_ahead {
                self.engine.prefetch_coming();
                self.prefetch_held();
            }
            self.engine.schedule.queue.pop();
            self.engine.clock.now = entry.time;
            self.done += u64::from(self.held[entry.particle as usize].is_owned());
            self.done_in_all += 1;
            self.save(entry.particle);
            let prediction = self.engine.schedule.predictions[entry.particle as usize];
            if prediction.is_transition() {
                self.transition(regions, entry.particle, entry.time);
            } else {
                self.contact(regions, entry.particle, &prediction, is_observed);
            }
        }
        // In the order of particles, those of each in the order in which they happened.
        self.steps.sort_by_key(|step| step.particle);
        self.moved.sort_unstable();
        self.moved.dedup();
        self.summarize();
    }

    fn transition(&mut self, regions: &Regions, particle: u32, time: f64) {
        let before = regions.readers[regions.column(&self.engine, particle)];
        let is_done = self.engine.execute_transition(particle, time).is_ok();
        let held = self.held[particle as usize];
        let column = regions.column(&self.engine, particle);
        if held.is_owned() {
            self.quiet.push(time);
            self.moved.push(particle);
            let unknown = regions.readers[column] & !held.known_to;
            if regions.near[column] & self.bit == 0 || unknown != 0 {
                self.trouble = Some(time);
            }
        } else {
            self.engine.counts.totals.transition -= 1;
        }
        if !is_done {
            self.trouble = Some(time);
        }
        if self.is_shared(particle) {
            let place = match self.engine.neighbours.place(particle) {
                Place::Cell(cell) => u64::from(cell),
                Place::Centre(centre) => hash(1, centre.iter().map(|x| x.to_bits())),
            };
            let hash = hash(2, [time.to_bits(), place]);
            let readers = before | regions.readers[column];
            self.steps.push(Step { particle: held.whole, time, hash, readers });
        }
    }

    fn contact(&mut self, regions: &Regions, particle: u32, prediction: &Prediction, is_observed: bool) {
        let time = self.engine.clock.now;
        let partner = prediction.partner_in_contact();
        if let Some(partner) = partner {
            if self.engine.state.bodies[partner as usize].events != prediction.partner_events {
                self.engine.repredict(particle, time);
                return;
            }
            self.save(partner);
        }
        let first = match partner {
            Some(partner) if self.engine.name(partner) < self.engine.name(particle) => partner,
            _ => particle,
        };
        let is_counted = self.held[first as usize].is_owned();
        if !is_counted {
            std::mem::swap(&mut self.engine.counts, &mut self.elsewhere);
        }
        let events = &mut self.events;
        let mut see = |event: &Event| {
            events.push(Seen { time, event: *event });
            ControlFlow::Continue(())
        };
        let mut observe: Observe<'_> = if is_observed && is_counted { Some(&mut see) } else { None };
        let executed = self.engine.execute(particle, prediction, time, &mut observe);
        self.engine.counts.executed += 1;
        if !is_counted {
            std::mem::swap(&mut self.engine.counts, &mut self.elsewhere);
        }
        let has_lost_speed = self.engine.clock.standstill.lost_speed.take().is_some();
        if has_lost_speed || !matches!(executed, Ok(Some(_))) {
            self.trouble = Some(time);
            return;
        }
        self.engine.repredict(particle, time);
        if let Some(partner) = partner
            && !self.engine.is_static(partner)
        {
            self.engine.repredict(partner, time);
        }
        if is_counted {
            if self.last.len() == 2 * LAST_EVENTS {
                self.last.drain(..LAST_EVENTS);
            }
            self.last.push(time);
            self.quiet.clear();
        }
        self.note_contact(regions, particle, partner, time);
        if let Some(partner) = partner {
            self.note_contact(regions, partner, Some(particle), time);
        }
    }

    /// Takes note of a contact of a particle that another domain has, too.
    #[inline]
    fn note_contact(&mut self, regions: &Regions, particle: u32, other: Option<u32>, time: f64) {
        if !self.is_shared(particle) || self.engine.is_static(particle) {
            return;
        }
        let body = &self.engine.state.bodies[particle as usize];
        let of_body = body.position.iter().chain(&body.velocity).map(|x| x.to_bits());
        let with = other.map_or(u64::from(NO_PARTICLE), |other| u64::from(self.held[other as usize].whole));
        let hash = hash(3, [time.to_bits(), with].into_iter().chain(of_body));
        let readers = regions.readers[regions.column(&self.engine, particle)];
        self.steps.push(Step { particle: self.held[particle as usize].whole, time, hash, readers });
    }

    /// Asks for what will be looked at of the particles that come next.
    #[inline]
    fn prefetch_held(&self) {
        if let Some((particle, prediction)) = self.engine.coming(SELF) {
            for particle in [particle, prediction.partner].into_iter().filter(|&particle| particle != NO_PARTICLE) {
                prefetch(&self.held, particle as usize);
                self.engine.state.images.prefetch(particle);
            }
        }
    }

    /// Whether another domain has the particle, too.
    #[inline]
    pub fn is_shared(&self, particle: u32) -> bool {
        self.held[particle as usize].known_to != self.bit
    }

    /// Keeps what a particle is before it is changed for the first time in this window.
    #[inline]
    fn save(&mut self, particle: u32) {
        let saved_in = &mut self.held[particle as usize].saved_in;
        if *saved_in != self.window {
            *saved_in = self.window;
            self.saved.push(self.engine.record(particle));
        }
    }

    /// Hashes of the particles that this window has touched and others have, too.
    fn summarize(&mut self) {
        self.summaries.clear();
        for at in 0..self.saved.len() {
            let particle = self.saved[at].number;
            if self.is_shared(particle) {
                let record = self.engine.record(particle);
                let number = |number: u32| self.held.get(number as usize).map_or(NO_PARTICLE, |held| held.whole);
                let summary = Summary {
                    particle: self.held[particle as usize].whole,
                    hash: record.hash(number),
                    saved: u32::try_from(at).unwrap_or(u32::MAX),
                };
                self.summaries.push(summary);
            }
        }
        self.summaries.sort_unstable_by_key(|summary| summary.particle);
    }

    /// Undoes this window.
    pub fn undo(&mut self, start: f64) {
        let saved = std::mem::take(&mut self.saved);
        self.engine.clock.now = start;
        let due = Due { predictions: &self.engine.schedule.predictions, bodies: &self.engine.state.bodies };
        self.engine.schedule.queue.rewind(start, &due);
        self.write(&saved);
        self.saved = saved;
        *self.engine.counts = self.engine.no_counts();
        self.begin_window();
    }
}
