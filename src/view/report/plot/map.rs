//! Maps that show a quantity as colour against two variables.

use std::collections::BTreeMap;
use std::fmt::Write;

use ordered_float::OrderedFloat;

use super::curve::{LARGEST_RATIO, extent};
use super::{Axis, BOTTOM, LEFT, TOP, WIDTH, frame, open, px, values};
use crate::base::numbers::trunc_to_usize;

/// Right end of the plot area, and left and right ends of the colour scale `[pixels]`.
const RIGHT: f64 = WIDTH - 108.0;
const SCALE: [f64; 2] = [WIDTH - 92.0, WIDTH - 76.0];

/// Number of colours for maps in the style sheet.
pub(in crate::view::report) const LEVELS: usize = 32;

/// Largest number of cells of a map.
pub(in crate::view::report) const MOST_CELLS: usize = 40_000;

/// Largest number of cells whose values the page shows at the pointer. More values would make the page large.
const MOST_SHOWN: usize = 5_000;

#[derive(Debug, Clone, PartialEq)]
pub(in crate::view::report) struct Map {
    /// Label for screen readers.
    pub label: String,
    /// Titles of both axes and of the colour scale, with units.
    pub titles: [String; 3],
    pub is_logarithmic: bool,
    /// Coordinates `x` and `y` and the value of each cell. The value may be missing.
    pub cells: Vec<(f64, f64, Option<f64>)>,
    /// Standard error of each cell, if known.
    pub errors: Vec<Option<f64>>,
}

impl Map {
    /// Returns the plot, and its numbers as JSON if there are not too many. `None` if there is nothing to draw.
    pub fn drawing(&self) -> Option<[String; 2]> {
        let columns = edges(self.cells.iter().map(|cell| cell.0))?;
        let rows = edges(self.cells.iter().map(|cell| cell.1))?;
        let is_logarithmic = self.is_logarithmic || self.asks_for_logarithms();
        let can = |value: &f64| value.is_finite() && (!is_logarithmic || *value > 0.0);
        let values = || self.cells.iter().filter_map(|cell| cell.2).filter(can);
        let (low, high) = (values().reduce(f64::min)?, values().reduce(f64::max)?);
        let ends = |edges: &BTreeMap<OrderedFloat<f64>, [f64; 2]>| {
            let first = edges.values().next().map_or(0.0, |edge| edge[0]);
            [first, edges.values().next_back().map_or(1.0, |edge| edge[1])]
        };
        let x = Axis::new(ends(&columns), false).between(LEFT, RIGHT);
        let y = Axis::new(ends(&rows), false).between(BOTTOM, TOP);
        let scale = Axis::new([low, high], is_logarithmic).between(BOTTOM, TOP);
        let mut paths = vec![String::new(); LEVELS];
        for (column, row, value) in &self.cells {
            let (Some(value), Some(across), Some(up)) =
                (value.filter(can), columns.get(&OrderedFloat(*column)), rows.get(&OrderedFloat(*row)))
            else {
                continue;
            };
            let [left, right] = across.map(|edge| x.place(edge));
            let [lower, upper] = up.map(|edge| y.place(edge));
            let level = trunc_to_usize(scale.fraction(value) * LEVELS as f64).min(LEVELS - 1);
            let (width, height) = (px(right - left), px(lower - upper));
            let _ = write!(paths[level], "M{} {}h{width}v{height}h-{width}z", px(left), px(upper));
        }
        let mut svg = open(&self.label, BOTTOM);
        frame(&mut svg, [&x, &y], [&self.titles[0], &self.titles[1]], RIGHT, BOTTOM);
        for (level, path) in paths.iter().enumerate().filter(|(_, path)| !path.is_empty()) {
            let _ = write!(svg, "<path class=\"m{level}\" d=\"{path}\"/>");
        }
        self.draw_scale(&mut svg, &scale);
        svg.push_str("</svg>");
        let errors = self.errors.iter().copied().chain(std::iter::repeat(None));
        let known = self.cells.iter().zip(errors).filter_map(|((x, y, value), error)| {
            let error = error.filter(|error| error.is_finite()).unwrap_or(0.0);
            (x.is_finite() && y.is_finite()).then_some([*x, *y, value.filter(can)?, error])
        });
        let known: Vec<[f64; 4]> = if self.cells.len() > MOST_SHOWN { Vec::new() } else { known.collect() };
        Some([svg, values::json_of_map(&self.titles, &[&x, &y, &scale], &known)])
    }

    fn asks_for_logarithms(&self) -> bool {
        let extent = extent(self.cells.iter().filter_map(|cell| cell.2));
        extent.is_some_and(|[least, most]| least > 0.0 && most > LARGEST_RATIO * least)
    }

    fn draw_scale(&self, svg: &mut String, scale: &Axis) {
        let [left, right] = SCALE;
        let height = (BOTTOM - TOP) / LEVELS as f64;
        for level in 0..LEVELS {
            let top = px(BOTTOM - (level + 1) as f64 * height);
            let (width, height) = (right - left, px(height + 0.3));
            let _ = write!(
                svg,
                "<rect class=\"m{level}\" x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"/>"
            );
        }
        for (value, _) in scale.marks().into_iter().filter(|mark| mark.1) {
            let (at, text) = (px(scale.place(value)), super::escape(&scale.label(value)));
            let _ = write!(svg, "<path class=\"axis\" d=\"M{right} {at}h4\"/>");
            let _ = write!(svg, "<text x=\"{}\" y=\"{at}\" dy=\".32em\">{text}</text>", right + 7.0);
        }
        super::name(svg, [WIDTH - 6.0, 0.5 * (TOP + BOTTOM)], &self.titles[2], BOTTOM - TOP, true);
    }
}

/// Returns the coordinates of a grid in ascending order, each with the edges of its cell.
fn edges(coordinates: impl Iterator<Item = f64>) -> Option<BTreeMap<OrderedFloat<f64>, [f64; 2]>> {
    let mut all: Vec<f64> = coordinates.filter(|x| x.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    let (first, last) = (*all.first()?, *all.last()?);
    let before = all.get(1).map_or(first - 0.5, |next| first - 0.5 * (next - first));
    let after = all.iter().rev().nth(1).map_or(last + 0.5, |previous| last + 0.5 * (last - previous));
    let middles = all.windows(2).map(|two| 0.5 * two[0] + 0.5 * two[1]);
    let bounds: Vec<f64> = [before].into_iter().chain(middles).chain([after]).collect();
    Some(all.iter().zip(bounds.windows(2)).map(|(&x, two)| (OrderedFloat(x), [two[0], two[1]])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_end_half_way_between_their_centres() {
        let edges = edges([2.0, 0.0, 1.0, 1.0].into_iter()).unwrap();
        let edges: Vec<[f64; 2]> = edges.into_values().collect();
        assert_eq!(edges, [[-0.5, 0.5], [0.5, 1.5], [1.5, 2.5]]);
    }

    #[test]
    fn the_highest_cell_has_the_last_colour_and_an_unknown_one_has_none() {
        let cells = vec![(0.0, 0.0, Some(1.0)), (1.0, 0.0, Some(2.0)), (0.0, 1.0, None), (1.0, 1.0, Some(f64::NAN))];
        let titles = ["x", "y", "value"].map(str::to_owned);
        let map = Map { label: "m".to_owned(), titles, is_logarithmic: false, cells, errors: vec![Some(0.5)] };
        let [svg, values] = map.drawing().unwrap();
        assert!(values.contains("\"cells\":[1.0,2.0],\"errors\":[0.5,0.0]"), "{values}");
        assert!(svg.contains("<path class=\"m0\"") && svg.contains("<path class=\"m31\""), "{svg}");
        assert_eq!(svg.matches("<path class=\"m").count(), 2);
        assert!(!svg.contains("NaN"));
    }
}
