//! Images of a frame: shaded spheres, bonds and the box, drawn without a display.
//!
//! Three-dimensional scenes are seen in perspective from a raised corner. Flat and one-dimensional scenes are seen from
//! the front. Light comes from the sky and from a sun with soft shadows. With gravity, shadows fall on the ground.
//! Static particles and [surfaces](Surfaces) are translucent. The same frame, surfaces and style give the same bytes on
//! every machine.
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
mod framing;
mod ground;
mod image;
pub(crate) mod legend;
mod letters;
mod light;
mod lists;
mod parallel;
mod raster;
mod scale;
mod shade;
mod sheets;
mod shot;
mod stroke;
mod style;
#[cfg(test)]
pub(super) mod tests;

use std::path::Path;

pub(super) use camera::Extent;
pub(super) use colour::{BACKGROUND, INK};
pub(super) use framing::{corners, fitted, joined, reach, with_surfaces};
pub use image::Image;
pub(super) use image::png_encoder;
pub(super) use parallel::{Team, cores};
pub(super) use scale::{Scale, shown_numbers};
pub(super) use shot::Shot;
pub(super) use style::refuse_style;
pub use style::{ColourBy, Framing, Style};

use super::{Surfaces, ViewError};
use crate::Vector;
use crate::base::numbers::single;
use crate::trajectory::Frame;
use crate::trajectory::extended_xyz::pick_frame;
pub(super) use bodies::BOND_RADIUS;
use bodies::Bodies;
use camera::Camera;
use colour::Colour;
use framing::{box_edges, framed};
use ground::Ground;
use light::Lights;
use raster::Rays;
use shade::Scenery;
use sheets::Sheets;
use stroke::{Edge, Pen};

pub(super) const BYTES_PER_PIXEL: u64 = 40;

/// Edges in front of the box are fainter than other edges of the box. Edges of surfaces are fainter and thinner.
const BOX_OPACITY: f32 = 0.6;
const NEAR_OPACITY: f32 = 0.22;
const FINE_OPACITY: f32 = 0.4;
const FINE: f32 = 0.7;

/// Draws the frame of a trajectory nearest to a time `[time]`, or the last frame. The scene beside the file gives the
/// surfaces and gravity. An incomplete last frame is ignored.
///
/// # Errors
/// [`ViewError::Trajectory`] if the file cannot be read, [`ViewError::SurfaceFile`] or [`ViewError::Surface`] if a
/// surface file cannot be read, and the errors of [`draw`].
pub fn of_trajectory(path: &Path, time: Option<f64>, style: &Style) -> Result<Image, ViewError> {
    let pick = pick_frame(path, time).map_err(ViewError::trajectory(path))?;
    draw_with(&pick.frame, &Surfaces::beside(path)?, &style.beside(path))
}

/// Draws a frame.
///
/// # Errors
/// The errors of [`draw_with`].
pub fn draw(frame: &Frame, style: &Style) -> Result<Image, ViewError> {
    draw_with(frame, &Surfaces::default(), style)
}

/// Draws a frame and surfaces. A surface much larger than the box does not enlarge the framed region.
///
/// # Errors
/// [`ViewError::Empty`], [`ViewError::Particle`] or [`ViewError::Box`] if the frame cannot be drawn;
/// [`ViewError::Size`], [`ViewError::Option`] or [`ViewError::NoColour`] if the style is invalid.
pub fn draw_with(frame: &Frame, surfaces: &Surfaces, style: &Style) -> Result<Image, ViewError> {
    refuse_style(style)?;
    refuse_frame(frame)?;
    let numbers = shown_numbers(frame, style)?;
    let has_scale = style.colour_by.has_scale();
    let footer = if has_scale { legend::STRIP * style.width.min(style.height) as f32 } else { 0.0 };
    let surfaces = &*surfaces.at(frame);
    let camera = Camera::facing(frame, style, &framed(frame, surfaces, style), footer).ok_or(ViewError::Box)?;
    let scale = Scale::of(frame, &numbers, style);
    let team = Team::whole();
    let mut pixels = paint((frame, surfaces, &numbers), style, &camera, scale.top, &team);
    legend::draw(&mut pixels, camera.width as usize, footer, style, &scale);
    Ok(image(&camera, &pixels, &team))
}

fn paint(
    (frame, surfaces, numbers): (&Frame, &Surfaces, &[f64]),
    style: &Style,
    camera: &Camera,
    top: f64,
    team: &Team,
) -> Vec<Colour> {
    let surfaces = &*surfaces.at(frame);
    let mut bodies = Bodies::of((frame, numbers), style, camera, top);
    bodies.sheets = Sheets::of(surfaces, camera, style);
    let thick = (0.0011 * style.width.min(style.height) as f32).max(1.0);
    let ink = colour::linear(colour::INK);
    let place = |[a, b]: &[Vector; 2]| [camera.place(a), camera.place(b)];
    let has_outline = style.surface_opacity > 0.0;
    let sharp = surfaces.skins.iter().filter(|_| has_outline).flat_map(|skin| &skin.edges);
    let fine = Pen { width: FINE * thick, colour: ink, opacity: FINE_OPACITY, is_behind: false };
    let edges = box_edges(frame).into_iter().filter(|_| style.has_box).filter_map(|(ends, faces)| {
        // An edge between two sides that face the camera is in front of the box.
        let is_near = faces.iter().all(|normal| camera.is_before(&ends[0], normal)) && !faces.is_empty();
        let opacity = if is_near { NEAR_OPACITY } else { BOX_OPACITY };
        Edge::of(camera, place(&ends), Pen { width: thick, colour: ink, opacity, is_behind: true })
    });
    let scenery = Scenery {
        camera,
        rays: Rays::of(camera),
        lights: Lights::on(&bodies.balls, camera),
        ground: Ground::of(frame, surfaces, style, camera, &bodies),
        background: colour::linear(colour::BACKGROUND),
        opacity: single(style.static_opacity),
        outline: sharp.filter_map(|ends| Edge::of(camera, place(ends), fine)).collect(),
        edges: edges.collect(),
        bodies: &bodies,
    };
    scenery.colours(team)
}

fn image(camera: &Camera, pixels: &[Colour], team: &Team) -> Image {
    let mut bytes = vec![[0; 4]; pixels.len()];
    let size = 1 << 14;
    parallel::for_each(team, bytes.chunks_mut(size).zip(pixels.chunks(size)), |(bytes, pixels)| {
        for (bytes, pixel) in bytes.iter_mut().zip(pixels) {
            *bytes = colour::encode(pixel);
        }
    });
    Image::new(camera.width, camera.height, bytes)
}

fn refuse_frame(frame: &Frame) -> Result<(), ViewError> {
    if frame.particles.is_empty() {
        return Err(ViewError::Empty);
    }
    refuse_numbers(frame)
}

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
