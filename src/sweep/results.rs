//! The results of all runs of a sweep, and their means over seeds.

use std::collections::BTreeMap;

use super::folder::SweepFolder;
use super::plan::{Point, Sweep};
use crate::analysis::instruments::Measured;
use crate::analysis::published::PublishedValue;
use crate::analysis::statistics::{Estimate, ROUNDING};
use crate::io::summary::{Observable, beside_instruments};
use crate::io::{FolderState, Measurements, Summary};
use crate::model::run_plan::MEASUREMENT;

/// First quantities in tables, in this order. The density is measured only with a barostat.
const FIRST: [&str; 10] = [
    "number_density",
    "compressibility_factor",
    "pressure",
    "potential_energy_per_particle",
    "core_rate",
    "collision_rate",
    "diffusion_coefficient",
    "diffusion_coefficient_infinite",
    "shear_viscosity",
    "thermal_conductivity",
];
const LAST: [&str; 7] =
    ["temperature", "pressure_xx", "pressure_yy", "pressure_zz", "pressure_xy", "pressure_xz", "pressure_yz"];

fn rank(name: &str, has_stages: bool) -> usize {
    if has_stages && name == "temperature" {
        return 0;
    }
    let place = |names: &[&str]| names.iter().position(|known| *known == name);
    1 + place(&FIRST).or_else(|| place(&LAST).map(|at| FIRST.len() + 1 + at)).unwrap_or(FIRST.len())
}

/// A quantity that at least one run of a sweep has measured.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredQuantity {
    /// Name of an observable, or of an instrument's number.
    pub name: String,
    /// Name for display.
    pub title: String,
    /// Unit of the quantity; `1` for a pure number.
    pub unit: String,
}

/// Mean over the runs of a state point, which have different seeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pooled {
    /// Mean over the runs, with equal weights. Its standard error is `sqrt(sum e_i^2) / n` from the errors `e_i` of the
    /// `n` runs; `None` if an error of a run is unknown.
    pub estimate: Estimate,
    /// Standard error of the mean from the scatter of the values `x_i` of the `n` runs,
    /// `sqrt(sum (x_i - mean)^2 / (n (n - 1)))`; 0 if the scatter is round-off, `None` for a single run.
    pub scatter: Option<f64>,
    /// Number of runs with a value. Short runs may have no value.
    pub runs: usize,
}

/// Status of the run of a point.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum Standing {
    /// The run has ended without problems.
    Done,
    /// The run failed, for the given reason.
    Failed(String),
    /// The run has started but not ended.
    Begun,
    /// The run has not started.
    Missing,
}

/// Status and results of a point.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct PointResult {
    /// Status of the run.
    pub standing: Standing,
    /// Results of the measured stages, then of the last measurement; empty if there are none yet.
    pub measurements: Vec<StageResult>,
}

/// Results of one measurement of a run.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StageResult {
    /// Name of the measured stage; `measurement` for the last measurement.
    pub stage: String,
    /// Simulated time of the measurement.
    pub duration: Option<f64>,
    /// Number of physical events.
    pub events: u64,
    /// Measured values, in the order of [`Results::quantities`].
    pub values: Vec<Option<Estimate>>,
    /// Published values for the simulated system.
    pub published: Vec<PublishedValue>,
}

/// The runs of a state point.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Group {
    /// Indices of the points of the group in [`Sweep::points`].
    pub places: Vec<usize>,
    /// Number of completed runs that repeat another run bit for bit. Repeated runs do not count in the means. Without a
    /// random start or a heat bath, all runs of the group are identical.
    pub repeats: usize,
    /// Means of the measured stages, then of the last measurement.
    pub measurements: Vec<StageMeans>,
}

/// Means of a measurement over the runs of a state point.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct StageMeans {
    /// Name of the measured stage; `measurement` for the last measurement.
    pub stage: String,
    /// Number of completed runs with this measurement. Repeated runs do not count.
    pub runs: usize,
    /// Means, in the order of [`Results::quantities`].
    pub values: Vec<Option<Pooled>>,
    /// Published values, each averaged over the runs.
    pub published: Vec<PublishedValue>,
}

/// Results of the runs in the folder of a sweep.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Results {
    /// Measured quantities, the most important ones first.
    pub quantities: Vec<MeasuredQuantity>,
    /// Names of the measured stages of all runs, then `measurement` for the last measurement.
    pub stages: Vec<String>,
    /// Results of each point.
    pub points: Vec<PointResult>,
    /// Runs and means of each state point, in the order of the points.
    pub groups: Vec<Group>,
}

impl Results {
    /// Reads the results so far from the folder of a sweep. Points with unreadable files have failed.
    #[must_use]
    pub fn read(folder: &SweepFolder, sweep: &Sweep) -> Self {
        let mut quantities = Vec::new();
        let mut points: Vec<PointResult> =
            sweep.points().iter().map(|point| result_of(folder, point, &mut quantities)).collect();
        let mut order: Vec<usize> = (0..quantities.len()).collect();
        let stages = stages(&points);
        order.sort_by_key(|at| rank(&quantities[*at].name, stages.len() > 1));
        for measurement in points.iter_mut().flat_map(|point| &mut point.measurements) {
            measurement.values = order.iter().map(|at| measurement.values.get(*at).copied().flatten()).collect();
        }
        let quantities: Vec<MeasuredQuantity> = order.iter().map(|at| quantities[*at].clone()).collect();
        let groups = groups(sweep, &points, &stages, quantities.len());
        Self { quantities, stages, points, groups }
    }

    /// Whether any run has measured stages before its last measurement.
    #[must_use]
    pub fn has_stages(&self) -> bool {
        self.stages.len() > 1
    }

    /// Returns all means, each with its state point.
    pub fn means(&self) -> impl Iterator<Item = (&Group, &StageMeans)> {
        self.groups.iter().flat_map(|group| group.measurements.iter().map(move |means| (group, means)))
    }

    /// Number of completed runs that repeat other runs bit for bit. Repeated runs do not count in the means.
    #[must_use]
    pub fn repeats(&self) -> usize {
        self.groups.iter().map(|group| group.repeats).sum()
    }

    /// Numbers of completed and failed points.
    #[must_use]
    pub fn counts(&self) -> [usize; 2] {
        let count = |is: fn(&Standing) -> bool| self.points.iter().filter(|point| is(&point.standing)).count();
        [count(|standing| *standing == Standing::Done), count(|standing| matches!(standing, Standing::Failed(_)))]
    }
}

fn result_of(folder: &SweepFolder, point: &Point, quantities: &mut Vec<MeasuredQuantity>) -> PointResult {
    let path = folder.of(point);
    let none = |standing| PointResult { standing, measurements: Vec::new() };
    let failure = folder.failure(point);
    match (folder.state_of(point), &failure) {
        (Ok(FolderState::Finished), _) => {}
        (Ok(_), Some(failure)) => return none(Standing::Failed(failure.clone())),
        (Ok(FolderState::Unfinished), None) => return none(Standing::Begun),
        (Ok(FolderState::Nothing), None) => return none(Standing::Missing),
        (Err(error), _) => return none(Standing::Failed(error.to_string())),
    }
    let summary = match Summary::read(&path) {
        Ok(summary) => summary,
        Err(error) => return none(Standing::Failed(format!("its summary.json cannot be read: {error}"))),
    };
    let measured = match Measurements::read(&path) {
        Ok(measurements) => measurements.unwrap_or_default(),
        Err(error) => return none(Standing::Failed(format!("its measurements.json cannot be read: {error}"))),
    };
    let trouble = failure.or_else(|| trouble_of(&summary));
    PointResult {
        standing: trouble.map_or(Standing::Done, Standing::Failed),
        measurements: measurements(summary, &measured, quantities),
    }
}

pub(super) fn trouble_of(summary: &Summary) -> Option<String> {
    let faults = || (!summary.faults.is_empty()).then(|| summary.faults.join("; "));
    summary.trouble.clone().or_else(faults)
}

fn measurements(summary: Summary, measured: &Measurements, quantities: &mut Vec<MeasuredQuantity>) -> Vec<StageResult> {
    let dimensions = summary.system.as_ref().map_or(3, |system| system.dimensions);
    let units = summary.units.clone();
    let unit = |unit: &str| units.of(unit, dimensions);
    let mut placed = |values: Vec<(MeasuredQuantity, Estimate)>| {
        let mut all = Vec::new();
        for (quantity, value) in values {
            let at = quantities.iter().position(|known| known.name == quantity.name).unwrap_or_else(|| {
                quantities.push(quantity);
                quantities.len() - 1
            });
            all.resize(all.len().max(at + 1), None);
            all[at] = Some(value);
        }
        all
    };
    let nothing = Measured::default();
    let of_stage = |name: &str| measured.stages.iter().find(|stage| stage.name == name);
    let mut all: Vec<StageResult> = summary
        .stages
        .into_iter()
        .map(|stage| {
            let measured = of_stage(&stage.name).map_or(&nothing, |stage| &stage.measured);
            StageResult {
                duration: Some(stage.measured.duration),
                events: stage.events.total,
                values: placed(values_of(&stage.observables, &unit, measured)),
                published: stage.published,
                stage: stage.name,
            }
        })
        .collect();
    all.push(StageResult {
        stage: MEASUREMENT.to_owned(),
        duration: summary.measured.map(|measured| measured.duration),
        events: summary.events.total,
        values: placed(values_of(&summary.observables, &unit, &measured.last)),
        published: summary.published,
    });
    all
}

fn stages(points: &[PointResult]) -> Vec<String> {
    let mut stages: Vec<String> = Vec::new();
    for measurement in points.iter().flat_map(|point| &point.measurements) {
        if measurement.stage != MEASUREMENT && !stages.contains(&measurement.stage) {
            stages.push(measurement.stage.clone());
        }
    }
    stages.push(MEASUREMENT.to_owned());
    stages
}

fn values_of(
    observables: &BTreeMap<String, Observable>,
    unit: &dyn Fn(&str) -> String,
    measured: &Measured,
) -> Vec<(MeasuredQuantity, Estimate)> {
    let observables = beside_instruments(observables, measured).filter_map(|(name, unit_of, observable)| {
        let quantity = MeasuredQuantity { name: name.to_owned(), title: name.replace('_', " "), unit: unit(unit_of) };
        Some((quantity, observable.estimate.finite()?))
    });
    let numbers = measured.numbers.iter().filter_map(|number| {
        let (name, title) = (number.name.clone(), number.title.clone());
        let quantity = MeasuredQuantity { name, title, unit: unit(&number.unit) };
        Some((quantity, number.estimate()?.finite()?))
    });
    observables.chain(numbers).collect()
}

fn groups(sweep: &Sweep, points: &[PointResult], stages: &[String], quantities: usize) -> Vec<Group> {
    let mut known: BTreeMap<Vec<&(String, String)>, usize> = BTreeMap::new();
    let mut groups: Vec<Group> = Vec::new();
    for (place, point) in sweep.points().iter().enumerate() {
        let at = *known.entry(point.state_point().collect()).or_insert_with(|| {
            groups.push(Group { places: Vec::new(), repeats: 0, measurements: Vec::new() });
            groups.len() - 1
        });
        groups[at].places.push(place);
    }
    for group in &mut groups {
        let mut done: Vec<&PointResult> = Vec::new();
        for run in group.places.iter().map(|place| &points[*place]).filter(|it| it.standing == Standing::Done) {
            if done.iter().any(|other| other.measurements == run.measurements) {
                group.repeats += 1;
            } else {
                done.push(run);
            }
        }
        let means = stages.iter().map(|stage| means_of(stage, &done, quantities));
        // Without completed runs, the state point has an entry for each stage of the sweep.
        group.measurements = means.filter(|means| means.runs > 0 || done.is_empty()).collect();
    }
    groups
}

fn means_of(stage: &str, runs: &[&PointResult], quantities: usize) -> StageMeans {
    let of_stage =
        || runs.iter().filter_map(|run| run.measurements.iter().find(|measurement| measurement.stage == stage));
    let values = |at: usize| of_stage().filter_map(|measurement| measurement.values[at]).collect::<Vec<Estimate>>();
    StageMeans {
        stage: stage.to_owned(),
        runs: of_stage().count(),
        values: (0..quantities).map(|at| pooled(&values(at))).collect(),
        published: mean_of_published(of_stage().map(|measurement| measurement.published.as_slice())),
    }
}

fn pooled(values: &[Estimate]) -> Option<Pooled> {
    let number = values.len() as f64;
    let mean = values.iter().map(|value| value.mean).sum::<f64>() / number;
    let squares = values.iter().map(|value| value.standard_error.map(|error| error * error)).sum::<Option<f64>>();
    let scatter = values.iter().map(|value| (value.mean - mean) * (value.mean - mean)).sum::<f64>();
    let scatter = (scatter / (number * (number - 1.0))).sqrt();
    // Conserved quantities differ by round-off, which is not scatter.
    let scatter = if scatter <= ROUNDING * mean.abs() { 0.0 } else { scatter };
    mean.is_finite().then(|| Pooled {
        estimate: Estimate { mean, standard_error: squares.map(|sum| sum.sqrt() / number) },
        runs: values.len(),
        scatter: (values.len() > 1).then_some(scatter),
    })
}

fn mean_of_published<'p>(runs: impl Iterator<Item = &'p [PublishedValue]>) -> Vec<PublishedValue> {
    let mut means: Vec<(PublishedValue, f64)> = Vec::new();
    for value in runs.flatten() {
        match means.iter_mut().find(|(mean, _)| mean.quantity == value.quantity && mean.label == value.label) {
            Some((mean, count)) => {
                mean.value += value.value;
                mean.finite_size += value.finite_size;
                *count += 1.0;
            }
            None => means.push((value.clone(), 1.0)),
        }
    }
    let mean = |(mut mean, count): (PublishedValue, f64)| {
        mean.value /= count;
        mean.finite_size /= count;
        mean
    };
    means.into_iter().map(mean).collect()
}

#[cfg(test)]
mod tests;
