//! Transitions: a particle enters the next cell of the grid.

use crate::engine::neighbours::Neighbours;
use crate::engine::parts::Engine;
use crate::engine::{Invariant, InvariantBroken};

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Moves a particle into the next cell. The predicted contact remains, unless a new candidate is met earlier.
    pub(in crate::engine) fn cross(&mut self, particle: u32, time: f64) -> Result<(), InvariantBroken> {
        self.counts.totals.transition += 1;
        let mut prediction = self.schedule.predictions[particle as usize];
        let face = prediction.exit;
        let is_kept_before = self.keeps_contact(particle);
        if let Neighbours::Cells(cells) = &self.neighbours
            && self.slides_behind(cells, particle, face)
        {
            return self.cross_sliding_side(particle, face, time);
        }
        let Neighbours::Cells(cells) = &mut self.neighbours else {
            return Err(self.broken(particle, None, Invariant::Cells));
        };
        let Some(transition) = cells.cross(particle, face) else {
            return Err(self.broken(particle, None, Invariant::Transition));
        };
        if transition.wrap != 0 {
            let axis = usize::from(face.axis);
            self.state.bodies[particle as usize].position[axis] +=
                f64::from(transition.wrap) * self.state.periods[axis];
            self.state.images.add(particle, axis, -transition.wrap);
        }
        let sees_others = transition.wrap != 0 && self.has_images_of_surfaces();
        if !(is_kept_before && self.keeps_contact(particle)) || self.is_loosely_bonded(particle) || sees_others {
            self.repredict(particle, time);
            return Ok(());
        }
        let mut scratch = self.take_scratch();
        let Neighbours::Cells(cells) = &self.neighbours else {
            return Err(self.broken(particle, None, Invariant::Cells));
        };
        let me = self.streamed(particle, time);
        self.predict_in_next_cell(&me, (cells, face), &mut scratch, &mut prediction);
        self.scratch = Some(scratch);
        self.schedule.predictions[particle as usize] = prediction;
        self.enqueue(particle);
        Ok(())
    }
}
