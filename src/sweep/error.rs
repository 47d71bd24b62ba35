//! Errors of sweeps.

use std::io;
use std::path::PathBuf;

use thiserror::Error;

use super::axis::{AxisError, MOST};
use crate::io::OutputError;
use crate::scene::SceneError;

/// Error of a sweep as a whole. A failure of a single run is [`Fate::Failed`](super::Fate::Failed).
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SweepError {
    /// An axis is invalid.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// Nothing varies.
    #[error("nothing varies in this sweep")]
    NoAxis,
    /// A key is varied or set more than once.
    #[error("`{0}` is varied or set more than once")]
    Twice(String),
    /// A value appears twice in an axis.
    #[error("`{key}` has the value {value} twice")]
    SameValue {
        /// The varied key.
        key: String,
        /// The repeated value.
        value: String,
    },
    /// Two keys set the same value, or the second key replaces a table or list that contains the first key.
    #[error("`{first}` and `{second}` set the same value of the scene: `{first}` would have no effect")]
    SamePlace {
        /// The earlier key, which would have no effect.
        first: String,
        /// The later key.
        second: String,
    },
    /// Runs with different seeds would be identical.
    #[error("the seed changes nothing here: {first} and {second} would be the same run twice")]
    SameRuns {
        /// Folder of the first point.
        first: String,
        /// Folder of the second point.
        second: String,
    },
    /// The axes have too many combinations of values.
    #[error("the axes have {0} combinations, more than {MOST}")]
    TooMany(usize),
    /// A scene is invalid or cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// The underlying system error.
        source: io::Error,
    },
    /// The file that describes a sweep is invalid.
    #[error("{} is not the file of a sweep", path.display())]
    File {
        /// Path of the file.
        path: PathBuf,
        /// The underlying parse error.
        source: Box<toml::de::Error>,
    },
    /// The scene of a sweep has changed since the sweep began.
    #[error("{} is not the scene of the sweep in {}", scene.display(), folder.display())]
    Changed {
        /// Path of the scene.
        scene: PathBuf,
        /// Path of the sweep's folder, or of its file.
        folder: PathBuf,
    },
    /// An input file of the runs has changed since the sweep began.
    #[error(
        "{path} has changed since the sweep in {} began: its checksum is {found}, expected {expected}",
        folder.display()
    )]
    Input {
        /// Path of the file or checkpoint.
        path: String,
        /// Current checksum of the file.
        found: String,
        /// Checksum of the file when the sweep began.
        expected: String,
        /// Path of the sweep's folder.
        folder: PathBuf,
    },
    /// The folder holds another sweep.
    #[error("{} holds another sweep: {why}", folder.display())]
    Other {
        /// Path of the folder.
        folder: PathBuf,
        /// Difference between the two sweeps.
        why: String,
    },
    /// The folder is not empty, and contains no sweep.
    #[error("{} exists and holds something that is not a sweep", .0.display())]
    Occupied(PathBuf),
    /// A file or a folder cannot be used.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl SweepError {
    /// Returns a suggestion for the user, if there is one.
    #[must_use]
    pub fn cure(&self) -> Option<&'static str> {
        Some(match self {
            Self::NoAxis => "give an axis, such as --vary seed=1..3",
            Self::Twice(_) => "give each key once; keys that change together are separated by `;`",
            Self::SameValue { .. } => "give each value once; for repeated runs, vary the seed",
            Self::SamePlace { .. } => "give one of them; keys that change together are separated by `;`",
            Self::SameRuns { .. } => {
                "leave the seeds out; repetitions need a random start, a heat bath, or a different run in start.from for each"
            }
            Self::Input { .. } => "restore the file, or begin another sweep with --out",
            Self::File { .. } => {
                "it has the keys scene = \"fluid.toml\", vary = [\"fill.0.packing_fraction=0.1..0.4/4\", \"seed=1..3\"] and, if \
                 wanted, set = [\"run.until_events=100000\"]"
            }
            Self::Changed { .. } => "restore the scene, or begin another sweep with --out",
            Self::Other { .. } | Self::Occupied(_) => "choose another folder with --out",
            Self::Output(error) => return error.cure(),
            Self::Axis(_) | Self::TooMany(_) | Self::Scene(_) | Self::Read { .. } => return None,
        })
    }
}
