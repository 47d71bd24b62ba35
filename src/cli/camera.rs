//! Camera options for pictures and movies.

use crate::Vector;
use crate::view::render::Style;
use clap::Args;

#[derive(Debug, Args)]
pub struct Camera {
    /// Direction from which the scene is seen: x, y, z, -x, -y or -z, or azimuth and elevation in degrees;
    /// flat scenes are seen from the front
    #[arg(long, value_name = "AXIS|AZIMUTH,ELEVATION", allow_hyphen_values = true, value_parser = view)]
    view: Option<View>,
    /// Magnification about the centre, 0.01 to 100
    #[arg(long, value_name = "FACTOR", default_value = "1", allow_negative_numbers = true, value_parser = zoom)]
    zoom: f64,
    /// Hides the edges of the box
    #[arg(long)]
    no_box: bool,
    /// Hides the ground that shows shadows in scenes with gravity
    #[arg(long)]
    no_ground: bool,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum View {
    /// Direction from which the scene is seen, as a unit vector.
    From(Vector),
    /// Azimuth and elevation in degrees.
    Angles([f64; 2]),
}

fn view(text: &str) -> Result<View, String> {
    let (sign, axis) = match text.trim().strip_prefix('-') {
        Some(axis) => (-1.0, axis),
        None => (1.0, text.trim().trim_start_matches('+')),
    };
    if let Some(axis) = ["x", "y", "z"].iter().position(|name| *name == axis) {
        return Ok(View::From(Vector::ith(axis, sign)));
    }
    let angle = |text: &str, most: f64| text.trim().parse().ok().filter(|angle: &f64| angle.abs() <= most);
    let angles = text.split_once(',').and_then(|(a, b)| Some([angle(a, 3600.0)?, angle(b, 90.0)?]));
    angles.map(View::Angles).ok_or_else(|| {
        "expected x, y, z, -x, -y or -z, or azimuth and elevation in degrees, such as 28,18, with the elevation from -90 to 90".to_owned()
    })
}

fn zoom(text: &str) -> Result<f64, String> {
    let factor = text.parse().ok().filter(|factor| (0.01..=100.0).contains(factor));
    factor.ok_or_else(|| "expected a factor from 0.01 to 100".to_owned())
}

impl Camera {
    pub fn applied_to(&self, style: Style) -> Style {
        let style = Style { zoom: self.zoom, has_box: !self.no_box, has_ground: !self.no_ground, ..style };
        match self.view {
            None => style,
            Some(View::From(side)) => Style { from: Some(side), azimuth: 0.0, ..style },
            Some(View::Angles([azimuth, elevation])) => Style { azimuth, elevation, ..style },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn views_are_sides_or_angles() {
        assert_eq!(view("x"), Ok(View::From(Vector::x())));
        assert_eq!(view("+z"), Ok(View::From(Vector::z())));
        assert_eq!(view("-y"), Ok(View::From(-Vector::y())));
        assert_eq!(view("-30, 12.5"), Ok(View::Angles([-30.0, 12.5])));
        assert!(["", "w", "--x", "30", "30,91", "nan,0", "0,inf", "1,2,3"].iter().all(|text| view(text).is_err()));
        assert_eq!(zoom("2.5"), Ok(2.5));
        assert!(["0", "-1", "nan", "101", "big"].iter().all(|text| zoom(text).is_err()));
    }
}
