//! The page of a replica exchange.

mod mean_force;
mod paths;

use std::path::{Path, PathBuf};

use super::families::{self, MOST_CURVES, Member, Parameter};
use super::figures::{capitalised, curves_figure};
use super::html::{self, cell, escape, quantity};
use super::plot::{Curves, Key, Line, Point as Dot, extent};
use super::results::value;
use super::{Page, listed, scene_text, shell, verdict};
use crate::analysis::instruments::CHAIN_SIZES;
use crate::analysis::observables::OBSERVABLES;
use crate::analysis::statistics::Estimate;
use crate::base::text::{digits, plural};
use crate::exchange::{
    DISTANCE, ExchangeFolder, ExchangeFolderError, ExchangeSummary, TemperatureResult, ThermalPoint,
};
use crate::model::ExchangeEnsemble;
use paths::{drawn, paths};

/// Largest ratio of temperatures on a linear axis.
const LONG: f64 = 10.0;

const HEAT_CAPACITY: (&str, &str) = ("heat_capacity_per_particle", "1");

const TOGETHER: &str = "Curve: from the energies of all replicas together (MBAR), in <code>curves.csv</code>. Error bars and band: standard errors.";

const FIRST: [&str; 4] = [DISTANCE.0, "temperature", "potential_energy_per_particle", HEAT_CAPACITY.0];

/// Makes the page of a completed replica exchange from its files.
///
/// # Errors
/// [`ExchangeFolderError::Read`] if a file is missing or damaged.
pub fn exchange_page(folder: &Path) -> Result<Page, ExchangeFolderError> {
    let summary = ExchangeFolder::read(folder)?;
    let [every, rows] = drawn(&summary).map(|rows| usize::try_from(rows).unwrap_or(usize::MAX));
    let places = ExchangeFolder::read_places(folder, every, rows)?;
    let scene = std::fs::read_to_string(ExchangeFolder::scene_of(folder)).unwrap_or_default();
    let results = &summary.results;
    let verdict = verdict(&results.faults);
    let state = match summary.warnings.is_empty() {
        true => "<span class=\"verdict sound\">✓ mixed</span>",
        false => "<span class=\"verdict failed\">✗ equilibrium not shown</span>",
    };
    let heading = format!(
        "<h1>{} {verdict} {state}</h1>\n<p class=\"subtitle\">{} of {} at {}</p>\n<p class=\"facts\">seed {} · {} · carom {}</p>\n",
        escape(&summary.scene),
        match results.ensemble {
            ExchangeEnsemble::Canonical => "Replica exchange",
            ExchangeEnsemble::Multicanonical => "Multicanonical ensemble",
            ExchangeEnsemble::Umbrella => "Umbrella sampling",
        },
        plural(summary.particles as u64, "particle"),
        plural(results.temperatures.len() as u64, place_of(&summary)),
        summary.seed,
        escape(&summary.engine),
        escape(&summary.version),
    );
    let again = "the exchange can be repeated bit for bit, on any number of threads";
    let sections = [
        match summary.umbrella {
            Some(_) => ("windows", "Windows", temperatures(&summary)),
            None => ("temperatures", "Temperatures", temperatures(&summary)),
        },
        ("plots", "Plots", plots(&summary, &places)),
        if is_swapped(&summary) {
            ("swaps", "Swaps", swaps(&summary))
        } else {
            ("trips", "Round trips", trips(&summary))
        },
        ("scene", "The scene", scene_text(again, &scene)),
    ];
    let notes = results.faults.clone();
    let warnings = listed("Equilibrium", "It may not be in equilibrium:", &summary.warnings);
    let above = warnings + &super::notes(&notes);
    Ok(Page { html: shell(&summary.scene, &heading, &above, &sections), notes })
}

/// In a multicanonical ensemble, each replica visits all energies.
fn is_swapped(summary: &ExchangeSummary) -> bool {
    summary.results.ensemble != ExchangeEnsemble::Multicanonical
}

fn place_of(summary: &ExchangeSummary) -> &'static str {
    if summary.umbrella.is_some() { "window" } else { "temperature" }
}

/// Path of the page in the folder of an exchange.
#[must_use]
pub fn exchange_page_in(folder: &Path) -> PathBuf {
    folder.join("exchange.html")
}

fn quantities(summary: &ExchangeSummary) -> Vec<(&str, String)> {
    let has = |name: &str| summary.results.temperatures.iter().any(|at| at.observables.contains_key(name));
    let mut all: Vec<_> = OBSERVABLES
        .into_iter()
        .chain([HEAT_CAPACITY])
        .chain(CHAIN_SIZES)
        .chain([DISTANCE])
        .filter(|(name, _)| has(name))
        .collect();
    all.sort_by_key(|(name, _)| FIRST.iter().position(|first| first == name).unwrap_or(FIRST.len()));
    let mut all: Vec<(&str, String)> = all.into_iter().map(|(name, of)| (name, summary.unit_of(of))).collect();
    for number in summary.results.temperatures.iter().flat_map(|at| &at.measured.numbers) {
        if number.mean.is_some() && all.iter().all(|(name, _)| *name != number.name) {
            all.push((&number.name, number.unit.clone()));
        }
    }
    all
}

fn measured(at: &TemperatureResult, name: &str) -> Option<Estimate> {
    at.observables.get(name).copied().or_else(|| at.measured.number(name)?.estimate())
}

fn words(name: &str) -> String {
    name.replace('_', " ")
}

fn table(caption: &str, heads: &[String], rows: &[Vec<String>]) -> String {
    let classes = std::iter::once("").chain(std::iter::repeat("n"));
    let row = |cells: &Vec<String>| {
        let head = heads.first().map(String::as_str).unwrap_or_default();
        let first = cell("th", "", head, cells.first().map(String::as_str).unwrap_or_default());
        let others: String = heads.iter().zip(cells).skip(1).map(|(head, it)| cell("td", "n", head, it)).collect();
        format!("<tr>{first}{others}</tr>\n")
    };
    let rows: String = rows.iter().map(row).collect();
    html::table("exchange", caption, classes.zip(heads.iter().map(|head| escape(head))), &rows)
}

fn mean(measured: Option<Estimate>) -> String {
    measured.map_or_else(String::new, |it| value(Some(it)))
}

fn named(at: &TemperatureResult) -> String {
    at.window.map_or_else(|| given(at.temperature), |[lower, upper]| format!("{} to {}", given(lower), given(upper)))
}

fn given(number: f64) -> String {
    escape(&html::number(&digits(number)))
}

fn temperatures(summary: &ExchangeSummary) -> String {
    let (results, quantities) = (&summary.results, quantities(summary));
    let is_swapped = is_swapped(summary);
    let head = if summary.umbrella.is_some() {
        quantity("window", &summary.unit_of("length"))
    } else {
        of_temperature(summary)
    };
    let fixed = std::iter::once(head).chain(is_swapped.then(|| "swaps with the next".to_owned()));
    let names = quantities.iter().map(|(name, unit)| match *name {
        "temperature" => quantity("kinetic temperature", unit),
        name => quantity(&words(name), unit),
    });
    let heads: Vec<String> = fixed.chain(names).collect();
    let row = |(place, at): (usize, &TemperatureResult)| {
        let acceptance = results.neighbours.get(place).and_then(|it| it.acceptance);
        let means = quantities.iter().map(|(name, _)| mean(measured(at, name)));
        let swaps = is_swapped.then(|| mean(acceptance));
        std::iter::once(named(at)).chain(swaps).chain(means).collect()
    };
    let rows: Vec<Vec<String>> = results.temperatures.iter().enumerate().map(row).collect();
    let (what, whose) =
        if is_swapped { ("attempts to swap", OVER_REPLICAS) } else { ("samples of each replica", REWEIGHTED) };
    let caption = format!("Averages over {} {what} in a time of {}", results.attempts, digits(results.duration));
    table(&caption, &heads, &rows)
        + &peak(summary)
        + &mean_force::sentence(summary)
        + &format!(
            "<p class=\"aside\">{whose} The heat capacity at constant volume is in units of k_B. It is D / 2 \
             plus a term from the fluctuations of the potential energy. The same numbers are in \
             <code>summary.json</code>, and results of instruments are in <code>measurements.json</code>.</p>\n"
        )
}

const OVER_REPLICAS: &str =
    "Averages at a temperature or in a window include each replica for the time it spent there.";
const REWEIGHTED: &str = "Averages at the temperatures follow from the energies of all replicas by reweighting.";

fn peak(summary: &ExchangeSummary) -> String {
    summary.heat_capacity_peak.map_or_else(String::new, |peak| {
        let [height, at] = [peak.heat_capacity_per_particle, peak.temperature].map(|it| mean(Some(it)));
        format!("<p>Between the temperatures, the heat capacity per particle is highest at T = {at}: {height}.</p>\n")
    })
}

fn swaps(summary: &ExchangeSummary) -> String {
    let results = &summary.results;
    let heads = ["between", "and", "attempts", "swaps", "acceptance"].map(str::to_owned);
    let row = |(place, it): (usize, &crate::exchange::NeighbouringTemperatures)| {
        let name = |place: usize| results.temperatures.get(place).map_or_else(String::new, named);
        let [one, other] = [name(place), name(place + 1)];
        vec![one, other, it.attempts.to_string(), it.accepted.to_string(), mean(it.acceptance)]
    };
    let rows: Vec<Vec<String>> = results.neighbours.iter().enumerate().map(row).collect();
    table(&format!("Swaps between neighbouring {}s", place_of(summary)), &heads, &rows)
        + &trips(summary)
        + &format!(
            "<p class=\"aside\">If the acceptance is low, add {0}s there. If there are few round trips, run for \
             longer. The replica at each {0}, and its potential energy, are in \
             <code>exchange.csv</code>.</p>\n",
            place_of(summary)
        )
}

fn trips(summary: &ExchangeSummary) -> String {
    let trips = |(trips, number): (&u64, u64)| vec![number.to_string(), trips.to_string()];
    let rows: Vec<Vec<String>> = summary.results.round_trips.iter().zip(1..).map(trips).collect();
    let ends = match summary.results.ensemble {
        ExchangeEnsemble::Canonical => "the highest temperature to the lowest and back",
        ExchangeEnsemble::Umbrella => "the last window to the first and back",
        ExchangeEnsemble::Multicanonical => {
            "the mean potential energy at the highest temperature to that at the lowest and back"
        }
    };
    table("Round trips of the replicas", &["replica", "round trips"].map(str::to_owned), &rows)
        + &format!("<p class=\"aside\">A round trip leads from {ends}.</p>\n")
}

fn plots(summary: &ExchangeSummary, places: &[(f64, Vec<usize>)]) -> String {
    if summary.umbrella.is_some() {
        return format!("<div class=\"plots\">\n{}</div>\n", mean_force::plots(summary, places));
    }
    let along = summary.results.temperatures.iter().map(|at| at.temperature);
    let [least, most] = along.fold([f64::INFINITY, 0.0], |[a, b]: [f64; 2], x| [a.min(x), b.max(x)]);
    let is_logarithmic = most / least > LONG;
    let of_quantities = quantities(summary).into_iter().filter(|(name, _)| *name != "temperature");
    let figures = of_quantities.filter_map(|(name, unit)| against_temperature(summary, name, &unit, is_logarithmic));
    let others = [acceptance(summary, is_logarithmic), populations(summary), paths(summary, places, is_logarithmic)];
    let figures = figures.chain(entropy(summary, is_logarithmic)).chain(density_of_states(summary));
    let figures: String =
        figures.chain(others.into_iter().flatten()).chain(functions(summary, is_logarithmic)).collect();
    format!("<div class=\"plots\">\n{figures}</div>\n")
}

/// Title of an axis with temperatures.
fn of_temperature(summary: &ExchangeSummary) -> String {
    quantity("temperature", &summary.unit_of("energy"))
}

fn functions(summary: &ExchangeSummary, is_logarithmic: bool) -> Vec<String> {
    let parameter = Parameter { title: of_temperature(summary), is_logarithmic };
    let member = |at: &TemperatureResult| Member {
        value: at.temperature,
        name: String::new(),
        curves: at.measured.curves.clone(),
    };
    let members: Vec<Member> = summary.results.temperatures.iter().map(member).collect();
    families::figures(&parameter, &members, "in the folder of each temperature")
}

fn dot(x: f64, it: Estimate) -> Option<Dot> {
    it.mean.is_finite().then_some(Dot { x, y: it.mean, error: it.standard_error.unwrap_or(0.0) })
}

fn against_temperature(summary: &ExchangeSummary, name: &str, unit: &str, is_logarithmic: bool) -> Option<String> {
    let means = || summary.results.temperatures.iter().map(|at| measured(at, name));
    // A quantity that is the same at all temperatures needs no figure.
    let mut all = means().flatten().map(|it| it.mean);
    let first = all.next()?;
    if all.all(|mean| mean == first) {
        return None;
    }
    let temperatures = summary.results.temperatures.iter().map(|at| at.temperature);
    let points = temperatures.zip(means()).map(|(x, it)| dot(x, it?)).collect();
    let titles = [of_temperature(summary), quantity(&words(name), unit)];
    let mut curves = measured_curve(&capitalised(&words(name)), titles, is_logarithmic, points);
    let between = between(summary, name);
    if between.is_empty() {
        return curves_figure(&curves.label, &curves, "Error bars: standard errors.");
    }
    curves.lines[0].label = "at each temperature".to_owned();
    let label = "from all replicas together".to_owned();
    curves.lines.push(Line { label, points: between, ..Line::default() });
    curves_figure(&curves.label, &curves, TOGETHER)
}

/// Returns the curve between the simulated temperatures, if the quantity has one.
fn between(summary: &ExchangeSummary, name: &str) -> Vec<Option<Dot>> {
    let point = |point: &ThermalPoint| {
        let (_, it) = point.quantities().into_iter().find(|(own, _)| *own == name)?;
        dot(point.temperature, it)
    };
    let points: Vec<Option<Dot>> = summary.curves.iter().map(point).collect();
    if points.iter().any(Option::is_some) { points } else { Vec::new() }
}

fn entropy(summary: &ExchangeSummary, is_logarithmic: bool) -> Option<String> {
    let titles = [of_temperature(summary), "entropy per particle".to_owned()];
    let points = between(summary, "entropy_per_particle");
    let curves = measured_curve("Entropy per particle", titles, is_logarithmic, points);
    curves_figure(
        &curves.label,
        &curves,
        &format!("In units of k_B, relative to the entropy at the highest temperature. {TOGETHER}"),
    )
}

fn density_of_states(summary: &ExchangeSummary) -> Option<String> {
    let points = summary.density_of_states.iter().map(|level| dot(level.energy, level.log_density_of_states)).collect();
    let titles = [quantity("potential energy", &summary.unit_of("energy")), "ln density of states".to_owned()];
    let curves = measured_curve("Density of states", titles, false, points);
    let text = "Natural logarithm of g(E), with sum g(E) exp(-E / T) = 1 at the highest temperature T. Error bars: standard errors. From <code>density_of_states.csv</code>.";
    curves_figure(&curves.label, &curves, text)
}

fn measured_curve(label: &str, titles: [String; 2], is_logarithmic: bool, points: Vec<Option<Dot>>) -> Curves {
    let lines = vec![Line { points, ..Line::default() }];
    Curves { label: label.to_owned(), titles, is_logarithmic: [is_logarithmic, false], lines, ..Curves::default() }
}

fn acceptance(summary: &ExchangeSummary, is_logarithmic: bool) -> Option<String> {
    let middle = |[a, b]: [f64; 2]| (a * b).sqrt();
    let points = summary.results.neighbours.iter().map(|it| dot(middle(it.temperatures), it.acceptance?)).collect();
    let titles = [of_temperature(summary), "acceptance".to_owned()];
    let curves = measured_curve("Acceptance", titles, is_logarithmic, points);
    let text = "Acceptance of swaps between two neighbours, plotted at the geometric mean of their temperatures. Error bars: standard errors.";
    curves_figure(&curves.label, &curves, text)
}

fn populations(summary: &ExchangeSummary) -> Option<String> {
    let temperatures = &summary.results.temperatures;
    let step = temperatures.len().div_ceil(MOST_CURVES);
    if temperatures.iter().all(|at| at.populations.len() < 2) {
        return None;
    }
    let ends = extent(temperatures.iter().map(|at| at.temperature))?;
    let key = Key { title: of_temperature(summary), ends, is_logarithmic: ends[1] > LONG * ends[0] };
    let line = |at: &TemperatureResult| Line {
        label: format!("T = {}", digits(at.temperature)),
        points: at.populations.iter().map(|it| dot(it.energy, it.population)).collect(),
        tone: Some(key.tone(at.temperature)),
        ..Line::default()
    };
    let is_binned = temperatures.iter().flat_map(|at| &at.populations).any(|it| it.width > 0.0);
    let what =
        if is_binned { "For bins of the potential energy" } else { "For the exact levels of the potential energy" };
    let text = format!("{what}, all particles together. Error bars: standard errors. From <code>energies.csv</code>.");
    let titles = ["potential energy".to_owned(), "population".to_owned()];
    let lines = temperatures.iter().step_by(step).map(line).collect();
    let (label, key) = ("Populations, by temperature".to_owned(), Some(key));
    curves_figure("Populations", &Curves { label, titles, lines, key, ..Curves::default() }, &text)
}
