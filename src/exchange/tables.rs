//! The tables of an exchange: `exchange.csv` with a row for each attempt to swap, `energies.csv` with the populations,
//! `curves.csv` and `density_of_states.csv`.

use std::iter::once;

use csv::StringRecord;

use super::curves::ThermalPoint;
use super::levels::LevelDensity;
use super::mean_force::MeanForcePoint;
use super::replicas::ExchangeRow;
use super::results::{ExchangeResults, Population};
use crate::analysis::statistics::Estimate;
use crate::io::number::Cell;
use crate::io::table;

/// The first line of `exchange.csv`. Temperatures and replicas are counted from 1.
pub(super) fn header(temperatures: usize, measured: &[&str]) -> String {
    let places = (1..=temperatures).flat_map(|place| ["replica", "potential"].map(|name| format!("{name}_{place}")));
    let measured = (1..=temperatures).flat_map(|place| measured.iter().map(move |name| format!("{name}_{place}")));
    table::line(once("time".to_owned()).chain(places).chain(measured))
}

pub(super) fn line(row: &ExchangeRow<'_>) -> String {
    let replicas = row.replicas.iter().zip(row.potential);
    let places = replicas.flat_map(|(replica, energy)| [(replica + 1) as f64, *energy]);
    table::line(once(row.time).chain(places).chain(row.measured.iter().copied()).map(|number| Cell(Some(number))))
}

/// Returns the time of a row of `exchange.csv`, and the index of the replica at each temperature.
pub(super) fn places(row: &StringRecord, temperatures: usize) -> Option<(f64, Vec<usize>)> {
    let mut cells = row.iter();
    let time = cells.next()?.parse().ok()?;
    let replicas = cells.step_by(2).take(temperatures).map(|cell| cell.parse::<usize>().ok()?.checked_sub(1));
    let replicas: Vec<usize> = replicas.collect::<Option<_>>()?;
    (replicas.len() == temperatures).then_some((time, replicas))
}

/// Returns a row of numbers without errors, and estimates with their errors.
fn row<'e>(numbers: &[f64], estimates: impl IntoIterator<Item = &'e Estimate>) -> String {
    let estimates = estimates.into_iter().flat_map(|it| [Some(it.mean), it.standard_error]);
    table::line(numbers.iter().copied().map(Some).chain(estimates).map(Cell))
}

fn heads_of(point: &ThermalPoint) -> String {
    let names = point.quantities().into_iter().map(|(name, _)| format!(",{name},{name}_error"));
    format!("temperature{}", names.collect::<String>())
}

pub(super) fn curves(points: &[ThermalPoint]) -> String {
    let heads = heads_of(points.first().unwrap_or(&ThermalPoint::default())) + "\n";
    let of = |point: &ThermalPoint| row(&[point.temperature], point.quantities().iter().map(|(_, it)| it));
    once(heads).chain(points.iter().map(of)).collect()
}

pub(super) fn read_curves(text: &str) -> Result<Vec<ThermalPoint>, String> {
    let always = heads_of(&ThermalPoint::default());
    let Some(heads) = text.lines().next().filter(|heads| heads.starts_with(&always)) else {
        return Err(format!("line 1: expected a header that begins with `{always}`"));
    };
    // The name of each quantity is followed by the name of the error column.
    let names: Vec<&str> = heads[always.len()..].split(',').skip(1).step_by(2).collect();
    let rows = table::read::<(f64, Vec<Estimate>)>(text, heads, "a temperature, and numbers with their errors")?;
    Ok(rows.iter().map(|(temperature, all)| ThermalPoint::new(*temperature, all, &names)).collect())
}

const DENSITY_HEADS: &str = "energy,log_density_of_states,log_density_of_states_error";

pub(super) fn density_of_states(levels: &[LevelDensity]) -> String {
    let rows = levels.iter().map(|it| row(&[it.energy], [&it.log_density_of_states]));
    once(format!("{DENSITY_HEADS}\n")).chain(rows).collect()
}

pub(super) fn read_density_of_states(text: &str) -> Result<Vec<LevelDensity>, String> {
    let rows = table::read::<(f64, Estimate)>(text, DENSITY_HEADS, "an energy, and a number with its error")?;
    Ok(rows.into_iter().map(|(energy, density)| LevelDensity::new(energy, density)).collect())
}

const MEAN_FORCE_HEADS: &str =
    "distance,width,free_energy,free_energy_error,potential_of_mean_force,potential_of_mean_force_error";

pub(super) fn mean_force(points: &[MeanForcePoint]) -> String {
    let of = |it: &MeanForcePoint| row(&[it.distance, it.width], [&it.free_energy, &it.potential_of_mean_force]);
    once(format!("{MEAN_FORCE_HEADS}\n")).chain(points.iter().map(of)).collect()
}

pub(super) fn read_mean_force(text: &str) -> Result<Vec<MeanForcePoint>, String> {
    table::read(text, MEAN_FORCE_HEADS, "a distance, a width, and two numbers with their errors")
}

const HEADS: &str = "temperature,energy,width,population,population_error";

pub(super) fn energies(results: &ExchangeResults) -> String {
    let temperatures = results.temperatures.iter();
    let all = temperatures.flat_map(|at| at.populations.iter().map(|it| (at.temperature, it)));
    let rows = all.map(|(temperature, it)| row(&[temperature, it.energy, it.width], [&it.population]));
    once(format!("{HEADS}\n")).chain(rows).collect()
}

pub(super) fn read_energies(text: &str, results: &mut ExchangeResults) -> Result<(), String> {
    let rows = table::read::<(f64, Population)>(text, HEADS, "four numbers, and a fifth number or an empty cell")?;
    for (number, (temperature, population)) in (2..).zip(rows) {
        let at = results.temperatures.iter_mut().find(|at| at.temperature == temperature);
        at.ok_or_else(|| format!("line {number}: expected a temperature of the exchange"))?
            .populations
            .push(population);
    }
    Ok(())
}
