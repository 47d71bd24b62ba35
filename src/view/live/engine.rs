//! The engine for browsers from `web/build`, compressed, with the fingerprint of its sources.

/// Start of an engine file, before the fingerprint and a line end.
const MAGIC: &[u8] = b"carom engine ";

const DIGITS: usize = 16;

/// Fingerprint of the sources that affect the exact results of a run.
const SOURCES: &str = env!("CAROM_FINGERPRINT");

/// The engine as compressed WebAssembly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Engine<'a> {
    sources: &'a [u8],
    /// WebAssembly module in the `.lzma` format. The header contains the uncompressed length.
    pub(super) packed: &'a [u8],
}

impl<'a> Engine<'a> {
    /// Returns the engine in a file from `web/build`; `None` for any other file.
    #[must_use]
    pub fn of(file: &'a [u8]) -> Option<Self> {
        let (sources, packed) = file.strip_prefix(MAGIC)?.split_at_checked(DIGITS)?;
        Some(Self { sources, packed: packed.strip_prefix(b"\n")? })
    }

    /// Whether the engine was built from the sources of this program, so that its results are bit-identical.
    #[must_use]
    pub fn is_of_these_sources(&self) -> bool {
        self.sources == SOURCES.as_bytes()
    }
}
