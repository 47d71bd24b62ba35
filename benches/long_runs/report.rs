//! The table and the plot of what was measured.

use super::row::{self, Row};
use super::{FOLDER, RUNS};
use plotters::prelude::*;
use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::Path;

type Quantity = (&'static str, fn(&Row) -> f64);

const QUANTITIES: [Quantity; 3] = [
    ("energy error, relative", |row| row.energy.abs()),
    ("momentum drift, relative", |row| row.momentum),
    ("deepest overlap, of the distance", |row| row.overlap),
];

pub fn write() -> Result<(), Box<dyn Error>> {
    let mut series = Vec::new();
    for (name, _) in RUNS {
        series.push((name, row::read(name)?));
    }
    series.retain(|(_, rows)| !rows.is_empty());
    if series.is_empty() {
        return Err("nothing was measured yet".into());
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

/// What rounds to nothing is drawn here.
const FLOOR: f64 = 1e-17;

fn plot(path: &Path, series: &[(&str, Vec<Row>)]) -> Result<(), Box<dyn Error>> {
    let root = SVGBackend::new(path, (760, 1020)).into_drawing_area();
    root.fill(&WHITE)?;
    let most = series.iter().flat_map(|(_, rows)| rows).map(|row| row.events).fold(0.0, f64::max);
    for (area, (title, quantity)) in root.split_evenly((3, 1)).into_iter().zip(QUANTITIES) {
        let mut chart = ChartBuilder::on(&area)
            .margin(12)
            .caption(title, ("sans-serif", 17))
            .x_label_area_size(38)
            .y_label_area_size(70)
            .build_cartesian_2d((1e3..most).log_scale(), (FLOOR..1e-9).log_scale())?;
        let power = |x: &f64| format!("1e{:.0}", x.log10());
        chart.configure_mesh().x_desc("events").x_label_formatter(&power).y_label_formatter(&power).draw()?;
        let walk = (0..=100).map(|k| 1e3 * (most / 1e3).powf(f64::from(k) / 100.0));
        chart
            .draw_series(LineSeries::new(walk.map(|n| (n, f64::EPSILON * n.sqrt())), BLACK.mix(0.4)))?
            .label("eps sqrt(n), a random walk")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 16, y)], BLACK.mix(0.4)));
        for (k, (name, rows)) in series.iter().enumerate() {
            let colour = Palette99::pick(k).mix(1.0);
            let points: Vec<(f64, f64)> =
                rows.iter().map(|row| (row.events, quantity(row).max(FLOOR))).filter(|(_, y)| y.is_finite()).collect();
            if rows.iter().all(|row| quantity(row).is_nan()) {
                continue;
            }
            chart
                .draw_series(LineSeries::new(points, colour.stroke_width(2)))?
                .label(name.replace('_', " "))
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], colour.stroke_width(2)));
        }
        chart.configure_series_labels().position(SeriesLabelPosition::UpperLeft).border_style(BLACK.mix(0.3)).draw()?;
    }
    root.present()?;
    Ok(())
}
