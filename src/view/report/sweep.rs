//! The page of a sweep: every quantity against the value that varies, with what is published beside, and the state of all runs.

mod curves;
mod pages;

use std::fmt::Write;
use std::path::Path;

use super::figures::{capitalised, curves_figure};
use super::html::{self, cell, escape, symbols};
use super::plot::{Curves, Line, LineStyle, Point as Dot, deviations, extent};
use super::results::value;
use super::{Page, shell};
use crate::base::text::digits;
use crate::io::SMALL_PAGE;
use crate::sweep::{Group, MeasuredQuantity, Point, Results, StageMeans, Standing, Sweep, SweepFolder};

pub use pages::{run_page_in, write_run_pages};

/// Values that span a larger ratio have a logarithmic axis.
const LONG: f64 = 50.0;

/// Of fewer state points, the mean square of the deviations says nothing.
const FEWEST: usize = 2;

/// Largest relative difference of a conserved quantity between points.
const SAME: f64 = 1e-9;

/// Rows that a table shows; the others are in the files.
const MOST_ROWS: usize = 500;

/// MeasuredQuantity along the horizontal axis.
struct Horizontal {
    /// Its place among the keys of a state point.
    at: usize,
    name: String,
    is_logarithmic: bool,
}

impl Horizontal {
    /// The other values of a state point, in words. What changes together with the value along the axis tells no series from another.
    fn others(&self, sweep: &Sweep, settings: &[(String, &str)]) -> Vec<String> {
        let axes = sweep.state_point_axes();
        let others = settings.iter().zip(&axes).filter(|(_, axis)| axes.get(self.at) != Some(*axis));
        others.map(|((name, value), _)| format!("{name} = {value}")).collect()
    }
}

/// State points along the horizontal axis that have all other values and the measured stage in common.
#[derive(Clone)]
struct Series<'r> {
    /// The stage, if there are several, and the other values, in words.
    label: String,
    /// In ascending order.
    points: Vec<(f64, &'r StageMeans)>,
}

/// Makes the page of a sweep from its results.
#[must_use]
pub fn sweep_page(folder: &SweepFolder, sweep: &Sweep, results: &Results) -> Page {
    let name = folder.path().file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let [done, failed] = results.counts();
    let total = results.points.len();
    let verdict = if failed > 0 {
        format!("<span class=\"verdict failed\">✗ {failed} of {total} runs failed</span>")
    } else if done == total {
        format!("<span class=\"verdict sound\">✓ {total} runs</span>")
    } else {
        format!("<span class=\"verdict failed\">{done} of {total} runs so far</span>")
    };
    let heading = format!(
        "<h1>{} {verdict}</h1>\n<p class=\"facts\">sweep of {} · {} · carom {}</p>\n",
        escape(&name),
        escape(&sweep.scene().file_name().unwrap_or_default().to_string_lossy()),
        escape(&sweep.short_names().join(", ")),
        env!("CARGO_PKG_VERSION"),
    );
    let mut sections = vec![
        ("plots", "Plots", plots(sweep, results)),
        ("means", "Means", means(sweep, results)),
        ("runs", "Runs", runs(folder, sweep, results)),
        ("axes", "What varies", axes(sweep)),
    ];
    let functions = horizontal(sweep, results).map(|along| curves::section(folder, sweep, results, &along));
    if let Some(functions) = functions.filter(|functions| !functions.is_empty()) {
        sections.insert(1, ("functions", "Measured functions", functions));
    }
    Page { html: shell(&name, &heading, "", &sections), notes: Vec::new() }
}

/// The settings of a state point with the short names of their keys.
fn settings<'s>(sweep: &'s Sweep, group: &Group) -> Vec<(String, &'s str)> {
    let point = group.places.first().and_then(|place| sweep.points().get(*place));
    let values = point.into_iter().flat_map(Point::state_point).map(|(_, value)| value.as_str());
    sweep.state_point_names().into_iter().zip(values).collect()
}

/// The first key whose values are all numbers, and not all the same.
fn horizontal(sweep: &Sweep, results: &Results) -> Option<Horizontal> {
    let all: Vec<Vec<(String, &str)>> = results.groups.iter().map(|group| settings(sweep, group)).collect();
    let keys = all.first()?.len();
    (0..keys).find_map(|at| {
        let numbers: Option<Vec<f64>> =
            all.iter().map(|it| it[at].1.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let [least, most] = extent(numbers?.into_iter())?;
        let is_logarithmic = least > 0.0 && most / least > LONG;
        (most > least).then(|| Horizontal { at, name: all[0][at].0.clone(), is_logarithmic })
    })
}

fn series<'r>(sweep: &Sweep, results: &'r Results, along: &Horizontal) -> Vec<Series<'r>> {
    let mut all: Vec<Series<'r>> = Vec::new();
    for group in &results.groups {
        let settings = settings(sweep, group);
        let Ok(x) = settings[along.at].1.parse() else { continue };
        let others = along.others(sweep, &settings);
        for means in &group.measurements {
            let stage = results.has_stages().then(|| means.stage.clone());
            let label = stage.into_iter().chain(others.iter().cloned()).collect::<Vec<_>>().join(", ");
            match all.iter_mut().find(|series| series.label == label) {
                Some(series) => series.points.push((x, means)),
                None => all.push(Series { label, points: vec![(x, means)] }),
            }
        }
    }
    for series in &mut all {
        series.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    all
}

fn plots(sweep: &Sweep, results: &Results) -> String {
    let Some(along) = horizontal(sweep, results) else {
        return "<p>No value that varies is a number with more than one value: there is nothing to plot against.</p>\n"
            .to_owned();
    };
    let series = series(sweep, results, &along);
    let mut constants = Vec::new();
    let mut figures = String::new();
    for (at, quantity) in results.quantities.iter().enumerate() {
        match constant(results, at) {
            Some(mean) => constants.push(format!("{} = {}", symbols(&quantity.title), digits(mean))),
            None => figures.extend(quantity_figure(quantity, at, &along, &series)),
        }
    }
    let constants = match constants.as_slice() {
        [] => String::new(),
        all => format!("<p class=\"aside\">The same at all points: {}.</p>\n", escape(&all.join(", "))),
    };
    if figures.is_empty() {
        return "<p>Nothing has been measured yet.</p>\n".to_owned();
    }
    format!("<div class=\"plots\">\n{figures}</div>\n{constants}")
}

/// The mean that a quantity has at all points, but for rounding.
fn constant(results: &Results, at: usize) -> Option<f64> {
    let means = || results.means().filter_map(|(_, means)| means.values[at].map(|value| value.mean));
    let [least, most] = extent(means())?;
    (means().count() > 1 && most - least <= SAME * least.abs().max(most.abs())).then_some(least)
}

fn quantity_figure(
    quantity: &MeasuredQuantity,
    at: usize,
    along: &Horizontal,
    series: &[Series<'_>],
) -> Option<String> {
    let (mut lines, mut text) = (Vec::new(), String::new());
    for one in series {
        let dot = |(x, means): &(f64, &StageMeans)| {
            means.values[at].map(|it| Dot { x: *x, y: it.mean, error: it.error.or(it.scatter).unwrap_or(0.0) })
        };
        let label = if one.label.is_empty() { "measured".to_owned() } else { symbols(&one.label) };
        let points: Vec<Option<Dot>> = one.points.iter().map(dot).collect();
        let known = published(quantity, std::slice::from_ref(one));
        let deviations = known.first().map_or_else(Vec::new, |(_, _, known)| deviations(&points, known));
        lines.push(Line { label, points, deviations, ..Line::default() });
    }
    for (label, source, points) in published(quantity, series) {
        let _ = write!(text, "{}: {}. ", escape(&label), escape(&source));
        if let Some((chi, count)) = chi_square(quantity, at, series, &label) {
            let _ = write!(text, "χ² per point {chi:.2} ({count} points). ");
        }
        lines.push(Line { style: LineStyle::Published, label, points, ..Line::default() });
    }
    text.push_str("Error bars: standard errors of the runs, pooled over seeds. From <code>sweep-mean.csv</code>.");
    let title = capitalised(&quantity.title);
    let titles = [symbols(&along.name.replace('_', " ")), html::quantity(&quantity.title, &quantity.unit)];
    let is_logarithmic = [along.is_logarithmic, false];
    curves_figure(&title, &Curves { label: title.clone(), titles, is_logarithmic, lines, ..Curves::default() }, &text)
}

/// Published values of a quantity along the axis, by label: with their source and points, once where several series have the same.
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
                    Some(Dot { x: *x, y: known.value, error: 0.0 })
                })
                .collect();
            if all.iter().all(|(known, _, other)| *known != label || !are_same(other, &points)) {
                all.push((label, source, points));
            }
        }
    }
    all
}

/// Whether two curves are the same but for rounding, as that of the edge of the box in a density.
fn are_same(one: &[Option<Dot>], other: &[Option<Dot>]) -> bool {
    let is_near = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
    one.len() == other.len()
        && one.iter().zip(other).all(|pair| match pair {
            (Some(a), Some(b)) => a.x == b.x && is_near(a.y, b.y),
            (a, b) => a.is_none() && b.is_none(),
        })
}

/// The mean square of the deviations from what is published over their standard errors, and the number of state points that have both.
fn chi_square(quantity: &MeasuredQuantity, at: usize, series: &[Series<'_>], label: &str) -> Option<(f64, usize)> {
    let all = series.iter().flat_map(|one| one.points.iter().map(|(_, means)| *means));
    let squares: Vec<f64> = all
        .filter_map(|means| {
            let known = means.published.iter().find(|it| it.quantity == quantity.name && it.label == label)?;
            let measured = means.values[at]?;
            let error = measured.error.filter(|error| *error > 0.0)?;
            let deviation = (measured.mean - known.value) / error;
            Some(deviation * deviation)
        })
        .collect();
    (squares.len() >= FEWEST).then(|| (squares.iter().sum::<f64>() / squares.len() as f64, squares.len()))
}

/// Head of a column: its class and its words.
type Head = (&'static str, String);

fn table(caption: &str, heads: &[Head], rows: &[String]) -> String {
    let more = match rows.len().saturating_sub(MOST_ROWS) {
        0 => String::new(),
        more => format!("<p class=\"aside\">And {more} more in the files.</p>\n"),
    };
    let rows: String = rows.iter().take(MOST_ROWS).map(String::as_str).collect();
    html::table("results", caption, heads.iter().map(|(class, head)| (*class, escape(head))), &rows) + &more
}

fn means(sweep: &Sweep, results: &Results) -> String {
    let Some(first) = results.groups.first() else { return String::new() };
    let keys = settings(sweep, first).into_iter().map(|(name, _)| name.replace('_', " "));
    let keys = keys.chain(results.has_stages().then(|| "stage".to_owned()));
    let of = |it: &MeasuredQuantity| html::quantity(&it.title, &it.unit);
    let values = std::iter::once("runs".to_owned()).chain(results.quantities.iter().map(of));
    let heads: Vec<Head> = keys.map(|key| ("", key)).chain(values.map(|value| ("n", value))).collect();
    let row = |group: &Group, means: &StageMeans| {
        let settings = settings(sweep, group);
        let stage = results.has_stages().then_some(means.stage.as_str());
        let of_row = settings.iter().map(|(_, value)| *value).chain(stage);
        let keys: String =
            heads.iter().zip(of_row).map(|((_, head), value)| cell("th", "", head, &escape(value))).collect();
        let shown = |it: &Option<crate::sweep::Pooled>| match it {
            None => String::new(),
            Some(it) => {
                let scatter = it.scatter.map_or_else(String::new, |scatter| {
                    format!("<br><small>scatter ± {}</small>", escape(&html::number(&digits(scatter))))
                });
                let of = (it.runs < means.runs).then(|| format!("<br><small>of {} runs</small>", it.runs));
                format!("{}{scatter}{}", value(Some(it.mean), it.error), of.unwrap_or_default())
            }
        };
        let cells = std::iter::once(means.runs.to_string()).chain(means.values.iter().map(shown));
        let first = heads.len() - 1 - means.values.len();
        let values: String =
            heads[first..].iter().zip(cells).map(|((_, head), it)| cell("td", "n", head, &it)).collect();
        format!("<tr>{keys}{values}</tr>\n")
    };
    let rows: Vec<String> = results.means().map(|(group, means)| row(group, means)).collect();
    table("Means over seeds, with the standard error of the runs and that of their scatter", &heads, &rows)
        + "<p class=\"aside\">The two errors should agree: where the scatter is much larger, the runs are too short for their own errors. \
           The same numbers are in <code>sweep-mean.csv</code>, those of each run in <code>sweep.csv</code>.</p>\n"
}

fn runs(folder: &SweepFolder, sweep: &Sweep, results: &Results) -> String {
    let keys = sweep.short_names().into_iter().map(|name| name.replace('_', " "));
    let last = [("", "state".to_owned()), ("n", "events".to_owned())];
    let heads: Vec<Head> = [("", "run".to_owned())].into_iter().chain(keys.map(|key| ("n", key))).chain(last).collect();
    let rows: Vec<String> = sweep
        .points()
        .iter()
        .zip(&results.points)
        .map(|(point, result)| {
            let state = match &result.standing {
                Standing::Done => "done".to_owned(),
                Standing::Begun => "begun".to_owned(),
                Standing::Missing => "not begun".to_owned(),
                Standing::Failed(why) => format!("<span class=\"verdict failed\">failed</span> {}", escape(why)),
            };
            // What has no page is a folder all the same.
            let page = if run_page_in(&folder.of(point)).is_file() { SMALL_PAGE } else { "" };
            let folder = escape(point.folder());
            let keys = heads.iter().skip(1).zip(point.settings());
            let keys: String = keys.map(|((_, head), (_, value))| cell("td", "n", head, &escape(value))).collect();
            let events: u64 = result.measurements.iter().map(|measurement| measurement.events).sum();
            let events = if result.measurements.is_empty() { String::new() } else { events.to_string() };
            format!(
                "<tr><th scope=\"row\"><a href=\"{folder}/{page}\">{folder}</a></th>{keys}{}{}</tr>\n",
                cell("td", "", "state", &state),
                cell("td", "n", "events", &events)
            )
        })
        .collect();
    table("All runs", &heads, &rows)
}

fn axes(sweep: &Sweep) -> String {
    let axes: String = sweep.axes().iter().map(|axis| format!("{axis}\n")).collect();
    let set: String = sweep.set().iter().map(|(key, value)| format!("{key}={value}\n")).collect();
    let set = if set.is_empty() {
        set
    } else {
        format!("<p>Set in all runs:</p>\n<pre><code>{}</code></pre>\n", escape(&set))
    };
    format!("<pre><code>{}</code></pre>\n{set}", escape(&axes))
}

/// Where the page of a sweep is, in its folder.
#[must_use]
pub fn sweep_page_in(folder: &Path) -> std::path::PathBuf {
    folder.join("sweep.html")
}
