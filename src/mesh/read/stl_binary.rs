//! Binary STL: a header of 80 bytes, the number of triangles, and 50 bytes per triangle. Up to 49 bytes after the last
//! triangle are ignored, because some programs append a few bytes.

use super::error::{MeshFileProblem, Place};
use crate::Vector;
use crate::model::triangle_mesh::{LARGEST_COORDINATE, MOST_TRIANGLES, TriangleMesh, Welder};

/// Length of the header, including the number of triangles `[bytes]`.
const HEADER: usize = 84;

/// Length of a triangle: normal, corners and attributes `[bytes]`.
const TRIANGLE: usize = 50;

const PROBED: usize = 1024;

/// Whether a file is binary STL: it has zero bytes near its beginning, or does not begin with `solid`. Some binary
/// files begin with `solid`, too, but text has no zero bytes.
pub(super) fn is_binary(content: &[u8]) -> bool {
    let text = content.strip_prefix(b"\xef\xbb\xbf").unwrap_or(content).trim_ascii_start();
    let is_solid = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    has_zeros(content) || !is_solid
}

fn has_zeros(content: &[u8]) -> bool {
    content.iter().take(PROBED).any(|byte| *byte == 0)
}

fn announced(content: &[u8]) -> Option<u32> {
    content.get(HEADER - 4..).and_then(|rest| rest.first_chunk()).map(|bytes| u32::from_le_bytes(*bytes))
}

fn length(triangles: u32) -> u64 {
    HEADER as u64 + TRIANGLE as u64 * u64::from(triangles)
}

pub(super) fn extra(content: &[u8]) -> usize {
    let expected = announced(content).map_or(0, length);
    content.len().saturating_sub(usize::try_from(expected).unwrap_or(usize::MAX))
}

pub(super) fn read(content: &[u8]) -> Result<TriangleMesh, MeshFileProblem> {
    let Some(triangles) = announced(content) else {
        return Err(MeshFileProblem::NoStl { found: content.len() });
    };
    let (expected, found) = (length(triangles), content.len() as u64);
    let is_whole = (expected..expected + TRIANGLE as u64).contains(&found);
    if !is_whole && !has_zeros(content) {
        return Err(MeshFileProblem::NoStl { found: content.len() });
    }
    if !is_whole {
        return Err(MeshFileProblem::Length { triangles, expected, found });
    }
    if triangles == 0 {
        return Err(MeshFileProblem::NoTriangle { expected: "triangle after the header" });
    }
    if triangles as usize > MOST_TRIANGLES {
        return Err(MeshFileProblem::TooManyTriangles { place: Place::Triangle(MOST_TRIANGLES) });
    }
    let mut welder = Welder::default();
    let (records, _) = content.get(HEADER..).unwrap_or_default().as_chunks::<TRIANGLE>();
    for (number, record) in records.iter().enumerate() {
        welder.push(&corners(record, number)?);
    }
    Ok(welder.finish())
}

fn corners(record: &[u8; TRIANGLE], number: usize) -> Result<[Vector; 3], MeshFileProblem> {
    let mut corners = [Vector::zeros(); 3];
    let coordinates = corners.iter_mut().flat_map(|corner| corner.iter_mut());
    // The first three numbers are the normal.
    let (numbers, _) = record.as_chunks::<4>();
    for (coordinate, bytes) in coordinates.zip(numbers.iter().skip(3)) {
        *coordinate = f64::from(f32::from_le_bytes(*bytes));
        let is_usable = coordinate.abs() <= LARGEST_COORDINATE;
        if !is_usable {
            return Err(MeshFileProblem::Coordinate { place: Place::Triangle(number), found: coordinate.to_string() });
        }
    }
    Ok(corners)
}
