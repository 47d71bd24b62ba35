//! Writes binary STL for other programs.

use std::io::{self, Write};

use thiserror::Error;

use crate::Vector;
use crate::base::numbers::single;
use crate::model::triangle_mesh::{TriangleMesh, twice_area};

/// Start of the file header. Other programs read a file that begins with `solid` as text.
const HEADER: &[u8; 5] = b"carom";

/// Error when writing a mesh.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteStlError {
    /// The system failed to write.
    #[error("cannot write the mesh")]
    Io(#[from] io::Error),
    /// The number of triangles does not fit in 32 bits.
    #[error("the mesh has {0} triangles, expected 4294967295 at most")]
    Count(usize),
    /// A corner is missing, not finite or beyond the range of `f32`.
    #[error("triangle {0} (from 0) has a corner that is no finite number of 32 bits, expected magnitudes up to 3.4e38")]
    Triangle(usize),
}

/// Writes a mesh. Coordinates are rounded to `f32`, so vertices that are very close to each other may coincide.
///
/// # Errors
/// [`WriteStlError`]. Nothing is written if a corner is not finite in `f32`.
pub fn write_stl(mesh: &TriangleMesh, output: &mut impl Write) -> Result<(), WriteStlError> {
    let triangles = mesh.triangles.len();
    let count = u32::try_from(triangles).map_err(|_| WriteStlError::Count(triangles))?;
    let is_written = |corner: &Vector| corner.iter().all(|x| single(*x).is_finite());
    if let Some(number) = mesh.all_corners().position(|corners| !corners.iter().all(is_written)) {
        return Err(WriteStlError::Triangle(number));
    }
    let mut header = [0; 80];
    header.iter_mut().zip(HEADER).for_each(|(byte, letter)| *byte = *letter);
    output.write_all(&header)?;
    output.write_all(&count.to_le_bytes())?;
    for corners in mesh.all_corners() {
        let area = twice_area(&corners);
        let length = area.norm();
        let normal = if length > 0.0 && length.is_finite() { area / length } else { Vector::zeros() };
        let [a, b, c] = corners;
        for x in [normal, a, b, c].iter().flatten() {
            output.write_all(&single(*x).to_le_bytes())?;
        }
        output.write_all(&[0; 2])?;
    }
    Ok(())
}
