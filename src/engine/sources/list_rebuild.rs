//! Rebuilds of Verlet lists. When a particle leaves its skin, its list is built anew around its current position.

use crate::Vector;
use crate::engine::neighbours::Neighbours;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::neighbours::verlet::VerletLists;
use crate::engine::pairs::Pairs;
use crate::engine::parts::Engine;
use crate::engine::state::State;
use crate::engine::{Invariant, InvariantBroken};

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub(in crate::engine) fn rebuild_list(&mut self, particle: u32, time: f64) -> Result<(), InvariantBroken> {
        self.counts.totals.transition += 1;
        let me = self.streamed(particle, time);
        let Neighbours::Lists(verlet) = &self.neighbours else {
            return Err(self.broken(particle, None, Invariant::VerletList));
        };
        let is_loosely_bonded = self.is_loosely_bonded(particle);
        if FALLING && !is_loosely_bonded {
            // The predicted time was a lower bound. If the particle has moved little, a new prediction is enough.
            let gone = (me.position - verlet.centres[particle as usize]).norm_squared();
            if gone < 0.25 * verlet.half_skin * verlet.half_skin {
                let mut prediction = self.schedule.predictions[particle as usize];
                self.predict_with_newcomers(&me, verlet, None, &mut prediction);
                self.schedule.predictions[particle as usize] = prediction;
                self.enqueue(particle);
                return Ok(());
            }
        }
        let has_come_round = self.wrap(particle, &me.position);
        self.move_centre(particle, time)?;
        if is_loosely_bonded || (has_come_round && self.has_images_of_surfaces()) {
            self.repredict(particle, time);
            return Ok(());
        }
        let me = self.streamed(particle, time);
        let Neighbours::Lists(verlet) = &self.neighbours else {
            return Err(self.broken(particle, None, Invariant::VerletList));
        };
        let mut prediction = self.schedule.predictions[particle as usize];
        self.predict_with_newcomers(&me, verlet, Some(verlet.lists.newcomers()), &mut prediction);
        self.schedule.predictions[particle as usize] = prediction;
        self.enqueue(particle);
        Ok(())
    }

    pub(in crate::engine) fn wrap(&mut self, particle: u32, position: &Vector) -> bool {
        let mut has_come_round = false;
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
            has_come_round = true;
        }
        has_come_round
    }

    /// Rebuilds the list of a particle around its position at `time`, and updates the lists of its neighbours.
    fn move_centre(&mut self, particle: u32, time: f64) -> Result<(), InvariantBroken> {
        let (to, _) = self.state_at(particle, time);
        let Self { neighbours: Neighbours::Lists(verlet), pairs, state, scratch, .. } = self else {
            return Err(self.broken(particle, None, Invariant::VerletList));
        };
        let near = &mut scratch.get_or_insert_with(|| Self::new_scratch(state)).near;
        verlet.levels.lift(particle, &verlet.centres[particle as usize]);
        verlet.centres[particle as usize] = to;
        Self::find_listed(verlet, pairs, state, particle, near);
        verlet.levels.put(particle, &to);
        verlet.lists.renew(particle, near.found(), |other| Self::keeps_no_list(pairs, state, other));
        Ok(())
    }

    /// Captured pairs must be stored first, because the lists do not contain captured partners.
    pub(in crate::engine) fn fill_lists(&mut self) {
        let Self { neighbours: Neighbours::Lists(verlet), pairs, state, scratch, .. } = self else { return };
        let near = &mut scratch.get_or_insert_with(|| Self::new_scratch(state)).near;
        for particle in (0..).take(verlet.centres.len()) {
            if !Self::keeps_no_list(pairs, state, particle) {
                Self::find_listed(verlet, pairs, state, particle, near);
                near.retain(|other| other != particle);
                verlet.lists.set(particle, near.found());
            }
        }
    }

    /// Builds the list of a new particle, and adds the particle to the lists of its neighbours.
    pub(in crate::engine) fn fill_list(&mut self, particle: u32) {
        let Self { neighbours: Neighbours::Lists(verlet), pairs, state, scratch, .. } = self else { return };
        let near = &mut scratch.get_or_insert_with(|| Self::new_scratch(state)).near;
        Self::find_listed(verlet, pairs, state, particle, near);
        near.retain(|other| other != particle);
        let keeps_none = |other| Self::keeps_no_list(pairs, state, other);
        if keeps_none(particle) {
            near.retain(|other| !keeps_none(other) && pairs.states.get(other, particle).is_none());
            near.found().iter().for_each(|&other| verlet.lists.add(other, particle));
        } else {
            verlet.lists.renew(particle, near.found(), keeps_none);
        }
    }

    /// Finds the uncaptured particles within reach of the centre of a list. The result may include the particle itself.
    #[inline]
    fn find_listed(verlet: &VerletLists, pairs: &Pairs, state: &State, particle: u32, near: &mut Candidates) {
        let centre = &verlet.centres[particle as usize];
        let species = |particle: u32| if TABLE { state.rows[particle as usize] } else { 0 };
        verlet.find_neighbours_within(centre, species(particle), species, near);
        if TABLE && pairs.states.is_used() {
            near.retain(|other| pairs.states.get(particle, other).is_none());
        }
    }

    #[inline]
    fn keeps_no_list(pairs: &Pairs, state: &State, particle: u32) -> bool {
        TABLE && pairs.rules.species[usize::from(state.rows[particle as usize])].is_static()
    }
}

#[cfg(test)]
pub(in crate::engine) mod tests;
