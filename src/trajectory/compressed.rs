//! Text files compressed by gzip or Zstandard. The first bytes of a file identify the format.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use flate2::bufread::MultiGzDecoder;
use ruzstd::decoding::StreamingDecoder;

const BUFFER: usize = 1 << 16;

/// Largest accepted window of Zstandard, as in the program `zstd` `[bytes]`.
const LARGEST_WINDOW: u64 = 1 << 27;

const GZIP: [u8; 2] = [0x1f, 0x8b];
const ZSTANDARD: [u8; 4] = [0x28, 0xb5, 0x2f, 0xfd];

pub(crate) fn is_compressed(start: &[u8]) -> bool {
    start.starts_with(&GZIP) || start.starts_with(&ZSTANDARD)
}

///
/// # Errors
/// If the file cannot be opened or read. Errors in compressed data are reported when the text is read.
pub(crate) fn open(path: &Path) -> io::Result<Box<dyn BufRead>> {
    unpacked(BufReader::with_capacity(BUFFER, File::open(path)?))
}

///
/// # Errors
/// If the beginning of the text cannot be read.
pub(crate) fn unpacked<'a>(mut packed: impl BufRead + 'a) -> io::Result<Box<dyn BufRead + 'a>> {
    let start = packed.fill_buf()?;
    if start.starts_with(&GZIP) {
        return Ok(Box::new(BufReader::with_capacity(BUFFER, MultiGzDecoder::new(packed))));
    }
    if start.starts_with(&ZSTANDARD) {
        return Ok(Box::new(BufReader::with_capacity(BUFFER, Frames { state: Some(State::Between(packed)) })));
    }
    Ok(Box::new(packed))
}

struct Frames<R: BufRead> {
    /// State of the decoder; `None` after an error.
    state: Option<State<R>>,
}

enum State<R: BufRead> {
    Between(R),
    Within(Box<StreamingDecoder<R, ruzstd::decoding::FrameDecoder>>),
}

impl<R: BufRead> Read for Frames<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let damaged = |why: String| io::Error::new(io::ErrorKind::InvalidData, format!("damaged Zstandard: {why}"));
        while !buffer.is_empty() {
            match self.state.take() {
                None => return Err(damaged("it cannot be read on".to_owned())),
                Some(State::Between(mut packed)) => {
                    if packed.fill_buf()?.is_empty() {
                        self.state = Some(State::Between(packed));
                        return Ok(0);
                    }
                    let decoder = StreamingDecoder::new_with_max_window_size(packed, LARGEST_WINDOW);
                    self.state = Some(State::Within(Box::new(decoder.map_err(|error| damaged(error.to_string()))?)));
                }
                Some(State::Within(mut decoder)) => match decoder.read(buffer) {
                    Ok(0) => self.state = Some(State::Between((*decoder).into_inner())),
                    Ok(count) => {
                        self.state = Some(State::Within(decoder));
                        return Ok(count);
                    }
                    Err(error) => return Err(damaged(error.to_string())),
                },
            }
        }
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn text() -> Vec<u8> {
        (0..20_000_u32).flat_map(|k| format!("{} {}\n", k, f64::from(k).sqrt()).into_bytes()).collect()
    }

    fn gzip(text: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        encoder.write_all(text).unwrap();
        encoder.finish().unwrap()
    }

    fn zstandard(text: &[u8]) -> Vec<u8> {
        ruzstd::encoding::compress_to_vec(text, ruzstd::encoding::CompressionLevel::Fastest)
    }

    fn read(packed: &[u8]) -> io::Result<Vec<u8>> {
        let mut all = Vec::new();
        unpacked(packed)?.read_to_end(&mut all)?;
        Ok(all)
    }

    #[test]
    fn gzip_zstandard_multipart_and_plain_files_are_read() {
        let text = text();
        let (one, other) = text.split_at(70_001);
        for pack in [gzip as fn(&[u8]) -> Vec<u8>, zstandard] {
            assert_eq!(read(&pack(&text)).unwrap(), text);
            assert_eq!(read(&[pack(one), pack(other)].concat()).unwrap(), text);
            assert_eq!(read(&pack(b"")).unwrap(), b"");
        }
        assert_eq!(read(&text).unwrap(), text);
        assert_eq!(read(b"").unwrap(), b"");
    }

    #[test]
    fn truncated_or_damaged_compressed_files_are_rejected() {
        let text = text();
        for (pack, has_checksum) in [(gzip as fn(&[u8]) -> Vec<u8>, true), (zstandard, false)] {
            let packed = pack(&text);
            for cut in [5, 40, packed.len() / 2, packed.len() - 3] {
                assert!(read(&packed[..cut]).is_err(), "{cut}");
            }
            // The file has a checksum, so reading a changed file fails or the text is unchanged.
            for k in 0..60 {
                let mut changed = packed.clone();
                let at = 4 + k * 7_919 % (packed.len() - 4);
                changed[at] ^= 0x41;
                let read = read(&changed);
                assert!(read.is_err() || !has_checksum || read.unwrap() == text, "{at}");
            }
        }
    }
}
