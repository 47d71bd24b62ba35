//! Prefetches the data of upcoming events.
//!
//! Successive events are far apart in space and therefore in memory. Each event needs a chain of loads, in which each
//! load gives the address of the next: the particle, its list or cells, and their contents. The loads are requested in
//! stages, while earlier events are executed.

use super::parts::Engine;
use super::prediction::{FIRST_ABSENT, Prediction};
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::neighbours::Neighbours;
use crate::engine::neighbours::cells::Cells;
use crate::engine::neighbours::verlet::VerletLists;

/// Distances of prefetching, in events: data of the particle and its partner are requested first, then their lists or
/// cells, and then their neighbours.
pub(super) const SELF: usize = 7;
const WHERE: usize = 4;
const NEIGHBOURS: usize = 2;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline]
    pub(super) fn prefetch_coming(&self) {
        if let Some((particle, prediction)) = self.coming(SELF) {
            self.prefetch_self(particle);
            if prediction.partner < FIRST_ABSENT && self.schedule.has(prediction.partner) {
                self.prefetch_self(prediction.partner);
                prefetch(&self.schedule.predictions, prediction.partner as usize);
            }
        }
        match &self.neighbours {
            Neighbours::Lists(verlet) => self.prefetch_listed(verlet),
            Neighbours::Cells(cells) => self.prefetch_in_cells(cells),
        }
    }

    #[inline]
    pub(super) fn coming(&self, ahead: usize) -> Option<(u32, &Prediction)> {
        let particle = self.schedule.queue.coming(ahead).filter(|particle| self.schedule.has(*particle))?;
        Some((particle, &self.schedule.predictions[particle as usize]))
    }

    #[inline]
    fn prefetch_self(&self, particle: u32) {
        prefetch(&self.state.bodies, particle as usize);
        match &self.neighbours {
            Neighbours::Lists(verlet) => {
                verlet.lists.prefetch_span(particle);
                prefetch(&verlet.centres, particle as usize);
            }
            Neighbours::Cells(cells) => cells.prefetch_home(particle),
        }
        if TABLE {
            self.pairs.states.prefetch(particle);
        }
    }

    #[inline]
    fn prefetch_listed(&self, verlet: &VerletLists) {
        let participants = |particle: u32, prediction: &Prediction| {
            let is_here = prediction.partner < FIRST_ABSENT && self.schedule.has(prediction.partner);
            [particle, if is_here { prediction.partner } else { particle }]
        };
        if let Some((particle, prediction)) = self.coming(WHERE) {
            for particle in participants(particle, prediction) {
                verlet.lists.prefetch_list(particle);
            }
            if prediction.is_transition() {
                verlet.prefetch_rows(particle);
            }
        }
        if let Some((particle, prediction)) = self.coming(NEIGHBOURS) {
            for particle in participants(particle, prediction) {
                for &other in verlet.lists.of(particle) {
                    prefetch(&self.state.bodies, other as usize);
                }
                self.prefetch_captured(particle);
            }
            if prediction.is_transition() {
                verlet.prefetch_near(particle);
            }
        }
    }

    /// Prefetches the captured partners of a particle, which are not in its Verlet list.
    #[inline]
    fn prefetch_captured(&self, particle: u32) {
        if TABLE {
            for captured in self.pairs.states.of(particle) {
                prefetch(&self.state.bodies, captured.partner as usize);
            }
        }
    }

    #[inline]
    fn prefetch_in_cells(&self, cells: &Cells) {
        if let Some((particle, prediction)) = self.coming(WHERE) {
            let home = cells.home(particle);
            if prediction.is_transition() {
                cells.prefetch_transition(home, prediction.exit);
            } else {
                cells.prefetch_rows(home);
            }
        }
        if let Some((particle, prediction)) = self.coming(NEIGHBOURS) {
            let home = cells.home(particle);
            if prediction.is_transition() {
                cells.prefetch_new(home, prediction.exit, |other| prefetch(&self.state.bodies, other as usize));
            } else {
                cells.prefetch_near(home, |other| prefetch(&self.state.bodies, other as usize));
            }
        }
    }
}
