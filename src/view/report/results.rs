use super::html::{brackets, escape, number, symbols, table};
use super::inputs::Results;
use crate::analysis::published::PublishedValue;
use crate::analysis::statistics::Estimate;
use crate::base::text::digits;
use crate::io::rates::{Rate, told_apart};
use crate::io::summary::{Observable, beside_instruments};
use crate::view::describe;

fn method_of(observable: &str) -> &'static str {
    match observable {
        "temperature" => "2 (K - P^2 / 2 M) / (D N - c), where the momentum P has c conserved components",
        "pressure" => PRESSURE,
        "compressibility_factor" => {
            "Z = p / (rho T), of the mean pressure and temperature; P <V> / (N T) with the pressure of a barostat"
        }
        "collision_rate" => {
            "n / (N t), where n counts the particles in core events: two in each, or one if the other is static"
        }
        "potential_energy_per_particle" => "energy of all pairs divided by N",
        "volume" => "<V>, averaged over time",
        "number_density" => "<N / V>, averaged over time",
        "packing_fraction" => "<1 / V> times the volume of the particles",
        "isothermal_compressibility" => "(<V^2> - <V>^2) / (<V> T), with the temperature T of the heat bath",
        name if name.starts_with("pressure_on_") => ON_WALL,
        name if name.starts_with("heat_flux_through_") => THROUGH_WALL,
        _ => "",
    }
}

const PRESSURE: &str = "(N T + W / (D t)) / V, where W sums r_ij . J over the events of a time t; between walls the mean over their axes of \
    <sum m v_x^2 / V> + (1 / t) sum x J / V, where V is the volume that centres can reach";
const ON_WALL: &str = "momentum that the wall transfers to particles per unit time and unit area; the area is the part that their centres can reach";
const THROUGH_WALL: &str = "energy that the wall supplies minus what it removes, per time and area";

const MOST_RATES: usize = 50;

struct Row<'a> {
    title: String,
    unit: String,
    estimate: Option<Estimate>,
    published: Vec<&'a PublishedValue>,
    /// Text that replaces the number, for example of a conserved observable.
    words: Option<String>,
    method: &'a str,
}

pub(super) fn section(results: &Results<'_>) -> String {
    let rows = rows(results);
    if rows.is_empty() {
        return "<p>Nothing with a mean was measured in this scene.</p>\n".to_owned();
    }
    let has_published = rows.iter().any(|row| !row.published.is_empty());
    let lines: String =
        rows.chunk_by(|a, b| a.method == b.method).flat_map(|rows| lines(rows, has_published)).collect();
    let published = has_published.then_some(("n", "published"));
    let heads = [("", "quantity"), ("n", "value"), ("", "unit")].into_iter().chain(published);
    let heads = heads.chain([("", "how it is measured")]);
    format!(
        "{}<p class=\"aside\">Boltzmann's constant is 1. Standard errors of the observables come from the \
         spectral density of their series at frequency zero, and assume that the series are stationary.</p>\n{}{}",
        table("results", "Means over the measurement and their standard errors", heads, &lines),
        sources(results),
        rates(results)
    )
}

fn sources(results: &Results<'_>) -> String {
    let mut known: Vec<(&str, &str)> = Vec::new();
    for value in results.published {
        if known.iter().all(|(_, source)| *source != value.source) {
            known.push((&value.label, &value.source));
        }
    }
    let words: Vec<String> = known.iter().map(|(label, source)| format!("{label}: {source}")).collect();
    if words.is_empty() {
        String::new()
    } else {
        format!("<p class=\"aside\">Published: {}.</p>\n", escape(&words.join("; ")))
    }
}

/// Returns a table of event rates, unless there are only core events of a single species.
fn rates(results: &Results<'_>) -> String {
    let rates = told_apart(results.rates);
    if rates.is_empty() {
        return String::new();
    }
    let line = |rate: &&Rate| {
        format!(
            "<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td class=\"how\">{}</td></tr>\n",
            escape(&rate.title()),
            rate.events,
            escape(&rate.words())
        )
    };
    let lines: String = rates.iter().take(MOST_RATES).map(line).collect();
    let more = match rates.len().saturating_sub(MOST_RATES) {
        0 => String::new(),
        more => format!("<p class=\"aside\">And {more} more in <code>summary.json</code>.</p>\n"),
    };
    let heads = [("", "what"), ("n", "number"), ("", "per unit of time, for each participating particle")];
    table("results", "Events by kind and species", heads, &lines) + &more
}

fn rows<'a>(results: &Results<'a>) -> Vec<Row<'a>> {
    let published = |name: &str| results.published.iter().filter(|value| value.quantity == name).collect::<Vec<_>>();
    let rows = beside_instruments(results.observables, results.measured).map(|(name, unit, observable)| Row {
        published: published(name),
        title: name.replace('_', " "),
        unit: results.unit_of(unit),
        estimate: Some(observable.estimate),
        words: words(name, observable, results.events),
        method: method_of(name),
    });
    let measured = results.measured.numbers.iter().map(|number| Row {
        published: published(&number.name),
        title: number.title.clone(),
        unit: results.unit_of(&number.unit),
        estimate: number.estimate(),
        words: None,
        method: &number.method,
    });
    rows.chain(measured).collect()
}

fn lines<'a>(rows: &'a [Row<'a>], has_published: bool) -> impl Iterator<Item = String> + 'a {
    rows.iter().enumerate().map(move |(index, row)| line(row, if index == 0 { rows.len() } else { 0 }, has_published))
}

/// Returns a table row whose method cell spans `span` rows. If `span` is 0, the row has no method cell.
fn line(row: &Row, span: usize, has_published: bool) -> String {
    let brackets = brackets(&row.unit);
    let method = escape(&symbols(row.method));
    let method = match span {
        0 => String::new(),
        1 => format!("<td class=\"how\">{method}</td>"),
        _ => format!("<td class=\"how\" rowspan=\"{span}\">{method}</td>"),
    };
    let known = row
        .published
        .iter()
        .map(|it| format!("{} <small>{}</small>", escape(&number(&digits(it.value))), escape(&it.label)));
    let published = if has_published {
        format!("<td class=\"n published\">{}</td>", known.collect::<Vec<_>>().join("<br>"))
    } else {
        String::new()
    };
    format!(
        "<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td>{}</td>{published}{method}</tr>\n",
        escape(&row.title),
        row.words.as_deref().map_or_else(|| value(row.estimate), with_signs),
        escape(brackets.trim_start().trim_matches(['[', ']'])),
    )
}

/// The error determines the number of digits.
pub(super) fn value(estimate: Option<Estimate>) -> String {
    match estimate.and_then(Estimate::finite) {
        None => "<em>insufficient data</em>".to_owned(),
        Some(Estimate { mean, standard_error: None }) => {
            format!("{} <small>error: insufficient data</small>", number(&digits(mean)))
        }
        Some(estimate) => with_signs(&describe::estimate(&estimate)),
    }
}

fn with_signs(text: &str) -> String {
    let parts: Vec<String> = text.split(" +- ").map(number).collect();
    escape(&parts.join(" ± "))
}

pub(super) fn shown(name: &str, observable: &Observable, events: u64) -> String {
    let plain = || value(Some(observable.estimate));
    words(name, observable, events).map_or_else(plain, |words| with_signs(&words))
}

fn words(name: &str, observable: &Observable, events: u64) -> Option<String> {
    let Observable { estimate, stationarity } = *observable;
    let text = describe::observable(name, &estimate, stationarity, events);
    (estimate.mean.is_finite() && text != describe::estimate(&estimate)).then_some(text)
}
