//! Plots against the temperatures of measured stages.

use crate::analysis::observables::OBSERVABLES;
use crate::analysis::statistics::Estimate;
use crate::view::report::families::{self, Member, Parameter};
use crate::view::report::figures::{capitalised, curves_figure};
use crate::view::report::html::quantity;
use crate::view::report::inputs::Results;
use crate::view::report::plot::{Curves, Line, Point, extent};

pub(in crate::view::report) const TEMPERATURE: &str = "temperature";

/// Smallest ratio of the highest to the lowest temperature in an anneal.
const LEAST_RATIO: f64 = 1.02;

/// Largest ratio of temperatures on a linear axis.
const LONG: f64 = 10.0;

/// Largest relative difference of equal values.
const SAME: f64 = 1e-9;

/// Plots all results against the temperature of the stage. Functions become families of curves, coloured by
/// temperature.
pub(super) fn plots(all: &[Results<'_>]) -> String {
    let temperature = |results: &Results<'_>| {
        results.observables.get(TEMPERATURE).map(|it| it.estimate.mean).filter(|it| it.is_finite())
    };
    let stages: Vec<(f64, &Results<'_>)> =
        all.iter().filter_map(|results| Some((temperature(results)?, results))).collect();
    let temperatures = || stages.iter().map(|(temperature, _)| *temperature);
    if !is_spread(temperatures()) {
        return String::new();
    }
    let is_logarithmic = is_long(temperatures());
    let mut figures: Vec<String> =
        quantities(all).iter().filter_map(|known| against_temperature(known, &stages, is_logarithmic)).collect();
    let members = stages.iter().map(|(temperature, results)| Member {
        value: *temperature,
        name: results.stage.unwrap_or("measurement").to_owned(),
        curves: results.measured.curves.clone(),
    });
    let parameter = Parameter { title: of_temperature(all.first()), is_logarithmic };
    figures.extend(families::figures(&parameter, &members.collect::<Vec<_>>(), "in the folder of each stage"));
    format!("<div class=\"plots\">\n{}</div>\n", figures.concat())
}

pub(in crate::view::report) fn is_spread(temperatures: impl Iterator<Item = f64>) -> bool {
    extent(temperatures).is_some_and(|[least, most]| least > 0.0 && most >= LEAST_RATIO * least)
}

pub(in crate::view::report) fn is_long(temperatures: impl Iterator<Item = f64>) -> bool {
    extent(temperatures).is_some_and(|[least, most]| most > LONG * least)
}

struct Known {
    name: String,
    title: String,
    unit: String,
}

fn of_temperature(results: Option<&Results<'_>>) -> String {
    quantity(TEMPERATURE, &results.map_or_else(|| "energy".to_owned(), |results| results.unit_of("energy")))
}

fn quantities(all: &[Results<'_>]) -> Vec<Known> {
    let of_scene = |unit: &str| all.first().map_or_else(|| unit.to_owned(), |results| results.unit_of(unit));
    let is_there = |name: &str| all.iter().any(|results| results.observables.contains_key(name));
    let observables = OBSERVABLES.iter().filter(|(name, _)| *name != TEMPERATURE && is_there(name));
    let mut known: Vec<Known> = observables
        .map(|(name, unit)| Known { name: (*name).to_owned(), title: name.replace('_', " "), unit: of_scene(unit) })
        .collect();
    for number in all.iter().flat_map(|results| &results.measured.numbers) {
        if number.name != TEMPERATURE && known.iter().all(|it| it.name != number.name) {
            known.push(Known { name: number.name.clone(), title: number.title.clone(), unit: of_scene(&number.unit) });
        }
    }
    known
}

fn against_temperature(known: &Known, stages: &[(f64, &Results<'_>)], is_logarithmic: bool) -> Option<String> {
    let mut points: Vec<Point> = stages
        .iter()
        .filter_map(|(x, results)| {
            let observable = results.observables.get(&known.name).map(|observable| observable.estimate);
            let estimate = observable.or_else(|| results.measured.number(&known.name)?.estimate())?;
            let Estimate { mean, standard_error } = estimate.finite()?;
            Some(Point { x: *x, y: mean, error: standard_error.unwrap_or(0.0) })
        })
        .collect();
    points.sort_by(|a, b| a.x.total_cmp(&b.x));
    let [low, high] = extent(points.iter().map(|point| point.y))?;
    // A quantity that is equal in all stages is shown only in the table.
    if points.len() < 2 || high - low <= SAME * low.abs().max(high.abs()) {
        return None;
    }
    let title = capitalised(&known.title);
    let curves = Curves {
        label: format!("{title} of each stage against its temperature"),
        titles: [of_temperature(stages.first().map(|(_, results)| *results)), quantity(&known.title, &known.unit)],
        is_logarithmic: [is_logarithmic, false],
        lines: vec![Line { points: points.into_iter().map(Some).collect(), ..Line::default() }],
        ..Curves::default()
    };
    curves_figure(&title, &curves, "Each point is a measured stage at its mean temperature. Bars: standard errors.")
}
