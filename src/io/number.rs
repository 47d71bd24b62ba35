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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn number_cells_hold_the_shortest_text() {
        for (number, text) in [(0.1, "0.1"), (0.0, "0"), (1e300, "1e300"), (-2.5e-9, "-2.5e-9"), (9999.0, "9999")] {
            assert_eq!(Cell(Some(number)).to_string(), text);
        }
        assert_eq!(Cell(None).to_string(), "");
    }
}
