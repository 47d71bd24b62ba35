//! Plots of curves.

use std::fmt::Write;

use super::{Axis, BOTTOM, Key, LEFT, STRIP, TOP, WIDTH, deviations, frame, key, mark, open, px, values};

const RIGHT: f64 = WIDTH - 14.0;

/// Largest number of points with error bars. Longer lines show errors as a band.
const MOST_BARS: usize = 60;

/// Largest number of markers on a line without error bars.
const SPARSE: usize = 9;

/// Largest ratio of values on a linear axis: two and a half decades.
pub(super) const LARGEST_RATIO: f64 = 316.3;

/// Error bands extend the vertical axis by at most twice the range of values, or two decades on a logarithmic axis.
const WIDEST_BAND: f64 = 2.0;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::view::report) struct Point {
    pub x: f64,
    pub y: f64,
    /// Standard error; 0 if unknown or hidden.
    pub error: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(in crate::view::report) enum LineStyle {
    /// Points with error bars, or a line with a band.
    #[default]
    Measured,
    TimeSeries,
    Published,
}

/// A line of a plot. Its index determines its colour and marker. Published lines are counted separately.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::view::report) struct Line {
    pub style: LineStyle,
    pub label: String,
    /// Points in order; `None` for a gap.
    pub points: Vec<Option<Point>>,
    /// Deviations from published values, in standard errors. There may be fewer deviations than points.
    pub deviations: Vec<Option<Point>>,
    pub tone: Option<usize>,
}

/// A mean with its error, drawn as a horizontal band across the plot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::view::report) struct Level {
    pub mean: f64,
    pub error: f64,
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::view::report) struct Curves {
    pub label: String,
    pub titles: [String; 2],
    pub is_logarithmic: [bool; 2],
    pub lines: Vec<Line>,
    pub level: Option<Level>,
    pub key: Option<Key>,
}

impl Curves {
    /// Returns the plot and its numbers as JSON; `None` if there are no points.
    pub fn drawing(&self) -> Option<[String; 2]> {
        let mut scaled = self.clone();
        scaled.is_logarithmic = [0, 1].map(|k| self.is_logarithmic[k] || self.asks_for_logarithms(k));
        let right = if self.key.is_some() { key::RIGHT } else { RIGHT };
        let x = Axis::new(scaled.horizontal()?, scaled.is_logarithmic[0]).widened(0.02).between(LEFT, right);
        let y = Axis::new(scaled.vertical()?, scaled.is_logarithmic[1]).widened(0.06).between(BOTTOM, TOP);
        Some([scaled.svg(&x, &y, right), values::json(&scaled, [&x, &y])])
    }

    fn svg(&self, x: &Axis, y: &Axis, right: f64) -> String {
        let has_strip = self.lines.iter().any(|line| line.deviations.iter().any(Option::is_some));
        let foot = if has_strip { STRIP[1] } else { BOTTOM };
        let mut svg = open(&self.label, foot);
        frame(&mut svg, [x, y], [&self.titles[0], &self.titles[1]], right, foot);
        // A nested `svg` element clips at the plot area.
        let (width, height) = (right - LEFT, BOTTOM - TOP);
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
            let _ = write!(svg, "<path class=\"level\" d=\"M{LEFT} {}H{right}\"/>", px(y.place(level.mean)));
        }
        let is_alone = self.lines.len() < 2 || self.key.is_some();
        for (number, (class, line)) in self.classes().into_iter().zip(&self.lines).enumerate() {
            let _ = write!(svg, "<g class=\"{class}\">");
            draw(&mut svg, line, (!is_alone).then_some(number), x, y);
            svg.push_str("</g>");
        }
        svg.push_str("</svg>");
        if has_strip {
            deviations::draw(&mut svg, self, x, right);
        }
        if let Some(key) = &self.key {
            key.draw(&mut svg);
        }
        svg.push_str("</svg>");
        svg
    }

    pub fn legend(&self) -> Vec<(usize, String, &Line)> {
        let lines = self.classes().into_iter().zip(&self.lines).enumerate();
        lines.map(|(number, (class, line))| (number, class, line)).collect()
    }

    pub(super) fn classes(&self) -> Vec<String> {
        let (mut measured, mut published) = (0, 0);
        let class = |line: &Line| {
            let (class, number) = match (line.style, line.tone) {
                (LineStyle::Published, _) => ("published p", &mut published),
                (_, Some(tone)) => return format!("f{tone}"),
                (LineStyle::Measured | LineStyle::TimeSeries, None) => ("s", &mut measured),
            };
            *number += 1;
            format!("{class}{}", (*number - 1) % COLOURS)
        };
        self.lines.iter().map(class).collect()
    }

    /// Whether values need a logarithmic axis. All values must be positive, and their range must be large. On the
    /// horizontal axis, the median must be below a tenth of the largest value, and no line may be a time series. On the
    /// vertical axis, all values must exceed their errors.
    fn asks_for_logarithms(&self, k: usize) -> bool {
        let lines = || self.lines.iter().filter(|line| line.style != LineStyle::Published);
        let points = || lines().flat_map(|line| line.points.iter().flatten());
        let mut values: Vec<f64> = points().map(|point| if k == 0 { point.x } else { point.y }).collect();
        values.retain(|value| value.is_finite());
        values.sort_by(f64::total_cmp);
        let (Some(least), Some(most), Some(middle)) = (values.first(), values.last(), values.get(values.len() / 2))
        else {
            return false;
        };
        let is_wide = *least > 0.0 && most / least > LARGEST_RATIO;
        match k {
            0 => is_wide && *middle < 0.1 * most && lines().all(|line| line.style != LineStyle::TimeSeries),
            _ => {
                is_wide
                    && points().all(|point| point.y > point.error)
                    && self.level.is_none_or(|level| level.mean > level.error)
            }
        }
    }

    fn drawn(&self, is_drawn: impl Fn(LineStyle) -> bool) -> impl Iterator<Item = &Point> {
        let can = |k: usize, value: f64| value.is_finite() && (!self.is_logarithmic[k] || value > 0.0);
        let lines = self.lines.iter().filter(move |line| is_drawn(line.style));
        lines.flat_map(|line| line.points.iter().flatten()).filter(move |point| can(0, point.x) && can(1, point.y))
    }

    fn horizontal(&self) -> Option<[f64; 2]> {
        extent(self.drawn(|style| style != LineStyle::Published).map(|point| point.x))
    }

    /// Returns the range of the vertical axis. Published values extend each side by at most the measured range, or by
    /// one decade on a logarithmic axis.
    fn vertical(&self) -> Option<[f64; 2]> {
        let measured = || self.drawn(|style| style != LineStyle::Published);
        let level =
            self.level.iter().flat_map(|level| [level.mean - level.error, level.mean, level.mean + level.error]);
        let can = |y: &f64| !self.is_logarithmic[1] || *y > 0.0;
        let [low, high] = extent(measured().map(|point| point.y).chain(level).filter(can))?;
        let [left, right] = self.horizontal()?;
        let published =
            self.drawn(|style| style == LineStyle::Published).filter(|point| (left..=right).contains(&point.x));
        let within = |room: f64| match (self.is_logarithmic[1], high > low) {
            (true, _) => [low / 10_f64.powf(room), high * 10_f64.powf(room)],
            (false, true) => [low - room * (high - low), high + room * (high - low)],
            (false, false) => [f64::NEG_INFINITY, f64::INFINITY],
        };
        let ends = self.lines.iter().filter(|line| line.style == LineStyle::Measured).flat_map(|line| {
            let [least, most] = if has_bars(line) { [f64::NEG_INFINITY, f64::INFINITY] } else { within(WIDEST_BAND) };
            let points = line.points.iter().flatten();
            points.flat_map(|point| [point.y - point.error, point.y + point.error]).map(move |y| y.clamp(least, most))
        });
        let [least, most] = within(1.0);
        // On a logarithmic axis, error bars reach at most two decades below the smallest value.
        let lowest = if self.is_logarithmic[1] { low / 100.0 } else { f64::NEG_INFINITY };
        let ends = ends.filter(can).map(|y| y.max(lowest));
        extent(ends.chain(published.map(|point| point.y.clamp(least, most))).chain([low, high]))
    }
}

fn has_bars(line: &Line) -> bool {
    line.style == LineStyle::Measured && line.points.iter().flatten().count() <= MOST_BARS
}

/// Number of line colours in the style sheet.
pub(super) const COLOURS: usize = 8;

pub(in crate::view::report) fn extent(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    values.filter(|value| value.is_finite()).fold(None, |range, value| {
        let [low, high] = range.unwrap_or([value, value]);
        Some([low.min(value), high.max(value)])
    })
}

/// `number` selects the marker; `None` for lines without markers.
fn draw(svg: &mut String, line: &Line, number: Option<usize>, x: &Axis, y: &Axis) {
    let runs = runs(line, x, y);
    let has_bars = has_bars(line);
    let at = |point: &Point| format!("{} {}", px(x.place(point.x)), px(y.place(point.y)));
    if line.style == LineStyle::Measured && !has_bars {
        for run in runs.iter().filter(|run| run.iter().any(|point| point.error > 0.0)) {
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
    let place = |point: &Point| [x.place(point.x), y.place(point.y)];
    for point in runs.iter().filter(|run| has_bars || run.len() == 1).flatten() {
        bar(svg, point, x, y);
        svg.push_str(&mark(number.unwrap_or(0), place(point)));
    }
    if let Some(number) = number.filter(|_| !has_bars && line.style != LineStyle::Published) {
        let points: Vec<&Point> = runs.iter().flatten().collect();
        let stride = points.len().div_ceil(SPARSE).max(1);
        // Markers are shifted from line to line, so that markers of nearly equal lines do not overlap.
        for point in points.iter().skip((number * stride / 4) % stride).step_by(stride) {
            svg.push_str(&mark(number, place(point)));
        }
    }
}

/// An error bar that extends below the plot area has no lower cap.
fn bar(svg: &mut String, point: &Point, x: &Axis, y: &Axis) {
    if point.error > 0.0 {
        let [low, high] = [point.y - point.error, point.y + point.error];
        let (left, top) = (px(x.place(point.x)), px(y.place(high)));
        let _ = match y.has_place(low) && y.fraction(low) >= 0.0 {
            true => write!(svg, "<path d=\"M{left} {0}V{top}m-3 0h6M{left} {0}m-3 0h6\"/>", px(y.place(low))),
            false => write!(svg, "<path d=\"M{left} {BOTTOM}V{top}m-3 0h6\"/>"),
        };
    }
}

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

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: &[(f64, f64, f64)]) -> Line {
        Line { points: points.iter().map(|&(x, y, error)| Some(Point { x, y, error })).collect(), ..Line::default() }
    }

    fn curves(points: &[(f64, f64, f64)]) -> Curves {
        Curves { lines: vec![line(points)], ..Curves::default() }
    }

    fn ends(curves: &Curves) -> serde_json::Value {
        let [_, values] = curves.drawing().unwrap();
        serde_json::from_str::<serde_json::Value>(&values).unwrap()["axes"].clone()
    }

    #[test]
    fn bars_are_within_the_frame() {
        let axes = ends(&curves(&[(0.0, 1.0, 0.1), (1.0, 2.0, 30.0), (2.0, 1.5, 0.1)]));
        let ends: Vec<f64> = axes[1]["ends"].as_array().unwrap().iter().map(|it| it.as_f64().unwrap()).collect();
        assert!(ends[0] < -28.0 && ends[1] > 32.0, "{ends:?}");
        // A wide band is cut off, so that the curve remains visible.
        let many: Vec<(f64, f64, f64)> = (0..100).map(|k| (f64::from(k), f64::from(k), 1e4)).collect();
        let axes = self::ends(&curves(&many));
        assert!(axes[1]["ends"][1].as_f64().unwrap() < 400.0, "{axes}");
    }

    #[test]
    fn values_over_decades_have_logarithmic_axes() {
        let is_logarithmic =
            |points: &[(f64, f64, f64)]| [0, 1].map(|k| ends(&curves(points))[k]["isLogarithmic"] == true);
        let decades: Vec<(f64, f64, f64)> = (-4..3).map(|k| (10_f64.powi(k), 10_f64.powi(2 * k), 0.0)).collect();
        assert_eq!(is_logarithmic(&decades), [true, true]);
        // The axis is linear if values are evenly spaced, or if a value is zero.
        let even: Vec<(f64, f64, f64)> = (1..2000).map(|k| (f64::from(k), 1.0 + f64::from(k) / 100.0, 0.0)).collect();
        assert_eq!(is_logarithmic(&even), [false, false]);
        assert_eq!(is_logarithmic(&[(1.0, 0.0, 0.0), (2.0, 1.0, 0.0), (3.0, 1e4, 0.0)]), [false, false]);
        // The axis is linear if a value is zero within its error.
        assert_eq!(is_logarithmic(&[(1.0, 1e-4, 0.1), (2.0, 1.0, 0.1), (3.0, 2.0, 0.1)]), [false, false]);
    }

    #[test]
    fn multiple_lines_have_different_marks() {
        let points: Vec<(f64, f64, f64)> = (0..100).map(|k| (f64::from(k), f64::from(k), 0.0)).collect();
        let two = Curves { lines: vec![line(&points), line(&points)], ..Curves::default() };
        let [svg, _] = two.drawing().unwrap();
        assert!(svg.contains("<circle") && svg.contains("class=\"mark\""), "{svg}");
        let [svg, _] = curves(&points).drawing().unwrap();
        assert!(!svg.contains("<circle") && !svg.contains("class=\"mark\""), "{svg}");
    }

    #[test]
    fn curve_family_has_a_colour_key() {
        let key = Key { title: "density".to_owned(), ends: [0.1, 0.5], is_logarithmic: false };
        let lines = [0.1, 0.5]
            .map(|density| Line { tone: Some(key.tone(density)), ..line(&[(0.0, density, 0.0), (1.0, 2.0, 0.0)]) });
        let [svg, _] = Curves { lines: lines.to_vec(), key: Some(key), ..Curves::default() }.drawing().unwrap();
        assert!(
            svg.contains("<g class=\"f0\">") && svg.contains("<g class=\"f15\">") && svg.contains(">density</text>"),
            "{svg}"
        );
    }
}
