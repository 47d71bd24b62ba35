//! Complete data of single particles, to move particles between engines.

use crate::Vector;
use crate::engine::columns::Order;
use crate::engine::neighbours::Place;
use crate::engine::neighbours::candidates::Candidates;
use crate::engine::neighbours::cells::NO_PARTICLE;
use crate::engine::pairs::states::PairState;
use crate::engine::parts::Engine;
use crate::engine::prediction::{Prediction, absent};
use crate::engine::sizes::Size;
use crate::engine::sources::rest::Watched;
use crate::engine::state::Body;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// All data of one particle. Other particles are given by their numbers in memory, and by their ids in messages.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(in crate::engine) struct Record {
    pub body: Body,
    pub number: u32,
    /// Table row of the particle; `None` in an engine without an interaction table.
    pub row: Option<u16>,
    /// Image numbers. With `None`, an existing particle keeps its numbers, and a new particle gets zeros.
    pub images: Option<[i32; 3]>,
    /// Spin of the particle `[1 / time]`; `None` if the scene has no spins.
    pub spin: Option<Vector>,
    /// Radius and mass; `None` if no particles have individual diameters.
    pub size: Option<Size>,
    /// Time of the last contact in the TC model, counted from the epoch; `None` without this model.
    pub last_contact: Option<f64>,
    /// Number of contacts with thermal surfaces; `None` if there are no such surfaces.
    pub surface_contacts: Option<u32>,
    /// Data that decide whether the particle falls asleep; `None` if particles never sleep.
    pub watched: Option<Watched>,
    /// States of the particle's pairs; `None` if no pair can be captured.
    pub captured: Option<Vec<PairState>>,
    /// Cell, or centre of the neighbour list. If `None`, an existing particle keeps its value, and a new particle gets
    /// the value for its position.
    pub place: Option<Place>,
    /// Prediction; `None` if the particle must be predicted anew.
    pub prediction: Option<Prediction>,
}

impl Record {
    /// Creates the record of a new particle. `time` is counted from the epoch.
    pub fn new(id: u32, position: Vector, velocity: Vector, time: f64) -> Self {
        Self {
            body: Body { position, velocity, time, version: 0, id },
            number: NO_PARTICLE,
            row: None,
            images: None,
            spin: None,
            size: None,
            last_contact: None,
            surface_contacts: None,
            watched: None,
            captured: None,
            place: None,
            prediction: None,
        }
    }
}

impl Record {
    pub fn of_motion(number: u32, body: Body, prediction: Prediction) -> Self {
        let record = Self::new(body.id, body.position, body.velocity, body.time);
        Self { number, body, prediction: Some(prediction), ..record }
    }

    /// Replaces the numbers of other particles by `number(old)`, which is `None` for an absent particle. Pairs with
    /// absent particles are dropped. An absent partner in the prediction keeps the old number and is marked as absent.
    pub fn renumber(&mut self, number: impl Fn(u32) -> Option<u32>) {
        if let Some(captured) = &mut self.captured {
            captured.retain_mut(|pair| number(pair.partner).map(|partner| pair.partner = partner).is_some());
        }
        if let Some(prediction) = &mut self.prediction
            && prediction.partner != NO_PARTICLE
        {
            prediction.partner = number(prediction.partner).unwrap_or(absent(prediction.partner));
        }
    }
}

impl<const FALLING: bool, const TABLE: bool> Engine<FALLING, TABLE> {
    /// Removes particles, and closes the gaps in memory. Predicted contacts with removed particles become void: when
    /// they are due, the other particle is predicted again.
    pub fn remove(&mut self, particles: &[u32]) {
        let count = self.state.bodies.len();
        let mut stays = vec![true; count];
        particles.iter().for_each(|&particle| stays[particle as usize] = false);
        for prediction in &mut self.schedule.predictions {
            if stays.get(prediction.partner as usize) == Some(&false) {
                prediction.partner = absent(self.state.bodies[prediction.partner as usize].id);
            }
        }
        self.permute(&Order::of(self.particles().filter(|&particle| stays[particle as usize]).collect(), count));
        self.scratch = None;
        self.schedule.queue.clear();
        for particle in self.particles() {
            self.enqueue(particle);
        }
    }

    /// Repeats the predictions in which a particle would meet a removed particle.
    pub fn predict_partners_of_removed(&mut self) {
        for particle in self.particles() {
            if self.schedule.predictions[particle as usize].absent_partner().is_some() {
                self.repredict(particle, self.clock.now);
            }
        }
    }

    /// Appends particles, and returns their numbers.
    pub fn push_records(&mut self, records: &[Record]) -> Range<u32> {
        let first = self.particles().end;
        for record in records {
            self.push_record(record);
        }
        self.state.number_anew();
        let count = if TABLE { self.state.bodies.len() } else { 0 };
        if let Some(scratch) = &mut self.scratch {
            scratch.enlarge(count);
        }
        first..self.particles().end
    }

    /// Writes records in the given order, and updates neighbour lists. Returns the numbers of the particles.
    pub fn restore(&mut self, records: &[Record]) -> Vec<u32> {
        let (mut written, mut moved) = (Vec::with_capacity(records.len()), Vec::new());
        for record in records {
            let particle = record.number;
            let is_moved = record.place.is_some_and(|place| place != self.neighbours.place(particle))
                || record.captured.as_ref().is_some_and(|captured| self.pairs.states.of(particle) != captured);
            if is_moved {
                moved.push(particle);
            }
            written.push(particle);
            self.write_record(particle, record);
        }
        for particles in [&mut moved, &mut written] {
            particles.sort_unstable();
            particles.dedup();
        }
        moved.into_iter().for_each(|particle| self.fill_list(particle));
        written
    }

    /// Fills the neighbour lists of appended particles, and predicts their events. Their captured pairs must be set.
    pub fn predict_added(&mut self, added: Range<u32>) {
        for particle in added.clone() {
            self.fill_list(particle);
        }
        for particle in added.clone() {
            self.predict_arrival(particle, added.start);
        }
    }

    /// Predicts an inserted particle. If the particle is static, moving particles nearby are predicted again. `first`
    /// is the number of the first inserted particle.
    pub(super) fn predict_arrival(&mut self, particle: u32, first: u32) {
        if !self.is_static(particle) {
            return self.repredict(particle, self.clock.now);
        }
        let mut near = Candidates::default();
        self.neighbours.find_candidates(particle, self.row(particle), &mut near);
        for &other in near.found().iter().filter(|&&other| other < first) {
            if !self.is_static(other) {
                self.repredict(other, self.clock.now);
            }
        }
    }
}

#[cfg(test)]
mod tests;
