//! Results of instruments: `measurements.json`, and a CSV table for each curve in the folder `measurements`.

use std::fs;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};

use super::error::OutputError;
use super::number::Cell;
use super::partial::PartialFile;
use super::table::line;
use crate::analysis::instruments::{Curve, Measured};
use crate::base::text;
use crate::run::{Finished, MeasuredStage};

pub(crate) const FILE: &str = "measurements.json";
pub(crate) const TABLES: &str = "measurements";

/// Results of the instruments in a run or a replica exchange. They are the content of `measurements.json`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Measurements {
    /// Results of the last measurement.
    #[serde(flatten)]
    pub last: Measured,
    /// Results of the earlier stages of a run, or of the temperatures of an exchange.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stages: Vec<StageMeasured>,
}

/// Results of the instruments in a stage, or at one temperature of an exchange.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct StageMeasured {
    /// Name of the stage, or for example `temperature-1` for the first temperature of an exchange.
    pub name: String,
    /// Results of the instruments.
    #[serde(flatten)]
    pub measured: Measured,
}

impl Measurements {
    pub(super) fn of(finished: &Finished) -> Self {
        let stage =
            |stage: &MeasuredStage| StageMeasured { name: stage.name.clone(), measured: stage.measured.clone() };
        let has_any = finished.stages.iter().any(|stage| stage.measured != Measured::default());
        let stages = if has_any { finished.stages.iter().map(stage).collect() } else { Vec::new() };
        Self { last: finished.measured.clone(), stages }
    }

    /// Reads the measurements in the folder of a run. `None` if there is no file, because the run had no instruments.
    ///
    /// # Errors
    /// If the file cannot be read, or is damaged.
    pub fn read(run: &Path) -> io::Result<Option<Self>> {
        match fs::read(run.join(FILE)) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            bytes => serde_json::from_slice(&bytes?).map(Some).map_err(io::Error::other),
        }
    }

    fn curves(&self) -> impl Iterator<Item = (String, &Curve)> {
        let of_stage = |stage: &StageMeasured, curve: &Curve| format!("{TABLES}/{}/{}.csv", stage.name, curve.name);
        let last = self.last.curves.iter().map(|curve| (format!("{TABLES}/{}.csv", curve.name), curve));
        let stages = self.stages.iter();
        last.chain(
            stages
                .flat_map(move |stage| stage.measured.curves.iter().map(move |curve| (of_stage(stage, curve), curve))),
        )
    }

    pub(crate) fn prepare(&self, folder: &Path) -> Result<Vec<PartialFile>, OutputError> {
        if *self == Self::default() {
            return Ok(Vec::new());
        }
        let all = folder.join(FILE);
        let text = serde_json::to_string(self).map_err(|error| OutputError::write(&all)(io::Error::other(error)))?;
        let mut files = vec![PartialFile::with_text(all, &(text + "\n"))?];
        for (name, curve) in self.curves() {
            let path = folder.join(name);
            if let Some(tables) = path.parent() {
                fs::create_dir_all(tables).map_err(|source| OutputError::Folder { path: tables.to_owned(), source })?;
            }
            files.push(PartialFile::with_text(path, &table(curve))?);
        }
        Ok(files)
    }

    pub(super) fn names(&self) -> Vec<String> {
        if *self == Self::default() {
            return Vec::new();
        }
        [FILE.to_owned()].into_iter().chain(self.curves().map(|(name, _)| name)).collect()
    }
}

pub(super) fn is_table(name: &str) -> bool {
    name.strip_prefix(TABLES).is_some_and(|rest| rest.starts_with('/'))
}

/// Writes a curve as a CSV table: the variables, and each quantity with its standard error. Missing data are empty
/// cells. Units are only in `measurements.json`.
fn table(curve: &Curve) -> String {
    let heads = curve.variables.iter().map(|variable| variable.name.clone());
    let series = curve.series.iter().flat_map(|series| [series.name.clone(), format!("{} error", series.name)]);
    let heads: Vec<String> = heads.chain(series).collect();
    let heads = text::identifiers(heads.iter().map(String::as_str));
    let mut text = line(heads);
    let rows = curve.variables.first().map_or(0, |variable| variable.values.len());
    for row in 0..rows {
        let variables = curve.variables.iter().map(|variable| variable.values.get(row).copied());
        let series = curve.series.iter().flat_map(|series| {
            [&series.values, &series.standard_errors].map(|values| values.get(row).copied().flatten())
        });
        text += &line(variables.chain(series).map(Cell));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::instruments::{Series, Variable};

    #[test]
    fn missing_curve_values_are_empty_cells() {
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
                normalisation: None,
            }],
            is_logarithmic: [false; 2],
            published: Vec::new(),
        };
        let expected = "r,g_r_A_B,g_r_A_B_error\n0.5,,\n1.5,2,1e-9\n";
        assert_eq!(table(&curve), expected);
    }
}
