//! Errors of movies.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::trajectory::extended_xyz::ReadError;
use crate::view::render::RenderError;

/// Error of a movie: why it could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MovieError {
    /// The ending of the name stands for no format.
    #[error("`{}` is not a supported movie format: expected .mp4, .gif or .apng", ending(.0))]
    Format(PathBuf),
    /// An option makes no sense.
    #[error("the {name} is {value}, expected {expected}")]
    Option {
        /// Which.
        name: &'static str,
        /// Its value.
        value: f64,
        /// Expected value, in words.
        expected: &'static str,
    },
    /// Players slow such a GIF down.
    #[error(
        "a GIF cannot show {0} images per second: its images last for whole hundredths of a second, and players make one of the shortest ten"
    )]
    FastGif(u32),
    /// An MP4 has one colour for each two by two pixels.
    #[error("an MP4 of {width} x {height} pixels cannot be written: expected even numbers")]
    OddSize {
        /// Columns of pixels.
        width: u32,
        /// Rows of pixels.
        height: u32,
    },
    /// The program that writes MP4 cannot be started.
    #[error("an MP4 is written by the program ffmpeg, which cannot be started")]
    NoFfmpeg(#[source] io::Error),
    /// The style makes no sense, or there is nothing to frame.
    #[error(transparent)]
    Render(RenderError),
    /// The trajectory could not be read.
    #[error("cannot read the trajectory {}", path.display())]
    Trajectory {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ReadError,
    },
    /// The trajectory is a pipe or a device.
    #[error("{} is not a file: its frames are found first and read then, which a pipe does not allow", .0.display())]
    NotFile(PathBuf),
    /// The trajectory was changed while it was read.
    #[error("{} was changed while it was read", .0.display())]
    Changed(PathBuf),
    /// No frame of the movie has a particle.
    #[error("no frame of {} that is asked for has a particle to draw", .0.display())]
    Empty(PathBuf),
    /// The trajectory ends before the first frame asked for.
    #[error("frame {first} of {} does not exist: it has {count} complete frames, counted from 0", path.display())]
    NoSuchFrame {
        /// The file.
        path: PathBuf,
        /// The frame asked for.
        first: u64,
        /// The number of complete frames.
        count: u64,
    },
    /// A frame cannot be drawn.
    #[error("frame {index} of {} cannot be drawn", path.display())]
    Frame {
        /// The file.
        path: PathBuf,
        /// The place of the frame, from 0.
        index: u64,
        /// Why.
        source: Box<RenderError>,
    },
    /// There is a file under the name of the movie.
    #[error("{} exists", .0.display())]
    Exists(PathBuf),
    /// There is something else under the name of the movie.
    #[error("{} is not a file, and cannot be replaced by a movie", .0.display())]
    NotReplaceable(PathBuf),
    /// The file could not be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The program that writes MP4 failed.
    #[error("ffmpeg failed: {0}")]
    Ffmpeg(String),
    /// No thread could be started.
    #[error("no thread could be started to draw images")]
    Threads,
    /// It was broken off.
    #[error("interrupted; nothing was written")]
    Interrupted,
}

/// Extension of a path with its dot, or its name if it has none.
fn ending(path: &Path) -> String {
    let extension = path.extension().map(|extension| format!(".{}", extension.display()));
    extension.unwrap_or_else(|| path.file_name().unwrap_or_default().display().to_string())
}

impl MovieError {
    pub(super) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| match source.kind() {
            io::ErrorKind::AlreadyExists => Self::Exists(path),
            _ => Self::Write { path, source },
        }
    }

    /// Cure: what the user can do, where that is not plain.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        match self {
            Self::Format(_) => {
                Some("choose a name such as film.mp4 (players, slides), film.gif (everywhere) or film.apng (browsers)")
            }
            Self::FastGif(_) => Some("choose at most 50 with --fps, or --out with the ending .apng or .mp4"),
            Self::OddSize { .. } => Some("choose even numbers with --size, or --out with the ending .gif or .apng"),
            Self::NoFfmpeg(_) => Some(
                "install ffmpeg (its package has that name: apt install ffmpeg, brew install ffmpeg) so that it is in PATH, \
                 or choose --out with the ending .gif or .apng, which need no other program",
            ),
            Self::NoSuchFrame { .. } => Some("choose earlier frames with --frames"),
            Self::Exists(_) => Some("replace it with --force, or choose another name with --out"),
            Self::NotReplaceable(_) => Some("choose another name with --out"),
            Self::NotFile(_) => Some("write it to a file first"),
            Self::Write { .. } => Some("choose a file with --out in a folder that can be written to"),
            Self::Ffmpeg(_) => Some("choose --out with the ending .gif or .apng, which need no other program"),
            Self::Changed(_) => Some("make the movie when the run is over"),
            Self::Threads => Some("allow this process more threads (ulimit -u)"),
            Self::Render(error) => error.cure(),
            Self::Frame { source, .. } => source.cure(),
            _ => None,
        }
    }
}
