//! From images to the bytes of a movie, in two steps: one that needs nothing but two images, for any core, and one in the order of time.

use std::io;
use std::ops::ControlFlow;

use thiserror::Error;

use crate::view::render::Image;

/// Compresses images, on any core.
pub(super) trait Codec: Sync {
    /// Compressed image.
    type Piece: Send;

    /// Compresses an image, given its place in the movie and the image before it.
    ///
    /// # Errors
    /// If the format cannot hold it.
    fn compress(&self, place: usize, previous: Option<&Image>, image: &Image) -> io::Result<Self::Piece>;
}

/// Callback that is asked while something is waited for: it may break the work off.
pub(super) type Ask<'a> = dyn FnMut() -> ControlFlow<()> + 'a;

/// The file of a movie, to which compressed images are added one after the other.
pub(super) trait Track {
    /// Compressed image that it takes.
    type Piece;

    /// Adds an image.
    fn add(&mut self, piece: Self::Piece, ask: &mut Ask) -> Result<(), TrackError>;

    /// Writes what stands at the end.
    fn finish(self, ask: &mut Ask) -> Result<(), TrackError>;
}

/// Why a movie could not be written.
#[derive(Debug, Error)]
pub(super) enum TrackError {
    /// By the system.
    #[error(transparent)]
    Output(#[from] io::Error),
    /// By ffmpeg, with what it printed.
    #[error("{0}")]
    Ffmpeg(String),
    /// By what was asked.
    #[error("interrupted")]
    Interrupted,
}
