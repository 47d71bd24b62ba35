//! The numbers of a plot as JSON. A script shows the value at the pointer.

use serde::Serialize;

use super::Axis;
use super::curve::{Curves, LineStyle, Point};

#[derive(Debug, Serialize)]
struct Values<'c> {
    /// The third axis of a map is its colour scale.
    axes: Vec<Scale>,
    lines: Vec<Column<'c>>,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct Scale {
    title: String,
    is_logarithmic: bool,
    /// Ends of the axis (logarithms on a logarithmic axis), and their positions `[pixels]`.
    ends: [f64; 4],
}

/// Points of a line, or all cells of a map.
#[derive(Debug, Serialize)]
struct Column<'c> {
    label: &'c str,
    class: String,
    x: Vec<f64>,
    y: Vec<f64>,
    /// Values of the cells of a map.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    cells: Vec<f64>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    errors: Vec<f64>,
    /// Deviations from published values, in standard errors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    deviations: Vec<Option<f64>>,
}

/// Numbers are written with five digits, to keep large plots small.
pub(super) fn json(curves: &Curves, [x, y]: [&Axis; 2]) -> String {
    let lines = curves.lines.iter().zip(curves.classes()).map(|(line, class)| {
        let none = [];
        let deviations = if line.deviations.is_empty() { &none[..] } else { &line.deviations[..] };
        let deviations = deviations.iter().copied().chain(std::iter::repeat(None));
        let is_there = |(point, deviation): (&Option<Point>, Option<Point>)| Some(((*point)?, deviation));
        let points = line.points.iter().zip(deviations).filter_map(is_there);
        let points: Vec<(Point, Option<Point>)> =
            points.filter(|(point, _)| x.has_place(point.x) && y.has_place(point.y)).collect();
        let of = |value: fn(&Point) -> f64| points.iter().map(|(point, _)| short(value(point))).collect::<Vec<_>>();
        let has_errors = line.style == LineStyle::Measured && points.iter().any(|(point, _)| point.error > 0.0);
        let has_deviations = points.iter().any(|(_, deviation)| deviation.is_some());
        let deviations = || points.iter().map(|(_, deviation)| deviation.map(|it| short(it.y))).collect();
        Column {
            label: &line.label,
            class,
            x: of(|point| point.x),
            y: of(|point| point.y),
            cells: Vec::new(),
            errors: if has_errors { of(|point| point.error) } else { Vec::new() },
            deviations: if has_deviations { deviations() } else { Vec::new() },
        }
    });
    text(&curves.titles, &[x, y], lines.collect())
}

/// Returns the numbers of a map. The fourth number of each cell is the error, or 0 if the error is unknown.
pub(super) fn json_of_map(titles: &[String; 3], axes: &[&Axis; 3], cells: &[[f64; 4]]) -> String {
    let of = |k: usize| cells.iter().map(|cell| short(cell[k])).collect::<Vec<_>>();
    let has_errors = cells.iter().any(|cell| cell[3] > 0.0);
    let errors = if has_errors { of(3) } else { Vec::new() };
    let column =
        Column { label: "", class: String::new(), x: of(0), y: of(1), cells: of(2), errors, deviations: Vec::new() };
    text(titles, axes, vec![column])
}

fn text(titles: &[String], axes: &[&Axis], lines: Vec<Column<'_>>) -> String {
    let axis = |(axis, title): (&&Axis, &String)| {
        let (title, is_logarithmic) = (title.clone(), axis.is_logarithmic());
        Scale { title, is_logarithmic, ends: axis.scale().map(short) }
    };
    let values = Values { axes: axes.iter().zip(titles).map(axis).collect(), lines };
    serde_json::to_string(&values).unwrap_or_default()
}

fn short(value: f64) -> f64 {
    format!("{value:.4e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::super::{Line, Point};
    use super::*;

    #[test]
    fn a_plot_carries_its_points_and_their_errors() {
        let points =
            vec![Some(Point { x: 1.0, y: 2.000_049, error: 0.25 }), None, Some(Point { x: 0.0, y: 3.0, error: 0.0 })];
        let line = Line {
            label: "</script>".to_owned(),
            points,
            deviations: vec![Some(Point { x: 1.0, y: -1.5, error: 0.0 })],
            ..Line::default()
        };
        let curves = Curves { lines: vec![line], titles: ["x".to_owned(), "y".to_owned()], ..Curves::default() };
        let axis = Axis::new([1.0, 100.0], true).between(90.0, 466.0);
        let text = json(&curves, [&axis, &Axis::new([0.0, 5.0], false).between(268.0, 12.0)]);
        let values: serde_json::Value = serde_json::from_str(&text).unwrap();
        assert_eq!(values["axes"][0]["ends"], serde_json::json!([0.0, 2.0, 90.0, 466.0]));
        let line = &values["lines"][0];
        // A logarithmic axis has no position for zero.
        assert_eq!((&line["x"], &line["y"]), (&serde_json::json!([1.0]), &serde_json::json!([2.0])));
        assert_eq!((&line["errors"], &line["deviations"]), (&serde_json::json!([0.25]), &serde_json::json!([-1.5])));
    }
}
