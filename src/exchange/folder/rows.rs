//! Reads the rows of an exchange, `exchange.csv`.

use std::fs::File;
use std::io::{self, BufRead, BufReader};
use std::path::Path;

use crate::exchange::curves::ThermalCurves;
use crate::exchange::{Exchange, ExchangeFolderError, tables};

/// Lines of a table without its heads, numbered from 2.
fn lines(path: &Path) -> Result<impl Iterator<Item = (usize, io::Result<String>)>, ExchangeFolderError> {
    let file = File::open(path).map_err(|source| read(path, source))?;
    Ok((1..).zip(BufReader::new(file).lines()).skip(1))
}

fn read(path: &Path, source: io::Error) -> ExchangeFolderError {
    ExchangeFolderError::Read { path: path.to_owned(), source }
}

fn damaged(path: &Path, number: usize) -> ExchangeFolderError {
    let why = format!("line {number}: expected a time, and a replica and an energy for each temperature");
    read(path, io::Error::new(io::ErrorKind::InvalidData, why))
}

/// The replica at each temperature by time: every N-th of the first rows.
pub(super) fn places(path: &Path, every: usize, rows: usize) -> Result<Vec<(f64, Vec<usize>)>, ExchangeFolderError> {
    let place = |(number, line): (usize, io::Result<String>)| {
        let line = line.map_err(|source| read(path, source))?;
        tables::places(&line).ok_or_else(|| damaged(path, number))
    };
    lines(path)?.take(rows).step_by(every.max(1)).map(place).collect()
}

/// Curves from the energies of all rows, which are read twice, so that any number of them needs no more memory.
pub(super) fn curves(path: &Path, exchange: &Exchange) -> Result<ThermalCurves, ExchangeFolderError> {
    let count = exchange.temperatures().len();
    let mut energies = Vec::with_capacity(count);
    ThermalCurves::of(exchange, |see| {
        for (number, line) in lines(path)? {
            let line = line.map_err(|source| read(path, source))?;
            if !tables::potential(&line, &mut energies) || energies.len() != count {
                return Err(damaged(path, number));
            }
            see(&energies);
        }
        Ok(())
    })
}
