//! Computes checksums of data while they are written.

use std::io::{self, Write};

use crc32fast::Hasher;

#[derive(Debug)]
pub(crate) struct Checked<W> {
    inner: W,
    hasher: Hasher,
    length: u64,
}

impl<W> Checked<W> {
    pub fn new(inner: W) -> Self {
        Self { inner, hasher: Hasher::new(), length: 0 }
    }

    pub fn go_on(inner: W, length: u64, checksum: u32) -> Self {
        Self { inner, hasher: Hasher::new_with_initial(checksum), length }
    }

    pub fn inner(&self) -> &W {
        &self.inner
    }

    pub fn pass(&mut self, length: u64) {
        self.length += length;
    }

    pub fn length(&self) -> u64 {
        self.length
    }

    pub fn checksum(&self) -> u32 {
        self.hasher.clone().finalize()
    }
}

impl<W: Write> Write for Checked<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.inner.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resumed_checksum_equals_uninterrupted_checksum() {
        let mut whole = Checked::new(Vec::new());
        whole.write_all(b"123456789").unwrap();
        // Check value in the specification of CRC-32.
        assert_eq!((whole.checksum(), whole.length()), (0xCBF4_3926, 9));
        let mut first = Checked::new(Vec::new());
        first.write_all(b"1234").unwrap();
        let mut rest = Checked::go_on(Vec::new(), first.length(), first.checksum());
        rest.write_all(b"56789").unwrap();
        assert_eq!((rest.checksum(), rest.length()), (whole.checksum(), whole.length()));
        assert_eq!(crate::base::checksum::checksum(b"123456789"), whole.checksum());
    }
}
