//! The table `thermo.csv` of measurements at regular times.
//!
//! Columns without meaning for the scene are absent, and unknown values are empty cells. The units are in
//! `summary.json`. The last column contains the name of the stage. The equilibration of a stage `a` is named `a
//! equilibration`. The last two stages are named `equilibration` and `measurement`.

use serde::{Deserialize, Serialize};

use super::number::Cell;
use super::table::{line, quoted};
use crate::analysis::observables::{ApplicableObservables, Row};
use crate::base::numbers::trunc_to_usize;
use crate::base::text;
use crate::model::{RunPlan, Scene, Units};
use crate::run::Stage;

/// Name and unit of a column of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Column {
    /// Name of the column, an identifier.
    pub name: String,
    /// Unit as powers of length, time, mass and energy; `1` for pure numbers, empty for text.
    pub unit: String,
}

impl Column {
    pub(super) fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned() }
    }
}

/// A column: whether the scene has it, the name, the unit, and a function that reads the value from a row.
type Quantity = (bool, &'static str, &'static str, fn(&Row) -> Option<f64>);

#[derive(Debug, Clone)]
pub(super) struct Columns {
    applicable: ApplicableObservables,
    is_driven: bool,
    regions: Vec<String>,
    plan: RunPlan,
    units: Units,
}

impl Columns {
    pub fn of(scene: &Scene) -> Self {
        Self::with(scene, ApplicableObservables::of(scene))
    }

    /// Returns the columns of a resumed run. The checkpoint contains `applicable`.
    pub fn with(scene: &Scene, applicable: ApplicableObservables) -> Self {
        let regions = scene.output.regions.iter().map(|region| region.name.clone()).collect();
        Self { applicable, is_driven: scene.is_driven(), regions, plan: scene.run.clone(), units: scene.units.clone() }
    }

    pub fn header(&self) -> String {
        line(self.columns().into_iter().map(|column| column.name))
    }

    pub fn columns(&self) -> Vec<Column> {
        let dimensions = trunc_to_usize(self.applicable.dimensions);
        let mut columns = vec![Column::new("time", &self.units.of("time", dimensions)), Column::new("events", "1")];
        for (has, name, unit, _) in self.quantities() {
            columns.extend(has.then(|| Column::new(name, &self.units.of(unit, dimensions))));
        }
        let regions: Vec<String> = self.regions.iter().map(|region| format!("in {region}")).collect();
        let names = text::identifiers(regions.iter().map(String::as_str));
        columns.extend(names.iter().map(|name| Column::new(name, "1")));
        columns.push(Column::new("stage", ""));
        columns
    }

    fn quantities(&self) -> [Quantity; 14] {
        let applicable = &self.applicable;
        [
            (applicable.has_temperature, "temperature", "energy", |row| row.temperature),
            (true, "kinetic", "energy", |row| Some(row.kinetic)),
            (applicable.has_spins, "rotational", "energy", |row| Some(row.rotational)),
            (true, "potential", "energy", |row| Some(row.potential)),
            (true, "energy_and_dissipated", "energy", |row| Some(row.ledger)),
            (self.is_driven, "supplied", "energy", |row| Some(row.supplied)),
            (applicable.has_pressure, "pressure", "energy / length^D", |row| row.pressure),
            (applicable.has_core, "collision_rate", "1 / time", |row| row.collision_rate),
            (self.plan.has_barostat(), "volume", "length^D", |row| row.volume),
            (applicable.has_height(), "height", "length", |row| row.height),
            (applicable.has_flow, "particles", "1", |row| Some(row.flow?[0] as f64)),
            (applicable.has_flow, "entered", "1", |row| Some(row.flow?[1] as f64)),
            (applicable.has_flow, "left", "1", |row| Some(row.flow?[2] as f64)),
            (applicable.has_sleep, "asleep", "1", |row| Some(row.asleep? as f64)),
        ]
    }

    pub fn line(&self, stage: Stage, row: &Row) -> String {
        let mut cells = vec![Cell(Some(row.time)).to_string(), row.events.to_string()];
        cells.extend(self.quantities().iter().filter(|(has, ..)| *has).map(|(.., of)| Cell(of(row)).to_string()));
        cells.extend(row.counts.iter().map(usize::to_string));
        cells.push(quoted(&stage.name(&self.plan)));
        line(cells)
    }
}
