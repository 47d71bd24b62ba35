//! The tables of an exchange: `exchange.csv`, a row for each attempt to swap, `energies.csv`, the populations, and `curves.csv`.

use std::fmt::Write;

use super::curves::ThermalPoint;
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

/// Reads the potential energies of a line into `energies`; says whether they are there.
pub(super) fn potential(line: &str, energies: &mut Vec<f64>) -> bool {
    energies.clear();
    let mut cells = line.split(',').skip(2).step_by(2).map(str::parse::<f64>);
    cells.all(|cell| cell.map(|energy| energies.push(energy)).is_ok())
}

/// The first line of `curves.csv`.
fn heads_of_curves() -> String {
    let names = ThermalPoint::default().quantities().map(|(name, _)| format!(",{name},{name}_error"));
    format!("temperature{}", names.concat())
}

/// `curves.csv`.
pub(super) fn curves(points: &[ThermalPoint]) -> String {
    let mut text = heads_of_curves() + "\n";
    for point in points {
        text.push_str(&Cell(Some(point.temperature)).to_string());
        for (_, it) in point.quantities() {
            // Writing to a string cannot fail.
            let _ = write!(text, ",{},{}", Cell(Some(it.mean)), Cell(it.standard_error));
        }
        text.push('\n');
    }
    text
}

/// Reads the curves back; otherwise says what is wrong.
pub(super) fn read_curves(text: &str) -> Result<Vec<ThermalPoint>, String> {
    let (mut lines, heads) = (text.lines(), heads_of_curves());
    if lines.next() != Some(heads.as_str()) {
        return Err(format!("line 1: expected `{heads}`"));
    }
    let point = |(number, line): (usize, &str)| {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |at: usize| cells.get(at).and_then(|cell| cell.parse::<f64>().ok());
        let estimate = |at: usize| Some(Estimate { mean: cell(2 * at + 1)?, standard_error: cell(2 * at + 2) });
        let point = || Some(ThermalPoint::new(cell(0)?, &[estimate(0)?, estimate(1)?, estimate(2)?, estimate(3)?]));
        point().ok_or_else(|| format!("line {number}: expected a temperature, and numbers with their errors"))
    };
    (2..).zip(lines).map(point).collect()
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
