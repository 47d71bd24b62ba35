use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::base::text::digits;
use crate::engine::{EngineError, SetStateError};
use crate::io::OutputError;
use crate::run::checkpoint::CheckpointError;

use super::multicanonical::Torn;

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unprepared {
    Torn,
    Outside { window: usize, ends: [f64; 2], distance: f64 },
}

impl From<Torn> for Unprepared {
    fn from(_: Torn) -> Self {
        Self::Torn
    }
}

impl<E> From<Unprepared> for ExchangeError<E> {
    fn from(why: Unprepared) -> Self {
        match why {
            Unprepared::Torn => Self::NoOverlap,
            Unprepared::Outside { window, ends, distance } => Self::OutsideOfWindow { window, ends, distance },
        }
    }
}

/// Reasons why a scene cannot be used for an exchange.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum StartError {
    /// The scene has no plan for an exchange.
    #[error("the scene has no [exchange]")]
    NoPlan,
    /// A velocity drawn at one of the temperatures is too large.
    #[error(transparent)]
    Velocities(#[from] SetStateError),
}

/// Reasons why an exchange ended early. `E` is the error of its [`ExchangeRecorder`](super::ExchangeRecorder).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExchangeError<E> {
    /// The recorder could not record a row, a frame or a checkpoint.
    #[error(transparent)]
    Recorder(E),
    /// The energies of a multicanonical exchange do not overlap sufficiently to determine weights.
    #[error(
        "no multicanonical weights could be determined: in the equilibration, the energies at some temperatures did not overlap with those at the others"
    )]
    NoOverlap,
    /// A replica has not reached its window after half of the equilibration.
    #[error(
        "window {}, from {} to {}, was not reached: after half of the equilibration, the distance is still {}",
        window + 1,
        digits(ends[0]),
        digits(ends[1]),
        digits(*distance)
    )]
    OutsideOfWindow {
        /// Index of the window, from 0.
        window: usize,
        /// Lower and upper end of the window `[length]`.
        ends: [f64; 2],
        /// The distance that the replica has reached `[length]`.
        distance: f64,
    },
    /// A replica could not continue.
    #[error("replica {}, at temperature {temperature}: {source}", replica + 1)]
    Engine {
        /// Index of the replica, from 0.
        replica: usize,
        /// Temperature of the replica when it stopped `[energy]`.
        temperature: f64,
        /// The error of the engine.
        source: EngineError,
    },
}

impl<E> ExchangeError<E> {
    /// Advice to the user for [`Self::NoOverlap`].
    pub const NO_OVERLAP_CURE: &str = "add temperatures between them, or give a longer equilibration_time";
    /// Advice to the user for [`Self::OutsideOfWindow`].
    pub const OUTSIDE_OF_WINDOW_CURE: &str = "give a longer equilibration_time, a shorter interval, windows that the particles can reach, or a start closer to the windows";
}

/// Errors of the folder of an exchange.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExchangeFolderError {
    /// The folder holds something other than a replica exchange.
    #[error("{} exists and holds something that is not a replica exchange", .0.display())]
    Occupied(PathBuf),
    /// The folder holds an exchange of another scene.
    #[error("{} holds the exchange of another scene: its scene.toml differs", .0.display())]
    Other(PathBuf),
    /// The exchange in the folder is already beyond the requested end.
    #[error("{} holds an exchange that has measured a time of {measured} already, expected a later end than {asked}", path.display())]
    Passed {
        /// The folder.
        path: PathBuf,
        /// Simulated time of the averages so far `[time]`.
        measured: f64,
        /// The requested simulated time of the averages `[time]`.
        asked: f64,
    },
    /// The exchange in the folder has no results yet.
    #[error("{} holds an unfinished replica exchange", .0.display())]
    Incomplete(PathBuf),
    /// A file in the folder cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The underlying error.
        source: io::Error,
    },
    /// A table has a different checksum than in the results.
    #[error("{} is not the table that the exchange wrote: its checksum is {found}, expected {expected} of summary.json", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// The checksum of the current content.
        found: String,
        /// The checksum of the content that the exchange wrote.
        expected: String,
    },
    /// The scene cannot be used for an exchange.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The folder or a file in the folder cannot be used.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl ExchangeFolderError {
    /// Returns a suggestion for the user.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        Some(match self {
            Self::Occupied(_) => "choose another folder with --out",
            Self::Other(_) => {
                "continue it with `carom exchange DIR`, or choose another folder with --out; remove the folder if you \
                 do not need it"
            }
            Self::Incomplete(_) => "continue it with `carom exchange DIR`",
            Self::Passed { .. } => "ask for a later end with --until-time, or choose another folder with --out",
            Self::Start(StartError::NoPlan) => {
                "add [exchange] with temperatures, interval and rate; `carom run` runs a scene without it"
            }
            Self::Start(_) => "choose lower temperatures, or larger masses",
            Self::Read { .. } => "make it readable, or choose another folder with --out",
            Self::Output(OutputError::Busy(_)) => "wait for it, or choose another folder with --out",
            Self::Table { .. } => {
                "restore it; or remove summary.json: `carom exchange DIR` then makes the tables again from exchange.checkpoint"
            }
            Self::Output(OutputError::Checkpoint(error)) => cure_of(error),
            Self::Output(error) => return error.cure(),
        })
    }
}

/// Suggestion for a checkpoint that cannot be used. There is no older checkpoint.
fn cure_of(error: &CheckpointError) -> &'static str {
    match error {
        CheckpointError::Missing(_) => {
            "restore exchange.checkpoint; or begin again, in another folder with --out or here without summary.json"
        }
        CheckpointError::Unreadable { .. } => "make the file readable",
        CheckpointError::Input { .. } => "restore the file, or remove it: the checkpoint does not need it",
        CheckpointError::OtherVersion { .. } => {
            "continue with the version that wrote it; or begin again, in another folder with --out or here without exchange.checkpoint and summary.json"
        }
        _ => {
            "restore the files; or begin again, in another folder with --out or here without exchange.checkpoint and summary.json"
        }
    }
}
