//! The table of all events, `contacts.csv`.

use std::path::PathBuf;

use super::error::OutputError;
use super::partial::PartialFile;
use super::thermo::Column;
use crate::base::shortest::Shortest;
use crate::engine::event::{Event, EventKind};
use crate::physics::response::Outcome;

/// The first line.
const HEADER: &str = "time,kind,particle,partner,impulse,energy_step,dissipated\n";

/// The units of its columns.
const UNITS: [&str; 7] = ["time", "", "1", "1", "mass length / time", "energy", "energy"];

/// Its columns.
pub(super) fn columns() -> Vec<Column> {
    HEADER.trim_end().split(',').zip(UNITS).map(|(name, unit)| Column::new(name, unit)).collect()
}

/// The table while it is written.
#[derive(Debug)]
pub(super) struct Contacts {
    file: PartialFile,
    /// The line that is being made.
    line: Vec<u8>,
}

impl Contacts {
    /// An empty table.
    pub fn create(path: PathBuf) -> Result<Self, OutputError> {
        let mut file = PartialFile::create(path)?;
        file.write(HEADER)?;
        Ok(Self::go_on(file))
    }

    /// Goes on with a table that has been checked.
    pub fn go_on(file: PartialFile) -> Self {
        Self { file, line: Vec::new() }
    }

    /// Appends a line for an event.
    pub fn add(&mut self, event: &Event) -> Result<(), OutputError> {
        self.line.clear();
        push_line(&mut self.line, event);
        self.file.write_bytes(&self.line)
    }

    pub fn file(&self) -> &PartialFile {
        &self.file
    }

    pub fn file_mut(&mut self) -> &mut PartialFile {
        &mut self.file
    }

    pub fn into_file(self) -> PartialFile {
        self.file
    }
}

/// A line for an event. The partner of a contact with a wall is the side of the box, `-z` for the lower wall of z.
fn push_line(line: &mut Vec<u8>, event: &Event) {
    let kind: &[u8] = match event.kind {
        EventKind::Pair(Outcome::Core) => b",core,",
        EventKind::Pair(Outcome::Capture) => b",capture,",
        EventKind::Pair(Outcome::Release) => b",release,",
        EventKind::Pair(Outcome::Bounce) => b",bounce,",
        EventKind::Thermostat => b",thermostat,",
        EventKind::Surface => b",wall,",
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
}
