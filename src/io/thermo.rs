//! The table of measurements at even times, `thermo.csv`.
//!
//! Columns have a name and a unit in brackets. A column that means nothing for a scene is absent; a cell that cannot be
//! known, as a rate at the start of a stage, is empty. The last column names the stage: those of the scene, where `a equilibration` comes
//! before the measurement of the stage `a`, then `equilibration` and `measurement`.

use std::fmt::Write;

use super::number::Cell;
use super::number::quoted;
use crate::analysis::observables::{ApplicableObservables, Row};
use crate::base::numbers::trunc_to_usize;
use crate::base::text;
use crate::model::{RunPlan, Scene};
use crate::run::Stage;

/// Which columns a scene has.
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
    /// Those of a scene from its start on.
    pub fn of(scene: &Scene) -> Self {
        Self::with(scene, ApplicableObservables::of(scene))
    }

    /// Those of a run that goes on: its scene may have no particles any more.
    pub fn with(scene: &Scene, applicable: ApplicableObservables) -> Self {
        let regions = scene.output.regions.iter().map(|region| region.name.clone()).collect();
        Self { applicable, is_driven: scene.is_driven(), regions, plan: scene.run.clone() }
    }

    /// The first line.
    pub fn header(&self) -> String {
        let mut line = "time [time],events [1]".to_owned();
        let applicable = &self.applicable;
        let pressure = format!(",{}", text::unit("pressure [energy/length^D]", trunc_to_usize(applicable.dimensions)));
        for (has, column) in [
            (applicable.has_temperature, ",temperature [energy]"),
            (true, ",kinetic [energy],potential [energy],energy_and_dissipated [energy]"),
            (self.is_driven, ",supplied [energy]"),
            (applicable.has_pressure, pressure.as_str()),
            (applicable.has_core, ",collision_rate [1/time]"),
            (applicable.has_height(), ",height [length]"),
        ] {
            line.push_str(if has { column } else { "" });
        }
        for region in &self.regions {
            line.push_str(",in ");
            line.push_str(region);
            line.push_str(" [1]");
        }
        line.push_str(",stage\n");
        line
    }

    /// A line of measurements.
    pub fn line(&self, stage: Stage, row: &Row) -> String {
        let mut line = format!("{},{}", Cell(Some(row.time)), row.events);
        let applicable = &self.applicable;
        for (has, cell) in [
            (applicable.has_temperature, row.temperature),
            (true, Some(row.kinetic)),
            (true, Some(row.potential)),
            (true, Some(row.ledger)),
            (self.is_driven, Some(row.supplied)),
            (applicable.has_pressure, row.pressure),
            (applicable.has_core, row.collision_rate),
            (applicable.has_height(), row.height),
        ] {
            if has {
                // Writing to a string cannot fail.
                let _ = write!(line, ",{}", Cell(cell));
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
