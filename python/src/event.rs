//! Events as bytes, for arrays of the type `carom.EVENT`.

use carom::engine::event::Event;

pub const SIZE: usize = 232;

/// Appends an event in the layout of `carom.EVENT`. All numbers are aligned and in the byte order of the machine.
pub fn write(event: &Event, bytes: &mut Vec<u8>) {
    bytes.extend_from_slice(&event.time.to_ne_bytes());
    // The kind is one byte. Seven bytes of padding align the following numbers.
    bytes.extend_from_slice(&[event.code(), 0, 0, 0, 0, 0, 0, 0]);
    bytes.extend_from_slice(&i64::from(event.particle.0).to_ne_bytes());
    bytes.extend_from_slice(&event.partner().map_or(-1, |partner| i64::from(partner.0)).to_ne_bytes());
    for vector in event.positions.iter().chain(&event.before).chain(&event.after) {
        for component in vector.iter() {
            bytes.extend_from_slice(&component.to_ne_bytes());
        }
    }
    for number in [event.energy_step, event.dissipated, event.normal_impulse(), event.distance] {
        bytes.extend_from_slice(&number.to_ne_bytes());
    }
    for component in event.normal.iter() {
        bytes.extend_from_slice(&component.to_ne_bytes());
    }
}
