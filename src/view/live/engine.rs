//! The engine for browsers as built by `web/build`: compressed, with the fingerprint of its sources.

/// Start of an engine file. A fingerprint and a line end follow.
const MAGIC: &[u8] = b"carom engine ";

const DIGITS: usize = 16;

/// Fingerprint of the sources that affect the exact results of a run.
const SOURCES: &str = env!("CAROM_FINGERPRINT");

/// The engine as WebAssembly, compressed for pages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Engine<'a> {
    sources: &'a [u8],
    /// WebAssembly module, compressed with LZMA in the `.lzma` format. The uncompressed length is in its header.
    pub(super) packed: &'a [u8],
}

impl<'a> Engine<'a> {
    /// Returns the engine in a file built by `web/build`; `None` for any other file.
    #[must_use]
    pub fn of(file: &'a [u8]) -> Option<Self> {
        let (sources, packed) = file.strip_prefix(MAGIC)?.split_at_checked(DIGITS)?;
        Some(Self { sources, packed: packed.strip_prefix(b"\n")? })
    }

    /// Whether the engine was built from the same sources as this program. If so, its results are bit-identical.
    #[must_use]
    pub fn is_of_these_sources(&self) -> bool {
        self.sources == SOURCES.as_bytes()
    }
}
