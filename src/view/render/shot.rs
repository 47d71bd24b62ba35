use super::camera::{Camera, Extent};
use super::caption::Caption;
use super::legend;
use super::parallel::Team;
use super::{ColourBy, Image, Style, image, paint, refuse_numbers, refuse_style, with_surfaces};
use crate::trajectory::Frame;
use crate::view::{Surfaces, ViewError};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::view) struct SpeedScale {
    /// Speed at the upper end of the scale `[length / time]`.
    pub fastest: f64,
    /// Highest speed of a particle `[length / time]`.
    pub highest: f64,
}

impl SpeedScale {
    pub fn of(frame: &Frame, style: &Style) -> Self {
        let moving = frame.particles.iter().filter(|particle| !frame.is_static(particle));
        let speeds: Vec<f64> = moving.map(|particle| particle.velocity.norm()).collect();
        let highest = speeds.iter().copied().fold(0.0, f64::max);
        Self { fastest: style.top_speed.unwrap_or_else(|| legend::fastest(speeds)), highest }
    }

    pub fn joined(&self, other: &Self) -> Self {
        Self { fastest: self.fastest.max(other.fastest), highest: self.highest.max(other.highest) }
    }

    pub fn is_exceeded(&self) -> bool {
        self.highest > self.fastest
    }
}

#[derive(Debug, Clone)]
pub(in crate::view) struct Shot {
    style: Style,
    /// A frame without particles.
    stage: Frame,
    surfaces: Surfaces,
    camera: Camera,
    scale: SpeedScale,
    caption: Caption,
}

impl Shot {
    /// Chooses a camera that moves around the scene by `turn` degrees and keeps the extents `framed` in the image.
    ///
    /// # Errors
    /// [`ViewError::Size`], [`ViewError::Option`] or [`ViewError::NoColour`] if the style is invalid,
    /// [`ViewError::Box`] if the framed region has no extent.
    pub fn new(
        (stage, surfaces): (Frame, Surfaces),
        style: &Style,
        framed: Vec<Extent>,
        turn: f64,
        scale: SpeedScale,
    ) -> Result<Self, ViewError> {
        refuse_style(style)?;
        let mut caption = Caption::of(style);
        let camera = Camera::walking(&stage, style, &with_surfaces(framed, &surfaces), caption.height, turn)
            .ok_or(ViewError::Box)?;
        caption.measure(&camera);
        Ok(Self { style: style.clone(), stage, surfaces, camera, scale, caption })
    }

    /// Draws a frame with `time` below it. The camera is at `azimuth` `[degrees]` and looks at `focus`. If `team` has
    /// been stopped, the image is unfinished.
    pub fn draw(
        &self,
        frame: &Frame,
        (azimuth, focus): (f64, [Option<f64>; 3]),
        time: &str,
        team: &Team,
    ) -> Result<Image, ViewError> {
        refuse_numbers(frame)?;
        let style = Style { azimuth, ..self.style.clone() };
        let camera = self.camera.turned(&self.stage, &style).looking_at(focus);
        let mut pixels = paint((frame, &self.surfaces), &style, &camera, self.scale.fastest, team);
        let width = camera.width as usize;
        if style.colour_by == ColourBy::Speed {
            legend::draw(&mut pixels, width, self.caption.row, self.scale.fastest, self.scale.is_exceeded());
        }
        self.caption.draw(&mut pixels, width, time);
        Ok(image(&camera, &pixels, team))
    }
}
