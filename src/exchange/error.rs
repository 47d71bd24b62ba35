//! Errors of replica exchange.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::base::text::digits;
use crate::engine::{EngineError, SetStateError};
use crate::io::OutputError;
use crate::run::checkpoint::CheckpointError;

use super::multicanonical::Torn;

/// Why the equilibration of an exchange has failed to prepare the measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Unprepared {
    /// The weights do not follow from the energies.
    Torn,
    /// A replica is not in its window.
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

/// Why no exchange can be made from a scene.
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

/// Why an exchange ended early. `E` is the error of its [`ExchangeRecorder`](super::ExchangeRecorder).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExchangeError<E> {
    /// Something could not be recorded.
    #[error(transparent)]
    Recorder(E),
    /// A multicanonical exchange found no weights.
    #[error(
        "no multicanonical weights: in the equilibration, the energies at some temperatures did not overlap with those at the others"
    )]
    NoOverlap,
    /// After half of the equilibration, a replica has not reached its window.
    #[error(
        "window {}, from {} to {}: the distance has only reached {} in half of the equilibration",
        window + 1,
        digits(ends[0]),
        digits(ends[1]),
        digits(*distance)
    )]
    OutsideOfWindow {
        /// Its number, from 0.
        window: usize,
        /// Its ends `[length]`.
        ends: [f64; 2],
        /// The distance that was reached `[length]`.
        distance: f64,
    },
    /// A replica could not continue.
    #[error("replica {}, at temperature {temperature}: {source}", replica + 1)]
    Engine {
        /// Its number, from 0.
        replica: usize,
        /// Its temperature at that time `[energy]`.
        temperature: f64,
        /// Why.
        source: EngineError,
    },
}

impl<E> ExchangeError<E> {
    /// Cure of [`Self::NoOverlap`]: advice to the user.
    pub const NO_OVERLAP_CURE: &str = "add temperatures between them, or give a longer equilibration_time";
    /// Cure of [`Self::OutsideOfWindow`]: advice to the user.
    pub const OUTSIDE_OF_WINDOW_CURE: &str = "give a longer equilibration_time or a shorter interval, windows that the particles can reach, or a start closer to them";
}

/// Error of the folder of an exchange.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExchangeFolderError {
    /// The folder holds something else.
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
        /// Simulated time that has been measured `[time]`.
        measured: f64,
        /// The requested time `[time]`.
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
        /// Why.
        source: io::Error,
    },
    /// A table does not belong to the results.
    #[error("{} is not the table that the exchange wrote: its checksum is {found}, expected {expected} of summary.json", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// The checksum of its content.
        found: String,
        /// The checksum of the content that was written.
        expected: String,
    },
    /// No exchange can be made from the scene.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A file or the folder cannot be used.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl ExchangeFolderError {
    /// Cure: advice to the user.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        Some(match self {
            Self::Occupied(_) => "choose another folder with --out",
            Self::Other(_) => {
                "continue it with `carom exchange DIR`, or choose another folder with --out; remove the folder if nothing of it is needed"
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

/// Cure if an exchange cannot continue from its only checkpoint.
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
