use crate::analysis::instruments::InstrumentError;
use std::io;
use std::path::{Path, PathBuf};

use thiserror::Error;

use super::convert::ConvertError;
use crate::base::text::size;
use crate::run::checkpoint::CheckpointError;
use crate::trajectory::extended_xyz::WriteError;

/// Errors of writing a run or another output.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The folder holds something other than a run.
    #[error("{} exists and holds something that is not a run of carom", .0.display())]
    Occupied(PathBuf),
    /// The output would overwrite an input file.
    #[error("{} would overwrite {}, which is read", target.display(), input.display())]
    Input {
        /// Path of the output.
        target: PathBuf,
        /// Path of the input.
        input: PathBuf,
    },
    /// A file exists at the path of the folder.
    #[error("{} is not a folder", .0.display())]
    NotFolder(PathBuf),
    /// The folder cannot be read or created.
    #[error("cannot make the folder {}", path.display())]
    Folder {
        /// Path of the folder.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
    /// A file cannot be written, for example without permission or space.
    #[error("cannot write {}", path.display())]
    Write {
        /// Path of the file.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
    /// A frame of a trajectory cannot be written.
    #[error("cannot write a frame to {}", path.display())]
    Frame {
        /// Path of the trajectory.
        path: PathBuf,
        /// Reason why the frame cannot be written.
        source: WriteError,
    },
    /// Another run writes to this folder.
    #[error("another run writes to {}", .0.display())]
    Busy(PathBuf),
    /// The files of a run exceed the permitted size.
    #[error("the files in {} take {}, more than the {} that a run may write without --force", path.display(), size(*bytes), size(*most))]
    TooMuch {
        /// Path of the folder.
        path: PathBuf,
        /// Total size of the files `[bytes]`.
        bytes: f64,
        /// Largest allowed size `[bytes]`.
        most: f64,
    },
    /// The folder holds a run that has ended.
    #[error("{} holds a run already", .0.display())]
    Finished(PathBuf),
    /// A file with the name of an output file was not written by Carom.
    #[error("{} exists and was not written by carom", .0.display())]
    Foreign(PathBuf),
    /// A link, a folder or a device has the name of an output file. Carom does not write through links.
    #[error("{} is {found}, expected {expected} of carom", path.display())]
    NotPlain {
        /// The path.
        path: PathBuf,
        /// What exists at the path, in words.
        found: &'static str,
        /// What was expected at the path, in words.
        expected: &'static str,
    },
    /// The folder holds an unfinished run that can be resumed.
    #[error("{} holds an unfinished run", .0.display())]
    Unfinished(PathBuf),
    /// The folder holds a run and its replacement. The replacement is unfinished or unsound.
    #[error("{} holds a run and its unfinished replacement", .0.display())]
    Replacing(PathBuf),
    /// The new run needs this path to replace an existing run, but something else exists there.
    #[error("{} is needed for the new run, but something else exists there", .0.display())]
    NotReplacement(PathBuf),
    /// The output folder is inside the folder of a run.
    #[error("{} is within {}, the folder of a run", target.display(), run.display())]
    WithinRun {
        /// The output folder.
        target: PathBuf,
        /// The folder of the run.
        run: PathBuf,
    },
    /// The trajectory cannot be converted to a format that the scene requests.
    #[error(transparent)]
    Convert(#[from] ConvertError),
    /// A checkpoint cannot be used, so the run cannot be resumed.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// The custom instruments differ from the instruments with which the run began.
    #[error(transparent)]
    Instrument(#[from] InstrumentError),
}

impl OutputError {
    /// Returns a suggestion for the user.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        Some(match self {
            Self::Occupied(_) => "remove the folder, or choose another one with --out",
            Self::Unfinished(_) => {
                "continue it with `carom run --resume DIR`; or choose another folder with --out, or replace it with --force"
            }
            Self::Finished(_) => {
                "choose another folder with --out, or replace it with --force; `carom run --resume DIR --until-time T` makes it longer"
            }
            Self::TooMuch { .. } => "to allow this size, continue with `carom run --force --resume DIR`",
            Self::Replacing(_) => {
                "continue the new one with `carom run --resume DIR`; or choose another folder with --out, or begin again with --force"
            }
            Self::WithinRun { .. } => "choose another folder with --out",
            Self::Foreign(_) | Self::NotReplacement(_) => "move it away, or choose another folder with --out",
            Self::NotPlain { .. } => {
                "restore the file, move the link away, or choose another folder with --out: carom never writes through a link in its own folders"
            }
            Self::Busy(_) => "wait for the other run, or choose another folder with --out",
            Self::Checkpoint(error) => error.cure(),
            Self::Instrument(_) => "continue with the program that started the run and defines its instruments",
            Self::Convert(error) => return error.cure(),
            Self::Input { .. } => "choose another path with --out",
            Self::NotFolder(_) => "choose another folder with --out",
            Self::Folder { source, .. }
            | Self::Write { source, .. }
            | Self::Frame { source: WriteError::Io(source), .. } => cure_of(source),
            _ => "choose a folder with --out that can be written to, on a disk with space left",
        })
    }

    pub(crate) fn write(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_owned();
        move |source| Self::Write { path, source }
    }
}

pub(crate) fn cure_of(error: &io::Error) -> &'static str {
    use io::ErrorKind::{FileTooLarge, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    /// Unix error numbers for too many open files, in the system or in a process.
    const TOO_MANY_OPEN: [i32; 2] = [23, 24];
    match error.kind() {
        StorageFull | QuotaExceeded | FileTooLarge => {
            "free some space; work with a checkpoint can then continue, bit for bit: a run with `carom run --resume \
             DIR`, a sweep or an exchange with the same command"
        }
        ReadOnlyFilesystem => {
            "choose a folder with --out that can be written to; to resume a run, copy its folder to such a place"
        }
        _ if cfg!(unix) && error.raw_os_error().is_some_and(|number| TOO_MANY_OPEN.contains(&number)) => {
            "allow more open files (`ulimit -n 1024`), or run fewer simulations at once"
        }
        _ => "choose a folder with --out that can be written to, on a disk with space left",
    }
}
