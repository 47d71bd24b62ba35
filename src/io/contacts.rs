//! The table of all events, `contacts.csv`.

use super::thermo::Column;
use crate::base::shortest::Shortest;
use crate::engine::event::{Event, EventKind};
use crate::model::Units;
use crate::physics::response::Outcome;

pub(super) const HEADER: &str = "time,kind,particle,partner,impulse,energy_step,dissipated\n";

const UNITS: [&str; 7] = ["time", "", "1", "1", "mass length / time", "energy", "energy"];

pub(super) fn columns(units: &Units) -> Vec<Column> {
    HEADER.trim_end().split(',').zip(UNITS).map(|(name, unit)| Column::new(name, &units.of(unit, 3))).collect()
}

/// Returns the line of an event. For a wall, the line names the side of the box, such as `-z`.
pub(super) fn line(event: &Event) -> Vec<u8> {
    let mut text = Vec::with_capacity(128);
    let line = &mut text;
    let kind: &[u8] = match event.kind {
        EventKind::Pair(Outcome::Core) => b",core,",
        EventKind::Pair(Outcome::Capture) => b",capture,",
        EventKind::Pair(Outcome::Release) => b",release,",
        EventKind::Pair(Outcome::Bounce) => b",bounce,",
        EventKind::Thermostat => b",thermostat,",
        EventKind::Surface => b",wall,",
        EventKind::Exit => b",exit,",
        EventKind::Entry => b",entry,",
        EventKind::Rest => b",rest,",
        EventKind::Wake => b",wake,",
    };
    Shortest(event.time).push(line);
    line.extend_from_slice(kind);
    Shortest(event.particle.0.into()).push(line);
    line.push(b',');
    match (event.partner(), event.wall()) {
        (Some(partner), _) => Shortest(partner.0.into()).push(line),
        (None, Some((axis, is_upper))) => {
            line.push(if is_upper { b'+' } else { b'-' });
            line.extend(b"xyz".get(usize::from(axis)));
        }
        _ => {}
    }
    for number in [event.normal_impulse(), event.energy_step, event.dissipated] {
        line.push(b',');
        Shortest(number).push(line);
    }
    line.push(b'\n');
    text
}
