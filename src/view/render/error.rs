//! Errors of images.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::model::ParticleId;
use crate::trajectory::extended_xyz::ReadError;

/// Error of rendering: why an image could not be drawn or written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RenderError {
    /// The trajectory could not be read.
    #[error("cannot read the trajectory {}", path.display())]
    Trajectory {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ReadError,
    },
    /// The frame has no particles.
    #[error("the frame has no particles to draw")]
    Empty,
    /// A particle cannot be placed.
    #[error("particle {} cannot be drawn: expected a finite position and velocity and a positive finite radius", .0.0)]
    Particle(ParticleId),
    /// The box cannot be placed.
    #[error("the box cannot be drawn: expected a finite corner and finite edges that are not negative")]
    Box,
    /// The image would have no pixels, or too many.
    #[error(
        "an image of {width} x {height} pixels cannot be drawn: expected 16 to 8192 by 16 to 8192, and no more than 8388608 in all"
    )]
    Size {
        /// Columns of pixels.
        width: u32,
        /// Rows of pixels.
        height: u32,
    },
    /// Another number of the style makes no sense.
    #[error("{name} of an image is {value}, expected {expected}")]
    Style {
        /// The field.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Expected value, in words.
        expected: &'static str,
    },
    /// The style lists no colour.
    #[error("the palette of an image is empty")]
    NoColour,
    /// There is something under the name of the image.
    #[error("{} exists", .0.display())]
    Exists(PathBuf),
    /// The file could not be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

impl RenderError {
    /// Cure: what the user can do, where that is not plain.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        match self {
            Self::Exists(_) => Some("replace it with --force, or choose another name with --out"),
            Self::Write { .. } => Some("choose a file with --out in a folder that can be written to"),
            _ => None,
        }
    }
}
