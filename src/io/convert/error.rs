use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use crate::io::error::cure_of;
use crate::model::ParticleId;
use crate::trajectory::extended_xyz::{ReadError, WriteError};

/// Errors of a conversion.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ConvertError {
    /// The source file cannot be read.
    #[error("cannot read the trajectory {}", path.display())]
    Read {
        /// Path of the source.
        path: PathBuf,
        /// The error of the trajectory reader.
        source: ReadError,
    },
    /// The source ends before the first requested frame.
    #[error("frame {first} of {} does not exist: it has {count} complete frames, counted from 0", path.display())]
    NoSuchFrame {
        /// Path of the source.
        path: PathBuf,
        /// Index of the requested frame.
        first: u64,
        /// Number of complete frames in the source.
        count: u64,
    },
    /// The target exists.
    #[error("{} exists", .0.display())]
    Exists(PathBuf),
    /// The target, or its temporary path, holds something other than a conversion to this format.
    #[error("{} exists and is not a conversion to this format", .0.display())]
    Foreign(PathBuf),
    /// The name of the target requests a compression that the format does not support.
    #[error("{} has the extension of a compressed file, but only extended XYZ can be compressed", .0.display())]
    Compressed(PathBuf),
    /// The target is the source, or writing the target would overwrite the source.
    #[error("{} is the trajectory that would be converted", .0.display())]
    Source(PathBuf),
    /// The target format cannot represent a frame of the source.
    #[error("frame {index} of {} cannot be converted", path.display())]
    Frame {
        /// Path of the source.
        path: PathBuf,
        /// Index of the frame, from 0.
        index: u64,
        /// Reason why the frame cannot be written.
        source: FrameError,
    },
    /// The format of a [`FrameSeries`](super::FrameSeries) cannot represent a frame.
    #[error("frame {index} cannot be written to {}", path.display())]
    Unwritable {
        /// Path of the target.
        path: PathBuf,
        /// Index of the frame, from 0.
        index: u64,
        /// Reason why the frame cannot be written.
        source: FrameError,
    },
    /// The conversion was interrupted.
    #[error("interrupted; the incomplete conversion was removed")]
    Interrupted,
    /// The file of a surface beside the trajectory cannot be read.
    #[error("cannot read the surface {}: {problem}", path.display())]
    Surface {
        /// Path of the surface file.
        path: PathBuf,
        /// Description of the problem.
        problem: String,
    },
    /// The target cannot be written, for example without permission or space.
    #[error("cannot write {}", path.display())]
    Write {
        /// Path of the target.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
}

impl ConvertError {
    pub(super) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Write { path, source }
    }

    /// Returns a suggestion for the user.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        match self {
            Self::Exists(_) => Some("choose another name with --out, or replace it with --force"),
            Self::Foreign(_) => Some("remove it, or choose another name with --out"),
            Self::Surface { .. } => Some("repair the file, or move it out of the folder `surfaces`"),
            Self::Source(_) => Some("choose another name with --out"),
            Self::Compressed(_) => Some("leave .gz or .zst out, or convert to xyz"),
            Self::Write { source, .. } => Some(cure_of(source)),
            _ => None,
        }
    }
}

/// Reason why a frame cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The operating system could not write the frame.
    #[error("cannot write it")]
    Io(#[from] io::Error),
    /// Extended XYZ cannot represent this frame.
    #[error(transparent)]
    ExtendedXyz(#[from] WriteError),
    /// Two particles of the frame have the same id.
    #[error("two particles have the id {}, and bonds refer to ids", .0.0)]
    RepeatedId(ParticleId),
    /// A bond refers to a particle that does not exist.
    #[error("a bond ends at particle {}, which does not exist", .0.0)]
    NoBondEnd(ParticleId),
    /// A number is too large for single precision.
    #[error("{0} is beyond the largest number of the format, which keeps numbers in single precision")]
    BeyondSingle(f64),
    /// The frame has too many particles, bonds or species for a 32-bit count.
    #[error("{0} particles, bonds or species are more than the format can hold")]
    TooMany(usize),
    /// A particle has travelled more periods than 32 bits can count.
    #[error("a particle has travelled {0} periods along x, more than the format can count")]
    BeyondPeriods(f64),
    /// The file has more array names than 16 bits can count.
    #[error("the array `{0}` cannot be written: the format can hold only 65536 names of arrays")]
    TooManyNames(String),
    /// A frame differs from the first frame. NumPy arrays need the same particles, axes and columns in all frames.
    #[error(
        "its {0} are not the same as in the first converted frame: arrays need the same particles, in the same order, in all frames"
    )]
    OtherParticles(&'static str),
}

impl FrameError {
    /// Adds a path to the error: the target if it cannot be written or if there is no source, otherwise the source.
    pub(super) fn at(self, source: Option<&Path>, index: u64, target: &Path) -> ConvertError {
        let path = target.to_owned();
        match (self, source) {
            (Self::Io(source) | Self::ExtendedXyz(WriteError::Io(source)), _) => ConvertError::Write { path, source },
            (error, Some(path)) => ConvertError::Frame { path: path.to_owned(), index, source: error },
            (source, None) => ConvertError::Unwritable { path, index, source },
        }
    }
}
