//! Arrays in the file format of NumPy, version 1.0. The number of rows is written when an array is complete.
//!
//! Source: *NumPy Enhancement Proposal 1*, <https://numpy.org/neps/nep-0001-npy-format.html>.

use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

use crate::io::convert::{Draft, draft, finish};

/// Length of the header `[bytes]`. For alignment, a multiple of 64.
pub(in crate::io) const HEADER_SIZE: usize = 10 + STATED_SIZE as usize;

/// Length of the header after the first ten bytes `[bytes]`.
const STATED_SIZE: u16 = 118;

#[derive(Debug)]
pub(super) struct Array {
    file: Draft,
    kind: String,
    row_shape: Vec<usize>,
    rows: usize,
}

impl Array {
    /// `kind` is the NumPy type, such as `<f8`.
    pub fn create(path: &Path, kind: &str, row_shape: &[usize]) -> io::Result<Self> {
        let mut file = draft(path)?;
        file.write_all(&[0; HEADER_SIZE])?;
        Ok(Self { file, kind: kind.to_owned(), row_shape: row_shape.to_vec(), rows: 0 })
    }

    pub fn whole(
        path: &Path,
        kind: &str,
        rows: usize,
        row_shape: &[usize],
        bytes: impl IntoIterator<Item = u8>,
    ) -> io::Result<()> {
        let mut array = Self::create(path, kind, row_shape)?;
        array.add(bytes)?;
        array.rows = rows;
        array.finish()
    }

    /// Writes words as Unicode text, four bytes per character. Shorter words are padded with zeros.
    pub fn words(path: &Path, words: &[&str]) -> io::Result<()> {
        let longest = words.iter().map(|word| word.chars().count()).max().unwrap_or(0).max(1);
        let codes = words.iter().flat_map(|word| {
            let fill = std::iter::repeat_n('\0', longest - word.chars().count());
            word.chars().chain(fill).flat_map(|c| u32::from(c).to_le_bytes())
        });
        Self::whole(path, &format!("<U{longest}"), words.len(), &[], codes)
    }

    pub fn add(&mut self, bytes: impl IntoIterator<Item = u8>) -> io::Result<()> {
        self.rows += 1;
        let bytes: Vec<u8> = bytes.into_iter().collect();
        self.file.write_all(&bytes)
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&header(&self.kind, &self.row_shape, self.rows))?;
        finish(self.file)
    }
}

pub(in crate::io) fn header(kind: &str, row_shape: &[usize], rows: usize) -> Vec<u8> {
    let shape: String = [rows].iter().chain(row_shape).map(|length| format!("{length}, ")).collect();
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}", shape.trim_end());
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend_from_slice(&STATED_SIZE.to_le_bytes());
    header.extend_from_slice(text.as_bytes());
    header.resize(HEADER_SIZE - 1, b' ');
    header.push(b'\n');
    header
}
