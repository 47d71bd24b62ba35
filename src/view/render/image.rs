use std::io::{self, Write};
use std::path::Path;

use crate::io::atomic::write_atomically;
use crate::io::{Existing, note};
use crate::view::ViewError;

/// An image. Pixels have red, green, blue and opacity in sRGB.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    pixels: Vec<[u8; 4]>,
}

impl Image {
    pub(in crate::view) fn new(width: u32, height: u32, pixels: Vec<[u8; 4]>) -> Self {
        debug_assert_eq!(pixels.len(), width as usize * height as usize);
        Self { width, height, pixels }
    }

    /// Number of columns.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    pub(in crate::view) fn size(&self) -> [usize; 2] {
        [self.width as usize, self.height as usize]
    }

    /// Pixels, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[[u8; 4]] {
        &self.pixels
    }

    /// Writes a PNG file, which appears when it is complete.
    ///
    /// # Errors
    /// [`ViewError::Exists`] if an existing file must be kept, [`ViewError::Write`] if the file cannot be written.
    pub fn write_png(&self, path: &Path, existing: Existing) -> Result<(), ViewError> {
        let written = write_atomically(path, existing, |file| self.encode_png(file));
        written.map_err(ViewError::write(path))?;
        note(path);
        Ok(())
    }

    /// Writes the bytes of a PNG file.
    ///
    /// # Errors
    /// If the output cannot be written.
    pub fn encode_png<W: Write>(&self, output: W) -> io::Result<()> {
        let mut writer = png_encoder(output, self.width, self.height).write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(())
    }
}

pub(in crate::view) fn png_encoder<W: Write>(output: W, width: u32, height: u32) -> png::Encoder<'static, W> {
    let mut encoder = png::Encoder::new(output, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder
}
