//! Positions of frames in a trajectory file. A frame can be read without reading all earlier frames.

use std::fs::File;
use std::io::{BufRead, BufReader, Seek, SeekFrom};
use std::path::Path;

use super::{FrameReader, ReadError};
use crate::trajectory::Frame;
use crate::trajectory::compressed::is_compressed;

const BUFFER: usize = 1 << 18;

/// Position at which a frame begins in a trajectory file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FramePlace {
    byte: u64,
    /// Number of earlier lines, for error messages.
    lines: usize,
}

/// Returns the positions of the frames in a trajectory file, in order. Numbers are not parsed. An incomplete frame at
/// the end of the file is left out.
///
/// ```
/// # use carom::trajectory::extended_xyz::{frame_at, frame_places};
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("trajectory.xyz");
/// std::fs::write(&path, "1\nTime=0\nA 0 0 0\n1\nTime=2\nA 1 0 0\n1\nTime=4\n")?;
/// let places = frame_places(&path)?;
/// assert_eq!(places.len(), 2);
/// assert_eq!(frame_at(&path, places[1])?.time, 2.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`ReadError::Open`] if the file cannot be opened or read; any other [`ReadError`] if a frame does not begin with its
/// number of particles.
pub fn frame_places(path: &Path) -> Result<Vec<FramePlace>, ReadError> {
    let unreadable = |source| ReadError::Open { path: path.to_owned(), source };
    let mut input = opened(path)?;
    let mut places = Vec::new();
    let mut at = FramePlace { byte: 0, lines: 0 };
    let mut line = Vec::new();
    loop {
        line.clear();
        let read = input.read_until(b'\n', &mut line).map_err(unreadable)?;
        if read == 0 {
            return Ok(places);
        }
        let text = String::from_utf8_lossy(&line);
        let mut next = FramePlace { byte: at.byte + read as u64, lines: at.lines + 1 };
        if text.trim().is_empty() {
            at = next;
            continue;
        }
        let Ok(count) = text.trim().parse::<u32>() else {
            // `frame_at` returns the error.
            return frame_at(path, at).map(|_| places);
        };
        let mut is_whole = true;
        for _ in 0..=count {
            let skipped = input.skip_until(b'\n').map_err(unreadable)? as u64;
            if skipped == 0 {
                is_whole = false;
                break;
            }
            next = FramePlace { byte: next.byte + skipped, lines: next.lines + 1 };
        }
        if is_whole {
            places.push(at);
        }
        at = next;
    }
}

/// Reads the frame at a position in a trajectory file.
///
/// # Errors
/// [`ReadError::Open`] if the file cannot be opened; any other [`ReadError`] if the frame is malformed or has changed.
pub fn frame_at(path: &Path, place: FramePlace) -> Result<Frame, ReadError> {
    let mut input = opened(path)?;
    input.seek(SeekFrom::Start(place.byte)).map_err(|source| ReadError::Open { path: path.to_owned(), source })?;
    FrameReader::behind(input, place.lines).next().unwrap_or(Err(ReadError::NoFrame))
}

fn opened(path: &Path) -> Result<BufReader<File>, ReadError> {
    let file = File::open(path).map_err(|source| ReadError::Open { path: path.to_owned(), source })?;
    let mut input = BufReader::with_capacity(BUFFER, file);
    let start = input.fill_buf().map_err(|source| ReadError::Open { path: path.to_owned(), source })?;
    if is_compressed(start) { Err(ReadError::Compressed(path.to_owned())) } else { Ok(input) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trajectory() -> String {
        let mut text = String::new();
        for frame in 0..5 {
            let count = if frame == 1 { 2 } else { 1 };
            text += &format!("{count}\nTime={frame}\n");
            (0..count).for_each(|at| text += &format!("A {frame} {at} 0.5\n"));
            text += if frame == 2 { "\n  \n" } else { "" };
        }
        text
    }

    #[test]
    fn frames_read_by_offset_equal_frames_read_in_sequence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trajectory.xyz");
        let text = trajectory();
        let all: Vec<Frame> = FrameReader::new(text.as_bytes()).map(Result::unwrap).collect();
        std::fs::write(&path, &text).unwrap();
        let places = frame_places(&path).unwrap();
        assert_eq!(places.len(), 5);
        for at in [3, 0, 4, 1, 2] {
            assert_eq!(frame_at(&path, places[at]).unwrap(), all[at]);
        }
        std::fs::write(&path, text.replace('\n', "\r\n")).unwrap();
        let places = frame_places(&path).unwrap();
        assert_eq!(places.iter().map(|place| frame_at(&path, *place).unwrap()).collect::<Vec<_>>(), all);
    }

    #[test]
    fn a_frame_that_is_cut_off_is_left_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trajectory.xyz");
        let text = trajectory();
        let last = text.rfind("1\nTime=4").unwrap();
        let lines = text.rfind("A 4").unwrap();
        for end in [last, last + 1, last + 2, lines - 1, lines] {
            std::fs::write(&path, &text[..end]).unwrap();
            assert_eq!(frame_places(&path).unwrap().len(), 4, "{end}");
        }
        std::fs::write(&path, "").unwrap();
        assert_eq!(frame_places(&path).unwrap(), []);
    }

    #[test]
    fn an_error_has_the_line_of_the_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("trajectory.xyz");
        let text = trajectory();
        std::fs::write(&path, text.replace("A 2 0 0.5", "A 2 x 0.5")).unwrap();
        let places = frame_places(&path).unwrap();
        assert_eq!(places.len(), 5);
        let error = frame_at(&path, places[2]).unwrap_err().to_string();
        assert!(error.contains("line 10"), "{error}");
        std::fs::write(&path, text.replace("1\nTime=3", "one\nTime=3")).unwrap();
        let error = frame_places(&path).unwrap_err().to_string();
        assert!(error.contains("one") && error.contains("line 13"), "{error}");
        assert!(matches!(frame_places(&folder.path().join("none")), Err(ReadError::Open { .. })));
    }
}
