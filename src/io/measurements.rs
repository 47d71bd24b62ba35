//! What a run has measured, as files: `measurements.json`, and a table for each curve in the folder `measurements`.

use std::fmt::Write;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::number::{Cell, quoted};
use super::partial::PartialFile;
use crate::analysis::instruments::{Curve, Measured};

/// Everything in one file.
pub(super) const FILE: &str = "measurements.json";
/// The folder of the tables.
const TABLES: &str = "measurements";

/// Writes the files beside their names; none if nothing was measured.
pub(super) fn prepare(folder: &Path, measured: &Measured) -> Result<Vec<PartialFile>, OutputError> {
    if *measured == Measured::default() {
        return Ok(Vec::new());
    }
    let mut all = PartialFile::create(folder.join(FILE))?;
    let text =
        serde_json::to_string(measured).map_err(|error| OutputError::write(all.path())(io::Error::other(error)))?;
    all.write(&(text + "\n"))?;
    let mut files = vec![all];
    let tables = tables_of(folder);
    if !measured.curves.is_empty() {
        fs::create_dir_all(&tables).map_err(|source| OutputError::Folder { path: tables.clone(), source })?;
    }
    for curve in &measured.curves {
        let mut file = PartialFile::create(tables.join(format!("{}.csv", curve.name)))?;
        file.write(&table(curve))?;
        files.push(file);
    }
    Ok(files)
}

/// The files of what was measured, in the folder of a run.
pub(super) fn names(measured: &Measured) -> Vec<String> {
    if *measured == Measured::default() {
        return Vec::new();
    }
    let tables = measured.curves.iter().map(|curve| format!("{TABLES}/{}.csv", curve.name));
    [FILE.to_owned()].into_iter().chain(tables).collect()
}

/// Whether a name is that of such a table.
pub(super) fn is_table(name: &str) -> bool {
    name.strip_prefix(TABLES).is_some_and(|rest| rest.starts_with('/'))
}

fn tables_of(folder: &Path) -> PathBuf {
    folder.join(TABLES)
}

/// A curve as a table: its variables, and each quantity with its standard error; empty cells for insufficient data.
fn table(curve: &Curve) -> String {
    let mut text = String::new();
    let heads = curve.variables.iter().map(|variable| format!("{} [{}]", variable.name, variable.unit));
    let series = curve.series.iter().flat_map(|series| {
        [format!("{} [{}]", series.name, series.unit), format!("standard error of {} [{}]", series.name, series.unit)]
    });
    let heads: Vec<String> = heads.chain(series).map(|head| quoted(&head)).collect();
    text.push_str(&heads.join(","));
    text.push('\n');
    let rows = curve.variables.first().map_or(0, |variable| variable.values.len());
    for row in 0..rows {
        let variables = curve.variables.iter().map(|variable| variable.values.get(row).copied());
        let series = curve.series.iter().flat_map(|series| {
            [&series.values, &series.standard_errors].map(|values| values.get(row).copied().flatten())
        });
        for (at, cell) in variables.chain(series).enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(text, "{}{}", if at == 0 { "" } else { "," }, Cell(cell));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::instruments::{Series, Variable};

    #[test]
    fn a_curve_is_a_table_with_empty_cells_for_what_is_not_known() {
        let curve = Curve {
            name: "g".into(),
            title: "g".into(),
            method: String::new(),
            variables: vec![Variable { name: "r".into(), unit: "length".into(), values: vec![0.5, 1.5] }],
            series: vec![Series {
                name: "g(r) A,B".into(),
                unit: "1".into(),
                values: vec![None, Some(2.0)],
                standard_errors: vec![None, Some(1e-9)],
            }],
            is_logarithmic: [false; 2],
            published: Vec::new(),
        };
        let expected = "r [length],\"g(r) A,B [1]\",\"standard error of g(r) A,B [1]\"\n0.5,,\n1.5,2,1e-9\n";
        assert_eq!(table(&curve), expected);
    }
}
