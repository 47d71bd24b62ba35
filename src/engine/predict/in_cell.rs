//! Prediction in a grid of cells: contacts with nearby particles, and the transition to the next cell.

use super::{Scratch, Streamed};
use crate::engine::images::Way;
use crate::engine::neighbours::cells::Cells;
use crate::engine::neighbours::grid::{CellFace, Grid};
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::engine::surfaces::{Placed, Surface};
use crate::physics::detection::lanes::MOST_LANES;
use crate::physics::detection::plane;
use crate::physics::overlap::Side;

/// Relative tolerance for half a period, far larger than the round-off of positions.
const TIED: f64 = 1e-6;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline]
    pub(in crate::engine) fn predict_in_cell(
        &self,
        me: &Streamed,
        cells: &Cells,
        scratch: &mut Scratch,
        prediction: &mut Prediction,
    ) {
        let cell = cells.home(me.number);
        // The slow divisions of the transition run while the candidates are loaded from memory.
        self.predict_transition(me, &cells.grid, cell, prediction);
        cells.find_candidates(cell, &mut scratch.near);
        self.predict_candidates(me, cells, scratch, prediction);
        self.predict_surfaces_of_cell(me, cells, prediction);
    }

    /// Predicts a particle that has entered a cell through `face`. The motion has not changed, so the predicted contact
    /// stays valid, and only new candidates are tested.
    pub(in crate::engine) fn predict_in_next_cell(
        &self,
        me: &Streamed,
        (cells, face): (&Cells, CellFace),
        scratch: &mut Scratch,
        prediction: &mut Prediction,
    ) {
        let cell = cells.home(me.number);
        self.predict_transition(me, &cells.grid, cell, prediction);
        cells.find_new_candidates(cell, face, &mut scratch.near);
        self.predict_candidates(me, cells, scratch, prediction);
        self.predict_surfaces_of_cell(me, cells, prediction);
    }

    #[inline]
    fn predict_surfaces_of_cell(&self, me: &Streamed, cells: &Cells, prediction: &mut Prediction) {
        let cell = cells.home(me.number);
        if !self.sources.surfaces.is_empty() {
            // A particle leaves its cell before it can reach other surfaces.
            let is_near = |surface: &Placed, radius| surface.shape.is_near(&cells.grid, cell, radius);
            self.predict_surfaces(me, is_near, prediction);
        }
    }

    fn predict_candidates(&self, me: &Streamed, cells: &Cells, scratch: &mut Scratch, prediction: &mut Prediction) {
        let Scratch { near, is_captured } = scratch;
        if TABLE {
            let captured = self.pairs.states.of(me.number);
            if !captured.is_empty() {
                for captured in captured {
                    is_captured[captured.partner as usize] = true;
                }
                near.retain(|other| !is_captured[other as usize]);
                for captured in captured {
                    is_captured[captured.partner as usize] = false;
                }
            }
        }
        if self.images.tied.contains(&true) {
            let (others, _) = near.filled_up(me.number);
            self.predict_ties(me, others, prediction);
        }
        self.for_each_across(me.number, |other| {
            if !(TABLE && self.pairs.states.get(me.number, other).is_some()) {
                near.put(other);
            }
        });
        match self.way(me.number, me.time) {
            Way::Nearest => {
                let found = near.filled_up(me.number);
                // In a thin gas, most cells are empty.
                if found.1 > 0 {
                    self.predict_batch(me, true, found, prediction);
                }
            }
            Way::Several => {
                let found = near.filled_up(me.number);
                self.predict_batch(me, true, found, prediction);
                self.predict_further_images(me, found.0, self.leaves_cell(me, cells), prediction);
            }
            Way::Sliding(sliding) => {
                let (others, _) = near.filled_up(me.number);
                self.predict_next_to_sliding_sides(me, others, sliding, self.leaves_cell(me, cells), prediction);
            }
            Way::OneByOne => {
                near.found().iter().for_each(|&other| self.predict_uncaptured_pair(me, other, prediction));
            }
        }
    }

    fn leaves_cell(&self, me: &Streamed, cells: &Cells) -> f64 {
        let mut leaves = Prediction::NONE;
        self.predict_transition(me, &cells.grid, cells.home(me.number), &mut leaves);
        leaves.transition_time
    }

    /// Predicts contacts in tied images: if two particles are half a period apart, two or more images are equally near.
    /// The other functions test only one of these images, so the remaining ones are tested here.
    fn predict_ties(&self, me: &Streamed, others: &[u32], prediction: &mut Prediction) {
        let least: [f64; 3] = std::array::from_fn(|axis| {
            if self.images.tied[axis] { 0.5 * self.state.periods[axis] * (1.0 - TIED) } else { f64::INFINITY }
        });
        let is_far = |some: &[u32]| {
            let is_batch = !(self.images.are_sliding() || FALLING && TABLE);
            !is_batch || self.batch_of(me, true).half_a_period_away::<FALLING>(me, some, least) != 0
        };
        let far = others.chunks_exact(MOST_LANES).filter(|some| is_far(some)).flatten();
        for &other in far.filter(|&&other| other != me.number) {
            let (nearest, _) = self.relative(me, other);
            let squared = if TABLE {
                let meeting = self.pairs.rules.meeting(self.row(me.number), self.row(other));
                if meeting.exists { self.squared_of_pair(meeting.squared, [me.number, other]) } else { continue }
            } else {
                self.pairs.rules.meeting(0, 0).squared
            };
            self.for_each_tied_image(&nearest, least, |state| {
                if let Some(dt) = self.detect(me, other, state, (squared, Side::Positive), f64::INFINITY) {
                    self.offer(me, other, Side::Positive, dt, prediction);
                }
            });
        }
    }

    fn predict_transition(&self, me: &Streamed, grid: &Grid, cell: u32, prediction: &mut Prediction) {
        prediction.transition_time = f64::INFINITY;
        if !FALLING {
            grid.for_each_face_ahead(cell, &me.velocity, |face: CellFace, at| {
                let axis = usize::from(face.axis);
                // Because of round-off, the particle may be slightly outside its cell.
                let time = me.time + ((at - me.position[axis]) / me.velocity[axis]).max(0.0);
                if time < prediction.transition_time {
                    (prediction.transition_time, prediction.exit) = (time, face);
                }
            });
            return;
        }
        grid.for_each_face(cell, |face: CellFace, at| {
            let axis = usize::from(face.axis);
            let inwards = face.inwards();
            let height = inwards * (me.position[axis] - at);
            if let Some(dt) = plane::next_event(height, inwards * me.velocity[axis], inwards * me.acceleration[axis])
                && me.time + dt < prediction.transition_time
            {
                prediction.transition_time = me.time + dt;
                prediction.exit = face;
            }
        });
    }
}
