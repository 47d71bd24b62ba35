//! The numbers of a run with their standard errors.

use super::html::{brackets, escape, number, unit};
use super::inputs::Inputs;
use crate::describe::{self, digits};
use crate::observe::OBSERVABLES;
use crate::statistics::Estimate;

/// How the observables of every run are measured.
const METHODS: [(&str, &str); 5] = [
    ("temperature", "2 K / (D N); where momentum is conserved 2 (K - P²/2M) / (D (N - 1))"),
    ("pressure", "ρ (T + W / (D (N - 1) t)), where W sums r·J over the events of a time t"),
    ("compressibility_factor", "Z = p / (ρ T), of the mean pressure and temperature"),
    ("collision_rate", "2 n / (N t), where n counts the core events of a time t"),
    ("potential_energy_per_particle", "energy of all pairs over N"),
];

/// A line of the table.
struct Row<'a> {
    title: String,
    unit: &'a str,
    mean: Option<f64>,
    standard_error: Option<f64>,
    method: &'a str,
}

/// The section of the page.
pub(super) fn section(inputs: &Inputs) -> String {
    let rows = rows(inputs);
    if rows.is_empty() {
        return "<p>Nothing with a mean was measured in this scene.</p>\n".to_owned();
    }
    let lines: String = rows.chunk_by(|a, b| a.method == b.method).flat_map(lines).collect();
    format!(
        "<div class=\"wide\"><table class=\"results\">\n<caption>Means over the measured stretch and their standard errors</caption>\n\
         <thead><tr><th scope=\"col\">quantity</th><th scope=\"col\" class=\"n\">value</th><th scope=\"col\">unit</th>\
         <th scope=\"col\">how it is measured</th></tr></thead>\n<tbody>\n{lines}</tbody>\n</table></div>\n\
         <p class=\"aside\">Reduced units; Boltzmann's constant is 1. Standard errors of the observables come from the \
         spectral density of their series at frequency zero and assume a stationary one.</p>\n"
    )
}

fn rows(inputs: &Inputs) -> Vec<Row<'_>> {
    let numbers = &inputs.measured.numbers;
    let is_new = |name: &&String| numbers.iter().all(|number| number.name != **name);
    // The order of the program first, then what a later version may have added.
    let known = OBSERVABLES.iter().map(|(name, _)| *name);
    let others = inputs
        .summary
        .observables
        .keys()
        .map(String::as_str)
        .filter(|name| OBSERVABLES.iter().all(|(known, _)| known != name));
    let observables = known.chain(others).filter_map(|name| inputs.summary.observables.get_key_value(name));
    let look_up = |table: &'static [(&str, &str); 5], name: &str| {
        table.iter().find(|(known, _)| *known == name).map_or("", |(_, text)| *text)
    };
    let rows = observables.filter(|(name, _)| is_new(name)).map(|(name, observable)| Row {
        title: name.replace('_', " "),
        unit: look_up(&OBSERVABLES, name),
        mean: Some(observable.mean),
        standard_error: observable.standard_error,
        method: look_up(&METHODS, name),
    });
    let measured = numbers.iter().map(|number| Row {
        title: number.title.clone(),
        unit: &number.unit,
        mean: number.mean,
        standard_error: number.standard_error,
        method: &number.method,
    });
    rows.chain(measured).collect()
}

/// Lines that share their method, which is told once.
fn lines<'a>(rows: &'a [Row<'a>]) -> impl Iterator<Item = String> + 'a {
    rows.iter().enumerate().map(|(index, row)| line(row, if index == 0 { rows.len() } else { 0 }))
}

/// A line, whose method stands for so many lines; for none it is that of a line above.
fn line(row: &Row, span: usize) -> String {
    let brackets = brackets(row.unit);
    let method = escape(&unit(row.method));
    let method = match span {
        0 => String::new(),
        1 => format!("<td class=\"how\">{method}</td>"),
        _ => format!("<td class=\"how\" rowspan=\"{span}\">{method}</td>"),
    };
    format!(
        "<tr><th scope=\"row\">{}</th><td class=\"n\">{}</td><td>{}</td>{method}</tr>\n",
        escape(&row.title),
        value(row.mean, row.standard_error),
        escape(brackets.trim_start().trim_matches(['[', ']'])),
    )
}

/// A mean with its error, in as many digits as the error leaves.
pub(super) fn value(mean: Option<f64>, standard_error: Option<f64>) -> String {
    const NONE: &str = "<em>insufficient data</em>";
    let finite = |number: Option<f64>| number.filter(|number| number.is_finite());
    match (finite(mean), finite(standard_error)) {
        (None, _) => NONE.to_owned(),
        (Some(mean), None) => format!("{} <small>error: insufficient data</small>", number(&digits(mean))),
        (Some(mean), error) => {
            let text = describe::estimate(&Estimate { mean, standard_error: error });
            let parts: Vec<String> = text.split(" +- ").map(number).collect();
            escape(&parts.join(" ± "))
        }
    }
}
