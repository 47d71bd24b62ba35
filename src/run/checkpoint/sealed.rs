//! Sealed files: a header with the version of the program, then the content, then its length and checksum.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::Checked;
use crate::base::numbers;

const FINGERPRINT: &str = env!("CAROM_FINGERPRINT");

const MAGIC: usize = 16;

const VERSION: usize = 15;

const PIECE: usize = 1 << 20;

/// Upper bound for the length of a string in a checkpoint `[bytes]`.
const LONGEST_TEXT: usize = 1 << 20;

const HEAD: usize = MAGIC + VERSION + FINGERPRINT.len() / 2;
const TAIL: usize = 12;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// State of a run or of a replica exchange.
    Checkpoint,
    Simulation,
}

impl Kind {
    fn magic(self) -> &'static [u8; MAGIC] {
        match self {
            Self::Checkpoint => b"carom checkpoint",
            Self::Simulation => b"carom simulation",
        }
    }

    pub fn is_that_of(self, path: &Path) -> bool {
        let mut magic = [0; MAGIC];
        // Only regular files are opened: opening a named pipe would block.
        path.is_file()
            && File::open(path).and_then(|mut file| file.read_exact(&mut magic)).is_ok()
            && magic == *self.magic()
    }

    fn head(self) -> [u8; HEAD] {
        let mut head = [0; HEAD];
        // The build script writes only hexadecimal digits, so this cannot fail.
        let sources = u64::from_str_radix(FINGERPRINT, 16).unwrap_or_default().to_le_bytes();
        head[..MAGIC].copy_from_slice(self.magic());
        head[MAGIC + VERSION..].copy_from_slice(&sources);
        for (to, from) in head[MAGIC..][..VERSION].iter_mut().zip(env!("CARGO_PKG_VERSION").bytes()) {
            *to = from;
        }
        head
    }
}

#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Flaw {
    Damaged(String),
    /// A different version or build of carom wrote the file.
    OtherVersion {
        found: String,
        here: &'static str,
    },
}

/// A writer that keeps its last error, because the serializer does not return the error of its writer.
struct KeepsError<W> {
    inner: W,
    failure: Option<io::Error>,
}

impl<W> KeepsError<W> {
    fn note<T>(&mut self, result: io::Result<T>) -> io::Result<T> {
        result.map_err(|error| {
            let kind = error.kind();
            self.failure = Some(error);
            kind.into()
        })
    }
}

impl<W: Write> Write for KeepsError<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let result = self.inner.write(bytes);
        self.note(result)
    }

    fn flush(&mut self) -> io::Result<()> {
        let result = self.inner.flush();
        self.note(result)
    }
}

pub(crate) fn write_sealed(out: impl Write, kind: Kind, content: &impl Serialize) -> io::Result<()> {
    // The serializer writes single numbers. Checksums of a few bytes at a time would be slow.
    let mut out = BufWriter::with_capacity(PIECE, Checked::new(out));
    out.write_all(&kind.head())?;
    let mut keeper = KeepsError { inner: &mut out, failure: None };
    if let Err(error) = postcard::to_io(content, &mut keeper) {
        return Err(keeper.failure.unwrap_or_else(|| io::Error::other(error)));
    }
    out.flush()?;
    let length = out.get_ref().length() - HEAD as u64;
    out.write_all(&length.to_le_bytes())?;
    out.flush()?;
    let checksum = out.get_ref().checksum();
    out.write_all(&checksum.to_le_bytes())?;
    out.flush()
}

/// Returns the header of a sealed file if its length and checksum are correct; otherwise describes the problem.
fn sound_head(input: &mut (impl Read + Seek), kind: Kind) -> io::Result<Result<[u8; HEAD], &'static str>> {
    let length = input.seek(SeekFrom::End(0))?;
    input.rewind()?;
    let mut head = [0; HEAD];
    let whole = length >= (HEAD + TAIL) as u64;
    let begins = if whole { HEAD } else { MAGIC.min(numbers::index(length)) };
    input.read_exact(&mut head[..begins])?;
    if head[..MAGIC] != *kind.magic() {
        return Ok(Err("its first bytes are wrong"));
    }
    if !whole {
        return Ok(Err("its end is missing"));
    }
    let content = length - (HEAD + TAIL) as u64;
    let mut found = Checked::new(io::sink());
    found.write_all(&head)?;
    io::copy(&mut BufReader::with_capacity(PIECE, &mut *input).take(content), &mut found)?;
    input.seek(SeekFrom::Start(HEAD as u64 + content))?;
    let (mut stated, mut checksum) = ([0; 8], [0; 4]);
    input.read_exact(&mut stated)?;
    input.read_exact(&mut checksum)?;
    found.write_all(&stated)?;
    if u64::from_le_bytes(stated) != content {
        return Ok(Err("its end is missing"));
    }
    Ok(if checksum == found.checksum().to_le_bytes() { Ok(head) } else { Err("its checksum is wrong") })
}

pub(crate) fn read_sealed<T: DeserializeOwned>(mut input: impl Read + Seek, kind: Kind) -> io::Result<Result<T, Flaw>> {
    let found = match sound_head(&mut input, kind)? {
        Ok(head) => head,
        Err(why) => return Ok(Err(Flaw::Damaged(why.to_owned()))),
    };
    if found != kind.head() {
        let (version, sources) = found[MAGIC..].split_at(VERSION);
        let version = String::from_utf8_lossy(version).trim_end_matches('\0').to_owned();
        let sources = sources.iter().rev().map(|byte| format!("{byte:02x}")).collect::<String>();
        return Ok(Err(Flaw::OtherVersion { found: format!("{version} ({sources})"), here: FINGERPRINT }));
    }
    input.seek(SeekFrom::Start(HEAD as u64))?;
    let reader = BufReader::with_capacity(PIECE, input);
    Ok(match postcard::from_io::<T, _>((reader, &mut vec![0; LONGEST_TEXT])) {
        Ok((content, _)) => Ok(content),
        Err(error) => Err(Flaw::Damaged(error.to_string())),
    })
}
