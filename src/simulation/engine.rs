//! The event loop: pop, stream, execute, repredict.

use super::{Arrest, Reason, Standstill, Until};
use crate::Vector;
use crate::event::{Event, Tally};
use crate::interaction::memory::{Known, PairMemory};
use crate::interaction::rules::Rules;
use crate::neighbours::cells::{Cells, Face, NOBODY};
use crate::overlap::Side;
use crate::queue::{EventQueue, Wake};
use crate::scene::{ParticleId, Scene};
use crate::space::{Boundary, Face as SpaceFace};

/// A particle where an event last touched it: a *delayed state*, one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
pub(super) struct Body {
    /// Position at the local time.
    pub position: Vector,
    /// Velocity at the local time.
    pub velocity: Vector,
    /// Local time, since the epoch.
    pub time: f64,
    /// Number of events that changed its motion: a prediction that names another number is void.
    pub events: u32,
    /// The cell that it is in.
    pub cell: u32,
}

/// What a particle is predicted to run into.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contact {
    /// A discontinuity of its potential with the partner.
    Pair(Side),
    /// A wall of the box.
    Wall(Face),
}

/// The one pending prediction of a particle: its earliest contact, and when it leaves its cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prediction {
    /// Time of the contact since the epoch; infinite if there is none.
    pub contact_time: f64,
    /// Time at which it leaves its cell since the epoch; infinite if it never does.
    pub transition_time: f64,
    /// The partner of a pair contact.
    pub partner: u32,
    /// The partner's number of events when this was predicted.
    pub partner_events: u32,
    pub contact: Contact,
    pub exit: Face,
}

impl Prediction {
    pub const NONE: Self = Self {
        contact_time: f64::INFINITY,
        transition_time: f64::INFINITY,
        partner: NOBODY,
        partner_events: 0,
        contact: Contact::Pair(Side::Positive),
        exit: Face { axis: 0, is_upper: false },
    };

    #[inline]
    pub fn wake_time(&self) -> f64 {
        self.contact_time.min(self.transition_time)
    }

    /// Orders simultaneous wakes: pairs, then walls, then cell transitions; then the lower id of the pair.
    #[inline]
    fn rank(&self, particle: u32) -> u32 {
        let (kind, id) = if self.transition_time < self.contact_time {
            (2, particle)
        } else {
            match self.contact {
                Contact::Pair(_) => (0, particle.min(self.partner)),
                Contact::Wall(_) => (1, particle),
            }
        };
        (kind << 30) | (id & 0x3fff_ffff)
    }
}

/// A wall of the box.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wall {
    pub face: Face,
    /// Coordinate along its axis.
    pub at: f64,
    pub restitution: f64,
}

/// State of the TC model.
#[derive(Debug)]
pub(super) struct ContactTimes {
    /// The model's `t_c`.
    pub contact_time: f64,
    /// Time of each particle's last contact since the epoch.
    pub last: Vec<f64>,
}

/// Counts events without time.
#[derive(Debug)]
struct Clock {
    /// Time at which the count began.
    since: f64,
    /// Physical events since then.
    events: u64,
    /// More than this many in no time is an arrest.
    most: u64,
}

/// The fast engine. `FALLING`: some particles accelerate. `TABLE`: pairs differ, or remember a state; otherwise there is one
/// species of hard spheres, and nothing about pairs is stored or looked up.
#[derive(Debug)]
pub(super) struct Engine<const FALLING: bool, const TABLE: bool> {
    pub bodies: Vec<Body>,
    pub species: Vec<u16>,
    /// How many periods each particle has travelled along the axes.
    pub images: Vec<[i32; 3]>,
    pub predictions: Vec<Prediction>,
    pub queue: EventQueue,
    pub cells: Cells,
    pub rules: Rules,
    pub memory: PairMemory,
    /// Scratch: whom the particle in hand already knows.
    pub is_known: Vec<bool>,
    pub walls: Vec<Wall>,
    pub periods: Vector,
    /// Images of a small box that have to be looked at one by one; empty for others.
    pub further_images: Vec<Vector>,
    pub contact_times: Option<ContactTimes>,
    pub tally: Tally,
    /// Physical events, the sum of the tally's.
    pub executed: u64,
    /// Cell transitions when the last of them happened.
    transitions_at_event: u64,
    /// Simulated time at the start, at the epoch since then, and now since the epoch.
    pub start: f64,
    pub epoch: f64,
    pub now: f64,
    /// How long the epoch before this one was.
    pub last_reached: f64,
    clock: Clock,
    /// Approach speed of an inelastic contact that lost it in rounding.
    pub lost_speed: Option<f64>,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub fn new(scene: &Scene) -> Self {
        let rules = Rules::new(scene);
        let count = scene.particles.len();
        let positions: Vec<Vector> = scene.particles.iter().map(|p| p.position).collect();
        let cells = Cells::new(&scene.space, scene.longest_range(), &positions);
        let bodies = scene
            .particles
            .iter()
            .map(|p| Body {
                position: p.position,
                velocity: p.velocity,
                time: 0.0,
                events: 0,
                cell: cells.cell_at(&p.position),
            })
            .collect();
        let n = count as u64;
        let mut engine = Self {
            bodies,
            species: scene.particles.iter().map(|p| p.species.0 as u16).collect(),
            images: vec![[0; 3]; count],
            predictions: vec![Prediction::NONE; count],
            queue: EventQueue::new(count, 1.0),
            further_images: cells.further_images(&scene.space.periods()),
            cells,
            memory: PairMemory::new(if TABLE { count } else { 0 }),
            is_known: vec![false; if TABLE { count } else { 0 }],
            walls: walls(scene),
            periods: scene.space.periods(),
            contact_times: scene
                .contact_time
                .map(|contact_time| ContactTimes { contact_time, last: vec![f64::NEG_INFINITY; count] }),
            tally: Tally::default(),
            executed: 0,
            transitions_at_event: 0,
            start: scene.start_time,
            epoch: 0.0,
            now: 0.0,
            last_reached: 0.0,
            lost_speed: None,
            clock: Clock {
                since: 0.0,
                events: 0,
                // Simultaneous events of a lattice, and N^2/2 of touching spheres on a line, are no arrest.
                most: 1_000 + 64 * n + (n * n / 2).min(10_000_000),
            },
            rules,
        };
        if TABLE {
            engine.remember_pairs(scene);
        }
        for particle in 0..count as u32 {
            if !engine.is_static(particle) {
                engine.predict(particle, 0.0);
            }
        }
        let mut times: Vec<f64> =
            engine.predictions.iter().map(Prediction::wake_time).filter(|t| t.is_finite()).collect();
        if !times.is_empty() {
            let middle = times.len() / 2;
            let median = *times.select_nth_unstable_by(middle, f64::total_cmp).1;
            engine.queue = EventQueue::new(times.len(), median);
        }
        for particle in 0..count as u32 {
            engine.schedule(particle);
        }
        engine
    }

    /// Sets the states of all pairs from their distances at the start, the one time that distances decide them.
    fn remember_pairs(&mut self, scene: &Scene) {
        for bond in &scene.bonds {
            let [a, b] = bond.pair.map(|id| id.0);
            self.remember(scene, a, b, bond.interaction.0 as u16, true);
        }
        let holds_all_pairs =
            scene.table.iter().flatten().any(|id| scene.interactions[id.0 as usize].potential.is_bond());
        let count = self.bodies.len() as u32;
        for a in (0..count).filter(|&a| !self.is_static(a)).collect::<Vec<_>>() {
            let mut near = Vec::new();
            if holds_all_pairs {
                near.extend(0..count);
            } else {
                self.cells.for_each_near(self.bodies[a as usize].cell, |b| near.push(b));
            }
            for b in near {
                // Pairs of two moving particles come up twice; the first time decides.
                if b == a || (b < a && !self.is_static(b)) || self.memory.get(a, b).is_some() {
                    continue;
                }
                let meeting = *self.rules.meeting(self.species[a as usize], self.species[b as usize]);
                if meeting.exists {
                    self.remember(scene, a, b, meeting.interaction, false);
                }
            }
        }
    }

    /// Sets one pair's state; `is_bond` keeps an entry also in state 0, because the pair's interaction is its own.
    fn remember(&mut self, scene: &Scene, a: u32, b: u32, interaction: u16, is_bond: bool) {
        let apart = self.bodies[a as usize].position - self.bodies[b as usize].position;
        let distance = crate::space::minimum_image(apart, &self.periods).norm();
        let state = scene.interactions[usize::from(interaction)].potential.state_at(distance) as u16;
        if state > 0 || is_bond {
            self.know(a, b, state, interaction);
        }
    }

    /// Writes what two particles know of each other into the lists of both; static ones keep none.
    pub(super) fn know(&mut self, a: u32, b: u32, state: u16, interaction: u16) {
        for (particle, partner) in [(a, b), (b, a)] {
            if !self.is_static(particle) {
                self.memory.set(particle, Known { partner, state, interaction });
            }
        }
    }

    /// Makes two particles strangers again.
    pub(super) fn forget(&mut self, a: u32, b: u32) {
        for (particle, partner) in [(a, b), (b, a)] {
            if !self.is_static(particle) {
                self.memory.forget(particle, partner);
            }
        }
    }

    #[inline]
    pub(super) fn is_static(&self, particle: u32) -> bool {
        TABLE && self.rules.species[usize::from(self.species[particle as usize])].is_static()
    }

    #[inline]
    pub(super) fn acceleration(&self, particle: u32) -> Vector {
        if FALLING {
            let species = if TABLE { self.species[particle as usize] } else { 0 };
            self.rules.species[usize::from(species)].acceleration
        } else {
            Vector::zeros()
        }
    }

    /// Puts a particle's pending prediction into the queue.
    #[inline]
    pub(super) fn schedule(&mut self, particle: u32) {
        let prediction = &self.predictions[particle as usize];
        let time = prediction.wake_time();
        if time < f64::INFINITY {
            self.queue.push(Wake { time, particle, rank: prediction.rank(particle) });
        }
    }

    /// Runs until a time or a number of physical events, and calls `observe` for each event.
    pub fn advance(&mut self, until: Until, mut observe: impl FnMut(&Event)) -> Result<Reason, Arrest> {
        let mut stop = self.since_epoch(until.time);
        loop {
            let Some(wake) = self.queue.peek() else {
                if self.move_epoch() {
                    stop = self.since_epoch(until.time);
                    continue;
                }
                if until.time == f64::INFINITY {
                    return Ok(Reason::Idle);
                }
                self.now = stop;
                return Ok(Reason::Time);
            };
            let particle = wake.particle;
            let prediction = self.predictions[particle as usize];
            if prediction.wake_time() != wake.time {
                self.queue.pop();
                continue;
            }
            if wake.time > stop {
                self.now = stop;
                return Ok(Reason::Time);
            }
            let is_transition = prediction.transition_time < prediction.contact_time;
            if !is_transition && self.executed >= until.events {
                return Ok(Reason::Events);
            }
            if is_transition && until.time == f64::INFINITY && self.is_dispersed() {
                return Ok(Reason::Idle);
            }
            self.queue.pop();
            self.now = wake.time;
            if is_transition {
                self.cross(particle, wake.time);
                continue;
            }
            match prediction.contact {
                Contact::Pair(side) => {
                    let partner = prediction.partner;
                    if self.bodies[partner as usize].events != prediction.partner_events {
                        self.predict(particle, wake.time);
                        self.schedule(particle);
                        continue;
                    }
                    observe(&self.execute_pair(particle, partner, side, wake.time));
                    self.predict(particle, wake.time);
                    self.schedule(particle);
                    if !self.is_static(partner) {
                        self.predict(partner, wake.time);
                        self.schedule(partner);
                    }
                }
                Contact::Wall(face) => {
                    observe(&self.execute_wall(particle, face, wake.time));
                    self.predict(particle, wake.time);
                    self.schedule(particle);
                }
            }
            self.executed += 1;
            self.transitions_at_event = self.tally.transition;
            self.count_standstill();
            self.check_standstill(particle, &prediction)?;
        }
    }

    /// Whether particles have only crossed cells for so long that they will never meet again, as far as anyone can wait.
    fn is_dispersed(&self) -> bool {
        self.tally.transition - self.transitions_at_event > 10_000_000 + 100 * self.bodies.len() as u64
    }

    /// Simulated time now.
    pub fn time(&self) -> f64 {
        self.start + (self.epoch + self.now)
    }

    fn since_epoch(&self, time: f64) -> f64 {
        (time - self.start) - self.epoch
    }

    /// Ends the run where events go on without time, or without speed: theory, section 6.
    fn check_standstill(&self, particle: u32, prediction: &Prediction) -> Result<(), Arrest> {
        let standstill = match self.lost_speed {
            Some(approach) => Standstill::Speed { approach },
            None if self.clock.events > self.clock.most => Standstill::Time { events: self.clock.events },
            None => return Ok(()),
        };
        let is_pair = matches!(prediction.contact, Contact::Pair(_));
        Err(Arrest {
            particle: ParticleId(particle),
            partner: is_pair.then_some(ParticleId(prediction.partner)),
            time: self.time(),
            standstill,
        })
    }

    /// Counts an event, unless time has moved since the last one.
    #[inline]
    fn count_standstill(&mut self) {
        if self.now - self.clock.since > self.queue.span() * SHORTEST_ADVANCE {
            (self.clock.since, self.clock.events) = (self.now, 0);
        } else {
            self.clock.events += 1;
        }
    }

    /// Moves the epoch to where the queue has come, or further if nothing happens before; false if nothing ever happens.
    ///
    /// Times stay small this way, so that the last event of a long run is as accurate as the first. The shift is a
    /// multiple of a power of two, which most times lose without rounding.
    fn move_epoch(&mut self) -> bool {
        let next = self.predictions.iter().map(Prediction::wake_time).fold(f64::INFINITY, f64::min);
        if next == f64::INFINITY {
            return false;
        }
        let reached = self.queue.reached();
        self.last_reached = reached;
        let shift = reached * (next / reached).floor().max(1.0);
        self.epoch += shift;
        self.now -= shift;
        self.clock.since -= shift;
        for body in &mut self.bodies {
            body.time -= shift;
        }
        for prediction in &mut self.predictions {
            prediction.contact_time -= shift;
            prediction.transition_time -= shift;
        }
        if let Some(times) = &mut self.contact_times {
            for last in &mut times.last {
                *last -= shift;
            }
        }
        self.queue.restart();
        for particle in 0..self.bodies.len() as u32 {
            self.schedule(particle);
        }
        true
    }
}

/// Time that advances by less than this part of the queue's span stands still: some thousand times the spacing of the
/// floats that count it. An epoch sees of the order of ten events per particle, so a working system is far away from it.
const SHORTEST_ADVANCE: f64 = 1.0 / (1_u64 << 40) as f64;

fn walls(scene: &Scene) -> Vec<Wall> {
    let mut walls = Vec::new();
    for axis in 0..3 {
        if let Boundary::Bounded { lower, upper } = scene.space.boundary[axis] {
            for (is_upper, side, at) in
                [(false, lower, scene.space.lower[axis]), (true, upper, scene.space.upper()[axis])]
            {
                if let SpaceFace::Wall { restitution } = side {
                    walls.push(Wall { face: Face { axis: axis as u8, is_upper }, at, restitution });
                }
            }
        }
    }
    walls
}
