//! Curves against one variable.

use std::fmt::Write;

use super::{Axis, BOTTOM, LEFT, TOP, WIDTH, frame, open, px};

/// Where the field ends `[pixels]`.
const RIGHT: f64 = WIDTH - 14.0;

/// Curves with more points show their errors as a band.
const MOST_BARS: usize = 60;

/// A measured value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::view::report) struct Point {
    pub x: f64,
    pub y: f64,
    /// Standard error; 0 if there is none to show.
    pub error: f64,
}

/// How a line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::view::report) enum LineStyle {
    /// Measured values: points with bars, or a line with a band.
    Measured,
    /// A time series: a line.
    TimeSeries,
    /// Published values: dashes.
    Published,
}

/// A line of a plot. Its index in the plot decides its colour, except that published lines count for themselves.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::view::report) struct Line {
    pub style: LineStyle,
    /// Words in the legend.
    pub label: String,
    /// `None` where there is a gap.
    pub points: Vec<Option<Point>>,
}

/// A mean with its error, as a band across the plot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::view::report) struct Level {
    pub mean: f64,
    pub error: f64,
}

/// A plot of curves.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::view::report) struct Curves {
    /// Label for readers that cannot see the plot.
    pub label: String,
    /// Titles of the axes with units.
    pub titles: [String; 2],
    pub is_logarithmic: [bool; 2],
    pub lines: Vec<Line>,
    pub level: Option<Level>,
}

impl Curves {
    /// The plot; `None` if there is no point to draw.
    pub fn svg(&self) -> Option<String> {
        let x = Axis::new(self.horizontal()?, self.is_logarithmic[0]).widened(0.02).between(LEFT, RIGHT);
        let y = Axis::new(self.vertical()?, self.is_logarithmic[1]).widened(0.06).between(BOTTOM, TOP);
        let mut svg = open(&self.label);
        frame(&mut svg, &x, &y, [&self.titles[0], &self.titles[1]], RIGHT);
        // What is outside of the field is cut off by an inner image.
        let (width, height) = (RIGHT - LEFT, BOTTOM - TOP);
        let view = format!("{LEFT} {TOP} {width} {height}");
        let _ = write!(svg, "<svg x=\"{LEFT}\" y=\"{TOP}\" width=\"{width}\" height=\"{height}\" viewBox=\"{view}\">");
        if let Some(level) = self.level.filter(|level| y.has_place(level.mean)) {
            let ends = [level.mean + level.error, level.mean - level.error].map(|value| y.place(value));
            let height = px((ends[1] - ends[0]).max(0.0));
            let _ = write!(
                svg,
                "<rect class=\"level\" x=\"{LEFT}\" y=\"{}\" width=\"{width}\" height=\"{height}\"/>",
                px(ends[0])
            );
            let _ = write!(svg, "<path class=\"level\" d=\"M{LEFT} {}H{RIGHT}\"/>", px(y.place(level.mean)));
        }
        for (class, line) in self.classes().into_iter().zip(&self.lines) {
            draw(&mut svg, line, &class, &x, &y);
        }
        svg.push_str("</svg></svg>");
        Some(svg)
    }

    /// The legend: class in the style sheet and words of each line.
    pub fn legend(&self) -> Vec<(String, &str)> {
        self.classes().into_iter().zip(self.lines.iter().map(|line| line.label.as_str())).collect()
    }

    /// Class of each line in the style sheet, which has its colour.
    fn classes(&self) -> Vec<String> {
        let (mut measured, mut published) = (0, 0);
        let class = |line: &Line| {
            let (class, number) = match line.style {
                LineStyle::Published => ("published p", &mut published),
                LineStyle::Measured | LineStyle::TimeSeries => ("s", &mut measured),
            };
            *number += 1;
            format!("{class}{}", (*number - 1) % COLOURS)
        };
        self.lines.iter().map(class).collect()
    }

    fn drawn(&self, is_drawn: impl Fn(LineStyle) -> bool) -> impl Iterator<Item = &Point> {
        let can = |k: usize, value: f64| value.is_finite() && (!self.is_logarithmic[k] || value > 0.0);
        let lines = self.lines.iter().filter(move |line| is_drawn(line.style));
        lines.flat_map(|line| line.points.iter().flatten()).filter(move |point| can(0, point.x) && can(1, point.y))
    }

    fn horizontal(&self) -> Option<[f64; 2]> {
        extent(self.drawn(|style| style != LineStyle::Published).map(|point| point.x))
    }

    /// Extent of the measured values with their errors and, as far as these do not dwarf them, of the published ones.
    fn vertical(&self) -> Option<[f64; 2]> {
        let measured = || self.drawn(|style| style != LineStyle::Published);
        let [low, high] = extent(measured().map(|point| point.y).chain(self.level.map(|level| level.mean)))?;
        let ends = measured().flat_map(|point| [point.y - point.error, point.y + point.error]);
        let [left, right] = self.horizontal()?;
        let published =
            self.drawn(|style| style == LineStyle::Published).filter(|point| (left..=right).contains(&point.x));
        let more = ends.chain(published.map(|point| point.y)).filter(|y| !self.is_logarithmic[1] || *y > 0.0);
        let (least, most) = if self.is_logarithmic[1] {
            (low / 10.0, high * 10.0)
        } else if high > low {
            (low - (high - low), high + (high - low))
        } else {
            (f64::NEG_INFINITY, f64::INFINITY)
        };
        extent(more.map(|y| y.clamp(least, most)).chain([low, high]))
    }
}

/// Colours of the style sheet.
pub(in crate::view::report) const COLOURS: usize = 8;

/// The least and the largest of the values that are finite.
pub(in crate::view::report) fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.filter(|value| value.is_finite()).fold(None, |range, value| {
        let [low, high] = range.unwrap_or([value, value]);
        Some([low.min(value), high.max(value)])
    })
}

fn draw(svg: &mut String, line: &Line, class: &str, x: &Axis, y: &Axis) {
    let runs = runs(line, x, y);
    let number = runs.iter().map(Vec::len).sum::<usize>();
    let has_bars = line.style == LineStyle::Measured && number <= MOST_BARS;
    let _ = write!(svg, "<g class=\"{class}\">");
    let at = |point: &Point| format!("{} {}", px(x.place(point.x)), px(y.place(point.y)));
    if line.style == LineStyle::Measured && !has_bars {
        for run in &runs {
            let side = |sign: f64| run.iter().map(move |p| Point { y: p.y + sign * p.error, ..*p });
            let lowest = |mut p: Point| {
                p.y = if y.has_place(p.y) { p.y } else { f64::MIN_POSITIVE };
                at(&p)
            };
            let outline: Vec<String> = side(1.0).chain(side(-1.0).rev()).map(lowest).collect();
            let _ = write!(svg, "<path class=\"band\" d=\"M{}Z\"/>", outline.join("L"));
        }
    }
    for run in runs.iter().filter(|run| run.len() > 1) {
        let places: Vec<String> = run.iter().map(at).collect();
        let thin = if has_bars { " class=\"thin\"" } else { "" };
        let _ = write!(svg, "<path{thin} d=\"M{}\"/>", places.join("L"));
    }
    for point in runs.iter().filter(|run| has_bars || run.len() == 1).flatten() {
        bar(svg, point, x, y);
    }
    svg.push_str("</g>");
}

/// A point with its error bar.
fn bar(svg: &mut String, point: &Point, x: &Axis, y: &Axis) {
    let (left, height) = (px(x.place(point.x)), px(y.place(point.y)));
    if point.error > 0.0 {
        let ends = [point.y - point.error, point.y + point.error];
        let [low, high] = ends.map(|end| px(y.place(if y.has_place(end) { end } else { f64::MIN_POSITIVE })));
        let _ = write!(svg, "<path d=\"M{left} {low}V{high}m-3 0h6M{left} {low}m-3 0h6\"/>");
    }
    let _ = write!(svg, "<circle cx=\"{left}\" cy=\"{height}\" r=\"2.6\"/>");
}

/// The points without a gap between them.
fn runs(line: &Line, x: &Axis, y: &Axis) -> Vec<Vec<Point>> {
    let mut runs: Vec<Vec<Point>> = vec![Vec::new()];
    for point in &line.points {
        match (point.filter(|point| x.has_place(point.x) && y.has_place(point.y)), runs.last_mut()) {
            (Some(point), Some(run)) => run.push(point),
            _ => runs.push(Vec::new()),
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}
