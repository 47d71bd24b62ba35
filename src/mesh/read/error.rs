//! Errors of mesh files.

use std::fmt;

use thiserror::Error;

use super::polygon::PolygonProblem;
use crate::model::triangle_mesh::{LARGEST_COORDINATE, MOST_TRIANGLES};

/// Error of reading a mesh: the file and its fault.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name}: {problem}")]
pub struct MeshFileError {
    /// The file, as named by the caller.
    pub name: String,
    /// The error in the file.
    pub problem: MeshFileProblem,
}

/// Position in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Line of a text, from 1.
    Line(usize),
    /// Triangle of a binary file, from 0.
    Triangle(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Line(line) => write!(f, "line {line}"),
            Self::Triangle(number) => write!(f, "triangle {number} (from 0)"),
        }
    }
}

/// An error in a mesh file.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshFileProblem {
    /// The extension belongs to no supported format.
    #[error(
        "`{extension}` is no format of meshes that is read: expected `stl` or `obj`; export the mesh as one of them"
    )]
    UnknownFormat {
        /// The extension.
        extension: String,
    },
    /// No bytes, or only blanks.
    #[error("the file is empty: expected a mesh; export it again")]
    Empty,
    /// Text with two bytes per character.
    #[error("the file is text in UTF-16: expected UTF-8 or ASCII; save it in that encoding")]
    Utf16,
    /// A complete file without triangles.
    #[error("the file has no triangle: expected at least one {expected}; export a surface, not points or lines")]
    NoTriangle {
        /// The part of the format that holds a triangle.
        expected: &'static str,
    },
    /// The file is not text STL, and too short for binary STL.
    #[error(
        "the file is no STL: expected text that begins with `solid`, or 84 bytes and 50 for each triangle, found {found} other bytes; export it again"
    )]
    NoStl {
        /// Length of the file `[bytes]`.
        found: usize,
    },
    /// The number of triangles in the header of a binary STL file does not fit the length of the file.
    #[error(
        "the header announces {triangles} triangles: expected {expected} bytes, found {found}, enough for {}; the file is damaged or cut off, copy or export it again",
        found.saturating_sub(84) / 50
    )]
    Length {
        /// Number of triangles in the header.
        triangles: u32,
        /// Length for that number `[bytes]`.
        expected: u64,
        /// Length of the file `[bytes]`.
        found: u64,
    },
    /// More triangles than a mesh can have.
    #[error("{place}: expected {MOST_TRIANGLES} triangles at most; export a coarser mesh")]
    TooManyTriangles {
        /// The first triangle above the limit.
        place: Place,
    },
    /// A coordinate that is NaN, infinite or too large.
    #[error(
        "{place}: coordinate is `{found}`, expected a finite number of magnitude {LARGEST_COORDINATE:e} at most; repair the mesh, or export it again"
    )]
    Coordinate {
        /// The position.
        place: Place,
        /// The coordinate.
        found: String,
    },
    /// An unexpected word.
    #[error("line {line}: found `{found}`, expected {expected}; export the mesh again, or correct the line")]
    Unexpected {
        /// The line, from 1.
        line: usize,
        /// The word, shortened.
        found: String,
        /// The expected words.
        expected: &'static str,
    },
    /// The text ends too early.
    #[error("line {line}: the file ends, expected {expected}; it is cut off, copy or export it again")]
    Truncated {
        /// The last line, from 1.
        line: usize,
        /// The expected words.
        expected: &'static str,
    },
    /// A face has fewer corners than a triangle.
    #[error("line {line}: the face has {found} corners, expected 3 or more; export lines as `l`, or correct the line")]
    Corners {
        /// The line, from 1.
        line: usize,
        /// The number of corners.
        found: usize,
    },
    /// A face of more than three corners cannot be cut into triangles.
    #[error("line {line}: the face of {corners} corners {problem}; export the mesh in triangles, or repair the face")]
    Polygon {
        /// The line, from 1.
        line: usize,
        /// The number of corners.
        corners: usize,
        /// The problem.
        problem: PolygonProblem,
    },
    /// A face refers to a vertex that is not in the file.
    #[error(
        "line {line}: the face refers to vertex {found}, expected 1 to {vertices}, or -{vertices} to -1; the file is damaged or cut off, export it again"
    )]
    Index {
        /// The line, from 1.
        line: usize,
        /// The number of the vertex.
        found: i64,
        /// Number of vertices to which a face can refer here.
        vertices: usize,
    },
}

impl MeshFileError {
    /// The position of the error, if it has one.
    #[must_use]
    pub fn place(&self) -> Option<Place> {
        match self.problem {
            MeshFileProblem::TooManyTriangles { place } | MeshFileProblem::Coordinate { place, .. } => Some(place),
            MeshFileProblem::Unexpected { line, .. }
            | MeshFileProblem::Truncated { line, .. }
            | MeshFileProblem::Corners { line, .. }
            | MeshFileProblem::Polygon { line, .. }
            | MeshFileProblem::Index { line, .. } => Some(Place::Line(line)),
            _ => None,
        }
    }
}

/// The beginning of a word, for an error message. A malformed word may be long, or not text.
pub(super) fn shorten(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(word.get(..4 * LONGEST).unwrap_or(word));
    let shown = |c: char| if c.is_control() { char::REPLACEMENT_CHARACTER } else { c };
    let mut short: String = text.chars().take(LONGEST).map(shown).collect();
    if text.chars().nth(LONGEST).is_some() {
        short.push_str("...");
    }
    short
}
