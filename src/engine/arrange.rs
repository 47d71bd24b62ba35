//! Where everything is kept: the order of particles in memory, the cells and the lists.
//!
//! All of that is chosen for a state that changes: particles wander away from those that lie next to them in memory, a heap
//! gathers where there was rain. At the end of an epoch the choice is looked at again. What happens to particles does not depend
//! on it, but for the rounding of positions that are brought forward and of times that are predicted from there.

use super::event_loop::Engine;
use super::order::along_curve;
use super::prediction::Prediction;
use super::sources::lees_edwards::{FLOW, GRADIENT};
use crate::Vector;
use crate::engine::hardware::pages::enlarge;
use crate::engine::neighbours::cells::Cells;
use crate::engine::neighbours::shells::Shells;
use crate::engine::neighbours::{Neighbours, Search};
use crate::engine::pairs::memory::{Known, PairMemory};

/// The order in memory is made anew after this many transitions per particle.
const WANDERED: u64 = 64;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Arranges everything anew if that pays, at the epoch; whether it did.
    pub(super) fn rearrange_if_due(&mut self) -> bool {
        let range = self.ranges.iter().copied().fold(0.0, f64::max);
        let search = {
            let positions: Vec<Vector> = self.bodies.iter().map(|body| body.position).collect();
            Search::choose(&self.space, range, &positions, Some(self.neighbours.search()))
        };
        let since = self.tally.transition - self.transitions_at_order;
        if search == self.neighbours.search() && since < WANDERED * self.bodies.len() as u64 {
            return false;
        }
        for particle in self.particles() {
            self.stream(particle, 0.0);
            let position = self.bodies[particle as usize].position;
            self.wrap(particle, &position);
        }
        // Gone before the new ones come, so that there is never memory for both.
        self.neighbours = Neighbours::none(&self.space);
        self.reorder();
        self.sort_in(search);
        self.fill_lists();
        self.enlarge();
        for particle in self.particles() {
            if !self.is_static(particle) {
                self.predict(particle, 0.0);
            }
        }
        true
    }

    /// Numbers the particles along the curve.
    pub(super) fn reorder(&mut self) {
        self.transitions_at_order = self.tally.transition;
        // By name among those in the same cell of the curve, so that the order depends on where particles are only.
        let names = {
            let by_name: Vec<Vector> =
                self.numbers.iter().map(|&number| self.bodies[number as usize].position).collect();
            along_curve(&self.space, &by_name)
        };
        let old: Vec<u32> = names.iter().map(|&name| self.numbers[name as usize]).collect();
        let mut new = vec![0; old.len()];
        for (&old, number) in old.iter().zip(0..) {
            new[old as usize] = number;
        }
        self.bodies = permuted(&self.bodies, &old);
        self.species = permuted(&self.species, &old);
        self.images = permuted(&self.images, &old);
        self.predictions = vec![Prediction::NONE; old.len()];
        if let Some(times) = &mut self.contact_times {
            times.permute(&old);
        }
        if TABLE {
            let mut memory = PairMemory::new(old.len());
            for (&old, particle) in old.iter().zip(0..) {
                for known in self.memory.of(old) {
                    memory.set(particle, Known { partner: new[known.partner as usize], ..*known });
                }
            }
            self.memory = memory;
        }
        for (&name, number) in names.iter().zip(0..) {
            self.numbers[name as usize] = number;
        }
    }

    /// Asks for large pages under everything large.
    pub(super) fn enlarge(&self) {
        enlarge(&self.bodies);
        enlarge(&self.predictions);
        self.neighbours.enlarge();
    }

    /// Sorts particles into cells from where they are, or centres their shells there.
    pub(super) fn sort_in(&mut self, search: Search) {
        let positions: Vec<Vector> = self.bodies.iter().map(|body| body.position).collect();
        self.further_images.clear();
        self.tied_axes = [false; 3];
        self.neighbours = match search {
            Search::Cells => {
                let reach = self.reach * self.sources.growth.map_or(1.0, |growing| growing.reach);
                let cells = Cells::new(&self.space, reach, &positions);
                self.further_images = cells.grid.further_images(&self.periods);
                if self.further_images.is_empty() {
                    self.tied_axes = cells.grid.tied_axes();
                    if self.sources.lees_edwards.is_some() {
                        // Images along the flow and the gradient slide, and are looked at beside each other.
                        (self.tied_axes[FLOW], self.tied_axes[GRADIENT]) = (false, false);
                    }
                }
                Neighbours::Cells(cells)
            }
            Search::Lists { shell } => {
                Neighbours::Lists(Shells::new(&self.space, shell, &self.ranges, self.longest, positions))
            }
        };
    }
}

/// The elements of `old` in another order.
fn permuted<T: Copy>(values: &[T], old: &[u32]) -> Vec<T> {
    old.iter().map(|&old| values[old as usize]).collect()
}
