//! Prediction with Verlet lists: contacts with listed particles, and the time when a particle leaves its skin.

use super::Streamed;
use crate::Vector;
use crate::engine::neighbours::verlet::VerletLists;
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::physics::detection::inertial;
use crate::physics::motion::RelativeState;
use crate::physics::overlap::{Quadratic, Side};

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    #[inline]
    pub(in crate::engine) fn predict_in_list(&self, me: &Streamed, verlet: &VerletLists, prediction: &mut Prediction) {
        // The slow square root and division run while the list is loaded from memory.
        prediction.transition_time = self.leaves_skin(me, verlet);
        self.predict_batch(me, verlet.wraps(&me.position), verlet.lists.filled_up(me.number), prediction);
        if !self.sources.surfaces.is_empty() {
            self.predict_surfaces(me, |_, _| true, prediction);
        }
    }

    /// Predicts a particle whose motion has not changed. The predicted contact stays valid, so only new particles in
    /// the list are tested.
    pub(in crate::engine) fn predict_with_newcomers(
        &self,
        me: &Streamed,
        verlet: &VerletLists,
        newcomers: Option<(&[u32], usize)>,
        prediction: &mut Prediction,
    ) {
        prediction.transition_time = self.leaves_skin(me, verlet);
        if let Some(newcomers) = newcomers {
            self.predict_batch(me, verlet.wraps(&me.position), newcomers, prediction);
        }
        if self.sources.surfaces.has_features() {
            self.predict_features(me, prediction);
        }
    }

    /// Returns the time when a particle leaves its skin. Its distance from `c`, where the list was built, is then
    /// `delta`, half the width of the skin.
    ///
    /// For a falling particle, the time is a lower bound for motion straight away from `c`:
    /// `|v| t + |a| t^2 / 2 = delta - |r|`, where `r` is the position relative to `c`.
    #[inline]
    fn leaves_skin(&self, me: &Streamed, verlet: &VerletLists) -> f64 {
        let position = me.position - verlet.centres[me.number as usize];
        let squared = verlet.half_skin * verlet.half_skin;
        if FALLING && me.acceleration != Vector::zeros() {
            let room = (verlet.half_skin - position.norm()).max(0.0);
            let (v2, a) = (me.velocity.norm_squared(), me.acceleration.norm());
            return me.time + 2.0 * room / (v2.sqrt() + (v2 + 2.0 * a * room).sqrt());
        }
        let state = RelativeState { position, velocity: me.velocity };
        let dt = inertial::next_event(&Quadratic::new(&state, squared), Side::Negative);
        me.time + dt.unwrap_or(f64::INFINITY)
    }
}
