use super::{Estimate, Outcome};
use plotters::prelude::*;

/// Okabe and Ito's colours, which colour-blind readers can distinguish.
const COLOURS: [RGBColor; 3] = [RGBColor(0, 114, 178), RGBColor(213, 94, 0), RGBColor(0, 158, 115)];

pub fn draw(path: &str, systems: &[(&str, &[Estimate])]) -> Outcome {
    let root = SVGBackend::new(path, (640, 420)).into_drawing_area();
    root.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&root)
        .margin(14)
        .x_label_area_size(42)
        .y_label_area_size(52)
        .build_cartesian_2d((1.0..64.0).log_scale().base(2.0), (1.0..64.0).log_scale().base(2.0))?;
    let mut mesh = chart.configure_mesh();
    mesh.x_desc("cores, one domain each").y_desc("speed relative to one thread").light_line_style(WHITE).draw()?;
    let ideal = [1.0, 64.0].map(|cores| (cores, cores));
    chart
        .draw_series(LineSeries::new(ideal, BLACK.mix(0.4)))?
        .label("as many times as fast")
        .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK.mix(0.4)));
    for ((name, estimates), colour) in systems.iter().zip(COLOURS) {
        let points = || estimates.iter().map(|one| (one.cores as f64, one.speedup));
        chart
            .draw_series(LineSeries::new(std::iter::once((1.0, 1.0)).chain(points()), colour.stroke_width(2)))?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
        chart.draw_series(points().map(|point| Circle::new(point, 4, colour.filled())))?;
    }
    let mut labels = chart.configure_series_labels();
    labels.position(SeriesLabelPosition::UpperLeft).background_style(WHITE).border_style(BLACK.mix(0.3)).draw()?;
    Ok(root.present()?)
}
