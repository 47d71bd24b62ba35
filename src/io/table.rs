//! CSV tables: lines of cells, and rows that are read back.

use std::fmt::{Display, Write};
use std::io;

use serde::de::DeserializeOwned;

/// Returns a line of a table.
pub(crate) fn line(cells: impl IntoIterator<Item: Display>) -> String {
    let mut line = String::new();
    for (at, cell) in cells.into_iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(line, "{}{cell}", if at == 0 { "" } else { "," });
    }
    line + "\n"
}

/// Returns a word as a cell. A word with a comma, a quote or a line end gets quotes.
pub(crate) fn quoted(word: &str) -> String {
    if word.contains([',', '"', '\n']) { format!("\"{}\"", word.replace('"', "\"\"")) } else { word.to_owned() }
}

/// Returns a text as a cell. An apostrophe protects texts that a spreadsheet would read as formulas.
pub(crate) fn text_cell(word: &str) -> String {
    let is_formula = word.starts_with(['=', '+', '-', '@', '\t', '\r']) && word.parse::<f64>().is_err();
    if is_formula { quoted(&format!("'{word}")) } else { quoted(word) }
}

/// Reads the rows of a table whose first line is `heads`. Cells fill the fields of a row in their order. `expected`
/// describes a row.
pub(crate) fn read<T: DeserializeOwned>(text: &str, heads: &str, expected: &str) -> Result<Vec<T>, String> {
    if text.lines().next() != Some(heads) {
        return Err(format!("line 1: expected `{heads}`"));
    }
    let row = |record: csv::Result<csv::StringRecord>| record.and_then(|record| record.deserialize(None));
    let rows = csv::Reader::from_reader(text.as_bytes()).into_records().map(row);
    rows.collect::<Result<_, _>>().map_err(|error| problem(error, expected).to_string())
}

/// Names the line of a row that cannot be read, and what was expected there.
pub(crate) fn problem(error: csv::Error, expected: &str) -> io::Error {
    match error.position() {
        Some(at) => unexpected(at.line(), expected),
        None => error.into(),
    }
}

/// Error of a line that is not as expected.
pub(crate) fn unexpected(line: u64, expected: &str) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, format!("line {line}: expected {expected}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::statistics::Estimate;

    #[test]
    fn no_cell_is_a_formula() {
        for (word, cell) in [
            ("=1+1", "'=1+1"),
            ("@a,b", "\"'@a,b\""),
            ("-x", "'-x"),
            ("-0.5", "-0.5"),
            ("+1e3", "+1e3"),
            ("a=b", "a=b"),
        ] {
            assert_eq!(text_cell(word), cell);
        }
    }

    #[test]
    fn damaged_rows_are_reported_with_their_line() {
        let read = |text: &str| read::<(f64, Estimate)>(text, "x,y,y_error", "three numbers");
        assert_eq!(
            read("x,y,y_error\n1,2,\n-2.5e-9,3,4\n").unwrap(),
            [
                (1.0, Estimate { mean: 2.0, standard_error: None }),
                (-2.5e-9, Estimate { mean: 3.0, standard_error: Some(4.0) })
            ]
        );
        assert_eq!(read("x,y,y_error\n").unwrap(), []);
        for text in ["", "x,y\n1,2\n", " x,y,y_error\n1,2,3\n"] {
            assert_eq!(read(text).unwrap_err(), "line 1: expected `x,y,y_error`");
        }
        for row in ["4", "4,", "4,5", "4,,6", "4,5,x", "4,5,6,7", "x,5,6"] {
            assert_eq!(read(&format!("x,y,y_error\n1,2,3\n{row}")).unwrap_err(), "line 3: expected three numbers");
        }
    }
}
