//! Swap moves: two particles exchange their species and diameters.

use super::contact::apply::With;
use super::neighbours::Neighbours;
use super::neighbours::candidates::Candidates;
use super::parts::Engine;
use super::{Chosen, Simulation};
use crate::Vector;
use crate::model::random::Random;
use crate::model::{Swap, SwapMoves};

impl Simulation {
    /// Makes a set of swap moves at the current time. The scene must allow them: only smooth and elastic hard spheres,
    /// without bonds, gravity, growth and shear.
    pub(crate) fn swap(&mut self, swap: &Swap, random: &mut Random) -> SwapMoves {
        with_engine!(&mut self.engine, engine => engine.swap(swap, random))
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn swap(&mut self, swap: &Swap, random: &mut Random) -> SwapMoves {
        let mut moves = SwapMoves::default();
        self.join();
        // In the order of ids, which does not depend on the order in memory.
        let moving: Vec<u32> = self.by_id().filter(|&particle| !self.is_static(particle)).collect();
        if moving.len() < 2 {
            return moves;
        }
        let mut near = Candidates::default();
        for _ in 0..swap.attempts(moving.len()) {
            let (first, other) = (random.below(moving.len()), random.below(moving.len() - 1));
            let mut pair = [moving[first], moving[other + usize::from(other >= first)]];
            if self.diameter(pair[0]) > self.diameter(pair[1]) {
                pair.reverse();
            }
            moves.attempted += 1;
            if self.are_alike(pair) {
                moves.alike += 1;
            } else if !swap.allows(pair.map(|particle| self.diameter(particle))) {
                moves.too_unlike += 1;
            } else if self.has_room(pair, &mut near) && self.has_room([pair[1], pair[0]], &mut near) {
                // The particle that grows is tested first, because it is more likely to overlap.
                moves.accepted += 1;
                self.exchange(pair);
            }
        }
        moves
    }

    fn diameter(&self, particle: u32) -> f64 {
        2.0 * self.radius(particle)
    }

    /// Whether an exchange of two particles would change nothing.
    fn are_alike(&self, [a, b]: [u32; 2]) -> bool {
        self.row(a) == self.row(b) && self.radius(a) == self.radius(b)
    }

    /// Whether a particle would overlap no particle and no surface if it had the species and the diameter of `other`.
    /// The pair itself is not tested, because its contact distance is the same after the exchange.
    fn has_room(&self, [particle, other]: [u32; 2], near: &mut Candidates) -> bool {
        let now = self.clock.now;
        let row = self.row(other);
        let (position, _) = self.wrapped(self.state_at(particle, now).0);
        self.neighbours.find_candidates_at(&position, row, near);
        let overlaps = |third: &u32| {
            let meeting = self.pairs.rules.meeting(row, self.row(*third));
            let apart = position - self.state_at(*third, now).0;
            let nearest = self.nearest(apart, Vector::zeros(), now).0.position;
            let squared = self.squared_of_pair(meeting.squared, [other, *third]);
            ![particle, other].contains(third) && meeting.exists && nearest.norm_squared() < squared
        };
        !near.found().iter().any(overlaps)
            && self.overlap_with_surfaces((row, self.radius(other)), &position, self.id(particle)).is_none()
    }

    /// Gives two particles new lists after a change of their rows. Cells do not depend on rows.
    fn list_anew(&mut self, pair: [u32; 2]) {
        if self.neighbours.verlet().is_none() {
            return;
        }
        for particle in pair {
            self.bring_in(particle);
            let (position, row) = (self.state.bodies[particle as usize].position, self.row(particle));
            if let Neighbours::Lists(verlet) = &mut self.neighbours {
                verlet.change_row(particle, &position, row);
            }
        }
        for particle in pair {
            self.fill_list(particle);
        }
    }

    /// Exchanges the species and diameters of two particles without checks.
    ///
    /// If another particle is predicted to meet one of the two, this contact becomes void. The other particle is
    /// predicted again when the contact is due.
    fn exchange(&mut self, pair: [u32; 2]) {
        let now = self.clock.now;
        let mut velocities = pair.map(|particle| self.state.bodies[particle as usize].velocity);
        if self.inverse_mass(pair[0]) != self.inverse_mass(pair[1]) {
            velocities.reverse();
        }
        for particle in pair {
            self.stream(particle, now);
            let _ = self.end_motion(particle, &Vector::zeros(), (With::Program, None), &mut None);
        }
        self.state.rows.swap(pair[0] as usize, pair[1] as usize);
        self.state.sizes.swap(pair);
        self.list_anew(pair);
        for (particle, velocity) in pair.into_iter().zip(velocities) {
            let _ = self.begin_motion(particle, velocity, (With::Program, None), &mut None);
        }
        for particle in pair {
            self.repredict(particle, now);
        }
    }
}

#[cfg(test)]
mod tests;
