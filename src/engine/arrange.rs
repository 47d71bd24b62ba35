//! Memory layout: the order of particles, the cells and the lists.
//!
//! The best layout changes during a run: particles move away from their neighbours in memory, and a rain of grains
//! becomes a heap. The order in memory does not change any result. The neighbour search only changes round-off.

use super::columns::Order;
use super::order::along_curve;
use super::parts::Engine;
use crate::Vector;
use crate::engine::hardware::pages::enlarge;
use crate::engine::neighbours::cells::Cells;
use crate::engine::neighbours::verlet::VerletLists;
use crate::engine::neighbours::{Neighbours, Search};

/// The particles are reordered in memory after this mean number of transitions per particle. A transition is the entry
/// into another cell, or a new list centre.
const WANDERED: u64 = 64;

/// With fewer particles, the neighbour search is not adapted to their number.
const FEW: usize = 64;

/// With cells, prefetching saves time above this number of particles.
const LARGE_IN_CELLS: usize = 32_768;
/// With neighbour lists, prefetching saves time above this number of particles.
const LARGE_IN_LISTS: usize = 2_048;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    fn is_order_outdated(&self) -> bool {
        let since = self.counts.totals.transition.wrapping_sub(self.counts.transitions_at_order);
        since >= WANDERED * self.state.bodies.len() as u64
    }

    pub(super) fn reorder_if_due(&mut self) {
        if self.is_order_outdated() {
            self.reorder();
            self.enlarge();
        }
    }

    /// Returns the neighbour search that replaces the current one, if this saves time.
    fn better_search(&self) -> Option<Search> {
        let may_change = !self.images.are_sliding() && self.distances.are_constant();
        may_change
            .then(|| self.best_search())
            .filter(|search| *search != self.neighbours.search() || self.is_search_outgrown())
    }

    /// Whether the neighbour search was set up for many more or fewer particles.
    pub(super) fn is_search_outgrown(&self) -> bool {
        let is_outgrown = |now: usize, before: usize| now > 2 * before.max(FEW) || before > 4 * now.max(FEW);
        is_outgrown(self.state.bodies.len(), self.state.count_when_sorted)
            || self.neighbours.verlet().is_some_and(|verlet| verlet.levels.are_outgrown(is_outgrown))
    }

    /// Whether the next check of the layout would change it.
    pub(super) fn is_layout_outdated(&self) -> bool {
        self.is_order_outdated() || self.better_search().is_some()
    }

    /// Changes the neighbour search or the skin, if this saves time. Returns true after a change.
    pub(super) fn change_search_if_due(&mut self) -> bool {
        let Some(search) = self.better_search() else { return false };
        self.stream_all(0.0);
        // Frees the old neighbours before the new ones are allocated.
        self.neighbours = Neighbours::none(&self.state.space);
        self.reorder();
        self.sort_in(search);
        self.predict_all();
        true
    }

    pub(super) fn best_search(&self) -> Search {
        self.search_like(Some(self.neighbours.search()))
    }

    /// Returns the best neighbour search at the present density, with a preference for the `current` search.
    fn search_like(&self, current: Option<Search>) -> Search {
        if self.images.are_sliding() {
            return Search::Cells;
        }
        let rows = self.state.rows.iter().copied().chain(std::iter::repeat(0));
        let particles = || self.state.bodies.iter().map(|body| body.position).zip(rows.clone());
        Search::choose(&self.state.space, (&self.ranges, self.distances.reach_factor()), particles, current)
    }

    /// Streams all particles to a time since the epoch, and wraps their positions into the box.
    pub(super) fn stream_all(&mut self, time: f64) {
        for particle in self.particles() {
            self.stream(particle, time);
            self.bring_in(particle);
        }
    }

    /// Sorts all particles into new cells or lists at their current positions. All of them must then be predicted
    /// again.
    pub(super) fn sort_anew(&mut self) {
        self.stream_all(self.clock.now);
        self.sort_in(self.search_like(None));
        self.fill_lists();
    }

    pub(super) fn reorder(&mut self) {
        self.counts.transitions_at_order = self.counts.totals.transition;
        // Ordering by id within a cell of the curve makes the new order independent of the old order.
        let names = {
            let by_name: Vec<Vector> =
                self.state.numbers.iter().map(|&number| self.state.bodies[number as usize].position).collect();
            along_curve(&self.state.space, &by_name)
        };
        let old = names.iter().map(|&name| self.state.numbers[name as usize]).collect();
        self.permute(&Order::of(old, self.state.bodies.len()));
    }

    pub(super) fn enlarge(&self) {
        enlarge(&self.state.bodies);
        enlarge(&self.schedule.predictions);
        self.neighbours.enlarge();
    }

    pub(super) fn sort_in(&mut self, search: Search) {
        let positions: Vec<Vector> = self.state.bodies.iter().map(|body| body.position).collect();
        self.state.count_when_sorted = positions.len();
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
                (&self.ranges, factor),
                positions,
                &self.state.rows,
            )),
        };
    }
}
