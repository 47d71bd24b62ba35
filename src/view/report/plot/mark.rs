//! Markers distinguish lines without colour.

use super::px;

/// Markers 1 to 7 as SVG paths around the origin, with similar areas. Marker 0 is a circle.
const SHAPES: [&str; 7] = [
    "m-2.6 -2.6h5.2v5.2h-5.2z",
    "m0 -3.7l3.7 3.7l-3.7 3.7l-3.7 -3.7z",
    "m0 -3.6l3.5 6h-7z",
    "m0 3.6l3.5 -6h-7z",
    "m-3 -3l6 6m0 -6l-6 6",
    "m0 -3.8v7.6m-3.8 -3.8h7.6",
    "m-3.4 0h6.8",
];

/// Index of the first marker that cannot be filled.
const FIRST_OPEN: usize = 5;

/// Returns the marker for the line with an index, at a position `[pixels]`.
pub(in crate::view::report) fn mark(line: usize, [x, y]: [f64; 2]) -> String {
    let (x, y) = (px(x), px(y));
    match (line % (SHAPES.len() + 1)).checked_sub(1) {
        None => format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"2.6\"/>"),
        Some(shape) if shape + 1 < FIRST_OPEN => format!("<path class=\"mark\" d=\"M{x} {y}{}\"/>", SHAPES[shape]),
        Some(shape) => format!("<path d=\"M{x} {y}{}\"/>", SHAPES[shape]),
    }
}

pub(super) fn arrow([x, y]: [f64; 2], is_upward: bool) -> String {
    let shape = if is_upward { "l4 6h-8z" } else { "l4 -6h-8z" };
    format!("<path class=\"mark\" d=\"M{} {}{shape}\"/>", px(x), px(y))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn neighbouring_lines_have_different_marks() {
        let marks: BTreeSet<String> = (0..super::super::curve::COLOURS).map(|line| mark(line, [10.0, 20.0])).collect();
        assert_eq!(marks.len(), super::super::curve::COLOURS);
        assert_eq!(mark(0, [1.0, 2.0]), mark(super::super::curve::COLOURS, [1.0, 2.0]));
    }
}
