//! Inlets: particles enter the system at regular times.

use serde::{Deserialize, Serialize};

use super::Repredict;
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
use crate::model::{Inlet, Particle, Scene};
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
    /// Number of the next particle that becomes due.
    number: u64,
    /// Time of the next attempt since the epoch.
    next: f64,
    /// Whether the next attempt is one more at the same time, so that no further particle becomes due.
    is_repeated: bool,
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
                number: 0,
                next: inlet.due(0) - scene.start_time,
                is_repeated: false,
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

    pub fn counts(&self) -> Vec<InletCounts> {
        self.list.iter().map(|source| source.counts).collect()
    }
}

impl Source {
    /// Updates the number of particles that are due at an attempt. Returns whether one may enter.
    fn is_due(&mut self, moving: u64) -> bool {
        let Inlet { count, keep, .. } = self.inlet;
        if !self.is_repeated {
            self.number += 1;
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
        let particle = if may_enter { self.draw_free(source) } else { None };
        source.counts.blocked += u64::from(may_enter && particle.is_none());
        if particle.is_some() {
            source.counts.entered += 1;
            source.counts.waiting -= 1;
        }
        source.is_repeated = particle.is_some() && source.counts.waiting > 0;
        if source.is_exhausted() {
            source.next = f64::INFINITY;
        } else if !source.is_repeated {
            source.next = self.next_attempt(source);
        }
        self.sources.inlets = Some(inlets);
        let Some(particle) = particle else { return Ok((Repredict::None, ControlFlow::Continue(()))) };
        let flow = self.enter(&[particle], (With::Inlet(index), Some(CountedKind::Entry)), observe, |_, _| {});
        Ok((Repredict::None, flow))
    }

    /// Time of the next attempt of an inlet, since the epoch. An inlet whose last particle waits tries on.
    fn next_attempt(&self, source: &Source) -> f64 {
        let Inlet { rate, from, until, .. } = source.inlet;
        let due = source.inlet.due(source.number);
        let time = if due == f64::INFINITY && source.counts.waiting > 0 {
            let intervals = ((self.time() - from) * rate).floor() + 1.0;
            Some(from + intervals / rate).filter(|time| *time <= until).unwrap_or(f64::INFINITY)
        } else {
            due
        };
        self.since_epoch(time)
    }

    /// Draws a particle at a free place; `None` if no place was free.
    fn draw_free(&mut self, source: &mut Source) -> Option<Particle> {
        let Source { inlet, random, .. } = source;
        let species = inlet.species_for(random.uniform());
        let row = self.pairs.rules.rows.row(species);
        let (radius, inverse_mass) = {
            let species = &self.pairs.rules.species[usize::from(row)];
            (species.radius, species.inverse_mass)
        };
        let mut near = Candidates::default();
        let mut places = (0..ATTEMPTS).map(|_| inlet.region.draw(&self.state.space, radius, random));
        let place = places.find(|place| self.is_free(place, row, &mut near))?;
        let drawn = random.normal_vector(&self.state.space) * (inlet.temperature * inverse_mass).sqrt();
        Some(Particle::new(species, place, inlet.velocity + drawn))
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
