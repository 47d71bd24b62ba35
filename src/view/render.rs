//! Images of a frame: shaded spheres, bonds and the box, drawn without a display.
//!
//! A frame is drawn by a camera that places itself: three-dimensional scenes in perspective from a raised corner, flat
//! and straight ones from the front. Light comes from a sky with shadows and from a sun, so that heaps and packings
//! read as bodies; static particles and [surfaces](Surfaces) are translucent, so that what they hold stays in sight. The same frame, surfaces and style
//! give the same bytes each time.
//!
//! ```
//! use carom::trajectory::{Frame};
//! use carom::io::{Existing};
//! use carom::view::render::{self, Style};
//! # fn image(frame: &Frame) -> Result<(), carom::view::ViewError> {
//! let image = render::draw(frame, &Style { width: 800, height: 600, ..Style::default() })?;
//! image.write_png("fluid.png".as_ref(), Existing::Keep)
//! # }
//! ```

mod bodies;
mod camera;
mod caption;
mod colour;
mod image;
pub(crate) mod legend;
mod letters;
mod light;
mod map;
mod parallel;
mod raster;
mod shade;
mod sheets;
mod shot;
mod stroke;
#[cfg(test)]
mod tests;

use std::path::Path;

pub(super) use camera::Extent;
pub(super) use colour::{BACKGROUND, INK};
pub use image::Image;
pub(super) use image::png_encoder;
pub(super) use light::MAP_BYTES;
pub(super) use parallel::{Team, cores};
pub(super) use shot::{Shot, SpeedScale};

use super::{Surfaces, ViewError};
use crate::Vector;
use crate::base::numbers::single;
use crate::trajectory::Frame;
use crate::trajectory::extended_xyz::pick_frame;
use bodies::Bodies;
use camera::Camera;
use colour::Colour;
use light::Fineness;
use shade::Scenery;
use sheets::Sheets;
use stroke::Pen;

/// The most pixels of an image, enough for 3840 x 2160.
const MOST_PIXELS: u32 = 1 << 23;

/// Memory of each pixel while it is drawn, besides the maps of the lights, so that the largest image takes 2 GB `[bytes]`.
pub(super) const BYTES_PER_PIXEL: u64 = 240;

/// Edges of surfaces: their width relative to those of the box, and their opacity.
const FINE: f32 = 0.7;
const FINE_OPACITY: f32 = 0.4;

/// Colouring of the particles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum ColourBy {
    /// Its species, in the colours of [`Style::palette`]; static species are pale grey.
    #[default]
    Species,
    /// Its speed, from dark blue at rest to yellow, with a scale below the image; static particles are pale grey.
    Speed,
}

/// Framing of the image. Particles outside of it are drawn as far as they are in view.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Framing {
    /// The box, and the spheres whose centres are in it.
    #[default]
    Box,
    /// All particles, wherever they are.
    Particles,
}

/// Style of a rendered image: size, colours, view direction.
#[derive(Debug, Clone, PartialEq)]
pub struct Style {
    /// The most columns of pixels: the image is cut down to what it frames.
    pub width: u32,
    /// The most rows of pixels.
    pub height: u32,
    /// Quantity that colours show.
    pub colour_by: ColourBy,
    /// Colours of the species that move, in the order of the table and over again, in sRGB.
    pub palette: Vec<[u8; 3]>,
    /// The speed at the upper end of the scale `[length / time]`; `None` takes it from the particles.
    pub top_speed: Option<f64>,
    /// Opacity of static particles, 0 to 1; those that hold a bond are always opaque.
    pub static_opacity: f64,
    /// Opacity of surfaces where they are seen straight on, 0 to 1; at 0 they are not drawn.
    pub surface_opacity: f64,
    /// Framing of the image.
    pub framing: Framing,
    /// Whether the edges of the box are drawn.
    pub has_box: bool,
    /// The direction that points up in the image; `None` takes z, or y where z is flat.
    pub up: Option<Vector>,
    /// Degrees by which the camera has walked around the scene to the right.
    pub azimuth: f64,
    /// Degrees by which the camera is raised above the horizon.
    pub elevation: f64,
}

impl Default for Style {
    fn default() -> Self {
        Self {
            width: 1600,
            height: 1200,
            colour_by: ColourBy::Species,
            palette: colour::PALETTE.to_vec(),
            top_speed: None,
            static_opacity: 0.16,
            surface_opacity: 0.35,
            framing: Framing::Box,
            has_box: true,
            up: None,
            azimuth: 28.0,
            elevation: 18.0,
        }
    }
}

/// Draws the frame of a trajectory file that is nearest to a time `[time]`, or the last one, with the surfaces beside it. Where a killed run has cut
/// the file off, the last complete frame counts.
///
/// # Errors
/// [`ViewError::Trajectory`] if the file cannot be read, [`ViewError::SurfaceFile`] or [`ViewError::Surface`] if that of a surface cannot; otherwise as [`draw`].
pub fn of_trajectory(path: &Path, time: Option<f64>, style: &Style) -> Result<Image, ViewError> {
    let pick = pick_frame(path, time).map_err(ViewError::trajectory(path))?;
    draw_with(&pick.frame, &Surfaces::beside(path)?, style)
}

/// Draws a frame.
///
/// # Errors
/// As [`draw_with`].
pub fn draw(frame: &Frame, style: &Style) -> Result<Image, ViewError> {
    draw_with(frame, &Surfaces::default(), style)
}

/// Draws a frame and surfaces. A surface that is much larger than the box and the particles is drawn as far as it is in view.
///
/// # Errors
/// [`ViewError::Empty`], [`ViewError::Particle`] or [`ViewError::Box`] if the frame cannot be drawn;
/// [`ViewError::Size`], [`ViewError::Option`] or [`ViewError::NoColour`] if the style makes no sense.
pub fn draw_with(frame: &Frame, surfaces: &Surfaces, style: &Style) -> Result<Image, ViewError> {
    refuse_style(style)?;
    refuse_frame(frame)?;
    let footer = match style.colour_by {
        ColourBy::Species => 0.0,
        ColourBy::Speed => legend::STRIP * style.width.min(style.height) as f32,
    };
    let surfaces = &*surfaces.at(frame);
    let camera = Camera::facing(frame, style, &framed(frame, surfaces, style), footer).ok_or(ViewError::Box)?;
    let scale = SpeedScale::of(frame, style);
    let mut pixels = paint((frame, surfaces), style, &camera, scale.fastest, Fineness::PICTURE, &Team::whole());
    if style.colour_by == ColourBy::Speed {
        legend::draw(&mut pixels, camera.width as usize, footer, scale.fastest, scale.is_exceeded());
    }
    Ok(Image::new(camera.width, camera.height, pixels.iter().map(colour::encode).collect()))
}

/// Draws a frame without letters.
fn paint(
    (frame, surfaces): (&Frame, &Surfaces),
    style: &Style,
    camera: &Camera,
    fastest: f64,
    fineness: Fineness,
    team: &Team,
) -> Vec<Colour> {
    let surfaces = &*surfaces.at(frame);
    let mut bodies = Bodies::of(frame, style, camera, fastest);
    bodies.sheets = Sheets::of(surfaces, camera, style);
    let scenery = Scenery::new(&bodies, camera, single(style.static_opacity), fineness, team);
    let mut pixels = scenery.colours();
    let thick = (0.0011 * style.width.min(style.height) as f32).max(1.0);
    let pen = |width, opacity| Pen { width, colour: colour::linear(colour::INK), opacity };
    let place = |[a, b]: &[Vector; 2]| [camera.place(a), camera.place(b)];
    let view = (camera, &scenery.solid);
    let sharp: Vec<_> = surfaces.skins.iter().flat_map(|skin| &skin.edges).map(place).collect();
    if style.surface_opacity > 0.0 && !sharp.is_empty() {
        stroke::draw_outline(&mut pixels, view, &sharp, pen(FINE * thick, FINE_OPACITY));
    }
    if style.has_box {
        let edges: Vec<_> = box_edges(frame).iter().map(place).collect();
        stroke::draw_edges(&mut pixels, view, &edges, pen(thick, 0.75));
    }
    pixels
}

/// Spheres and corners that have to be in the image.
fn framed(frame: &Frame, surfaces: &Surfaces, style: &Style) -> Vec<Extent> {
    let upper = frame.lower + frame.size;
    let is_inside = |position: &Vector| (0..3).all(|k| (frame.lower[k]..=upper[k]).contains(&position[k]));
    let has_all = style.framing == Framing::Particles || frame.size.iter().all(|&edge| edge == 0.0);
    let particles = frame.particles.iter().filter(|particle| has_all || is_inside(&particle.position));
    let mut framed: Vec<Extent> =
        particles.map(|particle| Extent { position: particle.position, radius: particle.radius }).collect();
    if !has_all {
        framed.extend(corners(&frame.lower, &frame.size).map(|position| Extent { position, radius: 0.0 }));
    }
    with_surfaces(framed, surfaces)
}

/// Adds those of the surfaces that are framed with what there is.
pub(super) fn with_surfaces(mut framed: Vec<Extent>, surfaces: &Surfaces) -> Vec<Extent> {
    let reach = |extent: &Extent| Vector::repeat(extent.radius);
    let lower = framed.iter().map(|e| e.position - reach(e)).reduce(|a, b| a.inf(&b));
    let upper = framed.iter().map(|e| e.position + reach(e)).reduce(|a, b| a.sup(&b));
    if let (Some(lower), Some(upper)) = (lower, upper) {
        framed.extend(surfaces.framed([lower, upper]).into_iter().map(|position| Extent { position, radius: 0.0 }));
    }
    framed
}

/// The corners of a box, given its lower corner and its edges; bit `k` of the index is the side along axis `k`.
pub(super) fn corners(lower: &Vector, size: &Vector) -> [Vector; 8] {
    std::array::from_fn(|index| Vector::from_fn(|k, _| lower[k] + if index >> k & 1 == 1 { size[k] } else { 0.0 }))
}

/// The edges of the box that have a length, each once.
fn box_edges(frame: &Frame) -> Vec<[Vector; 2]> {
    let corners = corners(&frame.lower, &frame.size);
    let mut edges = Vec::new();
    for axis in (0..3).filter(|&axis| !frame.is_flat(axis)) {
        let is_start =
            |index: &usize| index >> axis & 1 == 0 && (0..3).all(|k| !frame.is_flat(k) || index >> k & 1 == 0);
        edges.extend((0..8).filter(is_start).map(|index| [corners[index], corners[index | 1 << axis]]));
    }
    edges
}

pub(super) fn refuse_style(style: &Style) -> Result<(), ViewError> {
    let (width, height) = (style.width, style.height);
    if !((16..=8192).contains(&width) && (16..=8192).contains(&height) && width * height <= MOST_PIXELS) {
        return Err(ViewError::Size { width, height });
    }
    if style.palette.is_empty() {
        return Err(ViewError::NoColour);
    }
    let up = style.up.map_or(1.0, |up| up.norm());
    let top_speed = style.top_speed.unwrap_or(1.0);
    let checks = [
        ("static_opacity of an image", style.static_opacity, (0.0..=1.0).contains(&style.static_opacity), "0 to 1"),
        ("surface_opacity of an image", style.surface_opacity, (0.0..=1.0).contains(&style.surface_opacity), "0 to 1"),
        ("azimuth of an image", style.azimuth, style.azimuth.is_finite(), "a finite angle"),
        ("elevation of an image", style.elevation, style.elevation.abs() <= 90.0, "-90 to 90 degrees"),
        ("top_speed of an image", top_speed, top_speed.is_finite() && top_speed > 0.0, "a positive finite speed"),
        ("length of the direction up of an image", up, up.is_normal(), "a finite length that is not 0"),
    ];
    match checks.into_iter().find(|&(_, _, is_valid, _)| !is_valid) {
        Some((name, value, _, expected)) => Err(ViewError::Option { name, value, expected }),
        None => Ok(()),
    }
}

fn refuse_frame(frame: &Frame) -> Result<(), ViewError> {
    if frame.particles.is_empty() {
        return Err(ViewError::Empty);
    }
    refuse_numbers(frame)
}

/// Refuses what has no place in an image.
pub(super) fn refuse_numbers(frame: &Frame) -> Result<(), ViewError> {
    let is_finite = |vector: &Vector| vector.iter().all(|x| x.is_finite());
    if !(is_finite(&frame.lower) && is_finite(&frame.size) && frame.size.iter().all(|&edge| edge >= 0.0)) {
        return Err(ViewError::Box);
    }
    let is_drawable = |radius: f64| radius.is_finite() && radius > 0.0;
    let bad = frame.particles.iter().find(|particle| {
        !(is_finite(&particle.position) && is_finite(&particle.velocity) && is_drawable(particle.radius))
    });
    bad.map_or(Ok(()), |particle| Err(ViewError::Particle(particle.id)))
}
