//! Movie files in two steps. First, several cores compress the images. To compress an image, a core needs only this
//! image and the previous one. Then the compressed images are added to the file in order.

use std::io;
use std::ops::ControlFlow;

use thiserror::Error;

use crate::view::render::Image;

/// Compressor for the images of a movie format, used by several threads at once.
pub(super) trait Codec: Sync {
    type Piece: Send;

    /// Compresses an image, given its place and the previous image. Fails if the format cannot store the image.
    fn compress(&self, place: usize, previous: Option<&Image>, image: &Image) -> io::Result<Self::Piece>;
}

/// Callback that runs during a wait and can stop the work.
pub(super) type Ask<'a> = dyn FnMut() -> ControlFlow<()> + 'a;

pub(super) trait Track {
    type Piece;

    fn add(&mut self, piece: Self::Piece, ask: &mut Ask) -> Result<(), TrackError>;

    fn finish(self, ask: &mut Ask) -> Result<(), TrackError>;
}

#[derive(Debug, Error)]
pub(super) enum TrackError {
    /// Error of the system or of an encoder.
    #[error(transparent)]
    Output(#[from] io::Error),
    /// An error of ffmpeg, with its output.
    #[error("{0}")]
    Ffmpeg(String),
    /// The callback has stopped the movie.
    #[error("interrupted")]
    Interrupted,
}
