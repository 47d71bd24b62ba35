//! A domain: an engine that owns some of the particles and holds copies of the particles around them. It runs alone for
//! a window of time.

use super::exchange::Step;
use super::outcome::{Outcome, Tally};
use super::regions::Regions;
use crate::base::numbers::id;
use crate::engine::clock::Moved;
use crate::engine::columns::Order;
use crate::engine::columns::records::Record;
use crate::engine::hardware::pages::enlarge;
use crate::engine::marks::Marks;
use crate::engine::parts::{Counts, Engine};
use crate::engine::prediction::absent;
use crate::engine::sources::andersen::Collision;
use crate::engine::undo_log::UndoLog;

#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct Held {
    /// Set of domains that hold an owned particle, including the owner; empty for a copy.
    pub known_to: u64,
    /// Number of the particle in the whole system.
    pub whole: u32,
    /// Index in `Domain::touched`, if that element is this particle.
    pub touch: u32,
    pub owner: u8,
}

/// A shared particle that had a step in this window.
#[derive(Debug, Clone, Copy)]
pub struct Touched {
    pub particle: u32,
    pub held: Held,
    /// Digest of all steps and predictions of the particle in this window. If a particle and its copy agree before the
    /// window, and have equal digests, they agree after the window.
    pub digest: u64,
}

impl Held {
    pub fn new(whole: u32, owner: u8, known_to: u64) -> Self {
        Self { known_to, whole, touch: 0, owner }
    }

    #[inline]
    pub fn is_owned(self) -> bool {
        self.known_to != 0
    }
}

/// Particles have local numbers in a domain, and global numbers in the whole system.
#[derive(Debug, Clone)]
pub struct Domain<const FALLING: bool, const TABLE: bool> {
    pub engine: Engine<FALLING, TABLE>,
    pub number: u8,
    pub bit: u64,
    pub held: Vec<Held>,
    pub owned: Marks,
    /// Particles that several domains hold: all copies, and owned particles with copies elsewhere.
    pub shared: Marks,
    /// Local number by global number; [`NO_PARTICLE`](crate::engine::neighbours::cells::NO_PARTICLE) for absent
    /// particles.
    pub here: Vec<u32>,
    /// Event counts of copies. They are not used, because the owners count these events.
    pub elsewhere: Box<Counts>,
    /// Number of particles at the last cut.
    first: usize,
    pub log: UndoLog,
    /// True if contacts change nothing but motions, predictions and captured pairs, so that the log can be compact.
    pub is_plain: bool,
    /// Steps of owned particles with copies elsewhere.
    pub steps: Vec<Step>,
    /// Steps of copies, with global numbers, and the owners of the copies.
    pub steps_of_copies: Vec<(u8, Step)>,
    /// The particles with steps, each listed once.
    pub touched: Vec<Touched>,
    /// Owned particles that may need copies in more domains, or a new owner, after this window.
    pub moved: Vec<u32>,
    pub tally: Tally,
    /// Upcoming collisions with the heat bath in this window, with local numbers, in reverse order of time.
    pub collisions: Vec<(u32, Collision)>,
    pub trouble: Option<f64>,
}

/// Returns the number of particles above which a new cut is due, given the number at the last cut.
fn most(first: usize) -> usize {
    first + first / 8 + 64
}

impl<const FALLING: bool, const TABLE: bool> Domain<FALLING, TABLE> {
    pub fn of(whole: &Engine<FALLING, TABLE>, regions: &Regions, number: u8) -> Self {
        let bit = 1 << number;
        let count = whole.particles().len();
        let (mut old, mut held) = (Vec::new(), Vec::new());
        for particle in whole.particles() {
            let columns = regions.columns(whole, particle);
            let holders = regions.holders(columns);
            if holders & bit != 0 {
                old.push(particle);
                let owner = regions.owner(columns);
                let known_to = if owner == number { holders } else { 0 };
                held.push(Held::new(particle, owner, known_to));
            }
        }
        let order = Order { room: most(held.len()) - held.len(), ..Order::of(old, count) };
        let mut engine = whole.part(&order);
        for prediction in &mut engine.schedule.predictions {
            if let Some(number) = prediction.absent_partner() {
                prediction.partner = absent(whole.state.bodies[number as usize].id);
            }
        }
        let mut domain = Self {
            number,
            bit,
            first: held.len(),
            held: Vec::with_capacity(most(held.len())),
            owned: Marks::default(),
            shared: Marks::default(),
            here: order.new,
            elsewhere: engine.counts.clone(),
            log: UndoLog::default(),
            is_plain: engine.changes_motions_and_pairs_only(),
            steps: Vec::new(),
            steps_of_copies: Vec::new(),
            touched: Vec::new(),
            moved: Vec::new(),
            tally: Tally::new(),
            collisions: Vec::new(),
            trouble: None,
            engine,
        };
        held.into_iter().for_each(|held| domain.hold(held));
        domain.enqueue_all();
        domain.enlarge();
        domain
    }

    fn enlarge(&self) {
        self.engine.enlarge();
        enlarge(&self.held);
        enlarge(&self.here);
        self.log.enlarge();
    }

    pub fn hold(&mut self, held: Held) {
        self.held.push(held);
        self.set_held(id(self.held.len() - 1), held);
    }

    pub fn set_held(&mut self, particle: u32, held: Held) {
        self.held[particle as usize] = held;
        self.owned.put(particle, held.is_owned());
        self.shared.put(particle, held.known_to != self.bit);
    }

    /// Index of a particle in `touched`, if it had a step in this window.
    #[inline]
    pub fn touch(&self, particle: u32) -> Option<usize> {
        let at = self.held[particle as usize].touch as usize;
        self.touched.get(at).filter(|touched| touched.particle == particle).map(|_| at)
    }

    pub fn owned_particles(&self) -> impl Iterator<Item = u32> {
        self.engine.particles().filter(|&particle| self.owned.has(particle))
    }

    fn enqueue_all(&mut self) {
        for particle in self.engine.particles() {
            self.engine.enqueue(particle);
        }
    }

    pub fn next_due(&self) -> f64 {
        let due = |particle: u32| self.engine.schedule.predictions[particle as usize].due_time();
        self.owned_particles().map(due).fold(f64::INFINITY, f64::min)
    }

    /// Starts the next epoch, and brings owned particles without recent events forward. Returns the forwarded particles
    /// that other domains hold, with the sets of these domains.
    pub fn follow(&mut self, whole: &Engine<FALLING, TABLE>, moved: Moved) -> Vec<(u32, u64)> {
        self.engine.clock = whole.clock.clone();
        self.engine.shift_columns(moved.shift);
        let mut to_publish = Vec::new();
        for particle in self.engine.particles() {
            if self.owned.has(particle) && self.engine.bring_forward(particle, moved.oldest()) {
                let others = self.held[particle as usize].known_to & !self.bit;
                if others != 0 {
                    to_publish.push((particle, others));
                }
            }
        }
        self.engine.schedule.queue = whole.schedule.queue.of_part(0.0, self.held.len(), self.here.len());
        self.enqueue_all();
        self.enlarge();
        to_publish
    }

    pub fn record_for_whole(&self, particle: u32) -> Record {
        let mut record = self.engine.record(particle);
        record.renumber(|number| self.held.get(number as usize).map(|held| held.whole));
        record
    }

    /// Returns true if the number of copies exceeds its limit. A new cut then removes stale copies.
    fn has_grown(&self) -> bool {
        self.held.len() > most(self.first)
    }

    pub fn outcome(&mut self, difference: Option<f64>) -> Outcome {
        let none = Box::new(self.engine.no_counts());
        Outcome {
            difference,
            counts: std::mem::replace(&mut self.engine.counts, none),
            tally: std::mem::replace(&mut self.tally, Tally::new()),
            has_grown: self.has_grown(),
        }
    }

    pub fn begin_window(&mut self) {
        self.log.clear();
        self.steps.clear();
        self.steps_of_copies.clear();
        self.touched.clear();
        self.moved.clear();
        (self.tally, self.trouble) = (Tally::new(), None);
    }

    pub fn undo(&mut self, start: f64) {
        self.engine.clock.now = start;
        let (queue, due) = self.engine.schedule.split(&self.engine.state.bodies);
        queue.rewind(start, &due);
        let undone = self.log.undone(&self.engine.state.bodies);
        self.write(&undone);
        *self.engine.counts = self.engine.no_counts();
        self.begin_window();
    }
}
