use std::io;
use std::path::PathBuf;

use thiserror::Error;

use crate::base::text::shorten;
use crate::model::ParticleId;

/// Number of characters of a malformed text in a message.
pub(super) const LONGEST: usize = 60;

/// Error of reading extended XYZ. Lines count from 1.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ReadError {
    /// The file cannot be opened.
    #[error("cannot open {}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is compressed, but its frames must be accessed individually.
    #[error("{} is compressed, so that its frames cannot be reached one by one: unpack it first, with `carom convert --to xyz --out plain.xyz`", .0.display())]
    Compressed(PathBuf),
    /// The operating system reported an error while the file was read.
    #[error("line {line}: cannot read further")]
    Io {
        /// The line.
        line: usize,
        /// The cause.
        source: io::Error,
    },
    /// The file is empty or blank.
    #[error("the file holds no frame")]
    NoFrame,
    /// The file is not text.
    #[error("line {line} is not text (UTF-8)")]
    NotText {
        /// The line.
        line: usize,
    },
    /// A line is too long to be part of a trajectory.
    #[error("line {line} is too long to be part of a trajectory")]
    LineTooLong {
        /// The line.
        line: usize,
    },
    /// The file ends within a frame.
    #[error(
        "the frame that begins on line {line} is cut off: expected {expected} particles, the file ends after {found}"
    )]
    Truncated {
        /// Number of the first line of the frame.
        line: usize,
        /// Number of particles according to the first line of the frame.
        expected: usize,
        /// Number of complete particles in the frame.
        found: usize,
    },
    /// A line lacks the expected text.
    #[error("line {line}: {problem}")]
    Malformed {
        /// The line.
        line: usize,
        /// Expected text, and a shortened copy of the text found.
        problem: String,
    },
}

impl ReadError {
    pub(super) fn unexpected(line: usize, name: &str, value: &str, expected: &str) -> Self {
        Self::Malformed { line, problem: format!("{name} is `{}`, expected {expected}", shorten(value, LONGEST)) }
    }

    /// The line with the error, if there is one.
    #[must_use]
    pub fn line(&self) -> Option<usize> {
        match *self {
            Self::Open { .. } | Self::Compressed(_) | Self::NoFrame => None,
            Self::Io { line, .. }
            | Self::NotText { line }
            | Self::LineTooLong { line }
            | Self::Malformed { line, .. }
            | Self::Truncated { line, .. } => Some(line),
        }
    }

    /// Error message without the line number.
    #[must_use]
    pub fn problem(&self) -> String {
        let message = self.to_string();
        let place = self.line().map(|line| format!("line {line}"));
        let rest = place.and_then(|place| message.strip_prefix(&place)).map(|rest| rest.trim_start_matches([':', ' ']));
        rest.map_or_else(|| message.clone(), str::to_owned)
    }
}

/// Error of writing extended XYZ.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The operating system could not write to the output.
    #[error("cannot write the frame")]
    Io(#[from] io::Error),
    /// The name of a species cannot be stored in a column.
    #[error("species name `{0}` cannot be written: expected one word without quotes or backslashes, used once")]
    SpeciesName(String),
    /// The name or the values of a scalar cannot be stored in a column.
    #[error(
        "scalar `{0}` cannot be written: expected a name of one word that no other column has, and a finite number for each particle"
    )]
    Scalar(String),
    /// Some bonds have no interaction, or the name of an interaction is not one word.
    #[error(
        "the bonds cannot be written: expected an interaction for all bonds or for none, and names of one word without quotes or backslashes"
    )]
    Bonds,
    /// The name of a unit is not a word of up to 16 letters.
    #[error("the units cannot be written: expected names of up to 16 letters")]
    Units,
    /// Some particles have no image numbers.
    #[error("the image numbers cannot be written: expected image numbers for all particles or for none")]
    Images,
    /// A mass is zero, negative or NaN.
    #[error("the mass of species `{0}` cannot be written: expected a positive mass, or infinity for a static species")]
    Mass(String),
    /// A particle refers to a species that is not in the table.
    #[error("particle {} has a species that is not in the frame's table", .0.0)]
    NoSpecies(ParticleId),
    /// A position, velocity or radius is NaN or infinite, or the radius is negative.
    #[error("particle {} has a position, velocity or radius that is not finite, or a negative radius", .0.0)]
    Particle(ParticleId),
    /// The time or the box is not finite, an edge of the box is negative, or the displacement of the periodic images is
    /// invalid. A displacement requires periodic x and y axes, and is at most half a period.
    #[error("the frame's time or box is not finite, or the box is displaced by more than half of its edge")]
    Frame,
}
