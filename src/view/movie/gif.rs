use std::borrow::Cow;
use std::io::{self, Write};

use ::gif::{DisposalMethod, Encoder, EncodingError, Frame, Repeat};

use super::changes::Rectangle;
use super::palette::{Palette, UNCHANGED};
use super::track::{Ask, Codec, Track, TrackError};
use crate::base::numbers::trunc_to_u16;
use crate::view::render::{Image, Style};

/// Largest number of images per second. Players show images for 0.1 s if the given duration is only 0.01 s.
pub(super) const MOST_PER_SECOND: u32 = 50;

pub(super) struct GifCodec<'a> {
    pub palette: &'a Palette,
    pub per_second: u32,
}

impl Codec for GifCodec<'_> {
    type Piece = Frame<'static>;

    fn compress(&self, place: usize, previous: Option<&Image>, image: &Image) -> io::Result<Self::Piece> {
        let indices = self.palette.indices(image);
        let before = previous.map(|previous| self.palette.indices(previous));
        let (rectangle, buffer) = Rectangle::changes(before.as_deref(), &indices, image.size(), UNCHANGED);
        let side = |pixels: usize| u16::try_from(pixels).map_err(io::Error::other);
        let mut frame = Frame {
            delay: delay(place, self.per_second),
            dispose: DisposalMethod::Keep,
            transparent: before.is_some().then_some(UNCHANGED),
            left: side(rectangle.left)?,
            top: side(rectangle.top)?,
            width: side(rectangle.width)?,
            height: side(rectangle.height)?,
            buffer: Cow::Owned(buffer),
            ..Frame::default()
        };
        frame.make_lzw_pre_encoded();
        Ok(frame)
    }
}

/// Returns the duration of an image in hundredths of a second. Durations are rounded such that their mean is exact.
fn delay(place: usize, per_second: u32) -> u16 {
    let end = |images: usize| (images as f64 * 100.0 / f64::from(per_second)).round();
    trunc_to_u16(end(place + 1) - end(place))
}

pub(super) struct GifTrack<W: Write>(Encoder<W>);

impl<W: Write> GifTrack<W> {
    pub fn begin(output: W, palette: &Palette, style: &Style) -> Result<Self, TrackError> {
        let side = |pixels: u32| u16::try_from(pixels).map_err(io::Error::other);
        let encoder = Encoder::new(output, side(style.width)?, side(style.height)?, palette.bytes());
        let mut encoder = encoder.map_err(failed)?;
        encoder.set_repeat(Repeat::Infinite).map_err(failed)?;
        Ok(Self(encoder))
    }
}

impl<W: Write> Track for GifTrack<W> {
    type Piece = Frame<'static>;

    fn add(&mut self, piece: Self::Piece, _ask: &mut Ask) -> Result<(), TrackError> {
        self.0.write_lzw_pre_encoded_frame(&piece).map_err(failed)
    }

    fn finish(self, _ask: &mut Ask) -> Result<(), TrackError> {
        Ok(self.0.into_inner().map_err(failed)?.flush()?)
    }
}

fn failed(error: EncodingError) -> TrackError {
    TrackError::Output(match error {
        EncodingError::Io(error) => error,
        error => io::Error::other(error),
    })
}

#[cfg(test)]
mod tests {
    use super::delay;

    #[test]
    fn frame_delays_differ_by_at_most_one_hundredth() {
        for per_second in 1..=super::MOST_PER_SECOND {
            let delays: Vec<u16> = (0..per_second as usize).map(|place| delay(place, per_second)).collect();
            assert_eq!(delays.iter().sum::<u16>(), 100, "{per_second}");
            assert!(delays.iter().max().unwrap() - delays.iter().min().unwrap() <= 1, "{per_second}");
            assert!(*delays.iter().min().unwrap() >= 2, "{per_second}");
        }
    }
}
