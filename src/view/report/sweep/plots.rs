//! Plots the quantities of a sweep against the varied value. Annealing stages are also plotted against temperature.

use std::fmt::Write;

use super::settings;
use crate::analysis::statistics::Estimate;
use crate::base::text::digits;
use crate::sweep::{Agreement, Entry, Group, MeasuredQuantity, Pooled, Results, StageMeans, Sweep};
use crate::view::report::figures::{capitalised, curves_figure};
use crate::view::report::html::{self, escape, symbols};
use crate::view::report::plot::{Curves, Line, LineStyle, Point as Dot, deviations, extent};
use crate::view::report::stages::{TEMPERATURE, is_long, is_spread};

/// The axis is logarithmic if the ratio of the largest to the smallest value exceeds this number.
const LONG: f64 = 50.0;

/// Largest relative difference of equal values.
const SAME: f64 = 1e-9;

/// The varied number on the horizontal axis.
pub(super) struct Horizontal {
    entry: Entry,
    /// Index of the sweep axis that sets this number.
    axis: Option<usize>,
    pub is_logarithmic: bool,
}

impl Horizontal {
    pub fn title(&self) -> String {
        symbols(&self.entry.name().replace('_', " "))
    }

    pub fn of(&self, sweep: &Sweep, group: &Group) -> Option<f64> {
        self.entry.of(sweep.points().get(*group.places.first()?)?)
    }

    /// Returns the settings of a state point as `name = value`, except settings that vary along the horizontal axis.
    pub fn others(&self, sweep: &Sweep, settings: &[(String, &str)]) -> Vec<String> {
        let others = settings.iter().zip(sweep.state_point_axes()).filter(|(_, axis)| self.axis != Some(*axis));
        others.map(|((name, value), _)| format!("{name} = {value}")).collect()
    }
}

/// A line in a plot. The points are state points that differ only in the horizontal value, or stages of a state point.
#[derive(Clone)]
struct Series<'r> {
    label: String,
    /// Sorted by the horizontal value.
    points: Vec<(f64, &'r StageMeans)>,
}

struct Along {
    title: String,
    is_logarithmic: bool,
    words: &'static str,
}

/// Chooses the number on the horizontal axis from the first key with varying numbers. If a key has several numbers,
/// prefers a number that differs between all values of the key.
pub(super) fn horizontal(sweep: &Sweep) -> Option<Horizontal> {
    let all = sweep.numbers();
    let values = |entry: &Entry| sweep.points().iter().filter_map(|point| entry.of(point)).collect::<Vec<f64>>();
    let texts = |entry: &Entry| {
        let of_key = sweep.points().iter().flat_map(|point| point.settings()).filter(|(key, _)| key == entry.key());
        distinct(of_key.map(|(_, value)| value.clone()).collect())
    };
    let tells_apart = |entry: &&Entry| distinct(values(entry).iter().map(|x| x.to_bits()).collect()) == texts(entry);
    let first = all.first()?;
    let entry = all.iter().filter(|entry| entry.key() == first.key()).find(tells_apart).unwrap_or(first);
    let [least, most] = extent(values(entry).into_iter())?;
    let axis = sweep.axes().iter().position(|axis| axis.keys().iter().any(|key| key == entry.key()));
    Some(Horizontal { entry: entry.clone(), axis, is_logarithmic: least > 0.0 && most / least > LONG })
}

fn distinct<T: Ord>(mut all: Vec<T>) -> usize {
    all.sort_unstable();
    all.dedup();
    all.len()
}

fn series<'r>(sweep: &Sweep, results: &'r Results, along: &Horizontal) -> Vec<Series<'r>> {
    let mut all: Vec<Series<'r>> = Vec::new();
    for group in &results.groups {
        let Some(x) = along.of(sweep, group) else { continue };
        let others = along.others(sweep, &settings(sweep, group));
        for means in &group.measurements {
            let stage = results.has_stages().then(|| means.stage.clone());
            let label = stage.into_iter().chain(others.iter().cloned()).collect::<Vec<_>>().join(", ");
            match all.iter_mut().find(|series| series.label == label) {
                Some(series) => series.points.push((x, means)),
                None => all.push(Series { label, points: vec![(x, means)] }),
            }
        }
    }
    ascending(all)
}

/// Returns a line for each state point whose stages differ in temperature. Each stage is a point.
fn stages<'r>(sweep: &Sweep, results: &'r Results) -> Vec<Series<'r>> {
    let Some(at) = results.quantities.iter().position(|it| it.name == TEMPERATURE) else { return Vec::new() };
    let of_group = |group: &'r Group| {
        let words = settings(sweep, group).into_iter().map(|(name, value)| format!("{name} = {value}"));
        let points = group.measurements.iter().filter_map(|means| Some((means.values[at]?.estimate.mean, means)));
        Series { label: words.collect::<Vec<_>>().join(", "), points: points.collect() }
    };
    let is_annealed = |series: &Series<'_>| is_spread(series.points.iter().map(|(temperature, _)| *temperature));
    ascending(results.groups.iter().map(of_group).filter(is_annealed).collect())
}

fn ascending(mut all: Vec<Series<'_>>) -> Vec<Series<'_>> {
    for series in &mut all {
        series.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    all
}

pub(super) fn section(sweep: &Sweep, results: &Results) -> String {
    let (figures, constants) = match horizontal(sweep) {
        Some(along) => {
            let series = series(sweep, results, &along);
            let (title, is_logarithmic) = (along.title(), along.is_logarithmic);
            figures(results, &Along { title, is_logarithmic, words: "" }, &series, None)
        }
        None => (String::new(), Vec::new()),
    };
    let stages = stages(sweep, results);
    let of_stages = if stages.is_empty() {
        String::new()
    } else {
        let temperatures = stages.iter().flat_map(|series| series.points.iter().map(|(temperature, _)| *temperature));
        let is_logarithmic = is_long(temperatures);
        let known = results.quantities.iter().find(|it| it.name == TEMPERATURE);
        let unit = known.map_or("energy", |it| it.unit.as_str());
        let title = html::quantity(TEMPERATURE, unit);
        let words = "Each point is a measured stage at its mean temperature. ";
        let (figures, _) = self::figures(results, &Along { title, is_logarithmic, words }, &stages, Some(TEMPERATURE));
        format!("<h3>Measured stages against their temperature</h3>\n<div class=\"plots\">\n{figures}</div>\n")
    };
    if figures.is_empty() && of_stages.is_empty() {
        let why = match horizontal(sweep) {
            None => "No varied key has more than one numeric value, so there is nothing to plot against.",
            Some(_) => "Nothing has been measured yet.",
        };
        return format!("<p>{why}</p>\n");
    }
    let constants = match constants.as_slice() {
        [] => String::new(),
        all => format!("<p class=\"aside\">The same at all points: {}.</p>\n", escape(&all.join(", "))),
    };
    format!("<div class=\"plots\">\n{figures}</div>\n{of_stages}{constants}")
}

/// Returns the figures of all quantities except `but`, and the values of constant quantities as text.
fn figures(results: &Results, along: &Along, series: &[Series<'_>], but: Option<&str>) -> (String, Vec<String>) {
    let (mut constants, mut figures) = (Vec::new(), String::new());
    for (at, quantity) in results.quantities.iter().enumerate().filter(|(_, it)| but != Some(it.name.as_str())) {
        match constant(results, at) {
            Some(mean) => constants.push(format!("{} = {}", symbols(&quantity.title), digits(mean))),
            None => figures.extend(quantity_figure(results, at, along, series)),
        }
    }
    (figures, constants)
}

fn constant(results: &Results, at: usize) -> Option<f64> {
    let means = || results.means().filter_map(|(_, means)| means.values[at].map(|it| it.estimate.mean));
    let [least, most] = extent(means())?;
    (means().count() > 1 && most - least <= SAME * least.abs().max(most.abs())).then_some(least)
}

fn quantity_figure(results: &Results, at: usize, along: &Along, series: &[Series<'_>]) -> Option<String> {
    let quantity = &results.quantities[at];
    let (mut lines, mut text) = (Vec::new(), along.words.to_owned());
    for one in series {
        let dot = |(x, means): &(f64, &StageMeans)| {
            let Pooled { estimate: Estimate { mean, standard_error }, scatter, .. } = means.values[at]?;
            Some(Dot { x: *x, y: mean, error: standard_error.or(scatter).unwrap_or(0.0) })
        };
        let label = if one.label.is_empty() { "measured".to_owned() } else { symbols(&one.label) };
        let points: Vec<Option<Dot>> = one.points.iter().map(dot).collect();
        let known = published(quantity, std::slice::from_ref(one));
        let deviations = known.first().map_or_else(Vec::new, |(_, _, known)| deviations(&points, known));
        lines.push(Line { label, points, deviations, ..Line::default() });
    }
    for (label, source, points) in published(quantity, series) {
        if lines.iter().all(|line: &Line| line.label != label) {
            let agreement = agreement(results, at, &label).unwrap_or_default();
            let _ = write!(text, "{}: {}. {agreement}", escape(&label), escape(&source));
        }
        lines.push(Line { style: LineStyle::Published, label, points, ..Line::default() });
    }
    text.push_str("Error bars: standard errors of the runs, pooled over seeds. From <code>sweep-mean.csv</code>.");
    let title = capitalised(&quantity.title);
    let titles = [along.title.clone(), html::quantity(&quantity.title, &quantity.unit)];
    let is_logarithmic = [along.is_logarithmic, false];
    curves_figure(&title, &Curves { label: title.clone(), titles, is_logarithmic, lines, ..Curves::default() }, &text)
}

/// Returns the label, the source and the points of the published values of a quantity, for the system sizes of the runs. Equal
/// series are listed once.
fn published(quantity: &MeasuredQuantity, series: &[Series<'_>]) -> Vec<(String, String, Vec<Option<Dot>>)> {
    let mut all: Vec<(String, String, Vec<Option<Dot>>)> = Vec::new();
    for one in series {
        let mut labels: Vec<(String, String)> = Vec::new();
        for (_, means) in &one.points {
            for known in means.published.iter().filter(|it| it.quantity == quantity.name) {
                if labels.iter().all(|(label, _)| *label != known.label) {
                    labels.push((known.label.clone(), known.source.clone()));
                }
            }
        }
        for (label, source) in labels {
            let points: Vec<Option<Dot>> = one
                .points
                .iter()
                .map(|(x, means)| {
                    let known = means.published.iter().find(|it| it.quantity == quantity.name && it.label == label)?;
                    Some(Dot { x: *x, y: known.at_size(), error: 0.0 })
                })
                .collect();
            if all.iter().all(|(known, _, other)| *known != label || !are_same(other, &points)) {
                all.push((label, source, points));
            }
        }
    }
    all
}

fn are_same(one: &[Option<Dot>], other: &[Option<Dot>]) -> bool {
    let is_near = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    one.len() == other.len()
        && one.iter().zip(other).all(|pair| match pair {
            (Some(a), Some(b)) => a.x == b.x && is_near(a.y, b.y),
            (a, b) => a.is_none() && b.is_none(),
        })
}

/// Describes the deviation from published values by chi-squared. If published values depend on the system size,
/// chi-squared for infinite systems is added.
fn agreement(results: &Results, at: usize, label: &str) -> Option<String> {
    let agreement: Agreement = results.agreements(at).into_iter().find(|it| it.label == label)?;
    let Agreement { chi_square, without_size, freedom, .. } = agreement;
    let size = without_size
        .map(|_| "Drawn with the finite-size correction for the particle number of the runs, to first order. ");
    let without = without_size.map(|without| format!(", {} without the size", digits(without)));
    let chi_square = digits(chi_square);
    Some(format!(
        "{}χ² = {chi_square} for {freedom} degrees of freedom{}{}. ",
        size.unwrap_or_default(),
        without.unwrap_or_default(),
        agreement.left_out()
    ))
}

#[cfg(test)]
mod tests;
