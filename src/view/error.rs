//! Errors of pictures, movies and pages.

use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::mesh::read::MeshFileError;
use crate::model::ParticleId;
use crate::trajectory::extended_xyz::ReadError;

/// Error of making or writing a picture, a movie or a page.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ViewError {
    /// The trajectory could not be read.
    #[error("cannot read the trajectory {}", path.display())]
    Trajectory {
        /// Path of the trajectory.
        path: PathBuf,
        /// Error of the trajectory reader.
        source: ReadError,
    },
    /// A surface file beside the trajectory could not be read.
    #[error("cannot read the surface {}", path.display())]
    SurfaceFile {
        /// Path of the surface file.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
    /// A surface file beside the trajectory is damaged.
    #[error("a surface file next to the trajectory is damaged")]
    Surface(#[source] Box<MeshFileError>),
    /// The frame has no particles.
    #[error("the frame has no particles to draw")]
    Empty,
    /// A particle has an invalid position, velocity or radius.
    #[error("particle {} cannot be drawn: expected a finite position and velocity and a positive finite radius", .0.0)]
    Particle(ParticleId),
    /// Colours should show contact pressures, but the frame has none.
    #[error("the frame has no contact pressures to show: expected a run with `particle_stress = true` in [measure]")]
    NoPressure,
    /// The particle that the camera should follow is not in the frame.
    #[error("the frame has no particle {} to follow", .0.0)]
    NoParticle(ParticleId),
    /// The box has a corner or an edge that is not finite, or a negative edge.
    #[error("the box cannot be drawn: expected a finite corner and finite edges that are not negative")]
    Box,
    /// The image would have no pixels, or too many.
    #[error(
        "an image of {width} x {height} pixels cannot be drawn: expected 16 to 8192 by 16 to 8192, and no more than 8388608 in all"
    )]
    Size {
        /// Columns of pixels.
        width: u32,
        /// Rows of pixels.
        height: u32,
    },
    /// An option of an image or a movie has an invalid value.
    #[error("{name} is {value}, expected {expected}")]
    Option {
        /// Name of the option.
        name: &'static str,
        /// Value of the option.
        value: f64,
        /// Expected value.
        expected: &'static str,
    },
    /// The style lists no colour.
    #[error("the palette of an image is empty")]
    NoColour,
    /// The file extension does not belong to a movie format.
    #[error("`{}` is not a supported movie format: expected .mp4, .gif or .apng", ending(.0))]
    Format(PathBuf),
    /// A GIF has too many images per second. Players would slow it down.
    #[error(
        "a GIF cannot show {0} images per second: an image lasts for whole hundredths of a second, and players show the shortest images ten times longer"
    )]
    FastGif(u32),
    /// The requested MP4 would have an odd width or height. The format stores colours for blocks of two by two pixels.
    #[error("an MP4 of {width} x {height} pixels cannot be written: expected even numbers")]
    OddSize {
        /// Columns of pixels.
        width: u32,
        /// Rows of pixels.
        height: u32,
    },
    /// The program `ffmpeg`, which writes MP4, cannot be started.
    #[error("an MP4 is written by the program ffmpeg, which cannot be started")]
    NoFfmpeg(#[source] io::Error),
    /// The trajectory of a movie is a pipe or a device.
    #[error("{} is not a regular file: a movie reads its frames twice, which a pipe does not allow", .0.display())]
    NotFile(PathBuf),
    /// The trajectory was changed while it was read.
    #[error("{} was changed while it was read", .0.display())]
    Changed(PathBuf),
    /// No frame of the movie has a particle.
    #[error("no requested frame of {} contains a particle", .0.display())]
    EmptyMovie(PathBuf),
    /// The trajectory ends before the first requested frame.
    #[error("frame {first} of {} does not exist: it has {count} complete frames, counted from 0", path.display())]
    NoSuchFrame {
        /// Path of the trajectory.
        path: PathBuf,
        /// Index of the requested frame.
        first: u64,
        /// Number of complete frames.
        count: u64,
    },
    /// A frame of a movie cannot be drawn.
    #[error("frame {index} of {} cannot be drawn", path.display())]
    Frame {
        /// Path of the trajectory.
        path: PathBuf,
        /// Index of the frame, from 0.
        index: u64,
        /// Reason why the frame cannot be drawn.
        source: Box<Self>,
    },
    /// The target of the movie exists and is not a file.
    #[error("{} is not a file, and cannot be replaced by a movie", .0.display())]
    NotReplaceable(PathBuf),
    /// `ffmpeg` failed.
    #[error("ffmpeg failed: {0}")]
    Ffmpeg(String),
    /// No thread could be started.
    #[error("no thread could be started to draw images")]
    Threads,
    /// The callback for progress stopped the work.
    #[error("interrupted; nothing was written")]
    Interrupted,
    /// The path of a run is not a folder.
    #[error("{} is not the folder of a run", .0.display())]
    NotFolder(PathBuf),
    /// The summary of the run is missing or unreadable.
    #[error("cannot read {}", path.display())]
    Unreadable {
        /// Path of the summary.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
    /// The summary is damaged.
    #[error("{} is not the summary of a run", path.display())]
    Summary {
        /// Path of the summary.
        path: PathBuf,
        /// Error of the parser.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The target file already exists and must not be replaced.
    #[error("{} exists", .0.display())]
    Exists(PathBuf),
    /// The file could not be written.
    #[error("cannot write {}", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
}

fn ending(path: &Path) -> String {
    let extension = path.extension().map(|extension| format!(".{}", extension.display()));
    extension.unwrap_or_else(|| path.file_name().unwrap_or_default().display().to_string())
}

impl ViewError {
    pub(super) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        |source| match source.kind() {
            io::ErrorKind::AlreadyExists => Self::Exists(path),
            _ => Self::Write { path, source },
        }
    }

    pub(super) fn trajectory(path: &Path) -> impl Fn(ReadError) -> Self + Copy {
        move |source| Self::Trajectory { path: path.to_owned(), source }
    }

    /// Returns a suggestion for the user, if there is one.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        Some(match self {
            Self::Format(_) => {
                "choose a name such as film.mp4 (players, slides), film.gif (everywhere) or film.apng (browsers)"
            }
            Self::FastGif(_) => "choose at most 50 with --fps, or the extension .apng or .mp4 for --out",
            Self::OddSize { .. } => "choose even numbers with --size, or the extension .gif or .apng for --out",
            Self::NoFfmpeg(_) => {
                "install ffmpeg (its package has that name: apt install ffmpeg, brew install ffmpeg) so that it is in PATH, \
                 or choose the extension .gif or .apng for --out: these formats need no other program"
            }
            Self::NoSuchFrame { .. } => "choose earlier frames with --frames",
            Self::Exists(_) => "replace it with --force, or choose another name with --out",
            Self::SurfaceFile { .. } | Self::Surface(_) => {
                "remove the file, so that its surface is not drawn, or let `carom run --resume` write it again"
            }
            Self::NotReplaceable(_) => "choose another name with --out",
            Self::NotFile(_) => "write it to a file first",
            Self::Write { .. } => "choose a file with --out in a folder that can be written to",
            Self::Ffmpeg(_) => "choose the extension .gif or .apng for --out: these formats need no other program",
            Self::Changed(_) => "make the movie when the run is over",
            Self::Threads => "allow this process more threads (ulimit -u)",
            Self::NotFolder(_) => "carom run SCENE writes the folder runs/NAME",
            Self::Unreadable { .. } => "summary.json is the last file that a run writes: a killed run has none",
            Self::Summary { .. } => "run the scene again, or restore the file",
            _ => return None,
        })
    }
}
