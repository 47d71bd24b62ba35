//! Errors of replica exchange.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::engine::{EngineError, SetStateError};
use crate::io::OutputError;
use crate::run::checkpoint::CheckpointError;

/// Why a scene gives no exchange.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum StartError {
    /// The scene has no plan for it.
    #[error("the scene has no [exchange]")]
    NoPlan,
    /// A velocity of one of its temperatures is none that a particle can have.
    #[error(transparent)]
    Velocities(#[from] SetStateError),
}

/// Why an exchange did not come to its end: `E` is the error of its [`ExchangeRecorder`](super::ExchangeRecorder).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExchangeError<E> {
    /// Something could not be kept.
    #[error(transparent)]
    Recorder(E),
    /// A multicanonical exchange found no weights.
    #[error(
        "no multicanonical weights: in the equilibration, the energies at some temperatures did not overlap with those at the others"
    )]
    NoOverlap,
    /// A replica could not go on.
    #[error("replica {}, at temperature {temperature}: {source}", replica + 1)]
    Engine {
        /// Its number, from 0.
        replica: usize,
        /// Its temperature then `[energy]`.
        temperature: f64,
        /// Why.
        source: EngineError,
    },
}

impl<E> ExchangeError<E> {
    /// Cure of [`Self::NoOverlap`]: what the user can do.
    pub const NO_OVERLAP_CURE: &str = "add temperatures between them, or give a longer equilibration_time";
}

/// Error of the folder of an exchange.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ExchangeFolderError {
    /// The folder holds something else.
    #[error("{} exists and holds something that is not a replica exchange", .0.display())]
    Occupied(PathBuf),
    /// The folder holds the exchange of another scene.
    #[error("{} holds the exchange of another scene: its scene.toml is not what this one would be", .0.display())]
    Other(PathBuf),
    /// The exchange in the folder has come further than it is asked to.
    #[error("{} holds an exchange that has measured a time of {measured} already, expected a later end than {asked}", path.display())]
    Passed {
        /// The folder.
        path: PathBuf,
        /// How far its measurement has come `[time]`.
        measured: f64,
        /// Time that was asked for `[time]`.
        asked: f64,
    },
    /// A file in it is none that can be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A table is not the one that belongs to the results.
    #[error("{} is not the table that the exchange wrote: its checksum is {found}, expected {expected} of summary.json", path.display())]
    Table {
        /// The file.
        path: PathBuf,
        /// The checksum of what it holds.
        found: String,
        /// That of what was written.
        expected: String,
    },
    /// The scene gives no exchange.
    #[error(transparent)]
    Start(#[from] StartError),
    /// A file or the folder cannot be used.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl ExchangeFolderError {
    /// Cure: what the user can do.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        Some(match self {
            Self::Occupied(_) => "choose another folder with --out",
            Self::Other(_) => "go on with it, `carom exchange DIR`, or choose another folder with --out",
            Self::Passed { .. } => "ask for a later end with --until-time, or choose another folder with --out",
            Self::Start(StartError::NoPlan) => {
                "add [exchange] with temperatures, interval and rate; `carom run` runs a scene without it"
            }
            Self::Start(_) => "choose lower temperatures, or larger masses",
            Self::Read { .. } => "make it readable, or choose another folder with --out",
            Self::Output(OutputError::Busy(_)) => "wait for it, or choose another folder with --out",
            Self::Table { .. } => {
                "bring it back; or remove summary.json: `carom exchange DIR` then makes the tables again from exchange.checkpoint"
            }
            Self::Output(OutputError::Checkpoint(error)) => cure_of(error),
            Self::Output(error) => return error.cure(),
        })
    }
}

/// Cure where an exchange cannot go on from its checkpoint, of which there is one only.
fn cure_of(error: &CheckpointError) -> &'static str {
    match error {
        CheckpointError::Missing(_) => {
            "bring exchange.checkpoint back; or begin again, in another folder with --out or here without summary.json"
        }
        CheckpointError::Unreadable { .. } => "make the file readable",
        CheckpointError::Input { .. } => "bring the file back, or remove it: the checkpoint does not need it",
        CheckpointError::OtherVersion { .. } => {
            "go on with the version that wrote it; or begin again, in another folder with --out or here without exchange.checkpoint and summary.json"
        }
        _ => {
            "bring back what was there; or begin again, in another folder with --out or here without exchange.checkpoint and summary.json"
        }
    }
}
