//! The table of all events, `contacts.csv`.

use super::number::Cell;
use super::thermo::Column;
use crate::engine::event::{Event, EventKind};
use crate::physics::response::Outcome;

/// The first line.
pub(super) const HEADER: &str = "time,kind,particle,partner,impulse,energy_step,dissipated\n";

/// The units of its columns.
const UNITS: [&str; 7] = ["time", "", "1", "1", "mass length / time", "energy", "energy"];

/// Its columns.
pub(super) fn columns() -> Vec<Column> {
    HEADER.trim_end().split(',').zip(UNITS).map(|(name, unit)| Column::new(name, unit)).collect()
}

/// A line for an event. The partner of a contact with a wall is the side of the box, `-z` for the lower wall of z.
pub(super) fn line(event: &Event) -> String {
    let (kind, partner) = match event.kind {
        EventKind::Pair(outcome) => {
            let kind = match outcome {
                Outcome::Core => "core",
                Outcome::Capture => "capture",
                Outcome::Release => "release",
                Outcome::Bounce => "bounce",
            };
            (kind, event.partner.map_or_else(String::new, |partner| partner.0.to_string()))
        }
        EventKind::Thermostat => ("thermostat", String::new()),
        EventKind::Wall { axis, is_upper } => {
            let axis = ["x", "y", "z"].get(usize::from(axis)).copied().unwrap_or_default();
            ("wall", format!("{}{axis}", if is_upper { '+' } else { '-' }))
        }
    };
    let [time, impulse, energy_step, dissipated] =
        [event.time, event.impulse, event.energy_step, event.dissipated].map(|x| Cell(Some(x)));
    format!("{time},{kind},{},{partner},{impulse},{energy_step},{dissipated}\n", event.particle.0)
}
