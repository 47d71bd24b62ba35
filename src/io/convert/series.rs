//! Writes frames one by one in the formats of other programs.

use std::path::Path;

use super::target::Target;
use super::{ConvertError, Moment, Writer, open};
use crate::model::Format;
use crate::trajectory::Frame;

/// Writes frames one by one, in the format of another program.
///
/// Until the end, the output has a temporary name. Unfinished output is removed.
///
/// ```
/// use carom::io::convert::FrameSeries;
/// use carom::model::{Format, Scene};
/// use carom::trajectory::Frame;
///
/// let scene = Scene::from_file("configs/hard_sphere_fluid.toml")?;
/// # let directory = tempfile::tempdir()?;
/// # let path = directory.path().join("start.gsd");
/// let mut series = FrameSeries::create(&path, Format::Gsd, false)?;
/// series.write(&Frame::start_of(&scene))?;
/// series.finish()?;
/// assert!(path.exists());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct FrameSeries {
    writer: Box<dyn Writer>,
    target: Target,
    frames: u64,
}

impl FrameSeries {
    /// Creates the output file or folder.
    ///
    /// # Errors
    /// [`ConvertError::Exists`] or [`ConvertError::Foreign`] if the target may not be replaced. [`ConvertError::Write`]
    /// if the target cannot be written.
    pub fn create(path: &Path, format: Format, replace: bool) -> Result<Self, ConvertError> {
        let target = Target::claim(path, format, None, replace)?;
        Ok(Self { writer: open(format, &target, None)?, target, frames: 0 })
    }

    /// Number of frames written.
    #[must_use]
    pub fn frames(&self) -> u64 {
        self.frames
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`ConvertError::Unwritable`] if the format cannot represent the frame. [`ConvertError::Write`] if the target
    /// cannot be written.
    pub fn write(&mut self, frame: &Frame) -> Result<(), ConvertError> {
        let moment = Moment { index: self.frames, frame, has_velocities: true };
        self.writer.write(&moment).map_err(|error| error.at(None, self.frames, self.target.path()))?;
        self.frames += 1;
        Ok(())
    }

    /// Gives the file or folder its final name.
    ///
    /// # Errors
    /// [`ConvertError::Write`] if the target cannot be written. [`ConvertError::Exists`] if a file or folder now exists
    /// at the target.
    pub fn finish(self) -> Result<(), ConvertError> {
        let last = self.frames.saturating_sub(1);
        self.writer.finish().map_err(|error| error.at(None, last, self.target.path()))?;
        self.target.complete()
    }
}
