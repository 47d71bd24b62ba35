use std::path::Path;

use super::colour;
use super::letters::can_write;
use crate::Vector;
use crate::model::Units;
use crate::view::ViewError;
use crate::view::beside::Beside;

/// Maximum number of pixels in an image, enough for 3840 x 2160.
const MOST_PIXELS: u32 = 1 << 23;

/// What the colours of particles show.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ColourBy {
    /// The species, in the colours of [`Style::palette`]. Static species are pale grey.
    #[default]
    Species,
    /// The speed, from dark blue at rest to yellow, with a scale below the image. Static particles are pale grey.
    Speed,
    /// The contact pressure, with a scale as for the speed. Needs frames of a run with `particle_stress` in `[measure]`.
    Pressure,
}

impl ColourBy {
    pub(in crate::view) fn has_scale(self) -> bool {
        self != Self::Species
    }
}

/// Region that the image shows. Visible particles outside the region are drawn, too.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Framing {
    /// The box without empty parts along axes that are neither periodic nor mostly empty. Along gravity, only the top
    /// is cropped. A visible box is cropped only along gravity, and not at all if it is flat.
    #[default]
    Fitted,
    /// The box, and the spheres with centres in the box.
    Box,
    /// All particles, inside and outside the box.
    Particles,
}

/// Style of an image: size, colours and direction of view.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// Columns of pixels.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// Whether the image is cropped to the framed region.
    pub is_cut: bool,
    /// What the colours of particles show.
    pub colour_by: ColourBy,
    /// Colours of moving species in sRGB. The colours repeat if there are more species.
    pub palette: Vec<[u8; 3]>,
    /// Upper end of the scale if colours show the speed `[length / time]`. The default depends on the speeds of the
    /// particles.
    pub top_speed: Option<f64>,
    /// Names of the units, which are written beside numbers. The default is the names in the scene of the trajectory, if
    /// it gives any.
    pub units: Option<Units>,
    /// Opacity of static particles, 0 to 1. Static particles with a bond are opaque.
    pub static_opacity: f64,
    /// Opacity of surfaces seen straight on, 0 to 1. At 0, surfaces are not drawn.
    pub surface_opacity: f64,
    /// Region that the image shows.
    pub framing: Framing,
    /// Whether to draw the edges of the box.
    pub has_box: bool,
    /// Direction that points up in the image. The default is against gravity. Without gravity, z is up, or y if z is
    /// flat.
    pub up: Option<Vector>,
    /// Angle by which the camera has moved around the scene to the right `[degrees]`.
    pub azimuth: f64,
    /// Elevation of the camera above the horizon `[degrees]`.
    pub elevation: f64,
    /// Direction from the middle of the scene to the camera at azimuth 0, instead of an elevation. Flat and
    /// one-dimensional scenes are always seen from the front.
    pub from: Option<Vector>,
    /// Magnification about the middle of the image, 0.01 to 100.
    pub zoom: f64,
    /// Direction of gravity, if any. [`of_trajectory`](super::of_trajectory) reads it from the scene of the run.
    pub gravity: Option<Vector>,
    /// Whether shadows fall on the ground. They need gravity and a box with a floor.
    pub has_ground: bool,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            width: 1600,
            height: 1200,
            is_cut: true,
            colour_by: ColourBy::Species,
            palette: colour::PALETTE.to_vec(),
            top_speed: None,
            units: None,
            static_opacity: 0.16,
            surface_opacity: 0.35,
            framing: Framing::Fitted,
            has_box: true,
            up: None,
            azimuth: 28.0,
            elevation: 18.0,
            from: None,
            zoom: 1.0,
            gravity: None,
            has_ground: true,
        }
    }
}

impl Style {
    pub(in crate::view) fn beside(&self, trajectory: &Path) -> Self {
        if self.gravity.is_some() && self.units.is_some() {
            return self.clone();
        }
        let Beside { gravity, units } = Beside::of(trajectory);
        Self { gravity: self.gravity.or(gravity), units: self.units.clone().or(units), ..self.clone() }
    }

    /// Returns a number with the name of its unit, if units have names. `quantity` is a unit such as `length / time`. A
    /// unit with letters that images cannot show is left out, because a part of its name could be another unit.
    pub(super) fn with_unit(&self, number: String, quantity: &str, dimensions: usize) -> String {
        let unit = self.units.as_ref().map(|units| units.of(quantity, dimensions));
        match unit.filter(|unit| can_write(unit)) {
            Some(unit) => format!("{number} {unit}"),
            None => number,
        }
    }
}

pub(in crate::view) fn refuse_style(style: &Style) -> Result<(), ViewError> {
    let (width, height) = (style.width, style.height);
    if !((16..=8192).contains(&width) && (16..=8192).contains(&height) && width * height <= MOST_PIXELS) {
        return Err(ViewError::Size { width, height });
    }
    if style.palette.is_empty() {
        return Err(ViewError::NoColour);
    }
    let length = |direction: Option<Vector>| direction.map_or(1.0, |direction| direction.norm());
    let (up, from, gravity) =
        (length(style.up), length(style.from), style.gravity.map_or(0.0, |gravity| gravity.norm()));
    let top_speed = style.top_speed.unwrap_or(1.0);
    let checks = [
        ("static_opacity of an image", style.static_opacity, (0.0..=1.0).contains(&style.static_opacity), "0 to 1"),
        ("surface_opacity of an image", style.surface_opacity, (0.0..=1.0).contains(&style.surface_opacity), "0 to 1"),
        ("azimuth of an image", style.azimuth, style.azimuth.is_finite(), "a finite angle"),
        ("elevation of an image", style.elevation, style.elevation.abs() <= 90.0, "-90 to 90 degrees"),
        ("top_speed of an image", top_speed, top_speed.is_finite() && top_speed > 0.0, "a positive finite speed"),
        ("length of the up vector of an image", up, up.is_normal(), "a finite length that is not 0"),
        ("length of the vector from the scene to the camera", from, from.is_normal(), "a finite length that is not 0"),
        ("length of the gravity vector of an image", gravity, gravity.is_finite(), "a finite length"),
        ("zoom of an image", style.zoom, (0.01..=100.0).contains(&style.zoom), "0.01 to 100"),
    ];
    match checks.into_iter().find(|&(_, _, is_valid, _)| !is_valid) {
        Some((name, value, _, expected)) => Err(ViewError::Option { name, value, expected }),
        None => Ok(()),
    }
}
