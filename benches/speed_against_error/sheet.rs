//! Tables of measurements, saved as csv files.

use super::{FOLDER, Outcome, machine};
use std::fmt::Write;
use std::fs;
use std::path::PathBuf;

#[derive(Debug, Clone)]
pub struct Sheet {
    name: String,
    /// Machine, compiler, version and date.
    pub provenance: String,
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Sheet {
    pub fn new(name: &str, columns: &[&str]) -> Self {
        let columns = columns.iter().map(|&column| column.to_owned()).collect();
        Self { name: name.to_owned(), provenance: machine::provenance(), columns, rows: Vec::new() }
    }

    /// Appends a row and rewrites the file, so that a run can be stopped at any time.
    pub fn push(&mut self, row: Vec<String>) -> Outcome {
        println!("{}: {}", self.name, row.join(", "));
        self.rows.push(row);
        let mut text = format!("# {}\n{}\n", self.provenance, self.columns.join(","));
        for row in &self.rows {
            writeln!(text, "{}", row.join(","))?;
        }
        Ok(fs::write(file(&self.name), text)?)
    }

    pub fn read(name: &str) -> Option<Self> {
        let text = fs::read_to_string(file(name)).ok()?;
        let mut lines = text.lines();
        let provenance = lines.next()?.trim_start_matches("# ").to_owned();
        let split = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let columns = split(lines.next()?);
        let rows = lines.map(split).filter(|row| row.len() == columns.len()).collect();
        Some(Self { name: name.to_owned(), provenance, columns, rows })
    }

    pub fn with(&self, column: &str, value: &str) -> Self {
        let index = self.index(column);
        let rows = self.rows.iter().filter(|row| row[index] == value).cloned().collect();
        Self { rows, ..self.clone() }
    }

    /// Returns the different values of a column, in order of appearance.
    pub fn values(&self, column: &str) -> Vec<String> {
        let mut values: Vec<String> = Vec::new();
        for row in &self.rows {
            let value = &row[self.index(column)];
            if !values.contains(value) {
                values.push(value.clone());
            }
        }
        values
    }

    /// Returns the numbers of a column. A cell that is not a number becomes NaN.
    pub fn numbers(&self, column: &str) -> Vec<f64> {
        let index = self.index(column);
        self.rows.iter().map(|row| row[index].parse().unwrap_or(f64::NAN)).collect()
    }

    pub fn points(&self, x: &str, y: &str) -> Vec<(f64, f64)> {
        self.numbers(x).into_iter().zip(self.numbers(y)).collect()
    }

    fn index(&self, column: &str) -> usize {
        let found = self.columns.iter().position(|name| name == column);
        found.unwrap_or_else(|| panic!("{} has no column {column}", self.name))
    }

    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
        let mut text = line(&self.columns);
        text += &format!("|{}\n", "---|".repeat(self.columns.len()));
        for row in &self.rows {
            text += &line(&row.iter().map(|cell| short(cell)).collect::<Vec<_>>());
        }
        text
    }
}

fn file(name: &str) -> PathBuf {
    PathBuf::from(FOLDER).join(format!("{name}.csv"))
}

/// Formats a number with about three digits. Whole numbers below a million keep all digits. Text is unchanged.
fn short(cell: &str) -> String {
    match cell.parse::<f64>() {
        Ok(x) if !x.is_finite() => "-".to_owned(),
        Ok(0.0) => "0".to_owned(),
        Ok(x) if x.fract() == 0.0 && x.abs() < 1e6 => format!("{x}"),
        Ok(x) if (1e-3..1e5).contains(&x.abs()) => {
            #[expect(clippy::cast_possible_truncation, reason = "from 0 to 5")]
            let decimals = (2 - x.abs().log10().floor() as i32).max(0) as usize;
            format!("{x:.decimals$}")
        }
        Ok(x) => format!("{x:.1e}"),
        Err(_) => cell.to_owned(),
    }
}

/// Formats a number with seven significant digits.
pub fn number(x: f64) -> String {
    if x.is_nan() { "NaN".to_owned() } else { format!("{:e}", format!("{x:.6e}").parse::<f64>().unwrap_or(x)) }
}
