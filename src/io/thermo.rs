//! The table of measurements at regular times, `thermo.csv`.
//!
//! Names of columns are identifiers; their units are in `summary.json`. Columns that do not apply to a scene
//! are absent. Unknown values, such as a rate at the start of a stage, are empty cells. The last column names
//! the stage: the stages of the scene, with `a equilibration` before the measurement of a stage `a`, then
//! `equilibration` and `measurement`.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::number::{Cell, quoted};
use crate::analysis::observables::{ApplicableObservables, Row};
use crate::base::numbers::trunc_to_usize;
use crate::base::text;
use crate::model::{RunPlan, Scene};
use crate::run::Stage;

/// Column of a table: its name and unit.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// The name, an identifier.
    pub name: String,
    /// The unit, in powers of length, time, mass and energy; 1 for numbers, empty for words.
    pub unit: String,
}

impl Column {
    pub(super) fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned() }
    }
}

/// A quantity of a row: whether it applies to the scene, its name, its unit, and its value.
type Quantity = (bool, &'static str, &'static str, fn(&Row) -> Option<f64>);

/// The columns of a scene.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    applicable: ApplicableObservables,
    /// Whether anything acts from outside.
    is_driven: bool,
    regions: Vec<String>,
    /// The stages, which have names.
    plan: RunPlan,
}

impl Columns {
    /// Columns of a scene from its start on.
    pub fn of(scene: &Scene) -> Self {
        Self::with(scene, ApplicableObservables::of(scene))
    }

    /// Columns of a continued run, whose scene may no longer contain particles.
    pub fn with(scene: &Scene, applicable: ApplicableObservables) -> Self {
        let regions = scene.output.regions.iter().map(|region| region.name.clone()).collect();
        Self { applicable, is_driven: scene.is_driven(), regions, plan: scene.run.clone() }
    }

    /// The first line.
    pub fn header(&self) -> String {
        let names: Vec<String> = self.columns().into_iter().map(|column| column.name).collect();
        names.join(",") + "\n"
    }

    /// The names of the columns, which are identifiers, and their units.
    pub fn columns(&self) -> Vec<Column> {
        let dimensions = trunc_to_usize(self.applicable.dimensions);
        let mut columns = vec![Column::new("time", "time"), Column::new("events", "1")];
        for (has, name, unit, _) in self.quantities() {
            columns.extend(has.then(|| Column::new(name, &text::unit(unit, dimensions))));
        }
        let regions: Vec<String> = self.regions.iter().map(|region| format!("in {region}")).collect();
        let names = text::identifiers(regions.iter().map(String::as_str));
        columns.extend(names.iter().map(|name| Column::new(name, "1")));
        columns.push(Column::new("stage", ""));
        columns
    }

    /// The quantities of a row, in the order of their columns.
    fn quantities(&self) -> [Quantity; 9] {
        let applicable = &self.applicable;
        [
            (applicable.has_temperature, "temperature", "energy", |row| row.temperature),
            (true, "kinetic", "energy", |row| Some(row.kinetic)),
            (true, "potential", "energy", |row| Some(row.potential)),
            (true, "energy_and_dissipated", "energy", |row| Some(row.ledger)),
            (self.is_driven, "supplied", "energy", |row| Some(row.supplied)),
            (applicable.has_pressure, "pressure", "energy / length^D", |row| row.pressure),
            (applicable.has_core, "collision_rate", "1 / time", |row| row.collision_rate),
            (self.plan.has_barostat(), "volume", "length^D", |row| row.volume),
            (applicable.has_height(), "height", "length", |row| row.height),
        ]
    }

    /// A line of measurements.
    pub fn line(&self, stage: Stage, row: &Row) -> String {
        let mut line = format!("{},{}", Cell(Some(row.time)), row.events);
        for (has, .., of) in self.quantities() {
            if has {
                // Writing to a string cannot fail.
                let _ = write!(line, ",{}", Cell(of(row)));
            }
        }
        for count in &row.counts {
            let _ = write!(line, ",{count}");
        }
        line.push(',');
        line.push_str(&quoted(&stage.name(&self.plan)));
        line.push('\n');
        line
    }
}
