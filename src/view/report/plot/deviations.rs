//! Deviations of measured values from a published curve, in a strip below the plot.

use std::fmt::Write;

use super::curve::{Curves, Line, LineStyle, Point};
use super::mark::{arrow, mark};
use super::{Axis, LEFT, STRIP, frame_of_strip, px};

/// Smallest and largest half-height of the strip, in standard errors. Arrows mark points beyond the strip.
const ENDS: [f64; 2] = [3.0, 8.0];

/// Returns `(measured - published) / sigma` for each measured point with a standard error `sigma`. The published curve
/// is interpolated, but not extrapolated.
pub(in crate::view::report) fn deviations(
    measured: &[Option<Point>],
    published: &[Option<Point>],
) -> Vec<Option<Point>> {
    let mut known: Vec<[f64; 2]> = published.iter().flatten().map(|point| [point.x, point.y]).collect();
    known.retain(|point| point.iter().all(|value| value.is_finite()));
    known.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let at = |x: f64| -> Option<f64> {
        let after = known.iter().position(|point| point[0] >= x)?;
        let [right, top] = known[after];
        if right == x {
            return Some(top);
        }
        let [left, bottom] = *known.get(after.checked_sub(1)?)?;
        Some(bottom + (top - bottom) * (x - left) / (right - left))
    };
    let deviation = |point: &Point| -> Option<Point> {
        let y = (point.y - at(point.x)?) / point.error;
        (point.error > 0.0 && y.is_finite()).then_some(Point { x: point.x, y, error: 0.0 })
    };
    measured.iter().map(|point| point.as_ref().and_then(deviation)).collect()
}

/// Draws the strip. The range of two standard errors is shaded.
pub(super) fn draw(svg: &mut String, curves: &Curves, x: &Axis, right: f64) {
    let points = |line: &Line| -> Vec<Point> {
        line.deviations.iter().flatten().copied().filter(|point| x.has_place(point.x)).collect()
    };
    let largest = curves.lines.iter().flat_map(points).map(|point| point.y.abs()).fold(0.0, f64::max);
    let end = if largest > ENDS[0] { largest.ceil().min(ENDS[1]) } else { ENDS[0] };
    let y = Axis::new([-end, end], false).widened(0.1).between(STRIP[1], STRIP[0]);
    let width = px(right - LEFT);
    let [top, bottom] = [2.0, -2.0].map(|value| y.place(value));
    let _ = write!(
        svg,
        "<rect class=\"level\" x=\"{LEFT}\" y=\"{}\" width=\"{width}\" height=\"{}\"/>",
        px(top),
        px(bottom - top)
    );
    frame_of_strip(svg, x, &y, right, if end > 5.0 { 6.0 } else { 2.0 });
    for (number, (class, line)) in curves.classes().iter().zip(&curves.lines).enumerate() {
        let points = points(line);
        if line.style == LineStyle::Published || points.is_empty() {
            continue;
        }
        let _ = write!(svg, "<g class=\"{class}\">");
        for point in &points {
            let place = [x.place(point.x), y.place(point.y)];
            svg.push_str(&match point.y {
                above if above > end => arrow([place[0], STRIP[0] + 1.0], true),
                below if below < -end => arrow([place[0], STRIP[1] - 1.0], false),
                _ => mark(number, place),
            });
        }
        svg.push_str("</g>");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, error: f64) -> Option<Point> {
        Some(Point { x, y, error })
    }

    #[test]
    fn deviations_are_in_standard_errors_and_only_where_both_are_known() {
        let published = [point(3.0, 30.0, 0.0), None, point(1.0, 10.0, 0.0), point(2.0, 20.0, 0.0)];
        let measured = [
            point(0.5, 1.0, 1.0),
            point(1.0, 12.0, 0.5),
            point(2.5, 24.0, 2.0),
            point(2.0, 9.0, 0.0),
            None,
            point(4.0, 1.0, 1.0),
        ];
        let expected = [None, point(1.0, 4.0, 0.0), point(2.5, -0.5, 0.0), None, None, None];
        assert_eq!(deviations(&measured, &published), expected);
        assert_eq!(deviations(&measured, &[]), vec![None; 6]);
    }

    #[test]
    fn far_deviations_are_arrows_at_the_edge() {
        let line = |values: &[f64]| Line {
            deviations: values.iter().zip(0..).map(|(y, x)| point(f64::from(x), *y, 0.0)).collect(),
            ..Line::default()
        };
        let drawn = |values: &[f64]| {
            let mut svg = String::new();
            draw(
                &mut svg,
                &Curves { lines: vec![line(values)], ..Curves::default() },
                &Axis::new([0.0, 5.0], false).between(90.0, 466.0),
                466.0,
            );
            svg
        };
        let near = drawn(&[1.0, -2.5, 7.0]);
        assert_eq!((near.matches("<circle").count(), near.matches("class=\"mark\"").count()), (3, 0), "{near}");
        let far = drawn(&[1.0, -900.0, 70.0]);
        assert_eq!((far.matches("<circle").count(), far.matches("class=\"mark\"").count()), (1, 2), "{far}");
    }
}
