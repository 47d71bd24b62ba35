use std::fmt;

use crate::base::shortest::Shortest;

/// A number in a table, with the fewest digits that restore its value. A missing number is an empty cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cell(pub Option<f64>);

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(number) => Shortest(number).fmt(f),
            None => Ok(()),
        }
    }
}

/// Returns a word as a cell of a CSV table. A word with a comma, a quote or a line end gets quotes.
pub(crate) fn quoted(word: &str) -> String {
    if word.contains([',', '"', '\n']) { format!("\"{}\"", word.replace('"', "\"\"")) } else { word.to_owned() }
}

/// Returns a text as a cell of a CSV table. An apostrophe protects texts that a spreadsheet would read as formulas.
pub(crate) fn text_cell(word: &str) -> String {
    let is_formula = word.starts_with(['=', '+', '-', '@', '\t', '\r']) && word.parse::<f64>().is_err();
    if is_formula { quoted(&format!("'{word}")) } else { quoted(word) }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn number_cells_hold_the_shortest_text() {
        for (number, text) in [(0.1, "0.1"), (0.0, "0"), (1e300, "1e300"), (-2.5e-9, "-2.5e-9"), (9999.0, "9999")] {
            assert_eq!(Cell(Some(number)).to_string(), text);
        }
        assert_eq!(Cell(None).to_string(), "");
    }
}
