//! Where everything is kept: the order of particles in memory, the cells and the lists.
//!
//! All of that is chosen for a state that changes: particles wander away from those that lie next to them in memory, a heap
//! gathers where there was rain. At the end of an epoch the choice is looked at again. What happens to particles does not depend
//! on their order in memory at all; on the search only by the rounding of positions that are brought forward and of times that are predicted from
//! there.

use super::columns::Order;
use super::order::along_curve;
use super::parts::Engine;
use crate::Vector;
use crate::engine::hardware::pages::enlarge;
use crate::engine::neighbours::cells::Cells;
use crate::engine::neighbours::verlet::VerletLists;
use crate::engine::neighbours::{Neighbours, Search};

/// The order in memory is made again after this many transitions per particle.
const WANDERED: u64 = 64;

/// With more particles than these, prefetching pays: bodies and cells take some megabytes. Lists take as much of fewer particles, and an event
/// reads little else.
const LARGE_IN_CELLS: usize = 32_768;
const LARGE_IN_LISTS: usize = 2_048;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Puts particles that have wandered away from each other in order.
    pub(super) fn reorder_if_due(&mut self) {
        let since = self.counts.totals.transition.wrapping_sub(self.counts.transitions_at_order);
        if since >= WANDERED * self.state.bodies.len() as u64 {
            self.reorder();
            self.enlarge();
        }
    }

    /// Searches for neighbours in the other way, or with another skin, if that pays, at the epoch; whether it does from now on.
    pub(super) fn change_search_if_due(&mut self) -> bool {
        if self.images.slide() || !self.distances.are_constant() {
            return false;
        }
        let search = self.best_search();
        if search == self.neighbours.search() {
            return false;
        }
        self.stream_all(0.0);
        // Freed before the new ones are allocated, so that both are never in memory.
        self.neighbours = Neighbours::none(&self.state.space);
        self.reorder();
        self.sort_in(search);
        self.predict_all();
        true
    }

    /// The best neighbour search at the present density, given the current one.
    pub(super) fn best_search(&self) -> Search {
        let range = self.ranges.between.iter().copied().fold(0.0, f64::max);
        let positions = || self.state.bodies.iter().map(|body| body.position);
        Search::choose_among(&self.state.space, range, positions, Some(self.neighbours.search()))
    }

    /// Streams all particles to a time since the epoch, and wraps those outside of the box.
    pub(super) fn stream_all(&mut self, time: f64) {
        for particle in self.particles() {
            self.stream(particle, time);
            let position = self.state.bodies[particle as usize].position;
            self.wrap(particle, &position);
        }
    }

    /// Numbers the particles along the curve.
    pub(super) fn reorder(&mut self) {
        self.counts.transitions_at_order = self.counts.totals.transition;
        // By name among those in the same cell of the curve, so that the order depends on where particles are only.
        let names = {
            let by_name: Vec<Vector> =
                self.state.numbers.iter().map(|&number| self.state.bodies[number as usize].position).collect();
            along_curve(&self.state.space, &by_name)
        };
        let old = names.iter().map(|&name| self.state.numbers[name as usize]).collect();
        self.permute(&Order::of(old, self.state.bodies.len()));
    }

    /// Asks for large pages under everything large.
    pub(super) fn enlarge(&self) {
        enlarge(&self.state.bodies);
        enlarge(&self.schedule.predictions);
        self.neighbours.enlarge();
    }

    /// Sorts particles into cells from where they are, or centres their lists there.
    pub(super) fn sort_in(&mut self, search: Search) {
        let positions: Vec<Vector> = self.state.bodies.iter().map(|body| body.position).collect();
        let factor = self.distances.reach_factor();
        let most = if search == Search::Cells { LARGE_IN_CELLS } else { LARGE_IN_LISTS };
        self.hardware.looks_ahead = positions.len() > most;
        self.images.choose_for_lists();
        self.neighbours = match search {
            Search::Cells => {
                let cells = Cells::new(&self.state.space, self.ranges.of_cells * factor, &positions);
                self.images.choose_for_cells(&cells, &self.state.periods);
                Neighbours::Cells(cells)
            }
            Search::Lists { half_skin } => Neighbours::Lists(VerletLists::new(
                &self.state.space,
                half_skin,
                &self.ranges.between.iter().map(|range| range * factor).collect::<Vec<_>>(),
                self.ranges.longest * factor,
                positions,
            )),
        };
    }
}
