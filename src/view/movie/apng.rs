//! Animated PNG (<https://www.w3.org/TR/png-3/#11fcTL>). Each image is compressed as a separate PNG, in parallel.

use std::io::{self, Write};

use png::chunk::{ChunkType, IDAT};
use png::{EncodingError, Writer};

use super::changes::Rectangle;
use super::track::{Ask, Codec, Track, TrackError};
use crate::view::render::{Image, Style, png_encoder};

const ANIMATION: ChunkType = ChunkType(*b"acTL");
const CONTROL: ChunkType = ChunkType(*b"fcTL");
const DATA: ChunkType = ChunkType(*b"fdAT");

/// Length of a chunk without its data (length, name and checksum), and length of the file signature `[bytes]`.
const AROUND: usize = 12;
const SIGNATURE: usize = 8;

/// Blend operation: transparent pixels show the previous image.
const OVER: u8 = 1;

pub(super) struct ApngCodec;

pub(super) struct Piece {
    rectangle: Rectangle,
    data: Vec<u8>,
}

impl Codec for ApngCodec {
    type Piece = Piece;

    fn compress(&self, _place: usize, previous: Option<&Image>, image: &Image) -> io::Result<Piece> {
        let (rectangle, pixels) = Rectangle::changes(previous.map(Image::pixels), image.pixels(), image.size(), [0; 4]);
        let side = |pixels: usize| u32::try_from(pixels).map_err(io::Error::other);
        let mut file = Vec::new();
        Image::new(side(rectangle.width)?, side(rectangle.height)?, pixels).encode_png(&mut file)?;
        Ok(Piece { rectangle, data: data_of(&file) })
    }
}

fn data_of(file: &[u8]) -> Vec<u8> {
    let mut data = Vec::with_capacity(file.len());
    let mut rest = file.get(SIGNATURE..).unwrap_or_default();
    while let Some((length, after)) = rest.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        if after.starts_with(&IDAT.0) {
            data.extend_from_slice(after.get(4..4 + length).unwrap_or_default());
        }
        rest = rest.get(length + AROUND..).unwrap_or_default();
    }
    data
}

pub(super) struct ApngTrack<W: Write> {
    writer: Writer<W>,
    per_second: u16,
    /// Sequence number of the next chunk. The data chunks of the first image have no number.
    sequence: u32,
}

impl<W: Write> ApngTrack<W> {
    pub fn begin(output: W, style: &Style, count: usize, per_second: u32) -> Result<Self, TrackError> {
        let mut writer = png_encoder(output, style.width, style.height).write_header().map_err(failed)?;
        let count = u32::try_from(count).map_err(io::Error::other)?;
        // Zero repetitions repeat for ever.
        let animation = [count.to_be_bytes(), 0_u32.to_be_bytes()];
        writer.write_chunk(ANIMATION, animation.as_flattened()).map_err(failed)?;
        Ok(Self { writer, per_second: u16::try_from(per_second).map_err(io::Error::other)?, sequence: 0 })
    }

    fn number(&mut self) -> [u8; 4] {
        self.sequence += 1;
        (self.sequence - 1).to_be_bytes()
    }
}

impl<W: Write> Track for ApngTrack<W> {
    type Piece = Piece;

    fn add(&mut self, piece: Piece, _ask: &mut Ask) -> Result<(), TrackError> {
        let Rectangle { left, top, width, height } = piece.rectangle;
        let is_first = self.sequence == 0;
        let mut control = self.number().to_vec();
        for pixels in [width, height, left, top] {
            control.extend(u32::try_from(pixels).map_err(io::Error::other)?.to_be_bytes());
        }
        control.extend([1_u16.to_be_bytes(), self.per_second.to_be_bytes()].as_flattened());
        // Disposal method 0 keeps the canvas.
        control.extend([0, if is_first { 0 } else { OVER }]);
        self.writer.write_chunk(CONTROL, &control).map_err(failed)?;
        if is_first {
            return self.writer.write_chunk(IDAT, &piece.data).map_err(failed);
        }
        let data = [&self.number(), piece.data.as_slice()].concat();
        self.writer.write_chunk(DATA, &data).map_err(failed)
    }

    fn finish(self, _ask: &mut Ask) -> Result<(), TrackError> {
        self.writer.finish().map_err(failed)
    }
}

fn failed(error: EncodingError) -> TrackError {
    TrackError::Output(match error {
        EncodingError::IoError(error) => error,
        error => io::Error::other(error),
    })
}
