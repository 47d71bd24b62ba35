use super::html::{brackets, escape, escape_json, quantity, symbols, unit};
use super::inputs::Results;
use super::plot::{self, Curves, Level, Line, LineStyle, Map, Point, deviations, extent, mark};
use super::table::Trace;
use crate::analysis::instruments::{Curve, Series};
use crate::analysis::statistics::Estimate;

/// Columns of `thermo.csv` that share a plot.
const ENERGIES: [&str; 5] = ["kinetic", "rotational", "potential", "supplied", "energy_and_dissipated"];

/// Prefix of the columns of `thermo.csv` with the number of particles in a region.
const IN: &str = "in_";

/// A time series is constant if its relative variation is at most this value.
const SAME: f64 = 1e-9;

pub(super) fn section(results: &Results<'_>) -> String {
    let curves: Vec<String> = results.measured.curves.iter().flat_map(|curve| of_curve(curve, results.stage)).collect();
    let courses = courses(results);
    let mut section = String::new();
    if curves.is_empty() && courses.is_empty() {
        return "<p>There is nothing to plot.</p>\n".to_owned();
    }
    for (title, figures) in [("Measurements", &curves), ("Time series", &courses)] {
        if !figures.is_empty() {
            section.push_str(&format!("<h3>{title}</h3>\n<div class=\"plots\">\n{}</div>\n", figures.concat()));
        }
    }
    section
}

pub(super) fn figure(title: &str, svg: &str, text: &str) -> String {
    format!("<figure>\n<h4>{}</h4>\n{svg}\n<figcaption>{text}</figcaption>\n</figure>\n", escape(title))
}

/// Appends the plotted numbers to an SVG, for the script of the page.
fn with_values(svg: &str, values: &str) -> String {
    format!("{svg}\n<script type=\"application/json\" class=\"values\">{}</script>", escape_json(values))
}

pub(super) fn curves_figure(title: &str, curves: &Curves, text: &str) -> Option<String> {
    let entry = |(number, class, line): &(usize, String, &Line)| {
        let mark = if line.style == LineStyle::Published { String::new() } else { mark(*number, [13.0, 5.0]) };
        let sample = format!("<g class=\"{class}\"><path d=\"M1 5H25\"/>{mark}</g>");
        let sample = format!("<svg class=\"sample\" viewBox=\"0 0 26 10\" aria-hidden=\"true\">{sample}</svg>");
        format!("<li>{sample}{}</li>", escape(&line.label))
    };
    let ([svg, values], legend) = (curves.drawing()?, curves.legend());
    let mut plot = with_values(&svg, &values);
    if legend.len() > 1 && curves.key.is_none() {
        let entries: String = legend.iter().map(entry).collect();
        plot.push_str(&format!("\n<ul class=\"legend\">{entries}</ul>"));
    }
    Some(figure(title, &plot, &format!("{}{text}", strip(curves))))
}

/// Describes the strip of deviations below a plot.
fn strip(curves: &Curves) -> String {
    let compared = curves.lines.iter().filter(|line| line.deviations.iter().any(Option::is_some)).count();
    let published: Vec<&Line> = curves.lines.iter().filter(|line| line.style == LineStyle::Published).collect();
    let which = match (compared, published.as_slice()) {
        (0, _) => return String::new(),
        (1, [first, _, ..]) => format!(" ({})", escape(&first.label)),
        (_, [_, _, ..]) => " of the same series".to_owned(),
        _ => String::new(),
    };
    format!("Below: Δ / σ, the measured minus the published value{which} over its standard error; shaded: ±2. ")
}

/// Returns one figure for all series with the same unit, or a map for each series.
fn of_curve(curve: &Curve, stage: Option<&str>) -> Vec<String> {
    let folder = stage.map_or_else(String::new, |stage| format!("{stage}/"));
    let table = format!("The numbers are in <code>measurements/{}.csv</code>.", escape(&(folder + &curve.name)));
    let method = symbols(curve.method.trim());
    let stop = if method.is_empty() || method.ends_with('.') { "" } else { "." };
    let about = format!("{}{stop} {table}", escape(&method));
    let size = curve.variables.first().map_or(0, |variable| variable.values.len());
    let lone = |text: String| {
        vec![format!(
            "<figure>\n<h4>{}</h4>\n<figcaption>{text} {about}</figcaption>\n</figure>\n",
            escape(&curve.title)
        )]
    };
    match curve.variables.len() {
        1 => {
            let insufficient = || lone("<em>Insufficient data.</em>".to_owned()).concat();
            let of_unit = |curve: &Curve| line_figure(curve, &about).unwrap_or_else(insufficient);
            by_unit(curve).iter().map(of_unit).collect()
        }
        2 if size <= plot::MOST_CELLS => curve.series.iter().map(|series| map_figure(curve, series, &about)).collect(),
        2 => lone(format!("A grid of {size} cells, too many for a map.")),
        _ => lone(format!("A grid in {} dimensions with {size} cells.", curve.variables.len())),
    }
}

/// A density and a temperature cannot share an axis.
fn by_unit(curve: &Curve) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for series in &curve.series {
        match curves.iter_mut().find(|known| known.series[0].unit == series.unit) {
            Some(known) => known.series.push(series.clone()),
            None => curves.push(Curve { series: vec![series.clone()], ..curve.clone() }),
        }
    }
    if curves.len() > 1 {
        for curve in &mut curves {
            let names: Vec<&str> = curve.series.iter().map(|series| series.name.as_str()).collect();
            curve.title = format!("{}: {}", curve.title, names.join(", "));
        }
    }
    if curves.is_empty() { vec![curve.clone()] } else { curves }
}

fn line_figure(curve: &Curve, about: &str) -> Option<String> {
    let variable = curve.variables.first()?;
    let mut lines = Vec::new();
    for series in &curve.series {
        let points = variable.values.iter().zip(&series.values).zip(&series.standard_errors);
        let point = |((x, y), error): ((&f64, &Option<f64>), &Option<f64>)| {
            let error = error.filter(|error| error.is_finite()).unwrap_or(0.0).abs();
            y.map(|y| Point { x: *x, y, error })
        };
        let label = symbols(&series.name);
        lines.push(Line { label, points: points.map(point).collect(), ..Line::default() });
    }
    let measured = lines.len();
    let mut sources = String::new();
    for published in &curve.published {
        let points = published.x.iter().zip(&published.y).map(|(x, y)| Some(Point { x: *x, y: *y, error: 0.0 }));
        let (style, label) = (LineStyle::Published, published.label.clone());
        lines.push(Line { style, label, points: points.collect(), ..Line::default() });
        sources.push_str(&format!("{}: {} ", escape(&published.label), escape(&published.source)));
    }
    // With one published curve per series, each series is compared with its own curve. Otherwise, all series are
    // compared with the first curve.
    let (lines, published) = lines.split_at_mut(measured);
    for (number, line) in lines.iter_mut().enumerate() {
        let own = published.get(if published.len() == measured { number } else { 0 });
        line.deviations = own.map_or_else(Vec::new, |own| deviations(&line.points, &own.points));
    }
    let lines = [lines, published].concat();
    let unit = curve.series.first().map_or("1", |series| series.unit.as_str());
    let name = match curve.series.as_slice() {
        [one] => &one.name,
        _ => &curve.title,
    };
    let titles = [quantity(&variable.name, &variable.unit), quantity(name, unit)];
    let is_logarithmic = curve.is_logarithmic;
    let curves = Curves { label: curve.title.clone(), titles, is_logarithmic, lines, ..Curves::default() };
    curves_figure(&curve.title, &curves, &format!("{about} {sources}"))
}

fn map_figure(curve: &Curve, series: &Series, about: &str) -> String {
    let title = if curve.series.len() > 1 { format!("{}: {}", curve.title, series.name) } else { curve.title.clone() };
    let cells = match curve.variables.as_slice() {
        [x, y, ..] => {
            x.values.iter().zip(&y.values).zip(&series.values).map(|((x, y), value)| (*x, *y, *value)).collect()
        }
        _ => Vec::new(),
    };
    let mut titles: Vec<String> = curve.variables.iter().map(|v| quantity(&v.name, &v.unit)).collect();
    titles.push(quantity(&series.name, &series.unit));
    let map = |titles: [String; 3]| {
        let (is_logarithmic, errors) = (curve.is_logarithmic[1], series.standard_errors.clone());
        Map { label: title.clone(), titles, is_logarithmic, cells, errors }
    };
    let drawing = <[String; 3]>::try_from(titles).ok().and_then(|titles| map(titles).drawing());
    let error = series.standard_errors.iter().flatten().copied().filter(|error| error.is_finite()).reduce(f64::max);
    let error = error.map_or_else(String::new, |error| {
        let number = super::html::number(&crate::base::text::digits(error));
        format!("The largest standard error of a cell is {number}{}. ", escape(&brackets(&series.unit)))
    });
    match drawing {
        Some([svg, values]) => figure(&title, &with_values(&svg, &values), &format!("{error}{about}")),
        None => figure(&title, "", &format!("<em>Insufficient data.</em> {about}")),
    }
}

fn courses(results: &Results<'_>) -> Vec<String> {
    let find = |name: &str| results.thermo.iter().find(|trace| trace.name == name);
    let mut figures = Vec::new();
    let time = quantity("time", &results.unit_of("time"));
    let counts: Vec<&Trace> = results.thermo.iter().filter(|trace| trace.name.starts_with(IN)).collect();
    let is_alone = |trace: &&Trace| {
        trace.name != "events" && !ENERGIES.contains(&trace.name.as_str()) && !trace.name.starts_with(IN)
    };
    let energies: Vec<&Trace> = ENERGIES.iter().filter_map(|name| find(name)).collect();
    figures.extend(course("energy", &energies, None, &time));
    for trace in results.thermo.iter().filter(is_alone) {
        let estimate = results.observables.get(&trace.name).and_then(|observable| observable.estimate.finite());
        let level =
            estimate.map(|Estimate { mean, standard_error }| Level { mean, error: standard_error.unwrap_or(0.0) });
        figures.extend(course(&trace.name.replace('_', " "), &[trace], level, &time));
    }
    figures.extend(course("particles in regions", &counts, None, &time));
    figures
}

fn is_constant(trace: &Trace) -> bool {
    let extent = extent(trace.points().into_iter().flatten().map(|[_, y]| y));
    extent.is_none_or(|[least, most]| most - least <= SAME * least.abs().max(most.abs()))
}

fn course(title: &str, traces: &[&Trace], level: Option<Level>, time: &str) -> Option<String> {
    if traces.iter().all(|trace| is_constant(trace)) {
        return None;
    }
    let has = |name: &str| traces.iter().any(|trace| trace.name == name);
    let rotational = if has("rotational") { " + rotational" } else { "" };
    let supplied = if has("supplied") { " - supplied" } else { "" };
    let sum = format!("kinetic{rotational} + potential + dissipated{supplied}");
    let words = |name: &str| name.replace("energy_and_dissipated", &sum).replace('_', " ");
    let line = |trace: &&Trace| Line {
        style: LineStyle::TimeSeries,
        label: words(&trace.name),
        points: trace.points().into_iter().map(|point| point.map(|[x, y]| Point { x, y, error: 0.0 })).collect(),
        ..Line::default()
    };
    let first = traces.first()?;
    let name = if let [one] = traces { words(&one.name) } else { title.to_owned() };
    let curves = Curves {
        label: format!("{title} against time"),
        titles: [time.to_owned(), quantity(&name, &first.unit)],
        lines: traces.iter().map(line).collect(),
        level,
        ..Curves::default()
    };
    let mut text = String::new();
    if level.is_some() {
        text.push_str("Horizontal line: the mean over the measurement, with its standard error. ");
    }
    if traces.iter().any(|trace| trace.is_thinned()) {
        text.push_str("Not all rows can be drawn: of neighbouring rows, the lowest and the highest value are drawn. ");
    }
    text.push_str("From <code>thermo.csv</code>.");
    curves_figure(&unit(&capitalised(title)), &curves, &text)
}

pub(super) fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::instruments::{Published, Variable};

    #[test]
    fn each_series_is_compared_with_its_own_published_curve() {
        let series = |name: &str, value: f64| Series {
            name: name.to_owned(),
            unit: "1".to_owned(),
            values: vec![Some(value)],
            standard_errors: vec![Some(0.5)],
            normalisation: None,
        };
        let published = |label: &str, value: f64| Published {
            label: label.to_owned(),
            source: String::new(),
            x: vec![1.0],
            y: vec![value],
        };
        let curve = Curve::new("paths", "Free paths", "").variable("x", "length", vec![1.0]);
        let curve = Curve {
            series: vec![series("a", 3.0), series("b", 5.0)],
            published: vec![published("for a", 2.0), published("for b", 6.0)],
            ..curve
        };
        let figures = of_curve(&curve, None);
        assert!(
            figures[0].contains("\"deviations\":[2.0]") && figures[0].contains("\"deviations\":[-2.0]"),
            "{figures:?}"
        );
        assert!(figures[0].contains("of the same series"));
        let one = Curve { published: vec![published("for both", 2.0)], ..curve };
        assert!(of_curve(&one, None)[0].contains("\"deviations\":[6.0]"));
        let none = Curve { published: Vec::new(), ..one };
        assert!(!of_curve(&none, None)[0].contains("deviations"));
    }

    #[test]
    fn series_with_another_unit_get_their_own_figure() {
        let series = |name: &str, unit: &str| Series {
            name: name.to_owned(),
            unit: unit.to_owned(),
            values: vec![Some(1.0), Some(2.0)],
            standard_errors: vec![Some(0.1); 2],
            normalisation: None,
        };
        let curve = Curve {
            name: "profile".to_owned(),
            title: "Profile".to_owned(),
            method: String::new(),
            variables: vec![Variable { name: "z".to_owned(), unit: "length".to_owned(), values: vec![0.0, 1.0] }],
            series: vec![series("T_x", "energy"), series("density", "1 / length^3"), series("T_y", "energy")],
            is_logarithmic: [false; 2],
            published: Vec::new(),
        };
        let figures = of_curve(&curve, None);
        assert_eq!(figures.len(), 2);
        assert!(figures[0].contains("Profile: T_x, T_y") && figures[1].contains("Profile: density"));
        assert!(figures[0].contains("[energy]") && !figures[1].contains("[energy]"), "{figures:?}");
        let alone = Curve { series: vec![series("density", "1 / length^3")], ..curve };
        assert!(of_curve(&alone, None)[0].contains("<h4>Profile</h4>"));
    }
}
