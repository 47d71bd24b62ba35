//! Pairs with an interaction of their own that does not hold them together: no search for neighbours finds them again.
//!
//! Strangers are met in the cells or lists around a particle. A pair that has an interaction of its own is no pair of strangers: its
//! partner is known wherever it is, and may come back through any side of a periodic box.

use super::event_loop::Engine;
use super::predict::{Streamed, is_out_of_reach};
use super::prediction::Prediction;
use super::sources::lees_edwards::{FLOW, GRADIENT};
use crate::engine::neighbours::Neighbours;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::Side;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Whether a particle knows partners that are outside of all steps of their own interaction.
    #[inline]
    pub(super) fn is_apart(&self, particle: u32) -> bool {
        TABLE && self.pairs.has_loose_pairs && self.pairs.memory.of(particle).iter().any(|known| known.state == 0)
    }

    /// The first meeting with such a partner, in whichever image, before the particle goes into another cell or leaves its shell: then it
    /// is predicted anew.
    pub(super) fn predict_apart(&self, me: &Streamed, prediction: &mut Prediction) {
        let most = self.most_images();
        let around = |axis: usize| -most[axis]..=most[axis];
        for known in self.pairs.memory.of(me.id).iter().filter(|known| known.state == 0) {
            let steps = &self.pairs.rules.steps[usize::from(known.interaction)];
            let Some(seen) = steps.seen_from(known.state, Side::Positive) else { continue };
            let (nearest, _) = self.relative(me, known.partner);
            let acceleration = me.acceleration - self.acceleration(known.partner);
            for image in around(2).flat_map(|z| around(1).flat_map(move |y| around(0).map(move |x| [x, y, z]))) {
                let state = self.image_of(&nearest, image, me.time);
                let horizon = prediction.wake_time() - me.time;
                if is_out_of_reach(&state, &acceleration, seen.squared, horizon) {
                    continue;
                }
                if let Some(dt) = self.detect(me, known.partner, &state, seen.squared, Side::Positive, horizon) {
                    self.offer(me, known.partner, Side::Positive, dt, prediction);
                }
            }
        }
    }

    /// How many images to either side of the nearest one a pair can meet in before either is predicted anew.
    ///
    /// Until then each travels one cell at most, so that with three cells or more a separation that was half a period at most stays
    /// below seven sixths of one, and its range is half of one at most. While the images along x slide they go a quarter further.
    fn most_images(&self) -> [i32; 3] {
        let counts = match &self.neighbours {
            Neighbours::Cells(cells) => cells.grid.counts(),
            // Shells are smaller than cells.
            Neighbours::Lists(_) => [u32::MAX; 3],
        };
        std::array::from_fn(|axis| match counts[axis] {
            _ if self.state.periods[axis] == f64::INFINITY => 0,
            0..3 => 2,
            _ if axis == FLOW && self.sources.lees_edwards.is_some() => 2,
            _ => 1,
        })
    }

    /// A relative state as seen from another image of the partner, at a time since the epoch.
    fn image_of(&self, nearest: &RelativeState, image: [i32; 3], time: f64) -> RelativeState {
        let mut state = *nearest;
        for axis in (0..3).filter(|&axis| image[axis] != 0) {
            state.position[axis] -= f64::from(image[axis]) * self.state.periods[axis];
        }
        if let Some(shear) = &self.sources.lees_edwards {
            let up = f64::from(image[GRADIENT]);
            state.position[FLOW] -= up * shear.displacement_within(time, self.state.periods[FLOW]).0;
            state.velocity[FLOW] -= up * shear.speed;
        }
        state
    }
}
