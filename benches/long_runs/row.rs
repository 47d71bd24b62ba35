use std::error::Error;
use std::fmt;
use std::fs;
use std::path::PathBuf;

#[derive(Debug, Clone, Copy)]
pub struct Row {
    pub events: f64,
    pub time: f64,
    /// Relative energy error, `(E + dissipated - E_initial) / max(|E_initial|, kinetic, dissipated)`.
    pub energy: f64,
    /// Relative momentum error, `|P - P_initial| / sum m |v|`; NaN if momentum is not conserved.
    pub momentum: f64,
    /// Deepest overlap so far, relative to the distance of the discontinuity.
    pub overlap: f64,
    /// Number of events so far with an overlap deeper than round-off.
    pub invalid: f64,
    pub seconds: f64,
}

pub const HEADER: &str = "events,time,energy error,momentum drift,deepest overlap,events in invalid states,seconds";

impl fmt::Display for Row {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { events, time, energy, momentum, overlap, invalid, seconds } = self;
        write!(f, "{events},{time},{energy:e},{momentum:e},{overlap:e},{invalid},{seconds:.1}")
    }
}

impl Row {
    fn parse(line: &str) -> Result<Self, Box<dyn Error>> {
        let numbers = line.split(',').map(str::parse::<f64>).collect::<Result<Vec<_>, _>>()?;
        let [events, time, energy, momentum, overlap, invalid, seconds] = numbers[..] else {
            return Err(format!("not a row: {line}").into());
        };
        Ok(Self { events, time, energy, momentum, overlap, invalid, seconds })
    }
}

pub fn file(name: &str) -> PathBuf {
    PathBuf::from(super::FOLDER).join(format!("{name}.csv"))
}

/// Reads the rows of a long run. Returns no rows if the run has not been measured.
pub fn read(name: &str) -> Result<Vec<Row>, Box<dyn Error>> {
    match fs::read_to_string(file(name)) {
        Ok(text) => text.lines().skip(1).map(Row::parse).collect(),
        Err(_) => Ok(Vec::new()),
    }
}
