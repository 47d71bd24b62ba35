use crate::engine::columns::records::Record;
use crate::engine::hardware::pages::enlarge;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::prediction::Prediction;
use crate::engine::state::Body;

/// Log for rolling back a window, in the order of the steps. An entry is either a motion with a prediction, or a
/// complete record. Compact arrays leave more room for other data in the caches.
#[derive(Debug, Clone, Default)]
pub struct Log {
    /// For each entry, the particle with the stored motion and prediction, or [`NO_PARTICLE`] for a record.
    order: Vec<u32>,
    bodies: Vec<Body>,
    predictions: Vec<Prediction>,
    records: Vec<Record>,
}

impl Log {
    #[inline]
    pub fn push_motion(&mut self, particle: u32, body: Body, prediction: Prediction) {
        self.order.push(particle);
        self.bodies.push(body);
        self.predictions.push(prediction);
    }

    #[inline]
    pub fn push_record(&mut self, record: Record) {
        self.order.push(NO_PARTICLE);
        self.records.push(record);
    }

    pub fn clear(&mut self) {
        self.order.clear();
        self.bodies.clear();
        self.predictions.clear();
        self.records.clear();
    }

    /// Removes all entries and returns them, latest first. They must be restored in this order.
    pub fn undone(&mut self) -> Vec<Record> {
        let (mut bodies, mut predictions) = (self.bodies.drain(..).rev(), self.predictions.drain(..).rev());
        let mut records = self.records.drain(..).rev();
        let undone = self.order.drain(..).rev().filter_map(|particle| {
            if particle == NO_PARTICLE {
                return records.next();
            }
            Some(Record::of_motion(particle, bodies.next()?, predictions.next()?))
        });
        undone.collect()
    }

    pub fn enlarge(&self) {
        enlarge(&self.bodies);
        enlarge(&self.predictions);
    }
}
