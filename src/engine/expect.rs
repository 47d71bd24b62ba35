//! What the next wakes will touch is brought nearer to the processor.
//!
//! Successive events are far apart in space and so in memory. Each wake needs a chain of loads, one of which says where the next one
//! is: particle, list or cells, those in it. The links are taken some wakes ahead, one after the other, so that none is waited for.

use super::event_loop::Engine;
use super::prediction::Prediction;
use crate::engine::hardware::prefetch::prefetch;
use crate::engine::neighbours::Neighbours;
use crate::engine::neighbours::cells::{Cells, NOBODY};
use crate::engine::neighbours::shells::Shells;

/// So many wakes ahead, the particle and its partner are expected; where their neighbours are said to be; and the neighbours.
const SELF: usize = 7;
const WHERE: usize = 4;
const NEIGHBOURS: usize = 2;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Looks ahead; changes nothing but speed.
    #[inline]
    pub(super) fn expect_coming(&self) {
        if let Some((particle, prediction)) = self.coming(SELF) {
            self.expect_self(particle);
            if prediction.partner != NOBODY {
                self.expect_self(prediction.partner);
                prefetch(&self.schedule.predictions, prediction.partner as usize);
            }
        }
        match &self.neighbours {
            Neighbours::Lists(shells) => self.expect_listed(shells),
            Neighbours::Cells(cells) => self.expect_in_cells(cells),
        }
    }

    #[inline]
    fn coming(&self, ahead: usize) -> Option<(u32, &Prediction)> {
        let particle = self.schedule.queue.coming(ahead)?;
        Some((particle, &self.schedule.predictions[particle as usize]))
    }

    #[inline]
    fn expect_self(&self, particle: u32) {
        prefetch(&self.state.bodies, particle as usize);
        match &self.neighbours {
            Neighbours::Lists(shells) => {
                shells.lists.expect_span(particle);
                shells.cells.expect_home(particle);
                prefetch(&shells.centres, particle as usize);
            }
            Neighbours::Cells(cells) => cells.expect_home(particle),
        }
        if TABLE {
            self.pairs.memory.expect(particle);
        }
    }

    #[inline]
    fn expect_listed(&self, shells: &Shells) {
        let participants = |particle: u32, prediction: &Prediction| {
            let second = if prediction.partner == NOBODY { particle } else { prediction.partner };
            [particle, second]
        };
        if let Some((particle, prediction)) = self.coming(WHERE) {
            for particle in participants(particle, prediction) {
                shells.lists.expect_list(particle);
            }
            if prediction.is_transition() {
                shells.cells.expect_rows(shells.cells.home(particle));
            }
        }
        if let Some((particle, prediction)) = self.coming(NEIGHBOURS) {
            for particle in participants(particle, prediction) {
                for &other in shells.lists.of(particle) {
                    prefetch(&self.state.bodies, other as usize);
                }
            }
            if prediction.is_transition() {
                shells.cells.expect_near(shells.cells.home(particle));
            }
        }
    }

    #[inline]
    fn expect_in_cells(&self, cells: &Cells) {
        if let Some((particle, prediction)) = self.coming(WHERE) {
            let home = cells.home(particle);
            if prediction.is_transition() {
                cells.expect_transition(home, prediction.exit);
            } else {
                cells.expect_rows(home);
            }
        }
        if let Some((particle, prediction)) = self.coming(NEIGHBOURS) {
            let home = cells.home(particle);
            if prediction.is_transition() {
                cells.expect_new(home, prediction.exit, |other| prefetch(&self.state.bodies, other as usize));
            } else {
                cells.expect_near(home, |other| prefetch(&self.state.bodies, other as usize));
            }
        }
    }
}
