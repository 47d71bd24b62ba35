//! Compares the particles of two engines, bit for bit.

use crate::engine::parts::Engine;
use crate::engine::prediction::{Prediction, id_of};

/// Returns the state of a particle and its next contact as text. Other particles are given by id and sorted.
pub fn all_of<const FALLING: bool, const TABLE: bool>(
    engine: &Engine<FALLING, TABLE>,
    particle: u32,
) -> (String, Option<String>) {
    let id = |number: u32| id_of(number, &engine.state.bodies);
    let mut record = engine.record(particle);
    let mut captured: Vec<_> = record.captured.take().into_iter().flatten().collect();
    captured.iter_mut().for_each(|pair| pair.partner = id(pair.partner));
    captured.sort_by_key(|pair| pair.partner);
    let prediction = record.prediction.take().unwrap();
    let Prediction { contact_time, partner, partner_version, contact, transition_time, .. } = prediction;
    let contact = format!("{contact:?} {contact_time} {partner_version} {:?}", id(partner));
    record.number = 0;
    let all = format!("{record:?} {captured:?} {transition_time}");
    (all, (contact_time < f64::INFINITY).then_some(contact))
}

pub fn listed<const FALLING: bool, const TABLE: bool>(engine: &Engine<FALLING, TABLE>, particle: u32) -> Vec<u32> {
    let list = engine.neighbours.verlet().map_or(&[][..], |verlet| verlet.lists.of(particle));
    let mut ids: Vec<u32> = list.iter().map(|&other| engine.state.bodies[other as usize].id).collect();
    ids.sort_unstable();
    ids
}

/// Compares all data of all particles: states, images, spins, counters, next events and neighbours.
pub fn compare_records<const FALLING: bool, const TABLE: bool>(
    one: &Engine<FALLING, TABLE>,
    other: &Engine<FALLING, TABLE>,
    name: &str,
) {
    assert_eq!(one.particles(), other.particles(), "{name}");
    for (here, there) in one.by_id().zip(other.by_id()) {
        assert_eq!(all_of(one, here), all_of(other, there), "{name}");
        assert_eq!(listed(one, here), listed(other, there), "{name}");
    }
}
