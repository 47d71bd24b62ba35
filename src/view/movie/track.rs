//! Conversion of images to the bytes of a movie in two steps. The first step needs only two images and runs
//! on any core. The second step adds the compressed images in order.

use std::io;
use std::ops::ControlFlow;

use thiserror::Error;

use crate::view::render::Image;

/// Compresses images, on any core.
pub(super) trait Codec: Sync {
    /// Compressed image.
    type Piece: Send;

    /// Compresses an image, given its place in the movie and the previous image.
    ///
    /// # Errors
    /// If the format cannot store it.
    fn compress(&self, place: usize, previous: Option<&Image>, image: &Image) -> io::Result<Self::Piece>;
}

/// Callback during a wait, which may stop the work.
pub(super) type Ask<'a> = dyn FnMut() -> ControlFlow<()> + 'a;

/// The file of a movie, to which compressed images are added in order.
pub(super) trait Track {
    /// The compressed image that it accepts.
    type Piece;

    /// Adds an image.
    fn add(&mut self, piece: Self::Piece, ask: &mut Ask) -> Result<(), TrackError>;

    /// Writes the end of the file.
    fn finish(self, ask: &mut Ask) -> Result<(), TrackError>;
}

/// Why a movie could not be written.
#[derive(Debug, Error)]
pub(super) enum TrackError {
    /// An error of the system.
    #[error(transparent)]
    Output(#[from] io::Error),
    /// An error of ffmpeg, with its output.
    #[error("{0}")]
    Ffmpeg(String),
    /// The callback stopped the movie.
    #[error("interrupted")]
    Interrupted,
}
