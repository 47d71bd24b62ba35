//! Reads the rows of an exchange, `exchange.csv`.

use std::io;
use std::path::Path;

use csv::{Reader, StringRecord};

use crate::exchange::curves::ThermalCurves;
use crate::exchange::mean_force::MeanForce;
use crate::exchange::{Exchange, ExchangeFolderError, tables};
use crate::io::table;

const ROW: &str = "a time, and a replica and an energy for each temperature";

fn read(path: &Path, source: io::Error) -> ExchangeFolderError {
    ExchangeFolderError::Read { path: path.to_owned(), source }
}

/// Reads every N-th of the first `rows` rows, where N is `every`. Returns the time and the replica at each
/// temperature.
pub(super) fn places(path: &Path, every: usize, rows: usize) -> Result<Vec<(f64, Vec<usize>)>, ExchangeFolderError> {
    let problem = |error| read(path, table::problem(error, ROW));
    let mut reader = Reader::from_path(path).map_err(problem)?;
    let heads = reader.headers().map_err(problem)?;
    let temperatures = heads.iter().filter(|head| head.starts_with("replica_")).count();
    let place = |(line, row): (u64, csv::Result<StringRecord>)| {
        tables::places(&row.map_err(problem)?, temperatures).ok_or_else(|| read(path, table::unexpected(line, ROW)))
    };
    (2..).zip(reader.records()).take(rows).step_by(every.max(1)).map(place).collect()
}

/// Computes the curves. The rows are read twice, so that they need not be kept in memory.
pub(super) fn curves(path: &Path, exchange: &Exchange) -> Result<ThermalCurves, ExchangeFolderError> {
    ThermalCurves::of(exchange, |see| visit(path, exchange, |energies, measured| see(energies, measured)))
}

pub(super) fn mean_force(path: &Path, exchange: &Exchange) -> Result<MeanForce, ExchangeFolderError> {
    let each = exchange.measured_names().len();
    let mut distances = Vec::new();
    MeanForce::of(exchange, |see| {
        visit(path, exchange, |_, measured| {
            distances.clear();
            // For windows, the distance is the first quantity of each replica.
            distances.extend(measured.iter().step_by(each));
            see(&distances);
        })
    })
}

fn visit(path: &Path, exchange: &Exchange, mut see: impl FnMut(&[f64], &[f64])) -> Result<(), ExchangeFolderError> {
    let problem = |error| read(path, table::problem(error, ROW));
    let count = exchange.temperatures().len();
    let mut reader = Reader::from_path(path).map_err(problem)?;
    // All rows have as many cells as the header.
    if reader.headers().map_err(problem)?.len() != 1 + count * (2 + exchange.measured_names().len()) {
        return Err(read(path, table::unexpected(1, "the names of the columns")));
    }
    let mut energies = Vec::with_capacity(count);
    for row in reader.records() {
        let (_, numbers): (f64, Vec<f64>) = row.and_then(|row| row.deserialize(None)).map_err(problem)?;
        let (places, measured) = numbers.split_at(2 * count);
        energies.clear();
        // Replica numbers and energies alternate.
        energies.extend(places.iter().skip(1).step_by(2));
        see(&energies, measured);
    }
    Ok(())
}
