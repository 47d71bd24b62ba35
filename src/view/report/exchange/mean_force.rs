use super::paths::paths_at;
use super::{dot, given, measured_curve};
use crate::analysis::statistics::Estimate;
use crate::exchange::{ExchangeSummary, MeanForcePoint, TemperatureResult};
use crate::view::describe::distance_between;
use crate::view::report::figures::curves_figure;
use crate::view::report::html::{escape, quantity};
use crate::view::report::plot::Point as Dot;

pub(super) fn sentence(summary: &ExchangeSummary) -> String {
    let Some(umbrella) = &summary.umbrella else { return String::new() };
    let temperature = summary.results.temperatures.first().map_or_else(String::new, |at| given(at.temperature));
    let lowest = MeanForcePoint::lowest(&summary.potential_of_mean_force, |point| point.potential_of_mean_force);
    let lowest = lowest.map_or_else(String::new, |point| {
        format!(" The potential of mean force is lowest at {}.", given(point.distance))
    });
    format!("<p>Windows of {}, at the temperature {temperature}.{lowest}</p>\n", escape(&distance_between(umbrella)))
}

pub(super) fn plots(summary: &ExchangeSummary, places: &[(f64, Vec<usize>)]) -> String {
    let potential = along(
        summary,
        ["Potential of mean force", "potential of mean force"],
        "w(r) = F(r) + (D - 1) T ln r, from all windows together; zero for the mean density in the last window.",
        |point| point.potential_of_mean_force,
    );
    let free_energy = along(
        summary,
        ["Free energy as a function of the distance", "free energy"],
        "F(r) = -T ln p(r), with the probability density p(r) of the distance, from all windows together; zero for the mean density in the last window.",
        |point| point.free_energy,
    );
    let middle = |at: &TemperatureResult| at.window.map(|[lower, upper]| 0.5 * (lower + upper));
    let windows = &summary.results.temperatures;
    let height = |place: usize| windows.get(place).and_then(middle);
    let paths =
        paths_at(summary, places, (quantity("middle of the window", &summary.unit_of("length")), false), height);
    [potential, free_energy, acceptance(summary), paths].into_iter().flatten().collect()
}

fn along(
    summary: &ExchangeSummary,
    [label, title]: [&str; 2],
    text: &str,
    of: fn(&MeanForcePoint) -> Estimate,
) -> Option<String> {
    let points: Vec<Option<Dot>> =
        summary.potential_of_mean_force.iter().map(|point| dot(point.distance, of(point))).collect();
    let text = format!("{text} Error bars: standard errors. From <code>potential_of_mean_force.csv</code>.");
    let titles = [("distance", "length"), (title, "energy")].map(|(name, of)| quantity(name, &summary.unit_of(of)));
    curves_figure(label, &measured_curve(label, titles, false, points), &text)
}

/// Plots the acceptance of swaps between neighbouring windows, in the middle of their overlap.
fn acceptance(summary: &ExchangeSummary) -> Option<String> {
    let windows = &summary.results.temperatures;
    let middle = |place: usize| {
        let [lower, upper] = [windows.get(place + 1)?.window?[0], windows.get(place)?.window?[1]];
        Some(0.5 * (lower + upper))
    };
    let neighbours = summary.results.neighbours.iter().enumerate();
    let points = neighbours.map(|(place, it)| dot(middle(place)?, it.acceptance?)).collect();
    let text = "Acceptance of swaps between two neighbours, plotted at the middle of the overlap of their windows. Error bars: standard errors.";
    let titles = [quantity("distance", &summary.unit_of("length")), "acceptance".to_owned()];
    curves_figure("Acceptance", &measured_curve("Acceptance", titles, false, points), text)
}
