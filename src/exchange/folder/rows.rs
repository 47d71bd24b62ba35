//! Reads the rows of an exchange, `exchange.csv`.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use crate::exchange::curves::ThermalCurves;
use crate::exchange::mean_force::MeanForce;
use crate::exchange::{Exchange, ExchangeFolderError, tables};

/// Returns the header of a table, and the other lines with their line numbers.
fn lines(path: &Path) -> Result<(String, impl Iterator<Item = (usize, io::Result<String>)>), ExchangeFolderError> {
    let file = File::open(path).map_err(|source| read(path, source))?;
    let mut lines = BufReader::new(file).lines();
    let heads = lines.next().transpose().map_err(|source| read(path, source))?;
    Ok((heads.unwrap_or_default(), (2..).zip(lines)))
}

fn read(path: &Path, source: io::Error) -> ExchangeFolderError {
    ExchangeFolderError::Read { path: path.to_owned(), source }
}

fn damaged(path: &Path, number: usize) -> ExchangeFolderError {
    let why = format!("line {number}: expected a time, and a replica and an energy for each temperature");
    read(path, io::Error::new(io::ErrorKind::InvalidData, why))
}

pub(super) fn places(path: &Path, every: usize, rows: usize) -> Result<Vec<(f64, Vec<usize>)>, ExchangeFolderError> {
    let (heads, lines) = lines(path)?;
    let temperatures = tables::temperatures(&heads);
    let place = |(number, line): (usize, io::Result<String>)| {
        let line = line.map_err(|source| read(path, source))?;
        tables::places(&line, temperatures).ok_or_else(|| damaged(path, number))
    };
    lines.take(rows).step_by(every.max(1)).map(place).collect()
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
    let count = exchange.temperatures().len();
    let of_each = exchange.measured_names().len();
    let (mut energies, mut measured) = (Vec::new(), Vec::new());
    for (number, line) in lines(path)?.1 {
        let line = line.map_err(|source| read(path, source))?;
        let is_whole = tables::numbers(&line, count, &mut energies, &mut measured);
        if !is_whole || measured.len() != of_each * count {
            return Err(damaged(path, number));
        }
        see(&energies, &measured);
    }
    Ok(())
}
