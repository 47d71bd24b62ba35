//! A log of steps, with which they can be undone.

use crate::engine::columns::records::Record;
use crate::engine::hardware::pages::enlarge;
use crate::engine::neighbours::Place;
use crate::engine::pairs::states::PairState;
use crate::engine::parts::Engine;
use crate::engine::prediction::Prediction;
use crate::engine::state::Body;

/// Kind of an entry, which determines the stored data.
#[derive(Debug, Clone, Copy)]
enum Kind {
    /// Motion and prediction.
    Motion,
    /// Motion, prediction and a number of captured pairs.
    Pairs(u16),
    /// Prediction and place.
    Place,
    Record,
}

/// Log for undoing a window of time, in the order of the steps. Each entry stores only the data that its step can change.
/// The compact arrays leave more room for other data in the caches.
#[derive(Debug, Clone, Default)]
pub struct UndoLog {
    order: Vec<(u32, Kind)>,
    bodies: Vec<Body>,
    predictions: Vec<Prediction>,
    places: Vec<Place>,
    pairs: Vec<PairState>,
    records: Vec<Record>,
}

impl UndoLog {
    /// Saves what a contact of a particle can change. With `is_plain`, contacts change only motions, predictions and
    /// captured pairs.
    #[inline(always)]
    pub fn contact<const FALLING: bool, const TABLE: bool>(
        &mut self,
        engine: &Engine<FALLING, TABLE>,
        particle: u32,
        is_plain: bool,
    ) {
        if !is_plain {
            return self.push_record(engine.record_before_contact(particle));
        }
        let body = engine.state.bodies[particle as usize];
        let prediction = engine.schedule.predictions[particle as usize];
        if TABLE && !engine.pairs.states.is_empty() {
            self.push_pairs(particle, body, prediction, engine.pairs.states.of(particle));
        } else {
            self.push_motion(particle, Kind::Motion, body, prediction);
        }
    }

    /// Executes a transition, and saves what it changes. Returns false if it fails.
    #[inline(always)]
    pub fn execute_transition<const FALLING: bool, const TABLE: bool>(
        &mut self,
        engine: &mut Engine<FALLING, TABLE>,
        particle: u32,
        time: f64,
    ) -> bool {
        let before = (engine.state.bodies[particle as usize], engine.state.images.of(particle));
        let place = engine.neighbours.place(particle);
        let prediction = engine.schedule.predictions[particle as usize];
        let is_done = engine.execute_transition(particle, time).is_ok();
        if engine.state.images.of(particle) == before.1 {
            self.push_place(particle, place, prediction);
        } else {
            let record = Record::of_motion(particle, before.0, prediction);
            self.push_record(Record { images: Some(before.1), place: Some(place), ..record });
        }
        is_done
    }

    #[inline]
    fn push_motion(&mut self, particle: u32, kind: Kind, body: Body, prediction: Prediction) {
        self.order.push((particle, kind));
        self.bodies.push(body);
        self.predictions.push(prediction);
    }

    /// Saves what a contact can change in a system with captured pairs.
    #[inline]
    fn push_pairs(&mut self, particle: u32, body: Body, prediction: Prediction, captured: &[PairState]) {
        let Ok(count) = u16::try_from(captured.len()) else {
            let record = Record { captured: Some(captured.to_vec()), ..Record::of_motion(particle, body, prediction) };
            return self.push_record(record);
        };
        self.push_motion(particle, Kind::Pairs(count), body, prediction);
        self.pairs.extend_from_slice(captured);
    }

    /// Saves what a transition changes if the particle stays in the box. Its motion does not change.
    #[inline]
    fn push_place(&mut self, particle: u32, place: Place, prediction: Prediction) {
        self.order.push((particle, Kind::Place));
        self.places.push(place);
        self.predictions.push(prediction);
    }

    #[inline]
    fn push_record(&mut self, record: Record) {
        self.order.push((record.number, Kind::Record));
        self.records.push(record);
    }

    pub fn clear(&mut self) {
        self.order.clear();
        self.bodies.clear();
        self.predictions.clear();
        self.places.clear();
        self.pairs.clear();
        self.records.clear();
    }

    /// Removes all entries and returns them, latest first. They must be restored in this order. The entry of a
    /// transition has the current motion of its particle, from `current`.
    pub fn undone(&mut self, current: &[Body]) -> Vec<Record> {
        let (mut bodies, mut predictions) = (self.bodies.drain(..).rev(), self.predictions.drain(..).rev());
        let (mut places, mut records) = (self.places.drain(..).rev(), self.records.drain(..).rev());
        let mut restored = std::collections::BTreeMap::new();
        let mut end = self.pairs.len();
        let undone = self.order.drain(..).rev().filter_map(|(particle, kind)| {
            let record = match kind {
                Kind::Motion => Record::of_motion(particle, bodies.next()?, predictions.next()?),
                Kind::Pairs(count) => {
                    let begin = end - usize::from(count);
                    let captured = Some(self.pairs[begin..end].to_vec());
                    end = begin;
                    Record { captured, ..Record::of_motion(particle, bodies.next()?, predictions.next()?) }
                }
                Kind::Place => {
                    let body = restored.get(&particle).unwrap_or(&current[particle as usize]);
                    let place = Some(places.next()?);
                    Record { place, ..Record::of_motion(particle, *body, predictions.next()?) }
                }
                Kind::Record => records.next()?,
            };
            restored.insert(particle, record.body);
            Some(record)
        });
        let undone = undone.collect();
        self.pairs.clear();
        undone
    }

    pub fn enlarge(&self) {
        enlarge(&self.bodies);
        enlarge(&self.predictions);
    }
}
