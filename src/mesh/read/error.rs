use std::fmt;

use thiserror::Error;

use super::polygon::PolygonProblem;
use crate::base::text;
use crate::model::triangle_mesh::{LARGEST_COORDINATE, MOST_TRIANGLES};

/// Error of reading a mesh file.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{name}: {problem}")]
pub struct MeshFileError {
    /// Name of the file, as given by the caller.
    pub name: String,
    /// The problem with the file.
    pub problem: MeshFileProblem,
}

/// Position of an error in a mesh file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// Number of a line in a text file, from 1.
    Line(usize),
    /// Index of a triangle in a binary file, from 0.
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

/// Problem with a mesh file.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MeshFileProblem {
    /// No supported format has this extension.
    #[error("`{extension}` is not a supported mesh format: expected `stl` or `obj`; export the mesh as one of them")]
    UnknownFormat {
        /// The extension.
        extension: String,
    },
    /// The file is empty or blank.
    #[error("the file is empty: expected a mesh; export it again")]
    Empty,
    /// The file is text in UTF-16.
    #[error("the file is text in UTF-16: expected UTF-8 or ASCII; save it in that encoding")]
    Utf16,
    /// The file is complete but has no triangle.
    #[error("the file has no triangle: expected at least one {expected}; export a surface, not points or lines")]
    NoTriangle {
        /// Name of a triangle in this format, such as `facet`.
        expected: &'static str,
    },
    /// The file is neither text STL nor binary STL.
    #[error(
        "the file is not STL: expected text that begins with `solid`, or 84 bytes and 50 for each triangle, found {found} other bytes; export it again"
    )]
    NoStl {
        /// Length of the file `[bytes]`.
        found: usize,
    },
    /// The length of a binary STL file contradicts the number of triangles in the header.
    #[error(
        "the header announces {triangles} triangles: expected {expected} bytes, found {found}, enough for {}; the file is damaged or cut off, copy or export it again",
        found.saturating_sub(84) / 50
    )]
    Length {
        /// Number of triangles according to the header.
        triangles: u32,
        /// Length of a file with this number of triangles `[bytes]`.
        expected: u64,
        /// Length of the file `[bytes]`.
        found: u64,
    },
    /// The file has more triangles than a mesh can have.
    #[error("{place}: expected {MOST_TRIANGLES} triangles at most; export a coarser mesh")]
    TooManyTriangles {
        /// Position of the first triangle beyond the limit.
        place: Place,
    },
    /// A coordinate is NaN, infinite or too large.
    #[error(
        "{place}: coordinate is `{found}`, expected a finite number of magnitude {LARGEST_COORDINATE:e} at most; repair the mesh, or export it again"
    )]
    Coordinate {
        /// Position of the coordinate in the file.
        place: Place,
        /// The coordinate.
        found: String,
    },
    /// The file contains an unexpected word.
    #[error("line {line}: found `{found}`, expected {expected}; export the mesh again, or correct the line")]
    Unexpected {
        /// Number of the line, from 1.
        line: usize,
        /// The unexpected word, shortened.
        found: String,
        /// The expected words.
        expected: &'static str,
    },
    /// The file ends too early.
    #[error("line {line}: the file ends, expected {expected}; it is cut off, copy or export it again")]
    Truncated {
        /// Number of the last line, from 1.
        line: usize,
        /// The expected words.
        expected: &'static str,
    },
    /// A face has fewer than three corners.
    #[error("line {line}: the face has {found} corners, expected 3 or more; export lines as `l`, or correct the line")]
    Corners {
        /// Number of the line, from 1.
        line: usize,
        /// Number of corners of the face.
        found: usize,
    },
    /// A face with more than three corners cannot be cut into triangles.
    #[error("line {line}: the face of {corners} corners {problem}; export the mesh in triangles, or repair the face")]
    Polygon {
        /// Number of the line, from 1.
        line: usize,
        /// Number of corners of the face.
        corners: usize,
        /// Why the face cannot be cut into triangles.
        problem: PolygonProblem,
    },
    /// A face refers to a vertex that is not in the file.
    #[error(
        "line {line}: the face refers to vertex {found}, expected 1 to {vertices}, or -{vertices} to -1; the file is damaged or cut off, export it again"
    )]
    Index {
        /// Number of the line, from 1.
        line: usize,
        /// Number of the missing vertex, as written in the file.
        found: i64,
        /// Number of vertices read so far.
        vertices: usize,
    },
}

impl MeshFileError {
    /// Returns the position of the error in the file; `None` if the error concerns the whole file.
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

/// Shortens a malformed word for an error message. Such words can be very long or binary.
pub(super) fn shorten(word: &[u8]) -> String {
    const LONGEST: usize = 40;
    let text = String::from_utf8_lossy(word.get(..4 * LONGEST).unwrap_or(word));
    text::shorten(&text, LONGEST)
}
