//! The tables of an exchange: `exchange.csv`, a row for each attempt to swap, and `energies.csv`, the populations.

use std::fmt::Write;

use super::replicas::ExchangeRow;
use super::results::{ExchangeResults, Population};
use crate::analysis::statistics::Estimate;
use crate::io::number::Cell;

/// The first line of `exchange.csv`; temperatures and replicas count from 1.
pub(super) fn header(temperatures: usize) -> String {
    let mut line = "time".to_owned();
    for place in 1..=temperatures {
        // Writing to a string cannot fail.
        let _ = write!(line, ",replica_{place},potential_{place}");
    }
    line + "\n"
}

/// A line of it.
pub(super) fn line(row: &ExchangeRow<'_>) -> String {
    let mut line = Cell(Some(row.time)).to_string();
    for (replica, energy) in row.replicas.iter().zip(row.potential) {
        let _ = write!(line, ",{},{}", replica + 1, Cell(Some(*energy)));
    }
    line + "\n"
}

/// The time of a line, and the replica at each temperature, from 0.
pub(super) fn places(line: &str) -> Option<(f64, Vec<usize>)> {
    let mut cells = line.split(',');
    let time = cells.next()?.parse().ok()?;
    let replicas = cells.step_by(2).map(|cell| cell.parse::<usize>().ok()?.checked_sub(1));
    Some((time, replicas.collect::<Option<_>>()?))
}

const HEADS: &str = "temperature,energy,width,population,population_error";

/// `energies.csv`.
pub(super) fn energies(results: &ExchangeResults) -> String {
    let mut text = format!("{HEADS}\n");
    for at in &results.temperatures {
        for Population { energy, width, population } in &at.populations {
            let cells = [Some(at.temperature), Some(*energy), Some(*width), Some(population.mean)];
            let cells = cells.into_iter().chain([population.standard_error]).map(|cell| Cell(cell).to_string());
            text.push_str(&cells.collect::<Vec<_>>().join(","));
            text.push('\n');
        }
    }
    text
}

/// Reads the populations back; otherwise says what is wrong.
pub(super) fn read_energies(text: &str, results: &mut ExchangeResults) -> Result<(), String> {
    let mut lines = text.lines();
    if lines.next() != Some(HEADS) {
        return Err(format!("line 1: expected `{HEADS}`"));
    }
    for (number, line) in (2..).zip(lines) {
        let cells: Vec<&str> = line.split(',').collect();
        let wrong = || format!("line {number}: expected four numbers and a number or nothing");
        let cell = |at: usize| cells.get(at).and_then(|cell| cell.parse::<f64>().ok());
        let numbers = [cell(0), cell(1), cell(2), cell(3)].map(|it| it.ok_or_else(wrong));
        let [temperature, energy, width, mean] = numbers;
        let temperature = temperature?;
        let population = Estimate { mean: mean?, standard_error: cell(4) };
        let at = results.temperatures.iter_mut().find(|at| at.temperature == temperature).ok_or_else(wrong)?;
        at.populations.push(Population { energy: energy?, width: width?, population });
    }
    Ok(())
}
