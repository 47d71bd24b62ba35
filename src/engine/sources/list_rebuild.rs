//! Verlet lists in the event loop: contacts with the particles in a list, and when the list has to be rebuilt.

use crate::Vector;
use crate::engine::neighbours::Neighbours;
use crate::engine::neighbours::verlet::VerletLists;
use crate::engine::pairs::Pairs;
use crate::engine::parts::Engine;
use crate::engine::predict::Streamed;
use crate::engine::prediction::Prediction;
use crate::engine::{Invariant, InvariantBroken};
use crate::physics::detection::inertial;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::{Quadratic, Side};

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// The first contact with those in the particle's list, and when it leaves its skin.
    #[inline]
    pub(in crate::engine) fn predict_in_list(&self, me: &Streamed, verlet: &VerletLists, prediction: &mut Prediction) {
        // First, because its root and its quotient take long, and what comes then waits for memory.
        prediction.transition_time = self.leaves_skin(me, verlet);
        self.predict_listed(me, verlet, verlet.lists.filled_up(me.id), prediction);
        if !self.sources.surfaces.is_empty() {
            self.predict_surfaces(me, |_, _| true, prediction);
        }
    }

    /// The first contact with some others in the particle's list, filled up as lists are; so many are there.
    #[inline]
    fn predict_listed(
        &self,
        me: &Streamed,
        verlet: &VerletLists,
        listed: (&[u32], usize),
        prediction: &mut Prediction,
    ) {
        self.predict_nearest(me, verlet.wraps(&me.position), listed, prediction);
    }

    /// When the particle leaves its skin: like a bond to the centre that reaches its length.
    ///
    /// A falling particle is taken to fly straight away from the centre and to be accelerated that way too, so that it leaves no
    /// earlier than this: `|v| t + |a| t^2 / 2 = delta - |r|`.
    #[inline]
    fn leaves_skin(&self, me: &Streamed, verlet: &VerletLists) -> f64 {
        let position = me.position - verlet.centres[me.id as usize];
        let squared = verlet.half_skin * verlet.half_skin;
        if FALLING && me.acceleration != Vector::zeros() {
            let room = (verlet.half_skin - position.norm()).max(0.0);
            let (v2, a) = (me.velocity.norm_squared(), me.acceleration.norm());
            return me.time + 2.0 * room / (v2.sqrt() + (v2 + 2.0 * a * room).sqrt());
        }
        let state = RelativeState { position, velocity: me.velocity };
        let dt = inertial::next_event(&Quadratic::new(&state, squared), Side::Negative);
        me.time + dt.unwrap_or(f64::INFINITY)
    }

    /// Rebuilds the list of a particle that leaves its skin, around where it is now.
    pub(in crate::engine) fn rebuild_list(&mut self, particle: u32, time: f64) -> Result<(), InvariantBroken> {
        self.counts.totals.transition += 1;
        let me = self.streamed(particle, time);
        let Neighbours::Lists(verlet) = &self.neighbours else {
            return Err(self.broken(particle, None, Invariant::VerletList));
        };
        let has_own_interactions = self.has_own_interactions(particle);
        if FALLING && !has_own_interactions {
            // The bound came true without the particle having gone far.
            let gone = (me.position - verlet.centres[particle as usize]).norm_squared();
            if gone < 0.25 * verlet.half_skin * verlet.half_skin {
                self.schedule.predictions[particle as usize].transition_time = self.leaves_skin(&me, verlet);
                self.enqueue(particle);
                return Ok(());
            }
        }
        self.wrap(particle, &me.position);
        self.move_centre(particle, time)?;
        if has_own_interactions {
            self.repredict(particle, time);
            return Ok(());
        }
        // Its motion stays as it is, and so does its predicted contact, unless one of those that are new to it comes first.
        let me = self.streamed(particle, time);
        let Neighbours::Lists(verlet) = &self.neighbours else {
            return Err(self.broken(particle, None, Invariant::VerletList));
        };
        let mut prediction = self.schedule.predictions[particle as usize];
        prediction.transition_time = self.leaves_skin(&me, verlet);
        self.predict_listed(&me, verlet, verlet.lists.newcomers(), &mut prediction);
        self.schedule.predictions[particle as usize] = prediction;
        self.enqueue(particle);
        Ok(())
    }

    /// Brings a particle that has left the box on a periodic axis back in.
    pub(in crate::engine) fn wrap(&mut self, particle: u32, position: &Vector) {
        for axis in 0..3 {
            let period = self.state.periods[axis];
            if period == f64::INFINITY {
                continue;
            }
            let periods = if position[axis] < self.state.space.lower[axis] {
                1
            } else if position[axis] >= self.state.space.lower[axis] + period {
                -1
            } else {
                continue;
            };
            self.state.bodies[particle as usize].position[axis] += f64::from(periods) * period;
            self.state.images.add(particle, axis, -periods);
        }
    }

    /// Moves a particle's centre to where it is at `time`, and changes the lists accordingly.
    fn move_centre(&mut self, particle: u32, time: f64) -> Result<(), InvariantBroken> {
        let (to, _) = self.state_at(particle, time);
        let mut scratch = self.take_scratch();
        let near = &mut scratch.near;
        let Self { neighbours: Neighbours::Lists(verlet), pairs: Pairs { states, rules, .. }, state, .. } = self else {
            return Err(self.broken(particle, None, Invariant::VerletList));
        };
        let species = &state.species;
        verlet.cells.lift(particle, &verlet.centres[particle as usize]);
        verlet.centres[particle as usize] = to;
        let all: &[u16] = if TABLE { species } else { &[] };
        verlet.find_neighbours_within(&to, mine(all, particle), all, near);
        verlet.cells.put(particle, &to);
        if TABLE {
            near.retain(|other| states.get(particle, other).is_none());
        }
        let is_static = |other: u32| TABLE && rules.species[usize::from(species[other as usize])].is_static();
        verlet.lists.renew(particle, near.found(), is_static);
        self.scratch = Some(scratch);
        Ok(())
    }

    /// Builds the lists of all, once captured pairs are known.
    pub(in crate::engine) fn fill_lists(&mut self) {
        let mut scratch = self.take_scratch();
        let near = &mut scratch.near;
        let Self { neighbours: Neighbours::Lists(verlet), pairs: Pairs { states, rules, .. }, state, .. } = self else {
            return;
        };
        let species = &state.species;
        let all: &[u16] = if TABLE { species } else { &[] };
        for (particle, centre) in (0..).zip(&verlet.centres) {
            if TABLE && rules.species[usize::from(species[particle as usize])].is_static() {
                continue;
            }
            verlet.find_neighbours_within(centre, mine(all, particle), all, near);
            near.retain(|other| other != particle && !(TABLE && states.get(particle, other).is_some()));
            verlet.lists.set(particle, near.found());
        }
        self.scratch = Some(scratch);
    }
}

/// The species of a particle among those of all, which are not written down if there is only one.
#[inline]
fn mine(all: &[u16], particle: u32) -> u16 {
    if all.is_empty() { 0 } else { all[particle as usize] }
}

#[cfg(test)]
mod tests;
