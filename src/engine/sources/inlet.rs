//! Inlets: particles enter the system at regular times.

use serde::{Deserialize, Serialize};

use super::{PER_STEP, Repredict};
use crate::Vector;
use crate::engine::contact::apply::With;
use crate::engine::event::CountedKind;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::observe::Observe;
use crate::engine::parts::Engine;
use crate::engine::surfaces::Surface;
use crate::engine::{Chosen, Invariant, InvariantBroken, Simulation};
use crate::model::limits::MOST_PARTICLES;
use crate::model::random::{Purpose, Random};
use crate::model::state_point::StatePoint;
use crate::model::{Inlet, Particle, Scene, SpeciesId};
use std::ops::ControlFlow;

/// Number of random places at which a particle is tried before it waits.
const ATTEMPTS: usize = 100;

/// What an inlet has done so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct InletCounts {
    /// Number of particles that have entered.
    pub entered: u64,
    /// Number of particles that are due, but wait for a free place.
    pub waiting: u64,
    /// Number of times that a particle found no free place.
    pub blocked: u64,
}

/// All inlets of a scene.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct Inlets {
    list: Vec<Source>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Source {
    inlet: Inlet,
    random: Random,
    counts: InletCounts,
    /// Number of attempts so far. One particle becomes due at each attempt.
    attempts: u64,
    /// Time of the next attempt since the epoch.
    next: f64,
    /// Whether another particle that waits is tried at the same time.
    is_repeated: bool,
    /// Species of the particle that enters next. It is drawn once, so that large particles, which wait longer for a
    /// place, enter as often as they should.
    species: Option<SpeciesId>,
}

impl Inlets {
    /// Returns `None` for a scene without inlets.
    pub fn of(scene: &Scene) -> Option<Self> {
        let seed = StatePoint::at_start(scene).seed(scene.seed);
        let list: Vec<Source> = (0..)
            .zip(&scene.inlets)
            .map(|(index, inlet)| Source {
                inlet: inlet.clone(),
                random: Random::new(seed, Purpose::Inlet, (scene.first_stream() << 16) + index),
                counts: InletCounts::default(),
                attempts: 0,
                next: inlet.attempt(0) - scene.start_time,
                is_repeated: false,
                species: None,
            })
            .collect();
        (!list.is_empty()).then_some(Self { list })
    }

    pub fn next(&self) -> f64 {
        self.list.iter().fold(f64::INFINITY, |next, source| next.min(source.next))
    }

    pub fn shift(&mut self, shift: f64) {
        self.list.iter_mut().for_each(|source| source.next -= shift);
    }

    /// The shortest time between two particles that are due `[time]`.
    pub fn shortest_interval(&self) -> Option<f64> {
        self.list.iter().map(|source| source.inlet.rate.recip()).reduce(f64::min)
    }

    pub fn are_those_of(&self, inlets: &[Inlet]) -> bool {
        self.list.iter().map(|source| &source.inlet).eq(inlets)
    }

    pub fn counts(&self) -> Vec<InletCounts> {
        self.list.iter().map(|source| source.counts).collect()
    }
}

impl Source {
    /// Updates the number of particles that are due at an attempt. Returns whether one may enter.
    fn is_due(&mut self, moving: u64) -> bool {
        let Inlet { count, keep, .. } = self.inlet;
        if !self.is_repeated {
            self.attempts += 1;
            self.counts.waiting += 1;
        }
        if let Some(keep) = keep {
            self.counts.waiting = self.counts.waiting.min(keep.saturating_sub(moving));
        }
        if let Some(count) = count {
            self.counts.waiting = self.counts.waiting.min(count.saturating_sub(self.counts.entered));
        }
        self.counts.waiting > 0
    }

    /// Whether the inlet has let in all its particles.
    fn is_exhausted(&self) -> bool {
        self.inlet.count.is_some_and(|count| self.counts.entered >= count)
    }
}

impl Simulation {
    /// What each inlet of the scene has done so far.
    #[must_use]
    pub fn inlets(&self) -> Vec<InletCounts> {
        with_engine!(&self.engine, engine => engine.sources.inlets.as_ref().map_or_else(Vec::new, |it| it.counts()))
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Lets one particle in, if one is due and finds a free place.
    pub(in crate::engine) fn let_in(
        &mut self,
        observe: &mut Observe<'_>,
    ) -> Result<(Repredict, ControlFlow<()>), InvariantBroken> {
        let Some(mut inlets) = self.sources.inlets.take() else {
            return Err(self.broken(0, None, Invariant::GlobalEvent));
        };
        let next = inlets.next();
        let Some((index, source)) = (0..).zip(&mut inlets.list).find(|(_, source)| source.next <= next) else {
            return Err(self.broken(0, None, Invariant::GlobalEvent));
        };
        self.clock.now = next;
        let may_enter = source.is_due(self.state.moving as u64) && u64::from(self.state.next_name) < MOST_PARTICLES;
        let (particle, tried) = if may_enter { self.draw_free(source) } else { (None, 0) };
        source.counts.blocked += u64::from(may_enter && particle.is_none());
        if particle.is_some() {
            source.counts.entered += 1;
            source.counts.waiting -= 1;
        }
        source.is_repeated = particle.is_some() && source.counts.waiting > 0;
        if source.is_exhausted() {
            source.next = f64::INFINITY;
        } else if !source.is_repeated {
            source.next = self.since_epoch(source.inlet.attempt(source.attempts));
        }
        self.sources.inlets = Some(inlets);
        let cost = Repredict::Nothing { steps: tried / PER_STEP };
        let Some(particle) = particle else { return Ok((cost, ControlFlow::Continue(()))) };
        let flow = self.enter(&[particle], (With::Inlet(index), Some(CountedKind::Entry)), observe, |_, _| {});
        Ok((cost, flow))
    }

    /// Draws a particle at a free place; `None` if no place was free. Also returns the number of places that were tried.
    fn draw_free(&mut self, source: &mut Source) -> (Option<Particle>, u64) {
        let Source { inlet, random, species, .. } = source;
        let kind = *species.get_or_insert_with(|| inlet.species_for(random.uniform()));
        let row = self.pairs.rules.rows.row(kind);
        let (radius, inverse_mass) = {
            let species = &self.pairs.rules.species[usize::from(row)];
            (species.radius, species.inverse_mass)
        };
        let (mut near, mut tried) = (Candidates::default(), 0);
        let mut places = (0..ATTEMPTS).map(|_| {
            tried += 1;
            inlet.region.draw(&self.state.space, radius, random)
        });
        let Some(place) = places.find(|place| self.is_free(place, row, &mut near)) else { return (None, tried) };
        let drawn = random.normal_vector(&self.state.space) * (inlet.temperature * inverse_mass).sqrt();
        *species = None;
        (Some(Particle::new(kind, place, inlet.velocity + drawn)), tried)
    }

    /// Whether a new particle at `position` would be beyond the range of all other particles, and touch no surface.
    fn is_free(&self, position: &Vector, row: u16, near: &mut Candidates) -> bool {
        let rows = self.pairs.rules.rows.species().len();
        let is_far = |other: u32| {
            let range = self.ranges.between[usize::from(row) * rows + usize::from(self.row(other))];
            let (there, _) = self.state_at(other, self.clock.now);
            range < 0.0 || self.nearest(position - there, Vector::zeros(), self.clock.now).0.position.norm() > range
        };
        let is_clear = if self.images.slide() {
            self.particles().all(is_far)
        } else {
            self.neighbours.find_candidates_at(position, near);
            near.found().iter().all(|&other| is_far(other))
        };
        let radius = self.pairs.rules.species[usize::from(row)].radius;
        let mut touches = !is_clear;
        if is_clear {
            self.sources.surfaces.for_each_near((position, radius), row, self.time(), |surface, position| {
                touches |= surface.shape.gap(position, radius) <= 0.0;
            });
        }
        !touches
    }
}

#[cfg(test)]
mod tests;
