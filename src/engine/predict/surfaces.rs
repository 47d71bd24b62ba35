//! Prediction of contacts with walls and other surfaces.

use super::Streamed;
use crate::engine::parts::Engine;
use crate::engine::prediction::{Prediction, SEARCH};
use crate::engine::surfaces::{Flight, Found, Placed, Surface};

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Predicts contacts with unbounded surfaces for which `is_near` is true, and with features that the particle can
    /// reach before the predicted event.
    #[inline]
    pub(in crate::engine) fn predict_surfaces(
        &self,
        me: &Streamed,
        is_near: impl Fn(&Placed, f64) -> bool,
        prediction: &mut Prediction,
    ) {
        let flight = self.flight(me);
        self.sources.surfaces.for_each_unlimited(self.row(me.number), |index, surface| {
            if is_near(surface, flight.radius) {
                self.predict_surface(me, &flight, (index, surface), prediction);
            }
        });
        if self.sources.surfaces.has_features() {
            self.predict_features(me, prediction);
        }
    }

    /// Predicts contacts with features that the particle can reach before the predicted event. If the transition is
    /// postponed later, the search must be repeated.
    #[inline(never)] // most scenes have only walls
    pub(in crate::engine) fn predict_features(&self, me: &Streamed, prediction: &mut Prediction) {
        let flight = self.flight(me);
        let swept = flight.swept(prediction.due_time() - me.time);
        self.sources.surfaces.for_each_feature(&swept, self.row(me.number), |index, feature| {
            self.predict_surface(me, &flight, (index, feature), prediction);
        });
        let (now, id) = (self.simulated(me.time), self.state.bodies[me.number as usize].id);
        let horizon = prediction.due_time() - me.time;
        self.sources.surfaces.next_moving_contacts(&flight, self.row(me.number), now, horizon, |found| {
            let (index, dt) = match found {
                Found::Contact(index, dt) => (index, dt),
                Found::NoneUntil(dt) => (SEARCH, dt),
            };
            if me.time + dt < prediction.contact_time {
                prediction.reach(index, me.time + dt, id);
            }
            prediction.due_time() - me.time
        });
    }

    /// Whether surfaces may have periodic images, which a particle can meet when it crosses a periodic side.
    pub(in crate::engine) fn has_images_of_surfaces(&self) -> bool {
        !self.sources.surfaces.of_scene().is_empty()
    }

    #[inline(always)]
    fn predict_surface(
        &self,
        me: &Streamed,
        flight: &Flight<'_>,
        (index, surface): (u32, &Placed),
        prediction: &mut Prediction,
    ) {
        if let Some(dt) = surface.shape.next_contact(flight)
            && me.time + dt < prediction.contact_time
        {
            prediction.reach(index, me.time + dt, self.state.bodies[me.number as usize].id);
        }
    }

    #[inline]
    pub(in crate::engine) fn flight<'a>(&self, me: &'a Streamed) -> Flight<'a> {
        let radius = self.radius(me.number);
        Flight { position: &me.position, velocity: &me.velocity, acceleration: &me.acceleration, radius }
    }
}
