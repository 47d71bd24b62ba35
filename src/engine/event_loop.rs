//! The event loop: pop, stream, execute, repredict.

use super::clock::Clock;
use super::event::{EventCounts, Tally};
use super::neighbours::Neighbours;
use super::neighbours::ranges::Ranges;
use super::observe::Observe;
use super::pairs::Pairs;
use super::pairs::states::PairState;
use super::predict::Scratch;
use super::prediction::{Prediction, Schedule};
use super::schedule::{Pending, QueueEntry};
use super::sources::Sources;
use super::state::State;
use super::{EngineError, Invariant, InvariantBroken, Reason, Until};
use crate::Vector;
use crate::model::ParticleId;
use crate::physics::detection::lanes::Simd;
use serde::{Deserialize, Serialize};
use std::ops::{ControlFlow, Range};

/// What is due next.
enum Due {
    /// The prediction of a particle.
    Particle(QueueEntry),
    /// An entry of the queue that is no longer a particle's prediction.
    Void,
    /// A global event.
    GlobalEvent,
    /// The end of the epoch.
    Epoch,
    /// The end of the run.
    Limit,
}

/// What has happened so far.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Counts {
    pub totals: Tally,
    /// Events by species; empty without a table.
    pub by_species: EventCounts,
    /// Physical events, the sum of the totals'.
    pub executed: u64,
    /// Cell transitions when the last of them happened.
    pub transitions_at_event: u64,
    /// Transitions when particles were last put in order.
    pub transitions_at_order: u64,
}

impl Counts {
    pub fn new(species: usize) -> Self {
        Self {
            totals: Tally::default(),
            by_species: EventCounts::new(species),
            executed: 0,
            transitions_at_event: 0,
            transitions_at_order: 0,
        }
    }
}

/// What the machine decides about the way of a calculation, and never about its result.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Hardware {
    /// The SIMD instructions.
    #[serde(skip, default = "Simd::most")]
    pub width: Simd,
    /// Whether particles are too many for the caches next to the processor.
    pub is_large: bool,
}

/// The fast engine. `FALLING`: some particles accelerate. `TABLE`: pairs differ, or have states; otherwise there is one
/// species of hard spheres, and nothing about pairs is stored or looked up.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Engine<const FALLING: bool, const TABLE: bool> {
    pub state: State,
    pub clock: Clock,
    pub schedule: Schedule,
    pub neighbours: Neighbours,
    pub ranges: Ranges,
    pub pairs: Pairs,
    pub sources: Sources,
    pub counts: Counts,
    pub hardware: Hardware,
    /// The impossible state that it is in, if it is.
    pub broken: Option<InvariantBroken>,
    /// Room that is lent to predictions; part of no state.
    #[serde(skip)]
    pub scratch: Option<Box<Scratch>>,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Ends the run in an impossible state.
    #[cold]
    #[inline(never)]
    pub(super) fn broken(&mut self, particle: u32, partner: Option<u32>, expected: Invariant) -> InvariantBroken {
        let name = |number: u32| {
            self.state.bodies.get(number as usize).map_or(ParticleId(number), |body| ParticleId(body.name))
        };
        let names = (name(particle), partner.map(name));
        let broken = InvariantBroken { particle: names.0, partner: names.1, time: self.time(), expected };
        self.broken = Some(broken);
        broken
    }

    /// The user's id of a particle.
    #[inline]
    pub(super) fn name(&self, particle: u32) -> ParticleId {
        ParticleId(self.state.bodies[particle as usize].name)
    }

    /// The number of a particle that the user names.
    #[inline]
    pub(super) fn number(&self, id: ParticleId) -> u32 {
        self.state.numbers[id.0 as usize]
    }

    /// Writes the state of a pair into the lists of both; static ones keep none.
    pub(super) fn set_pair_state(&mut self, a: u32, b: u32, state: u16, interaction: u16) {
        for (particle, partner) in [(a, b), (b, a)] {
            if !self.is_static(particle) {
                let is_new = self.pairs.states.set(particle, PairState { partner, state, interaction });
                if is_new && let Some(lists) = self.neighbours.lists_mut() {
                    lists.remove(particle, partner);
                }
            }
        }
    }

    /// Removes the state of a pair: it is uncaptured again.
    pub(super) fn remove_pair_state(&mut self, a: u32, b: u32) -> Result<(), InvariantBroken> {
        for (particle, partner) in [(a, b), (b, a)] {
            if !self.is_static(particle) {
                if !self.pairs.states.remove(particle, partner) {
                    return Err(self.broken(particle, Some(partner), Invariant::CapturedPair));
                }
                if let Some(lists) = self.neighbours.lists_mut() {
                    lists.add(particle, partner);
                }
            }
        }
        Ok(())
    }

    #[inline]
    pub(super) fn is_static(&self, particle: u32) -> bool {
        TABLE && self.pairs.rules.species[usize::from(self.state.species[particle as usize])].is_static()
    }

    #[inline]
    pub(super) fn acceleration(&self, particle: u32) -> Vector {
        if FALLING {
            let species = if TABLE { self.state.species[particle as usize] } else { 0 };
            self.pairs.rules.species[usize::from(species)].acceleration
        } else {
            Vector::zeros()
        }
    }

    /// Puts a particle's pending prediction into the queue.
    #[inline]
    pub(super) fn enqueue(&mut self, particle: u32) {
        let wake = self.schedule.predictions.wake(particle);
        if wake.time < f64::INFINITY {
            self.schedule.queue.push(wake);
        }
    }

    /// Runs until a time or a number of physical events, calls `observe` for each event and ends where that breaks.
    pub fn advance(&mut self, until: Until, observe: &mut Observe<'_>) -> Result<Reason, EngineError> {
        loop {
            if let Some(reason) = self.advance_for(u64::MAX, until, observe)? {
                return Ok(reason);
            }
        }
    }

    /// The same, but pauses with `None` after a number of steps, be they events, cell transitions, predictions anew or whatever else
    /// takes as long. Where it pauses changes nothing.
    ///
    /// The observer is no type parameter: the loop is compiled once for each engine, in the library, and not for each closure of each caller.
    pub fn advance_for(
        &mut self,
        steps: u64,
        until: Until,
        observe: &mut Observe<'_>,
    ) -> Result<Option<Reason>, EngineError> {
        if let Some(broken) = self.broken {
            return Err(broken.into());
        }
        let mut stop = self.since_epoch(until.time);
        let mut left = steps;
        loop {
            let Some(rest) = left.checked_sub(1) else { return Ok(None) };
            left = rest;
            let entry = match self.next_due(stop) {
                Due::Particle(entry) => entry,
                Due::Void => {
                    self.schedule.queue.pop();
                    continue;
                }
                Due::GlobalEvent => {
                    let (taken, flow) = self.execute_global(observe)?;
                    if flow.is_break() {
                        return Ok(Some(Reason::Observer));
                    }
                    left = left.saturating_sub(taken);
                    continue;
                }
                Due::Epoch if self.move_epoch() => {
                    left = left.saturating_sub(self.steps_of_all());
                    stop = self.since_epoch(until.time);
                    continue;
                }
                Due::Epoch if until.time == f64::INFINITY => return Ok(Some(Reason::Idle)),
                Due::Epoch | Due::Limit => {
                    self.clock.now = stop;
                    return Ok(Some(Reason::Time));
                }
            };
            let particle = entry.particle;
            let prediction = self.schedule.predictions[particle as usize];
            if prediction.is_transition() {
                if until.time == f64::INFINITY && self.is_proof_due() && self.is_over() {
                    return Ok(Some(Reason::Idle));
                }
                self.schedule.queue.pop();
                self.clock.now = entry.time;
                self.execute_transition(particle, entry.time)?;
                continue;
            }
            if self.counts.executed >= until.events {
                return Ok(Some(Reason::Events));
            }
            self.schedule.queue.pop();
            self.clock.now = entry.time;
            if self.execute_contact(particle, &prediction, observe)?.is_break() {
                return Ok(Some(Reason::Observer));
            }
            // At the time of the last event, whatever else goes on until the next one.
            if self.counts.executed >= until.events {
                return Ok(Some(Reason::Events));
            }
        }
    }

    /// Executes the contact of a particle that is due now, shows it, and predicts anew what it has changed.
    #[inline]
    fn execute_contact(
        &mut self,
        particle: u32,
        prediction: &Prediction,
        observe: &mut Observe<'_>,
    ) -> Result<ControlFlow<()>, EngineError> {
        let now = self.clock.now;
        let Some(flow) = self.execute(particle, prediction, now, observe)? else {
            self.repredict(particle, now);
            return Ok(ControlFlow::Continue(()));
        };
        self.repredict(particle, now);
        if let Some(partner) = prediction.partner_in_contact()
            && !self.is_static(partner)
        {
            self.repredict(partner, now);
        }
        self.counts.executed += 1;
        self.counts.transitions_at_event = self.counts.totals.transition;
        self.count_standstill();
        self.check_standstill(particle, prediction)?;
        Ok(flow)
    }

    /// What is due next, up to a time since the epoch.
    #[inline]
    fn next_due(&mut self, stop: f64) -> Due {
        let next_global = self.sources.next_global;
        let Some(entry) = self.schedule.queue.peek(&self.schedule.predictions) else {
            let is_global = next_global <= stop.min(self.schedule.queue.reached());
            return if is_global { Due::GlobalEvent } else { Due::Epoch };
        };
        if self.schedule.predictions[entry.particle as usize].due_time() != entry.time {
            return Due::Void;
        }
        if self.hardware.is_large {
            self.prefetch_coming();
        }
        if entry.time <= stop.min(next_global) {
            Due::Particle(entry)
        } else if next_global <= stop {
            Due::GlobalEvent
        } else {
            Due::Limit
        }
    }

    /// The room for predictions, to be given back.
    #[inline]
    pub(super) fn take_scratch(&mut self) -> Box<Scratch> {
        self.scratch.take().unwrap_or_else(|| Box::new(Scratch::new(if TABLE { self.state.bodies.len() } else { 0 })))
    }

    /// Predicts a particle anew.
    #[inline]
    pub(super) fn predict_anew(&mut self, particle: u32, time: f64) {
        let mut scratch = self.take_scratch();
        self.schedule.predictions[particle as usize] = self.predict(particle, time, &mut scratch);
        self.scratch = Some(scratch);
    }

    /// Predicts a particle anew, and puts its prediction into the queue.
    #[inline]
    pub(super) fn repredict(&mut self, particle: u32, time: f64) {
        self.predict_anew(particle, time);
        self.enqueue(particle);
    }

    /// The numbers of all particles.
    #[inline]
    pub(super) fn particles(&self) -> Range<u32> {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "a scene has at most MOST_PARTICLES, by affordable of scene/limits.rs"
        )]
        let count = self.state.bodies.len() as u32;
        0..count
    }

    /// Whether pairs have to be looked at one by one.
    #[inline]
    pub(super) fn is_one_by_one(&self) -> bool {
        !self.ranges.further_images.is_empty() || self.sources.growth.is_some() || self.sources.lees_edwards.is_some()
    }

    /// Simulated time now.
    pub fn time(&self) -> f64 {
        self.clock.start + (self.clock.epoch + self.clock.now)
    }

    fn since_epoch(&self, time: f64) -> f64 {
        (time - self.clock.start) - self.clock.epoch
    }
}
