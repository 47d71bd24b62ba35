//! The file layer of GSD: a header, named arrays of each frame, the list of names, and an index of all arrays.
//!
//! The index stays in memory until the end. It needs about 130 bytes per frame.

use std::borrow::Cow;
use std::io::{self, Seek, SeekFrom, Write};

use crate::io::convert::{Draft, FrameError, finish};

const MAGIC: u64 = 0x65DF_65DF_65DF_65DF;
const FILE_VERSION: u32 = 2 << 16;
const SCHEMA_VERSION: u32 = 1 << 16 | 4;
const HEADER_SIZE: usize = 256;
/// The header contains the length of the list of names in units of this size `[bytes]`.
const NAME_PIECE: usize = 64;

/// Type of the numbers in an array. The value is the code of the type in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Kind {
    Uint8 = 1,
    Uint32 = 3,
    Uint64 = 4,
    Int8 = 5,
    Int32 = 7,
    Float = 9,
    Double = 10,
}

impl Kind {
    fn size(self) -> u64 {
        match self {
            Self::Uint8 | Self::Int8 => 1,
            Self::Uint32 | Self::Int32 | Self::Float => 4,
            Self::Uint64 | Self::Double => 8,
        }
    }
}

/// Index entry: the position of an array in the file.
#[derive(Debug)]
struct Entry {
    frame: u64,
    rows: u64,
    location: u64,
    columns: u32,
    name: u16,
    kind: Kind,
}

#[derive(Debug)]
pub(super) struct Chunks {
    file: Draft,
    /// Position of the next array `[bytes]`. Zero before the header is written.
    end: u64,
    frame: u64,
    names: Vec<Cow<'static, str>>,
    index: Vec<Entry>,
    /// Index of the first entry of the current frame.
    frame_start: usize,
}

impl Chunks {
    pub fn new(file: Draft) -> Self {
        Self { file, end: 0, frame: 0, names: Vec::new(), index: Vec::new(), frame_start: 0 }
    }

    pub fn frame(&self) -> u64 {
        self.frame
    }

    /// Appends an array to the current frame, unless the array is empty.
    pub fn write(
        &mut self,
        name: impl Into<Cow<'static, str>>,
        kind: Kind,
        columns: u32,
        bytes: &[u8],
    ) -> Result<(), FrameError> {
        if bytes.is_empty() {
            return Ok(());
        }
        if self.end == 0 {
            self.file.write_all(&[0; HEADER_SIZE])?;
            self.end = HEADER_SIZE as u64;
        }
        let name = name.into();
        let place = self.names.iter().position(|known| *known == name).unwrap_or(self.names.len());
        let Ok(number) = u16::try_from(place) else { return Err(FrameError::TooManyNames(name.into_owned())) };
        if place == self.names.len() {
            self.names.push(name);
        }
        let rows = bytes.len() as u64 / (u64::from(columns) * kind.size());
        self.index.push(Entry { frame: self.frame, rows, location: self.end, columns, name: number, kind });
        self.file.write_all(bytes)?;
        self.end += bytes.len() as u64;
        Ok(())
    }

    pub fn end_frame(&mut self) {
        // GSD requires an index sorted by frame and name.
        if let Some(entries) = self.index.get_mut(self.frame_start..) {
            entries.sort_by_key(|entry| entry.name);
        }
        self.frame_start = self.index.len();
        self.frame += 1;
    }

    /// Writes the list of names and the index. The header is written last, because it contains their positions.
    pub fn finish(mut self) -> io::Result<()> {
        let mut names: Vec<u8> = self.names.iter().flat_map(|name| name.bytes().chain([0])).collect();
        // An empty name marks the end of the list.
        names.resize((names.len() + 1).next_multiple_of(NAME_PIECE), 0);
        self.file.write_all(&names)?;
        for entry in &self.index {
            self.file.write_all(&entry.bytes())?;
        }
        let header = self.header(names.len() as u64);
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&header)?;
        finish(self.file)
    }

    fn header(&self, names_size: u64) -> Vec<u8> {
        let mut header = Vec::with_capacity(HEADER_SIZE);
        let pieces = names_size / NAME_PIECE as u64;
        for number in [MAGIC, self.end + names_size, self.index.len() as u64, self.end, pieces] {
            header.extend_from_slice(&number.to_le_bytes());
        }
        for version in [SCHEMA_VERSION, FILE_VERSION] {
            header.extend_from_slice(&version.to_le_bytes());
        }
        for text in [concat!("carom ", env!("CARGO_PKG_VERSION")), "hoomd"] {
            let field = header.len() + 64;
            // The last byte of the field stays zero.
            header.extend(text.bytes().take(63));
            header.resize(field, 0);
        }
        header.resize(HEADER_SIZE, 0);
        header
    }
}

impl Entry {
    fn bytes(&self) -> [u8; 32] {
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&self.frame.to_le_bytes());
        bytes[8..16].copy_from_slice(&self.rows.to_le_bytes());
        bytes[16..24].copy_from_slice(&self.location.to_le_bytes());
        bytes[24..28].copy_from_slice(&self.columns.to_le_bytes());
        bytes[28..30].copy_from_slice(&self.name.to_le_bytes());
        bytes[30] = self.kind as u8;
        bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn more_than_65536_chunk_names_are_rejected() {
        let folder = tempfile::tempdir().unwrap();
        let mut chunks = Chunks::new(crate::io::convert::draft(&folder.path().join("a.gsd")).unwrap());
        chunks.names = vec![Cow::Borrowed("taken"); usize::from(u16::MAX)];
        chunks.write("last", Kind::Uint8, 1, &[0]).unwrap();
        assert_eq!(chunks.index[0].name, u16::MAX);
        let error = chunks.write("one_more", Kind::Uint8, 1, &[0]).unwrap_err();
        assert!(matches!(&error, FrameError::TooManyNames(name) if name == "one_more"), "{error}");
        chunks.write("last", Kind::Uint8, 1, &[0]).unwrap();
        assert_eq!((chunks.names.len(), chunks.index.len()), (1 << 16, 2));
    }
}
