//! Tables of a sweep: `sweep.csv` with a row for each run, `sweep-mean.csv` with means over the seeds for each state
//! point, and `sweep-columns.csv` with the units. Each measured stage has its own row; a column names the stage.
//!
//! A column `x_error` is the standard error of `x`. In `sweep-mean.csv`, `x_error` follows from the errors of the runs,
//! and `x_scatter` from the scatter of their values. These two errors should agree. If some runs have no value of `x`,
//! `x_runs` is the number of runs with a value. Unknown values are empty cells. Numbers that vary inside a list or
//! table have their own columns, such as `size_0`.

use std::path::PathBuf;

use super::error::SweepError;
use super::folder::SweepFolder;
use super::plan::{Point, Sweep};
use super::results::{Results, Standing};
use crate::io::number::Cell;
use crate::io::table::{line, quoted, text_cell};
use crate::model::run_plan::MEASUREMENT;

const RUNS: &str = "sweep.csv";
const MEANS: &str = "sweep-mean.csv";
const COLUMNS: &str = "sweep-columns.csv";

const STAGE: &str = "stage";

impl SweepFolder {
    /// Writes the tables of the results so far. Returns the paths of the tables.
    ///
    /// # Errors
    /// [`SweepError::Output`] if a table cannot be written.
    pub fn write_tables(&self, sweep: &Sweep, results: &Results) -> Result<Vec<PathBuf>, SweepError> {
        let tables = [(RUNS, runs(sweep, results)), (MEANS, means(sweep, results)), (COLUMNS, columns(sweep, results))];
        tables.iter().map(|(name, text)| self.write(name, text)).collect()
    }
}

fn typed(value: &str) -> String {
    text_cell(value.trim_matches(['"', '\'']))
}

fn entry_heads(sweep: &Sweep) -> impl Iterator<Item = String> {
    sweep.entries().into_iter().map(|entry| entry.name().to_owned())
}

fn stage_head(results: &Results) -> impl Iterator<Item = String> {
    results.has_stages().then(|| STAGE.to_owned()).into_iter()
}

fn runs(sweep: &Sweep, results: &Results) -> String {
    let fixed = ["folder", "state"].map(str::to_owned);
    let sizes = ["duration", "events"].map(str::to_owned);
    let names = results.quantities.iter().flat_map(|it| [it.name.clone(), format!("{}_error", it.name)]);
    let heads = fixed
        .into_iter()
        .chain(sweep.short_names())
        .chain(entry_heads(sweep))
        .chain(stage_head(results))
        .chain(sizes)
        .chain(names);
    let mut text = line(heads);
    let entries = sweep.entries();
    let numbers_at = |point: &Point| entries.iter().map(|entry| Cell(entry.of(point)).to_string()).collect::<Vec<_>>();
    for (point, result) in sweep.points().iter().zip(&results.points) {
        let state = match &result.standing {
            Standing::Done => "done".to_owned(),
            Standing::Begun => "begun".to_owned(),
            Standing::Missing => "missing".to_owned(),
            Standing::Failed(why) => quoted(&format!("failed: {why}")),
        };
        let settings = || point.settings().iter().map(|(_, value)| typed(value)).chain(numbers_at(point));
        let run = || [quoted(point.folder()), state.clone()].into_iter().chain(settings());
        for measurement in &result.measurements {
            let stage = results.has_stages().then(|| quoted(&measurement.stage));
            let sizes = [Cell(measurement.duration).to_string(), measurement.events.to_string()];
            let numbers = measurement
                .values
                .iter()
                .flat_map(|value| [value.map(|value| value.mean), value.and_then(|value| value.standard_error)]);
            let values = numbers.map(|number| Cell(number).to_string());
            text += &line(run().chain(stage).chain(sizes).chain(values));
        }
        if result.measurements.is_empty() {
            let cells = usize::from(results.has_stages()) + 2 + 2 * results.quantities.len();
            text += &line(run().chain(std::iter::repeat_n(String::new(), cells)));
        }
    }
    text
}

fn means(sweep: &Sweep, results: &Results) -> String {
    let quantities = || results.quantities.iter();
    let is_partial: Vec<bool> = (0..results.quantities.len()).map(|at| is_partial(results, at)).collect();
    let suffixes = |at: usize| ["", "_error", "_scatter"].into_iter().chain(is_partial[at].then_some("_runs"));
    let names = quantities().enumerate().flat_map(|(at, it)| suffixes(at).map(|suffix| format!("{}{suffix}", it.name)));
    let settings = sweep.state_point_names().into_iter().chain(entry_heads(sweep));
    let mut text = line(settings.chain(stage_head(results)).chain(["runs".to_owned()]).chain(names));
    let entries = sweep.entries();
    for group in &results.groups {
        let Some(point) = group.places.first().and_then(|place| sweep.points().get(*place)) else { continue };
        for means in &group.measurements {
            let numbers = entries.iter().map(|entry| Cell(entry.of(point)).to_string());
            let settings = point.state_point().map(|(_, value)| typed(value)).chain(numbers);
            let stage = results.has_stages().then(|| quoted(&means.stage));
            let values = means.values.iter().zip(&is_partial).flat_map(|(value, is_partial)| {
                let estimate = value.map(|it| it.estimate);
                let error = estimate.and_then(|it| it.standard_error);
                let numbers = [estimate.map(|it| it.mean), error, value.and_then(|it| it.scatter)];
                let runs = is_partial.then(|| value.map_or(0, |it| it.runs).to_string());
                numbers.map(|number| Cell(number).to_string()).into_iter().chain(runs)
            });
            text += &line(settings.chain(stage).chain([means.runs.to_string()]).chain(values));
        }
    }
    text
}

fn is_partial(results: &Results, quantity: usize) -> bool {
    results
        .means()
        .filter_map(|(_, means)| Some((means.values[quantity]?.runs, means.runs)))
        .any(|(known, all)| known < all)
}

fn columns(sweep: &Sweep, results: &Results) -> String {
    let row = |name: &str, unit: &str, meaning: &str| line([name, unit, meaning].map(quoted));
    let mut text = row("column", "unit", "meaning");
    for (name, key) in sweep.short_names().iter().zip(sweep.keys()) {
        text += &row(name, "", &format!("the key {key} of the scene"));
    }
    for entry in sweep.entries() {
        text += &row(entry.name(), "", &format!("an entry of the key {} of the scene", entry.key()));
    }
    if results.has_stages() {
        text += &row(STAGE, "", &format!("the measured stage; {MEASUREMENT} is the last measurement"));
    }
    text += &row("duration", "time", "simulated time of the measurement");
    text += &row("events", "1", "physical events of the measurement");
    for quantity in &results.quantities {
        text += &row(&quantity.name, &quantity.unit, &quantity.title);
    }
    text
}
