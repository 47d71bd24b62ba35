//! Reads a stage of `thermo.csv`. Long tables are thinned while they are read.

use std::io::Read;

use csv::{ReaderBuilder, StringRecord};

use crate::io::summary::Column;

/// At this number of spans, neighbouring spans are merged. A plot is only about 500 pixels wide.
const MOST_SPANS: usize = 1024;

/// A column of `thermo.csv` as a time series.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Trace {
    pub name: String,
    pub unit: String,
    rows_per_span: usize,
    spans: Vec<Span>,
    open: Span,
}

/// A group of neighbouring rows, with the lowest and the highest point.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Span {
    rows: usize,
    lowest: Option<[f64; 2]>,
    highest: Option<[f64; 2]>,
}

impl Span {
    fn joined(self, other: Self) -> Self {
        let pick = |a: Option<[f64; 2]>, b: Option<[f64; 2]>, is_better: fn(f64, f64) -> bool| match (a, b) {
            (Some(a), Some(b)) => Some(if is_better(b[1], a[1]) { b } else { a }),
            (a, b) => a.or(b),
        };
        Self {
            rows: self.rows + other.rows,
            lowest: pick(self.lowest, other.lowest, |new, old| new < old),
            highest: pick(self.highest, other.highest, |new, old| new > old),
        }
    }
}

impl Trace {
    pub fn new(name: &str, unit: &str) -> Self {
        let (name, unit) = (name.to_owned(), unit.to_owned());
        Self { name, unit, rows_per_span: 1, spans: Vec::new(), open: Span::default() }
    }

    /// `y` is `None` for an empty cell.
    pub fn push(&mut self, x: f64, y: Option<f64>) {
        let point = y.map(|y| [x, y]);
        self.open = self.open.joined(Span { rows: 1, lowest: point, highest: point });
        if self.open.rows == self.rows_per_span {
            self.spans.push(std::mem::take(&mut self.open));
        }
        if self.spans.len() == MOST_SPANS {
            self.spans = self.spans.chunks_exact(2).map(|two| two[0].joined(two[1])).collect();
            self.rows_per_span *= 2;
        }
    }

    /// Returns the points; `None` for a gap.
    pub fn points(&self) -> Vec<Option<[f64; 2]>> {
        let mut points = Vec::new();
        for span in self.spans.iter().chain((self.open.rows > 0).then_some(&self.open)) {
            match (span.lowest, span.highest) {
                (Some(a), Some(b)) if a == b => points.push(Some(a)),
                (Some(a), Some(b)) if a[0] < b[0] => points.extend([Some(a), Some(b)]),
                (Some(a), Some(b)) => points.extend([Some(b), Some(a)]),
                _ => points.push(None),
            }
        }
        points
    }

    pub fn is_thinned(&self) -> bool {
        self.rows_per_span > 1
    }
}

/// Reads the rows of a stage as one trace per column, without the columns for time and stage. If the name of a column
/// has no unit in brackets, the unit is looked up in `units`.
pub(super) fn read(input: impl Read, stage: &str, units: &[Column]) -> Result<Vec<Trace>, String> {
    let unreadable = |error: csv::Error| format!("cannot read it: {error}");
    let mut table = ReaderBuilder::new().flexible(true).from_reader(input);
    let heads = table.headers().map_err(unreadable)?;
    if heads.len() < 2 || !heads[0].starts_with("time") {
        return Err("line 1: expected the names of the columns, `time [time],...`".to_owned());
    }
    let named = |head: &str| match head.rsplit_once(" [") {
        Some((name, unit)) => Trace::new(name, unit.trim_end_matches(']')),
        None => Trace::new(head, units.iter().find(|column| column.name == head).map_or("1", |column| &column.unit)),
    };
    let columns = heads.len();
    let has_stage = heads.iter().next_back() == Some("stage");
    let mut traces: Vec<Trace> = heads.iter().take(columns - usize::from(has_stage)).skip(1).map(named).collect();
    let mut cells = StringRecord::new();
    while table.read_record(&mut cells).map_err(unreadable)? {
        let line = cells.position().map_or(0, csv::Position::line);
        if cells.len() != columns {
            return Err(format!("line {line}: expected {columns} cells, found {}", cells.len()));
        }
        if !has_stage || &cells[columns - 1] == stage {
            row(&cells, line, &mut traces)?;
        }
    }
    Ok(traces)
}

fn row(cells: &StringRecord, line: u64, traces: &mut [Trace]) -> Result<(), String> {
    let wrong = |column: &str, text: &str| {
        let text: String = text.chars().take(60).collect();
        format!("line {line}: {column} is `{text}`, expected a finite number")
    };
    let finite = |text: &str| text.parse::<f64>().ok().filter(|number| number.is_finite());
    let time = finite(&cells[0]).ok_or_else(|| wrong("time", &cells[0]))?;
    for (trace, cell) in traces.iter_mut().zip(cells.iter().skip(1)) {
        let value = match cell {
            "" => None,
            cell => Some(finite(cell).ok_or_else(|| wrong(&trace.name, cell))?),
        };
        trace.push(time, value);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::run_plan::MEASUREMENT;

    #[test]
    fn columns_have_names_units_and_gaps() {
        let traces =
            read("time [time],p [energy/length^D],in a [1]\n0,,1\n1,2.5,2\n".as_bytes(), MEASUREMENT, &[]).unwrap();
        assert_eq!((traces[0].name.as_str(), traces[0].unit.as_str()), ("p", "energy/length^D"));
        assert_eq!(traces[1].name, "in a");
        assert_eq!(traces[0].points(), [None, Some([1.0, 2.5])]);
    }

    #[test]
    fn only_the_rows_of_a_stage_are_read() {
        let text = "time [time],p [1],stage\n0,1,\"first, warm\"\n1,2,equilibration\n1,,measurement\n2,4,measurement\n";
        let traces = read(text.as_bytes(), MEASUREMENT, &[]).unwrap();
        assert_eq!(traces.len(), 1);
        assert_eq!(traces[0].points(), [None, Some([2.0, 4.0])]);
        let other = read(text.as_bytes(), "equilibration", &[]).unwrap();
        assert_eq!(other[0].points(), [Some([1.0, 2.0])]);
        let quoted = read(text.as_bytes(), "first, warm", &[]).unwrap();
        assert_eq!(quoted[0].points(), [Some([0.0, 1.0])]);
    }

    #[test]
    fn damaged_table_is_reported_with_its_line() {
        for (text, expected) in [
            ("", "line 1"),
            ("a,b\n1,2\n", "line 1"),
            ("time,b\n1\n", "line 2: expected 2 cells, found 1"),
            ("time,b\n1,2\n2,x\n", "line 3: b is `x`"),
            ("time,b\n1,NaN\n", "line 2: b is `NaN`"),
            ("time,b\ninf,1\n", "line 2: time is `inf`"),
        ] {
            let error = read(text.as_bytes(), MEASUREMENT, &[]).unwrap_err();
            assert!(error.contains(expected), "{text:?}: {error}");
        }
        let error = read(&[b't', b'i', b'm', b'e', 0xff][..], MEASUREMENT, &[]).unwrap_err();
        assert!(error.starts_with("cannot read it: "), "{error}");
    }

    #[test]
    fn thinning_keeps_every_peak_in_bounded_memory() {
        let mut trace = Trace::new("y", "1");
        for k in 0..100_000_i32 {
            let y = match k {
                54_321 => 7.0,
                54_322 => -7.0,
                k => f64::from(k % 2),
            };
            trace.push(f64::from(k), Some(y));
        }
        let points = trace.points();
        assert!(trace.is_thinned() && points.len() <= 2 * MOST_SPANS);
        assert!(points.contains(&Some([54_321.0, 7.0])) && points.contains(&Some([54_322.0, -7.0])));
        assert!(points.is_sorted_by(|a, b| a.unwrap()[0] < b.unwrap()[0]));
        assert_eq!(points[0].unwrap()[0], 0.0);
    }
}
