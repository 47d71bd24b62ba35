//! Plots as SVG: curves with error bars or bands, and maps.
//!
//! The style sheet of the page sets colours and fonts.

mod axis;
mod curve;
mod deviations;
mod key;
mod map;
mod mark;
mod values;

use std::fmt::Write;

pub(super) use axis::Axis;
pub(super) use curve::{Curves, Level, Line, LineStyle, Point, extent};
pub(super) use deviations::deviations;
pub(super) use key::Key;
pub(super) use map::{MOST_CELLS, Map};
pub(super) use mark::mark;

use super::html::escape;

const WIDTH: f64 = 480.0;
/// Sides of the plot area `[pixels]`. Labels of nine letters fit beside the vertical axis.
const LEFT: f64 = 90.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 268.0;
/// Top and bottom of the strip of deviations `[pixels]`.
const STRIP: [f64; 2] = [284.0, 348.0];
const FOOT: f64 = 52.0;

/// Formats a coordinate to a tenth of a pixel.
fn px(x: f64) -> String {
    let text = format!("{:.1}", x.clamp(-1e5, 1e5));
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

/// Opens a plot. `foot` is the lower end of the plot area or strip. `label` is for screen readers.
fn open(label: &str, foot: f64) -> String {
    format!(
        "<svg class=\"plot\" viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"{}\" xmlns=\"http://www.w3.org/2000/svg\">",
        foot + FOOT,
        escape(label)
    )
}

/// Draws the axes of a plot area that ends at `right`. The labels of the horizontal axis are below `foot`.
fn frame(svg: &mut String, [x, y]: [&Axis; 2], titles: [&str; 2], right: f64, foot: f64) {
    for (place, is_labelled) in x.marks() {
        let at = px(x.place(place));
        if is_labelled {
            let text = escape(&x.label(place));
            let _ = write!(svg, "<path class=\"grid\" d=\"M{at} {TOP}V{BOTTOM}\"/>");
            let _ = write!(svg, "<text x=\"{at}\" y=\"{}\" text-anchor=\"middle\">{text}</text>", foot + 18.0);
        }
        let length = if is_labelled { 5 } else { 3 };
        let _ = write!(svg, "<path class=\"axis\" d=\"M{at} {BOTTOM}v{length}\"/>");
    }
    ticks_of_upright(svg, y, right);
    let _ = write!(svg, "<path class=\"axis\" d=\"M{LEFT} {TOP}V{BOTTOM}H{right}\"/>");
    name(svg, [0.5 * (LEFT + right), foot + 42.0], titles[0], right - LEFT, false);
    name(svg, [14.0, 0.5 * (TOP + BOTTOM)], titles[1], BOTTOM - TOP, true);
}

fn ticks_of_upright(svg: &mut String, y: &Axis, right: f64) {
    for (place, is_labelled) in y.marks() {
        let at = px(y.place(place));
        if is_labelled {
            let text = escape(&y.label(place));
            let _ = write!(svg, "<path class=\"grid\" d=\"M{LEFT} {at}H{right}\"/>");
            let _ = write!(svg, "<text x=\"{}\" y=\"{at}\" dy=\".32em\" text-anchor=\"end\">{text}</text>", LEFT - 8.0);
        }
        let length = if is_labelled { 5 } else { 3 };
        let _ = write!(svg, "<path class=\"axis\" d=\"M{LEFT} {at}h-{length}\"/>");
    }
}

/// Draws the axes of a strip. The vertical axis is in standard errors, with labels at 0, `labelled` and `-labelled`.
fn frame_of_strip(svg: &mut String, x: &Axis, y: &Axis, right: f64, labelled: f64) {
    let [top, bottom] = STRIP;
    for (place, is_labelled) in x.marks() {
        let (at, length) = (px(x.place(place)), if is_labelled { 5 } else { 3 });
        if is_labelled {
            let _ = write!(svg, "<path class=\"grid\" d=\"M{at} {top}V{bottom}\"/>");
        }
        let _ = write!(svg, "<path class=\"axis\" d=\"M{at} {bottom}v{length}\"/>");
    }
    for value in [-labelled, 0.0, labelled] {
        let (at, text) = (px(y.place(value)), super::html::number(&value.to_string()));
        let class = if value == 0.0 { "axis" } else { "grid" };
        let _ = write!(
            svg,
            "<path class=\"{class}\" d=\"M{LEFT} {at}H{right}\"/><path class=\"axis\" d=\"M{LEFT} {at}h-5\"/>"
        );
        let _ = write!(svg, "<text x=\"{}\" y=\"{at}\" dy=\".32em\" text-anchor=\"end\">{text}</text>", LEFT - 8.0);
    }
    let _ = write!(svg, "<path class=\"axis\" d=\"M{LEFT} {top}V{bottom}H{right}\"/>");
    name(svg, [14.0, 0.5 * (top + bottom)], "Δ / σ", bottom - top, true);
}

/// Writes the title of an axis. A title longer than `room` pixels is compressed.
fn name(svg: &mut String, middle: [f64; 2], title: &str, room: f64, is_upright: bool) {
    let [x, y] = middle.map(px);
    let turn = if is_upright { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
    // A letter is about 7 pixels wide.
    let is_long = 7.0 * title.chars().count() as f64 > room;
    let squeeze =
        if is_long { format!(" textLength=\"{}\" lengthAdjust=\"spacingAndGlyphs\"", px(room)) } else { String::new() };
    let title = escape(title);
    let _ =
        write!(svg, "<text class=\"name\" x=\"{x}\" y=\"{y}\" text-anchor=\"middle\"{turn}{squeeze}>{title}</text>");
}
