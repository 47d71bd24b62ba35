//! Bonded pairs beyond the range of their interaction.
//!
//! The neighbour search does not find these pairs. The two particles may meet again across any side of a periodic box.

use super::{Streamed, is_out_of_reach};
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::physics::overlap::Side;

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Whether a particle has a bonded partner beyond the range of the bond's interaction.
    #[inline]
    pub(in crate::engine) fn is_loosely_bonded(&self, particle: u32) -> bool {
        TABLE && self.pairs.has_loose_bonds && self.pairs.states.of(particle).iter().any(|captured| captured.state == 0)
    }

    /// Predicts the earliest contact with the periodic images of distant bonded partners. Contacts after the next
    /// transition of the particle are ignored, because the particle is predicted again at the transition.
    pub(in crate::engine) fn predict_loose_bonds(&self, me: &Streamed, prediction: &mut Prediction) {
        let most = self.most_images();
        let around = |axis: usize| -most[axis]..=most[axis];
        for captured in self.pairs.states.of(me.number).iter().filter(|captured| captured.state == 0) {
            let steps = &self.pairs.rules.steps[usize::from(captured.interaction)];
            let Some(seen) = steps.seen_from(captured.state, Side::Positive) else { continue };
            let squared = self.squared_of_pair(seen.squared, [me.number, captured.partner]);
            let (nearest, _) = self.relative(me, captured.partner);
            let acceleration = me.acceleration - self.acceleration(captured.partner);
            for image in around(2).flat_map(|z| around(1).flat_map(move |y| around(0).map(move |x| [x, y, z]))) {
                let state = self.image_of(&nearest, image, me.time);
                let horizon = prediction.due_time() - me.time;
                if is_out_of_reach(&state, &acceleration, squared, horizon) {
                    continue;
                }
                if let Some(dt) = self.detect(me, captured.partner, &state, (squared, Side::Positive), horizon) {
                    self.offer(me, captured.partner, Side::Positive, dt, prediction);
                }
            }
        }
    }
}
