//! Checksums of files.

/// Returns the checksum of a byte sequence.
pub(crate) fn checksum(bytes: &[u8]) -> u32 {
    crc32fast::hash(bytes)
}
