//! Movie files. Images are compressed in parallel, and added to the file in order.

use std::io;
use std::ops::ControlFlow;

use thiserror::Error;

use crate::view::render::Image;

/// Compressor for the images of a movie, used by several threads at once.
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
    #[error(transparent)]
    Output(#[from] io::Error),
    #[error("{0}")]
    Ffmpeg(String),
    #[error("interrupted")]
    Interrupted,
}
