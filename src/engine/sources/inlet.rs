//! Inlets: new particles enter the system at regular times, and particles that have left return.

pub(in crate::engine) mod newcomer;

use serde::{Deserialize, Serialize};

use self::newcomer::{Newcomer, SizesOfSpecies};
use super::{PER_STEP, Repredict};
use crate::Vector;
use crate::engine::contact::apply::With;
use crate::engine::event::CountedKind;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::observe::Observe;
use crate::engine::pairs::rules::Rules;
use crate::engine::parts::Engine;
use crate::engine::sizes::Size;
use crate::engine::surfaces::{FIRST_SURFACE, Surface};
use crate::engine::{Chosen, Invariant, InvariantBroken, Simulation};
use crate::model::limits::MOST_PARTICLES;
use crate::model::random::{Purpose, Random};
use crate::model::state_point::StatePoint;
use crate::model::{Inlet, Particle, Scene, SpeciesId};
use std::collections::VecDeque;
use std::ops::ControlFlow;

/// Number of random positions that are tried for a particle before it has to wait.
const ATTEMPTS: usize = 100;

/// Number of attempts to place a returning particle during the time in which a particle travels its own diameter.
const TRIES_PER_DIAMETER: f64 = 10.0;

/// Counts of an inlet: particles that have entered or wait, and failed attempts to place a particle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct InletCounts {
    /// Number of particles that have entered: new particles, and those that have returned.
    pub entered: u64,
    /// Number of particles that have left at an outlet and have returned here.
    pub returned: u64,
    /// Number of particles that are due, but wait for a free place.
    pub waiting: u64,
    /// Number of times that a particle found no free place.
    pub blocked: u64,
}

/// All inlets of a scene.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct Inlets {
    list: Vec<Source>,
    sizes: Vec<SizesOfSpecies>,
}

#[derive(Debug, Clone, Serialize, Deserialize)]
struct Source {
    inlet: Inlet,
    random: Random,
    /// Here, `waiting` counts only new particles.
    counts: InletCounts,
    /// Number of new particles that have been due so far.
    attempts: u64,
    /// Time since the epoch at which the next new particle is due.
    next: f64,
    /// Whether the inlet tries another waiting particle at the current time.
    is_repeated: bool,
    /// The new particle that enters next. It is drawn once, so that large particles, which wait longer for a place,
    /// enter as often as they should.
    newcomer: Option<Newcomer>,
    /// Numbers of the outlets whose particles return, as in [`Other::Surface`](crate::engine::event::Other::Surface).
    outlets: Vec<u32>,
    /// Particles that wait to return, in the order in which they left.
    returning: VecDeque<Newcomer>,
    /// Time since the epoch at which the first of them is tried; infinite if none waits.
    next_return: f64,
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
                newcomer: None,
                outlets: outlets_of(inlet, scene),
                returning: VecDeque::new(),
                next_return: f64::INFINITY,
            })
            .collect();
        (!list.is_empty()).then(|| Self { list, sizes: SizesOfSpecies::all(scene) })
    }

    pub fn next(&self) -> f64 {
        self.list.iter().fold(f64::INFINITY, |next, source| next.min(source.earliest()))
    }

    pub fn shift(&mut self, shift: f64) {
        for source in &mut self.list {
            source.next -= shift;
            source.next_return -= shift;
        }
    }

    /// The shortest time between two new particles that are due `[time]`.
    pub fn shortest_interval(&self) -> Option<f64> {
        let filling = self.list.iter().filter(|source| source.inlet.has_new_particles());
        filling.map(|source| source.inlet.rate.recip()).reduce(f64::min)
    }

    /// Records that a particle leaves at an outlet, at the time `now` since the epoch. The particle then waits at the
    /// inlet that takes the particles of this outlet, if there is one.
    pub fn take(&mut self, particle: Newcomer, outlet: u32, now: f64) {
        let Some(source) = self.list.iter_mut().find(|source| source.outlets.contains(&outlet)) else { return };
        source.returning.push_back(particle);
        // If others wait already, all are tried together.
        if source.next_return == f64::INFINITY {
            source.next_return = now;
        }
    }

    pub fn are_those_of(&self, inlets: &[Inlet]) -> bool {
        self.list.iter().map(|source| &source.inlet).eq(inlets)
    }

    pub fn counts(&self) -> Vec<InletCounts> {
        let of_one = |source: &Source| InletCounts {
            waiting: source.counts.waiting + source.returning.len() as u64,
            ..source.counts
        };
        self.list.iter().map(of_one).collect()
    }

    /// Checks the waiting particles and the sizes that were read from a file. `species` is the number of species.
    pub fn are_sound(&self, species: usize, rules: &Rules) -> bool {
        let mut waiting = self.list.iter().flat_map(|source| source.returning.iter().chain(&source.newcomer));
        let mut sizes = (0..).map(SpeciesId).zip(&self.sizes);
        self.sizes.len() == species
            && waiting.all(|newcomer| newcomer.is_sound(species, rules))
            && sizes.all(|(id, sizes)| sizes.is_sound(id, species, rules))
    }
}

/// Numbers of the outlets whose particles return at an inlet.
fn outlets_of(inlet: &Inlet, scene: &Scene) -> Vec<u32> {
    let surfaces = (FIRST_SURFACE..).zip(&scene.surfaces);
    surfaces.filter(|(_, surface)| inlet.recirculate.contains(&surface.name)).map(|(number, _)| number).collect()
}

impl Source {
    /// Time since the epoch of the next attempt.
    fn earliest(&self) -> f64 {
        self.next.min(self.next_return)
    }

    /// Updates the number of new particles that are due at the time `now`. Returns whether a particle may enter.
    fn is_due(&mut self, now: f64, moving: u64) -> bool {
        let Inlet { count, keep, .. } = self.inlet;
        if !self.is_repeated && self.next <= now {
            self.attempts += 1;
            self.counts.waiting += 1;
        }
        if let Some(keep) = keep {
            self.counts.waiting = self.counts.waiting.min(keep.saturating_sub(moving));
        }
        if let Some(count) = count {
            self.counts.waiting = self.counts.waiting.min(count.saturating_sub(self.new_particles()));
        }
        self.has_waiting()
    }

    fn has_waiting(&self) -> bool {
        self.counts.waiting > 0 || !self.returning.is_empty()
    }

    /// Number of new particles that have entered.
    fn new_particles(&self) -> u64 {
        self.counts.entered.saturating_sub(self.counts.returned)
    }

    /// Whether the inlet has let in all its new particles.
    fn is_exhausted(&self) -> bool {
        self.inlet.count.is_some_and(|count| self.new_particles() >= count)
    }

    /// The particle that is tried next. Particles that return come before new ones.
    fn next_newcomer(&mut self, sizes: &[SizesOfSpecies]) -> Newcomer {
        let Self { inlet, random, newcomer, returning, .. } = self;
        match returning.front() {
            Some(first) => *first,
            None => *newcomer.get_or_insert_with(|| {
                let species = inlet.species_for(random.uniform());
                Newcomer { species, size: sizes[species.0 as usize].draw(random) }
            }),
        }
    }

    /// Counts a particle that enters, and removes it from the waiting particles.
    fn let_go(&mut self) {
        self.counts.entered += 1;
        if self.returning.pop_front().is_some() {
            self.counts.returned += 1;
        } else {
            self.newcomer = None;
            self.counts.waiting -= 1;
        }
    }
}

impl Simulation {
    /// Returns the counts of each inlet of the scene.
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
        let Inlets { list, sizes } = &mut *inlets;
        let Some((index, source)) = (0..).zip(list).find(|(_, source)| source.earliest() <= next) else {
            return Err(self.broken(0, None, Invariant::GlobalEvent));
        };
        self.clock.now = next;
        let may_enter = source.is_due(next, self.state.moving as u64) && u64::from(self.state.next_id) < MOST_PARTICLES;
        let (particle, tried) = if may_enter { self.draw_free(source, sizes) } else { (None, 0) };
        source.counts.blocked += u64::from(may_enter && particle.is_none());
        if particle.is_some() {
            source.let_go();
        }
        source.is_repeated = particle.is_some() && source.has_waiting();
        if source.is_exhausted() {
            source.next = f64::INFINITY;
        } else if !source.is_repeated && source.next <= next {
            source.next = self.since_epoch(source.inlet.attempt(source.attempts));
        }
        if source.returning.is_empty() {
            source.next_return = f64::INFINITY;
        } else {
            source.next_return = if source.is_repeated { next } else { self.next_try(source) };
        }
        self.sources.inlets = Some(inlets);
        let cost = Repredict::Nothing { steps: tried / PER_STEP };
        let Some(particle) = particle else { return Ok((cost, ControlFlow::Continue(()))) };
        let (particle, size) = particle;
        let sizes = self.has_sizes().then_some(std::slice::from_ref(&size));
        let how = (With::Inlet(index), Some(CountedKind::Entry));
        let flow = self.enter((&[particle], sizes), how, observe, |_, _| {});
        Ok((cost, flow))
    }

    /// Draws a particle at a free place; `None` if no place was free. Also returns the number of places that were
    /// tried.
    fn draw_free(&mut self, source: &mut Source, sizes: &[SizesOfSpecies]) -> (Option<(Particle, Size)>, u64) {
        let newcomer = source.next_newcomer(sizes);
        let Source { inlet, random, .. } = source;
        let size = self.size_of(newcomer);
        let Newcomer { species, size: individual } = newcomer;
        let diameter = individual.map(|size| 2.0 * size.radius);
        let particle = Particle { diameter, ..Particle::new(species, Vector::zeros(), inlet.velocity) };
        let row = self.pairs.rules.rows.row_of(&particle);
        let (mut near, mut tried) = (Candidates::default(), 0);
        let mut places = (0..ATTEMPTS).map(|_| {
            tried += 1;
            inlet.region.draw(&self.state.space, size.radius, random)
        });
        let place = places.find(|place| self.is_free(place, (row, size.radius), &mut near));
        let Some(position) = place else { return (None, tried) };
        let drawn = random.normal_vector(&self.state.space) * (inlet.temperature * size.inverse_mass).sqrt();
        (Some((Particle { position, velocity: inlet.velocity + drawn, ..particle }, size)), tried)
    }

    fn size_of(&self, newcomer: Newcomer) -> Size {
        newcomer.size.unwrap_or_else(|| {
            let rules = &self.pairs.rules;
            let species = &rules.species[usize::from(rules.rows.row(newcomer.species))];
            Size { radius: species.radius, inverse_mass: species.inverse_mass }
        })
    }

    /// Returns the time since the epoch of the next attempt to place the first returning particle.
    ///
    /// The previous particle has to make room first. This takes about the time in which a particle travels its
    /// diameter, so the interval between attempts is a fraction of this time.
    fn next_try(&self, source: &Source) -> f64 {
        let Some(first) = source.returning.front() else { return f64::INFINITY };
        let rules = &self.pairs.rules;
        let acceleration = rules.species[usize::from(rules.rows.row(first.species))].acceleration.norm();
        let Size { radius, inverse_mass } = self.size_of(*first);
        let Inlet { velocity, temperature, .. } = &source.inlet;
        let speed = (velocity.norm_squared() + temperature * inverse_mass).sqrt();
        let diameter = 2.0 * radius;
        // The positive solution of v t + a t^2 / 2 = d.
        let time = 2.0 * diameter / (speed + (speed * speed + 2.0 * acceleration * diameter).sqrt());
        let now = self.clock.now;
        (now + time / TRIES_PER_DIAMETER).max(now.next_up())
    }

    /// Whether a new particle at `position` would be beyond the range of all other particles, and touch no surface.
    fn is_free(&self, position: &Vector, (row, radius): (u16, f64), near: &mut Candidates) -> bool {
        let is_far = |other: u32| {
            let range = self.range_between((row, radius), other);
            let (there, _) = self.state_at(other, self.clock.now);
            range < 0.0 || self.nearest(position - there, Vector::zeros(), self.clock.now).0.position.norm() > range
        };
        let is_clear = if self.images.are_sliding() {
            self.particles().all(is_far)
        } else {
            self.neighbours.find_candidates_at(position, row, near);
            near.found().iter().all(|&other| is_far(other))
        };
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
