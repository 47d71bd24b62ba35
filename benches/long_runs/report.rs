use super::row::{self, Row};
use super::{FOLDER, RUNS};
use plotters::prelude::*;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

type Quantity = (&'static str, fn(&Row) -> f64, bool);

const QUANTITIES: [Quantity; 3] = [
    ("energy error, relative", |row| row.energy.abs(), true),
    ("momentum drift, relative", |row| row.momentum, true),
    ("deepest overlap so far, relative to the distance of the discontinuity", |row| row.overlap, false),
];

pub fn write() -> Result<(), Box<dyn Error>> {
    let mut series = Vec::new();
    for (name, _) in RUNS {
        series.push((name, row::read(name)?));
    }
    series.retain(|(_, rows)| !rows.is_empty());
    if series.is_empty() {
        return Err("nothing has been measured yet".into());
    }
    let folder = Path::new(FOLDER).parent().ok_or("the folder has a parent")?;
    fs::write(folder.join("long_runs.md"), table(&series)?)?;
    plot(&folder.join("long_runs.svg"), &series)?;
    print!("{}", table(&series)?);
    Ok(())
}

fn table(series: &[(&str, Vec<Row>)]) -> Result<String, std::fmt::Error> {
    let mut text = String::new();
    writeln!(
        text,
        "| run | events | time | energy error | / (eps sqrt n) | momentum drift | deepest overlap | in invalid states |"
    )?;
    writeln!(text, "|---|---|---|---|---|---|---|---|")?;
    for (name, rows) in series {
        let decades = rows.iter().filter(|row| row.events.log10().fract() == 0.0 && row.events >= 1e5);
        let last = rows.last().filter(|row| row.events.log10().fract() != 0.0);
        for row in decades.chain(last) {
            let walk = row.energy.abs() / (f64::EPSILON * row.events.sqrt());
            let momentum = if row.momentum.is_nan() { "-".to_owned() } else { format!("{:.1e}", row.momentum) };
            writeln!(
                text,
                "| {name} | {:.2e} | {:.4e} | {:+.1e} | {walk:.4} | {momentum} | {:.1e} | {} |",
                row.events, row.time, row.energy, row.overlap, row.invalid
            )?;
        }
    }
    Ok(text)
}

/// Lower limit of the logarithmic axis. Smaller values are drawn at this limit.
const FLOOR: f64 = 1e-18;

const COLOURS: [RGBColor; 4] =
    [RGBColor(0, 90, 160), RGBColor(220, 110, 0), RGBColor(0, 140, 110), RGBColor(160, 60, 140)];

fn plot(path: &Path, series: &[(&str, Vec<Row>)]) -> Result<(), Box<dyn Error>> {
    let root = SVGBackend::new(path, (760, 1020)).into_drawing_area();
    root.fill(&WHITE)?;
    let most = series.iter().flat_map(|(_, rows)| rows).map(|row| row.events).fold(0.0, f64::max);
    for (area, (title, quantity, has_walk)) in root.split_evenly((3, 1)).into_iter().zip(QUANTITIES) {
        let mut chart = ChartBuilder::on(&area)
            .margin(12)
            .caption(title, ("sans-serif", 17))
            .x_label_area_size(38)
            .y_label_area_size(70)
            .build_cartesian_2d((1e3..most).log_scale(), (1.0..1e-10 / FLOOR).log_scale())?;
        let power = |x: &f64| format!("1e{:.0}", x.log10());
        // The plot library does not label values below its own precision, so the axis shows multiples of `FLOOR`.
        let of_floors = |x: &f64| power(&(x * FLOOR));
        let mut mesh = chart.configure_mesh();
        mesh.x_desc("events").y_labels(9).light_line_style(WHITE).bold_line_style(BLACK.mix(0.15));
        mesh.x_label_formatter(&power).y_label_formatter(&of_floors).draw()?;
        let walk = (0..=100).map(|k| 1e3 * (most / 1e3).powf(f64::from(k) / 100.0));
        if has_walk {
            chart
                .draw_series(LineSeries::new(walk.map(|n| (n, f64::EPSILON / FLOOR * n.sqrt())), BLACK.mix(0.5)))?
                .label("eps sqrt(n): a random walk")
                .legend(|(x, y)| PathElement::new([(x, y), (x + 16, y)], BLACK.mix(0.5)));
        }
        for (k, (name, rows)) in series.iter().enumerate() {
            let colour = COLOURS[k % COLOURS.len()];
            let points: Vec<(f64, f64)> = rows
                .iter()
                .map(|row| (row.events, quantity(row).max(FLOOR) / FLOOR))
                .filter(|(_, y)| y.is_finite())
                .collect();
            if rows.iter().all(|row| quantity(row).is_nan()) {
                continue;
            }
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(name.replace('_', " "))
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperLeft)
            .background_style(WHITE.mix(0.8))
            .border_style(TRANSPARENT)
            .draw()?;
    }
    root.present()?;
    Ok(())
}
