use super::camera::{Camera, Extent};
use super::caption::Caption;
use super::legend;
use super::parallel::Team;
use super::{Image, Scale, Style, image, paint, refuse_numbers, refuse_style, shown_numbers, with_surfaces};
use crate::trajectory::Frame;
use crate::view::{Surfaces, ViewError};

#[derive(Debug, Clone)]
pub(in crate::view) struct Shot {
    style: Style,
    /// A frame without particles.
    stage: Frame,
    surfaces: Surfaces,
    camera: Camera,
    scale: Scale,
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
        scale: Scale,
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
        let numbers = shown_numbers(frame, &style)?;
        let mut pixels = paint((frame, &self.surfaces, &numbers), &style, &camera, self.scale.top, team);
        let width = camera.width as usize;
        legend::draw(&mut pixels, width, self.caption.row, &style, &self.scale);
        self.caption.draw(&mut pixels, width, &style, time);
        Ok(image(&camera, &pixels, team))
    }
}
