use super::{FOLDER, Outcome};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::path::Path;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

pub struct Series {
    pub name: String,
    pub points: Vec<(f64, f64)>,
    pub has_line: bool,
}

pub struct Panel {
    pub title: String,
    pub x: String,
    pub y: String,
    pub series: Vec<Series>,
}

/// Smaller magnitudes, such as zero, are drawn at this value, because the axes are logarithmic.
const FLOOR: f64 = 1e-17;

/// Okabe and Ito's colours, which colour-blind readers can distinguish.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
    RGBColor(0, 0, 0),
];

const LEGEND_WIDTH: u32 = 230;
const PANEL: (i32, i32) = (470, 350);

/// Draws rows of panels. The legend of the first panel is to the right of the row.
pub fn draw(name: &str, rows: &[Vec<Panel>]) -> Outcome {
    let path = Path::new(FOLDER).join(format!("{name}.svg"));
    let columns = u32::try_from(rows.iter().map(Vec::len).max().unwrap_or(1))?;
    let size = (PANEL.0 as u32 * columns + LEGEND_WIDTH, PANEL.1 as u32 * u32::try_from(rows.len())?);
    let root = SVGBackend::new(&path, size).into_drawing_area();
    root.fill(&WHITE)?;
    for (mut rest, panels) in root.split_evenly((rows.len(), 1)).into_iter().zip(rows) {
        for panel in panels {
            let (left, right) = rest.split_horizontally(PANEL.0);
            draw_panel(&left, panel)?;
            rest = right;
        }
        draw_legend(&rest, &panels[0])?;
    }
    Ok(root.present()?)
}

fn draw_panel(area: &Area, panel: &Panel) -> Outcome {
    let points = panel.series.iter().flat_map(|series| &series.points);
    let (x, y): (Vec<f64>, Vec<f64>) = points.map(|&(x, y)| (logarithm(x), logarithm(y))).unzip();
    let ((x0, x1), (y0, y1)) = (decades(&x), decades(&y));
    let mut chart = ChartBuilder::on(area)
        .margin(12)
        .caption(&panel.title, ("sans-serif", 17))
        .x_label_area_size(42)
        .y_label_area_size(66)
        .build_cartesian_2d(x0..x1, y0..y1)?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(&panel.x).y_desc(&panel.y).light_line_style(WHITE).bold_line_style(BLACK.mix(0.15));
    mesh.x_labels(labels(x0, x1)).y_labels(labels(y0, y1));
    mesh.x_label_formatter(&power).y_label_formatter(&power).draw()?;
    for (k, series) in panel.series.iter().enumerate() {
        draw_series(&mut chart, series, k)?;
    }
    Ok(())
}

fn draw_series(chart: &mut Chart, series: &Series, k: usize) -> Outcome {
    let colour = COLOURS[k % COLOURS.len()];
    let finite = series.points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    let points: Vec<(f64, f64)> = finite.map(|&(x, y)| (logarithm(x), logarithm(y))).collect();
    if series.has_line {
        chart.draw_series(LineSeries::new(points.clone(), colour.stroke_width(2)))?;
    }
    let is_hollow = k >= COLOURS.len();
    let style = if is_hollow { colour.stroke_width(2) } else { colour.filled() };
    if k.is_multiple_of(2) {
        chart.draw_series(points.into_iter().map(|point| Circle::new(point, 4, style)))?;
    } else {
        chart.draw_series(points.into_iter().map(|point| TriangleMarker::new(point, 5, style)))?;
    }
    Ok(())
}

fn draw_legend(area: &Area, panel: &Panel) -> Outcome {
    for ((k, series), line) in panel.series.iter().enumerate().zip(0..) {
        let colour = COLOURS[k % COLOURS.len()];
        let style = if k >= COLOURS.len() { colour.stroke_width(2) } else { colour.filled() };
        let y = 50 + 20 * line;
        if series.has_line {
            area.draw(&PathElement::new([(4, y), (28, y)], colour.stroke_width(2)))?;
        }
        if k.is_multiple_of(2) {
            area.draw(&Circle::new((16, y), 4, style))?;
        } else {
            area.draw(&TriangleMarker::new((16, y), 5, style))?;
        }
        area.draw(&Text::new(series.name.clone(), (34, y - 7), ("sans-serif", 14)))?;
    }
    Ok(())
}

/// NaN stays NaN and is not drawn.
fn logarithm(x: f64) -> f64 {
    if x.is_nan() { x } else { x.abs().max(FLOOR).log10() }
}

/// Powers of ten that enclose all values, at least one decade apart.
fn decades(logarithms: &[f64]) -> (f64, f64) {
    let finite = || logarithms.iter().copied().filter(|x| x.is_finite());
    let (lower, upper) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    if lower > upper {
        return (0.0, 1.0);
    }
    (lower.floor(), upper.ceil().max(lower.floor() + 1.0))
}

/// Number of labels: one for each power of ten, or more if there are few powers.
fn labels(lower: f64, upper: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, reason = "floats have some 600 decades")]
    let decades = (upper - lower) as usize;
    if decades <= 2 { 2 * decades + 1 } else { (decades + 1).min(10) }
}

fn power(x: &f64) -> String {
    #[expect(clippy::cast_possible_truncation, reason = "floats have some 600 decades")]
    let [exponent, nearest] = [x.floor(), x.round()].map(|x| x as i32);
    let is_whole = (x - x.round()).abs() < 1e-6;
    match (is_whole, nearest) {
        (true, exponent @ -2..=3) => format!("{}", 10_f64.powi(exponent)),
        (true, exponent) => format!("1e{exponent}"),
        (false, 0..=3) => format!("{:.*}", (1 - exponent).max(0) as usize, 10_f64.powf(*x)),
        (false, _) => format!("{:.1}e{exponent}", 10_f64.powf(x - x.floor())),
    }
}
