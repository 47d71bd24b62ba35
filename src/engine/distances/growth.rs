//! Growing diameters: the discontinuities of all pairs move outwards at a constant speed.

use std::convert::Infallible;

use serde::{Deserialize, Serialize};

use crate::engine::event::{EventCounts, EventCountsBySpecies};
use crate::engine::parts::Engine;
use crate::engine::sources::Repredict;
use crate::engine::{Chosen, EngineChoice, Invariant, InvariantBroken, Simulation};
use crate::model::{Growth, Particle};
use crate::physics::detection::plane;
use crate::physics::motion::RelativeState;

/// Cells and lists are made for spheres that are larger by this factor. A smaller factor means more frequent
/// rebuilding, a larger factor longer searches.
const STAGE: f64 = 1.1;

/// Growth of all diameters. At the time `t`, a diameter is `1 + rate (t - start)` times the diameter in the scene.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
pub(in crate::engine) struct GrowingDiameters {
    /// Growth rate `[1 / time]`.
    pub rate: f64,
    /// Start of the growth, as time since the epoch.
    start: f64,
    /// Largest scale factor for the current cells or lists.
    pub reach: f64,
    /// Scale factor at the end of the growth.
    largest: f64,
}

impl GrowingDiameters {
    #[inline]
    pub fn scale(&self, time: f64) -> f64 {
        1.0 + self.rate * (time - self.start)
    }

    /// Returns the scale factor of all diameters, and the growth rate `[1, 1 / time]`.
    #[inline]
    pub fn factor(&self, time: f64) -> [f64; 2] {
        [self.scale(time), self.rate]
    }

    pub fn shift(&mut self, shift: f64) {
        self.start -= shift;
    }

    /// Time since the epoch at which the cells or lists become too small; infinite if the growth ends before.
    pub fn next_stage(&self) -> f64 {
        if self.reach < self.largest { self.start + (self.reach - 1.0) / self.rate } else { f64::INFINITY }
    }
}

/// Returns the time until two spheres touch. `distance` is the current contact distance, which grows at `speed`.
///
/// Let `r` be the relative position, `v` the relative velocity, `s` the contact distance and `u` its growth rate. The
/// overlap function is `f(t) = |r + v t|^2 - (s + u t)^2 = (r^2 - s^2) + 2 (r.v - s u) t + (v^2 - u^2) t^2`. As in
/// [`crate::physics::detection`], the contact is the first time at which `f <= 0` and `f` falls. The function has the
/// form of the height of a ball above a floor, with an acceleration of either sign.
#[inline]
pub(in crate::engine) fn next_contact(state: &RelativeState, distance: f64, speed: f64) -> Option<f64> {
    let (r, v) = (&state.position, &state.velocity);
    let height = r.norm_squared() - distance * distance;
    plane::next_event(height, 2.0 * (r.dot(v) - distance * speed), 2.0 * (v.norm_squared() - speed * speed))
}

#[derive(Debug, Clone)]
pub(in crate::engine) struct Carried {
    event_counts: EventCounts,
    counts: EventCountsBySpecies,
    executed: u64,
    accepted_overlap: f64,
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    pub fn carried(&self) -> Carried {
        Carried {
            event_counts: self.counts.totals,
            counts: self.counts.by_species.clone(),
            executed: self.counts.executed,
            accepted_overlap: self.counts.accepted_overlap,
        }
    }

    pub fn carry(&mut self, carried: Carried, images: &[[i32; 3]]) {
        let wrapped = std::mem::take(&mut self.counts.totals);
        debug_assert_eq!(wrapped.physical(), 0, "it has just been made");
        (self.counts.totals, self.counts.by_species, self.counts.executed) =
            (carried.event_counts, carried.counts, carried.executed);
        self.counts.accepted_overlap = carried.accepted_overlap;
        self.counts.transitions_at_event = self.counts.totals.transition;
        self.counts.transitions_at_proof = self.counts.totals.transition;
        self.counts.transitions_at_order = self.counts.totals.transition;
        let bodies = &self.state.bodies;
        self.state.images.set(|particle| images[bodies[particle as usize].id as usize]);
    }

    /// Lets all diameters grow up to `largest` times the diameters of the scene.
    pub fn grow(&mut self, rate: f64, largest: f64) {
        self.join();
        let growing = GrowingDiameters { rate, start: self.clock.now, reach: STAGE.min(largest), largest };
        self.distances.growing = Some(growing);
        self.sort_anew();
        self.start_anew();
        self.schedule_global();
    }

    /// Sorts the spheres into new cells or lists when the old ones are too small.
    pub(in crate::engine) fn begin_distance_stage(&mut self) -> Result<Repredict, InvariantBroken> {
        let Some(growing) = &mut self.distances.growing else {
            return Err(self.broken(0, None, Invariant::GlobalEvent));
        };
        self.clock.now = growing.next_stage().max(self.clock.now);
        growing.reach = (growing.reach * STAGE).min(growing.largest);
        self.sort_anew();
        Ok(Repredict::All)
    }
}

impl Simulation {
    /// Lets all diameters grow up to `largest` times their current values.
    ///
    /// The caller guarantees hard spheres without gravity in a periodic box.
    pub(crate) fn grow(&mut self, growth: &Growth, largest: f64) {
        with_engine!(&mut self.engine, engine => engine.grow(growth.rate, largest));
    }

    /// Ends the growth at the current diameters.
    pub(crate) fn end_growth(&mut self) {
        let scale = with_engine!(&self.engine, engine => engine.scale());
        let mut images = Vec::with_capacity(self.scene.particles.len());
        let mut particles = Vec::with_capacity(self.scene.particles.len());
        // Swap moves may have changed species and diameters since the start.
        let Ok(()) = self.for_each_now(|now| {
            images.push(now.image);
            let particle =
                Particle { diameter: now.diameter, ..Particle::new(now.species, now.position, now.velocity) };
            particles.push(particle.spin(now.spin));
            Ok::<(), Infallible>(())
        });
        self.scene.grow(scale);
        self.scale *= scale;
        self.scene.particles = particles;
        self.scene.start_time = self.time();
        let scene = &self.scene;
        let carried = with_engine!(&self.engine, engine => engine.carried());
        with_engine!(&mut self.engine, engine => engine.let_go());
        match &mut self.engine {
            Chosen::FreeHard(engine) => *engine = Engine::new(scene),
            Chosen::FreeTable(engine) => *engine = Engine::new(scene),
            Chosen::FallingHard(engine) => *engine = Engine::new(scene),
            Chosen::FallingTable(engine) => *engine = Engine::new(scene),
        }
        with_engine!(&mut self.engine, engine => engine.carry(carried, &images));
        self.choice = EngineChoice::new(&self.scene);
        self.set_threads(self.threads);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Vector;

    fn state(x: f64, v: f64) -> RelativeState {
        RelativeState { position: Vector::new(x, 0.0, 0.0), velocity: Vector::new(v, 0.0, 0.0) }
    }

    #[test]
    fn spheres_that_grow_meet_at_rest_and_when_they_part_slowly() {
        assert_eq!(next_contact(&state(2.0, 0.0), 1.0, 0.5), Some(2.0));
        // The distance is 2 + t/4, and the diameter is 1 + t/2.
        assert_eq!(next_contact(&state(2.0, 0.25), 1.0, 0.5), Some(4.0));
        assert_eq!(next_contact(&state(2.0, 0.5), 1.0, 0.5), None);
        assert_eq!(next_contact(&state(2.0, 1.0), 1.0, 0.5), None);
        // The distance is 2 - t, and the diameter is 1 + t.
        assert_eq!(next_contact(&state(2.0, -1.0), 1.0, 1.0), Some(0.5));
    }

    #[test]
    fn a_contact_is_due_at_once_only_where_the_gap_closes() {
        assert_eq!(next_contact(&state(1.0, 0.0), 1.0, 0.5), Some(0.0));
        assert_eq!(next_contact(&state(1.0, 1.0), 1.0, 0.5), None);
        // The pair recedes at 0.25, but the contact distance grows at 0.5.
        assert_eq!(next_contact(&state(1.0, 0.25), 1.0, 0.5), Some(0.0));
    }
}
