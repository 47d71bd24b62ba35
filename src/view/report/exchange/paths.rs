use super::{is_swapped, of_temperature};
use crate::exchange::ExchangeSummary;
use crate::view::report::figures::curves_figure;
use crate::view::report::html::quantity;
use crate::view::report::plot::{Curves, Line, LineStyle, Point as Dot};

const MOST_ROWS: u64 = 120;
const ROUND_TRIPS: u64 = 4;

/// Maximum number of plotted paths. More paths could not be distinguished.
const MOST_PATHS: usize = 3;

/// Returns `[n, last]`: the plot shows every n-th row of `exchange.csv` up to row `last`.
pub(super) fn drawn(summary: &ExchangeSummary) -> [u64; 2] {
    let attempts = summary.results.attempts;
    let trips = summary.results.round_trips.iter().copied().max().unwrap_or(0);
    let rows = (attempts / (trips + 1)).saturating_mul(ROUND_TRIPS).clamp(MOST_ROWS.min(attempts), attempts);
    [rows.div_ceil(MOST_ROWS), rows]
}

pub(super) fn paths(summary: &ExchangeSummary, places: &[(f64, Vec<usize>)], is_logarithmic: bool) -> Option<String> {
    if !is_swapped(summary) {
        return None;
    }
    let temperatures = &summary.results.temperatures;
    let height = |place: usize| temperatures.get(place).map(|at| at.temperature);
    paths_at(summary, places, (of_temperature(summary), is_logarithmic), height)
}

/// `height` is the vertical position of a temperature or window.
pub(super) fn paths_at(
    summary: &ExchangeSummary,
    places: &[(f64, Vec<usize>)],
    (title, is_logarithmic): (String, bool),
    height: impl Fn(usize) -> Option<f64>,
) -> Option<String> {
    let temperatures = &summary.results.temperatures;
    let shown: Vec<usize> = (0..temperatures.len()).step_by(temperatures.len().div_ceil(MOST_PATHS)).collect();
    let line = |replica: &usize| Line {
        style: LineStyle::TimeSeries,
        label: format!("replica {}", replica + 1),
        points: places
            .iter()
            .map(|(time, replicas)| {
                let place = replicas.iter().position(|number| number == replica)?;
                Some(Dot { x: *time, y: height(place)?, error: 0.0 })
            })
            .collect(),
        ..Line::default()
    };
    let titles = [quantity("time", &summary.unit_of("time")), title];
    let [every, rows] = drawn(summary);
    let which = match (every > 1, rows < summary.results.attempts) {
        (true, true) => format!("one in {every} of the first {rows} rows"),
        (true, false) => format!("one in {every} rows"),
        (false, true) => format!("the first {rows} rows"),
        (false, false) => "all rows".to_owned(),
    };
    let text = format!("Where replicas are, from {which} of <code>exchange.csv</code>.");
    let (label, lines) = ("Replica paths".to_owned(), shown.iter().map(line).collect());
    let curves = Curves { label, titles, is_logarithmic: [false, is_logarithmic], lines, ..Curves::default() };
    curves_figure("Replica paths", &curves, &text)
}
