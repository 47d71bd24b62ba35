//! The tables of an exchange: `exchange.csv` with a row for each attempt to swap, `energies.csv` with the populations,
//! `curves.csv` and `density_of_states.csv`.

use std::fmt::Write;
use std::str::Lines;

use super::curves::ThermalPoint;
use super::levels::LevelDensity;
use super::mean_force::MeanForcePoint;
use super::replicas::ExchangeRow;
use super::results::{ExchangeResults, Population};
use crate::analysis::statistics::Estimate;
use crate::io::number::Cell;

/// The first line of `exchange.csv`. Temperatures and replicas are counted from 1.
pub(super) fn header(temperatures: usize, measured: &[&str]) -> String {
    let mut line = "time".to_owned();
    for place in 1..=temperatures {
        let _ = write!(line, ",replica_{place},potential_{place}");
    }
    for place in 1..=temperatures {
        for name in measured {
            let _ = write!(line, ",{name}_{place}");
        }
    }
    line + "\n"
}

pub(super) fn line(row: &ExchangeRow<'_>) -> String {
    let mut line = Cell(Some(row.time)).to_string();
    for (replica, energy) in row.replicas.iter().zip(row.potential) {
        let _ = write!(line, ",{},{}", replica + 1, Cell(Some(*energy)));
    }
    for number in row.measured {
        let _ = write!(line, ",{}", Cell(Some(*number)));
    }
    line + "\n"
}

pub(super) fn temperatures(heads: &str) -> usize {
    heads.split(',').filter(|head| head.starts_with("replica_")).count()
}

/// Returns the time of a line of `exchange.csv`, and the index of the replica at each temperature.
pub(super) fn places(line: &str, temperatures: usize) -> Option<(f64, Vec<usize>)> {
    let mut cells = line.split(',');
    let time = cells.next()?.parse().ok()?;
    let replicas = cells.step_by(2).take(temperatures).map(|cell| cell.parse::<usize>().ok()?.checked_sub(1));
    let replicas: Vec<usize> = replicas.collect::<Option<_>>()?;
    (replicas.len() == temperatures).then_some((time, replicas))
}

/// Reads the energies and other quantities from a line of `exchange.csv`. Returns whether the line is complete.
pub(super) fn numbers(line: &str, temperatures: usize, energies: &mut Vec<f64>, measured: &mut Vec<f64>) -> bool {
    energies.clear();
    measured.clear();
    let mut cells = line.split(',').skip(1).map(str::parse::<f64>).enumerate();
    let are_numbers = cells.all(|(at, cell)| {
        let list = if at < 2 * temperatures { &mut *energies } else { &mut *measured };
        cell.map(|number| {
            if at % 2 == 1 || at >= 2 * temperatures {
                list.push(number)
            }
        })
        .is_ok()
    });
    are_numbers && energies.len() == temperatures
}

fn heads_of(point: &ThermalPoint) -> String {
    let names = point.quantities().into_iter().map(|(name, _)| format!(",{name},{name}_error"));
    format!("temperature{}", names.collect::<String>())
}

pub(super) fn curves(points: &[ThermalPoint]) -> String {
    let mut text = heads_of(points.first().unwrap_or(&ThermalPoint::default())) + "\n";
    for point in points {
        text.push_str(&Cell(Some(point.temperature)).to_string());
        for (_, it) in point.quantities() {
            let _ = write!(text, ",{},{}", Cell(Some(it.mean)), Cell(it.standard_error));
        }
        text.push('\n');
    }
    text
}

pub(super) fn read_curves(text: &str) -> Result<Vec<ThermalPoint>, String> {
    let (mut lines, heads) = (text.lines(), heads_of(&ThermalPoint::default()));
    let Some(others) = lines.next().and_then(|line| line.strip_prefix(heads.as_str())) else {
        return Err(format!("line 1: expected a header that begins with `{heads}`"));
    };
    // The name of each quantity is followed by the name of the error column.
    let names: Vec<&str> = others.split(',').skip(1).step_by(2).collect();
    read_lines(lines, "a temperature, and numbers with their errors", |cells| {
        let all = (0..4 + names.len()).map(|at| cells.estimate(2 * at + 1)).collect::<Option<Vec<_>>>()?;
        Some(ThermalPoint::new(cells.number(0)?, &all, &names))
    })
}

const DENSITY_HEADS: &str = "energy,log_density_of_states,log_density_of_states_error";

pub(super) fn density_of_states(levels: &[LevelDensity]) -> String {
    let mut text = format!("{DENSITY_HEADS}\n");
    for LevelDensity { energy, log_density_of_states: it, .. } in levels {
        let _ = writeln!(text, "{},{},{}", Cell(Some(*energy)), Cell(Some(it.mean)), Cell(it.standard_error));
    }
    text
}

pub(super) fn read_density_of_states(text: &str) -> Result<Vec<LevelDensity>, String> {
    read_lines(behind(text, DENSITY_HEADS)?, "an energy, and a number with its error", |cells| {
        Some(LevelDensity::new(cells.number(0)?, cells.estimate(1)?))
    })
}

const MEAN_FORCE_HEADS: &str =
    "distance,width,free_energy,free_energy_error,potential_of_mean_force,potential_of_mean_force_error";

pub(super) fn mean_force(points: &[MeanForcePoint]) -> String {
    let mut text = format!("{MEAN_FORCE_HEADS}\n");
    for MeanForcePoint { distance, width, free_energy, potential_of_mean_force } in points {
        let _ = write!(text, "{},{}", Cell(Some(*distance)), Cell(Some(*width)));
        for it in [free_energy, potential_of_mean_force] {
            let _ = write!(text, ",{},{}", Cell(Some(it.mean)), Cell(it.standard_error));
        }
        text.push('\n');
    }
    text
}

pub(super) fn read_mean_force(text: &str) -> Result<Vec<MeanForcePoint>, String> {
    let expected = "a distance, a width, and two numbers with their errors";
    read_lines(behind(text, MEAN_FORCE_HEADS)?, expected, |cells| {
        Some(MeanForcePoint {
            distance: cells.number(0)?,
            width: cells.number(1)?,
            free_energy: cells.estimate(2)?,
            potential_of_mean_force: cells.estimate(4)?,
        })
    })
}

const HEADS: &str = "temperature,energy,width,population,population_error";

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

pub(super) fn read_energies(text: &str, results: &mut ExchangeResults) -> Result<(), String> {
    let temperatures = &mut results.temperatures;
    read_lines(behind(text, HEADS)?, "four numbers, and a fifth number or an empty cell", |cells| {
        let (energy, width, population) = (cells.number(1)?, cells.number(2)?, cells.estimate(3)?);
        let temperature = cells.number(0)?;
        let at = temperatures.iter_mut().find(|at| at.temperature == temperature)?;
        at.populations.push(Population { energy, width, population });
        Some(())
    })
    .map(|_| ())
}

struct Cells<'t>(Vec<&'t str>);

impl Cells<'_> {
    fn number(&self, at: usize) -> Option<f64> {
        self.0.get(at)?.parse().ok()
    }

    /// Reads a mean from a cell, and its error from the next cell, which may be empty.
    fn estimate(&self, at: usize) -> Option<Estimate> {
        Some(Estimate { mean: self.number(at)?, standard_error: self.number(at + 1) })
    }
}

fn behind<'t>(text: &'t str, heads: &str) -> Result<Lines<'t>, String> {
    let mut lines = text.lines();
    if lines.next() == Some(heads) { Ok(lines) } else { Err(format!("line 1: expected `{heads}`")) }
}

fn read_lines<T>(
    lines: Lines<'_>,
    expected: &str,
    mut made: impl FnMut(&Cells<'_>) -> Option<T>,
) -> Result<Vec<T>, String> {
    let of_line = |(number, line): (usize, &str)| {
        made(&Cells(line.split(',').collect())).ok_or_else(|| format!("line {number}: expected {expected}"))
    };
    (2..).zip(lines).map(of_line).collect()
}
