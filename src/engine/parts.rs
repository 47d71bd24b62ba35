//! The engine and its parts: particle states, clock, event schedule, neighbours, pairs and event sources.

use super::clock::Clock;
use super::distances::Distances;
use super::domains::Domains;
use super::event::{EventCounts, EventCountsBySpecies};
use super::images::ImagePolicy;
use super::neighbours::Neighbours;
use super::neighbours::ranges::Ranges;
use super::pairs::Pairs;
use super::pairs::states::PairState;
use super::predict::Scratch;
use super::prediction::Schedule;
use super::slabs::Slabs;
use super::sources::Sources;
use super::state::State;
use super::{Invariant, InvariantBroken};
use crate::Vector;
use crate::model::ParticleId;
use crate::model::SpeciesId;
use crate::physics::detection::lanes::Simd;
use serde::{Deserialize, Serialize};
use std::ops::Range;

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Counts {
    pub totals: EventCounts,
    /// Event counts of each species; empty for an engine without an interaction table.
    pub by_species: EventCountsBySpecies,
    pub executed: u64,
    /// Number of transitions at the last event. May wrap below zero when the counts are reset, so only differences from
    /// the current number of transitions are meaningful.
    pub transitions_at_event: u64,
    /// Number of transitions at the last attempt to prove that no further event will happen.
    pub transitions_at_proof: u64,
    pub transitions_at_order: u64,
    /// Deepest overlap that was accepted as round-off `[length]`. An inelastic pair can stay this deep, so this depth
    /// is added to the tolerance of later overlaps.
    pub accepted_overlap: f64,
}

impl Default for Counts {
    fn default() -> Self {
        Self::new(0)
    }
}

impl Counts {
    pub fn new(species: usize) -> Self {
        Self {
            totals: EventCounts::default(),
            by_species: EventCountsBySpecies::new(species),
            executed: 0,
            transitions_at_event: 0,
            transitions_at_proof: 0,
            transitions_at_order: 0,
            accepted_overlap: 0.0,
        }
    }

    pub fn merge(&mut self, part: &Self) {
        self.totals.merge(&part.totals);
        self.by_species.merge(&part.by_species);
        self.executed += part.executed;
        self.accepted_overlap = self.accepted_overlap.max(part.accepted_overlap);
    }

    /// Sets all event counts to zero, for a run that continues an earlier run.
    pub fn restart(&mut self, species: usize) {
        let done = self.totals.transition;
        *self = Self {
            transitions_at_event: self.transitions_at_event.wrapping_sub(done),
            transitions_at_proof: self.transitions_at_proof.wrapping_sub(done),
            transitions_at_order: self.transitions_at_order.wrapping_sub(done),
            accepted_overlap: self.accepted_overlap,
            ..Self::new(species)
        };
    }
}

/// Hardware settings. They affect the speed, but not the results.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(super) struct Hardware {
    #[serde(skip, default = "Simd::most")]
    pub width: Simd,
    /// Whether the particle data are larger than the inner processor caches. Only then is prefetching worthwhile.
    pub looks_ahead: bool,
}

/// The fast engine, compiled for several kinds of scenes. With `FALLING`, some particles accelerate. With `TABLE`,
/// species differ or pairs have states. Without `TABLE`, all particles are hard spheres of one species.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct Engine<const FALLING: bool, const TABLE: bool> {
    pub state: State,
    pub clock: Clock,
    pub schedule: Schedule,
    pub neighbours: Neighbours,
    pub ranges: Ranges,
    pub pairs: Pairs,
    pub images: ImagePolicy,
    pub distances: Distances,
    pub sources: Sources,
    /// Boxed, so that exchanging two sets of counts is cheap.
    pub counts: Box<Counts>,
    pub hardware: Hardware,
    pub broken: Option<InvariantBroken>,
    #[serde(skip)]
    pub domains: Option<Box<Domains<FALLING, TABLE>>>,
    #[serde(skip)]
    pub slabs: Option<Box<Slabs>>,
    #[serde(skip)]
    pub scratch: Option<Box<Scratch>>,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub fn time(&self) -> f64 {
        self.simulated(self.clock.now)
    }

    /// Converts a time since the epoch to simulated time `[time]`.
    #[inline]
    pub fn simulated(&self, time: f64) -> f64 {
        self.clock.start + (self.clock.epoch + time)
    }

    /// Records that the simulation is in an impossible state, and returns the error that ends the run.
    #[cold]
    #[inline(never)]
    pub(super) fn broken(&mut self, particle: u32, partner: Option<u32>, expected: Invariant) -> InvariantBroken {
        let id =
            |number: u32| self.state.bodies.get(number as usize).map_or(ParticleId(number), |body| ParticleId(body.id));
        let (particle, partner) = (id(particle), partner.map(id));
        let broken = InvariantBroken { particle, partner, time: self.time(), expected };
        self.broken = Some(broken);
        broken
    }

    #[inline]
    pub(super) fn id(&self, particle: u32) -> ParticleId {
        ParticleId(self.state.bodies[particle as usize].id)
    }

    #[inline]
    pub(super) fn number(&self, id: ParticleId) -> u32 {
        let number = self.state.number(id.0);
        debug_assert!(number.is_some(), "no particle {}", id.0);
        number.unwrap_or(0)
    }

    /// Stores the state of a pair for both particles. Static particles store no pair states.
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

    pub(super) fn no_counts(&self) -> Counts {
        Counts { accepted_overlap: self.counts.accepted_overlap, ..Counts::new(self.counted_species()) }
    }

    pub(super) fn counted_species(&self) -> usize {
        if TABLE { self.pairs.rules.rows.species().len() } else { 0 }
    }

    #[inline]
    pub(super) fn row(&self, particle: u32) -> u16 {
        if TABLE { self.state.rows[particle as usize] } else { 0 }
    }

    pub(super) fn species_of(&self, particle: u32) -> SpeciesId {
        self.pairs.rules.rows.species()[usize::from(self.row(particle))]
    }

    #[inline]
    pub(super) fn is_static(&self, particle: u32) -> bool {
        TABLE && self.pairs.rules.species[usize::from(self.row(particle))].is_static()
    }

    /// Whether a particle sleeps. Sleeping particles are static until they wake up.
    #[inline]
    pub(super) fn is_asleep(&self, particle: u32) -> bool {
        TABLE && self.pairs.rules.rows.is_asleep(self.row(particle))
    }

    /// Whether a particle is of a static species, and never moves.
    #[inline]
    pub(super) fn is_of_static_species(&self, particle: u32) -> bool {
        self.is_static(particle) && !self.is_asleep(particle)
    }

    #[inline]
    pub(super) fn acceleration(&self, particle: u32) -> Vector {
        if FALLING { self.pairs.rules.species[usize::from(self.row(particle))].acceleration } else { Vector::zeros() }
    }

    /// Takes the working memory of predictions out of the engine. The caller puts it back into `self.scratch`.
    #[inline(always)]
    pub(super) fn take_scratch(&mut self) -> Box<Scratch> {
        self.scratch.take().unwrap_or_else(|| Self::new_scratch(&self.state))
    }

    pub(super) fn new_scratch(state: &State) -> Box<Scratch> {
        Box::new(Scratch::new(if TABLE { state.bodies.len() } else { 0 }))
    }

    #[inline]
    pub(super) fn particles(&self) -> Range<u32> {
        #[expect(
            clippy::cast_possible_truncation,
            reason = "`affordable` in scene/limits.rs accepts at most MOST_PARTICLES particles"
        )]
        let count = self.state.bodies.len() as u32;
        0..count
    }
}
