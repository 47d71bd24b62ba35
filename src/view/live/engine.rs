//! The engine for browsers from `web/build`.

/// Start of an engine file, followed by the fingerprint and a line end.
const MAGIC: &[u8] = b"carom engine ";

const DIGITS: usize = 16;

const SOURCES: &str = env!("CAROM_FINGERPRINT");

/// The engine as compressed WebAssembly.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Engine<'a> {
    sources: &'a [u8],
    /// WebAssembly module in the `.lzma` format.
    pub(super) packed: &'a [u8],
}

impl<'a> Engine<'a> {
    /// Returns the engine in a file from `web/build`, or `None` for any other file.
    #[must_use]
    pub fn of(file: &'a [u8]) -> Option<Self> {
        let (sources, packed) = file.strip_prefix(MAGIC)?.split_at_checked(DIGITS)?;
        Some(Self { sources, packed: packed.strip_prefix(b"\n")? })
    }

    /// Whether the engine was built from the sources of this program. If so, the results are bit-identical.
    #[must_use]
    pub fn is_of_these_sources(&self) -> bool {
        self.sources == SOURCES.as_bytes()
    }
}
