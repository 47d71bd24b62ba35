//! The engine for browsers as built by `web/build`: compressed, with the fingerprint of its sources.

/// First bytes of a compressed engine, before the fingerprint and the end of the line.
const MAGIC: &[u8] = b"carom engine ";

/// Number of digits of a fingerprint.
const DIGITS: usize = 16;

/// Fingerprint of the sources that determine the bits of a run.
const SOURCES: &str = env!("CAROM_FINGERPRINT");

/// The engine as WebAssembly, compressed for pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Engine<'a> {
    sources: &'a [u8],
    /// LZMA in its `.lzma` format, with the uncompressed length.
    pub(super) packed: &'a [u8],
}

impl<'a> Engine<'a> {
    /// The engine in a file built by `web/build`; `None` for any other file.
    #[must_use]
    pub fn of(file: &'a [u8]) -> Option<Self> {
        let (sources, packed) = file.strip_prefix(MAGIC)?.split_at_checked(DIGITS)?;
        Some(Self { sources, packed: packed.strip_prefix(b"\n")? })
    }

    /// Whether it was built from the same sources as this program, and so computes the same bits.
    #[must_use]
    pub fn is_of_these_sources(&self) -> bool {
        self.sources == SOURCES.as_bytes()
    }
}
