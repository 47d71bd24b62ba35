//! A text file, plain or compressed by gzip or Zstandard.

use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;
use ruzstd::encoding::{CompressionLevel, compress_to_vec};

use super::target::{Draft, finish};

/// Length of the uncompressed text in a Zstandard frame `[bytes]`.
const FRAME: usize = 1 << 20;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Compressed {
    Gzip,
    Zstandard,
}

impl Compressed {
    pub fn of_name(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        match ending.as_str() {
            "gz" => Some(Self::Gzip),
            "zst" => Some(Self::Zstandard),
            _ => None,
        }
    }
}

pub(super) enum Text {
    Plain(Draft),
    Gzip(GzEncoder<Draft>),
    /// The file, and the uncompressed text of the next frame.
    Zstandard(Draft, Vec<u8>),
}

impl Text {
    pub fn new(file: Draft, kind: Option<Compressed>) -> Self {
        match kind {
            None => Self::Plain(file),
            Some(Compressed::Gzip) => Self::Gzip(GzEncoder::new(file, Compression::default())),
            Some(Compressed::Zstandard) => Self::Zstandard(file, Vec::with_capacity(FRAME)),
        }
    }

    pub fn finish(self) -> io::Result<()> {
        match self {
            Self::Plain(file) => finish(file),
            Self::Gzip(encoder) => finish(encoder.finish()?),
            Self::Zstandard(mut file, text) => {
                file.write_all(&frame(&text))?;
                finish(file)
            }
        }
    }
}

fn frame(text: &[u8]) -> Vec<u8> {
    compress_to_vec(text, CompressionLevel::Fastest)
}

impl Write for Text {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Plain(file) => file.write(bytes),
            Self::Gzip(encoder) => encoder.write(bytes),
            Self::Zstandard(file, text) => {
                if text.len() >= FRAME {
                    file.write_all(&frame(text))?;
                    text.clear();
                }
                text.extend(bytes);
                Ok(bytes.len())
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Plain(file) => file.flush(),
            Self::Gzip(encoder) => encoder.flush(),
            Self::Zstandard(file, _) => file.flush(),
        }
    }
}
