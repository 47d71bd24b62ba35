mod curves;
mod pages;
mod plots;

use std::path::Path;

use super::html::{self, cell, escape};
use super::results::value;
use super::{Page, shell};
use crate::base::text::digits;
use crate::io::SMALL_PAGE;
use crate::sweep::{Group, MeasuredQuantity, Point, Results, StageMeans, Standing, Sweep, SweepFolder};

pub use pages::{run_page_in, write_run_pages};

/// Largest number of rows in a table. Files contain all rows.
const MOST_ROWS: usize = 500;

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
        ("plots", "Plots", plots::section(sweep, results)),
        ("means", "Means", means(sweep, results)),
        ("runs", "Runs", runs(folder, sweep, results)),
        ("axes", "What varies", axes(sweep)),
    ];
    let functions = plots::horizontal(sweep).map(|along| curves::section(folder, sweep, results, &along));
    if let Some(functions) = functions.filter(|functions| !functions.is_empty()) {
        sections.insert(1, ("functions", "Measured functions", functions));
    }
    Page { html: shell(&name, &heading, "", &sections), notes: Vec::new() }
}

fn settings<'s>(sweep: &'s Sweep, group: &Group) -> Vec<(String, &'s str)> {
    let point = group.places.first().and_then(|place| sweep.points().get(*place));
    let values = point.into_iter().flat_map(Point::state_point).map(|(_, value)| value.as_str());
    sweep.state_point_names().into_iter().zip(values).collect()
}

/// Style class and text of a column heading.
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
                format!("{}{scatter}{}", value(Some(it.estimate)), of.unwrap_or_default())
            }
        };
        let cells = std::iter::once(means.runs.to_string()).chain(means.values.iter().map(shown));
        let first = heads.len() - 1 - means.values.len();
        let values: String =
            heads[first..].iter().zip(cells).map(|((_, head), it)| cell("td", "n", head, &it)).collect();
        format!("<tr>{keys}{values}</tr>\n")
    };
    let rows: Vec<String> = results.means().map(|(group, means)| row(group, means)).collect();
    table("Means over seeds, with standard errors from the runs and from their scatter", &heads, &rows)
        + "<p class=\"aside\">The two errors should agree: where the scatter is much larger, the runs are too short for their own errors. \
           The same numbers are in <code>sweep-mean.csv</code>, and the numbers of each run are in <code>sweep.csv</code>.</p>\n"
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
            // A run without a page gets a link to its folder.
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

/// Path of the page in the folder of a sweep.
#[must_use]
pub fn sweep_page_in(folder: &Path) -> std::path::PathBuf {
    folder.join("sweep.html")
}
