//! Compresses data of the page as gzip in base64, which browsers can decompress.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::GzEncoder;

use crate::view::report::base64;

pub(super) fn letters(bytes: &[u8]) -> String {
    let mut gzip = GzEncoder::new(Vec::new(), Compression::best());
    let packed: io::Result<Vec<u8>> = gzip.write_all(bytes).and_then(|()| gzip.finish());
    let mut letters = String::new();
    base64::encode(&packed.unwrap_or_default(), &mut letters);
    letters
}
