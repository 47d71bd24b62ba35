//! Readers of triangle meshes: binary STL, text STL and Wavefront OBJ.
//!
//! | format | precision | rejected, besides malformed files |
//! |---|---|---|
//! | binary STL | coordinates are `f32`, which `f64` represents exactly | files whose length contradicts the number of triangles in the header |
//! | text STL | nearest `f64` | files that end before `endsolid` |
//! | OBJ | nearest `f64` | vertex numbers that do not exist; faces that are not flat or that cross themselves |
//!
//! Names, colours, texture coordinates and normals are ignored. The order of the corners defines the normal of a
//! triangle. The required memory depends only on the length of the file.

mod error;
mod obj;
mod polygon;
mod stl_binary;
mod stl_text;
#[cfg(test)]
mod tests;
mod words;

pub use error::{MeshFileError, MeshFileProblem, Place};
pub use polygon::PolygonProblem;

use crate::model::triangle_mesh::TriangleMesh;

/// Reads an STL or OBJ file. The extension selects the format. The content shows whether an STL file is binary.
///
/// Corners with equal coordinates become one vertex. Triangles with two identical vertices are kept.
///
/// # Errors
/// [`MeshFileError`] with the name of the file and the problem.
pub fn read_mesh(name_for_errors: &str, extension: &str, content: &[u8]) -> Result<TriangleMesh, MeshFileError> {
    let read = || {
        let format = extension.trim_start_matches('.').to_ascii_lowercase();
        let reader = match format.as_str() {
            "stl" if stl_binary::is_binary(content) => stl_binary::read,
            "stl" => stl_text::read,
            "obj" => obj::read,
            _ => return Err(MeshFileProblem::UnknownFormat { extension: error::shorten(extension.as_bytes()) }),
        };
        if content.trim_ascii().is_empty() {
            return Err(MeshFileProblem::Empty);
        }
        if content.starts_with(b"\xff\xfe") || content.starts_with(b"\xfe\xff") {
            return Err(MeshFileProblem::Utf16);
        }
        reader(content)
    };
    read().map_err(|problem| MeshFileError { name: name_for_errors.to_owned(), problem })
}

/// Returns the number of bytes after the triangles of a binary STL file, which [`read_mesh`] ignores. Returns zero for
/// other files.
#[must_use]
pub fn unread_bytes(extension: &str, content: &[u8]) -> usize {
    let is_stl = extension.trim_start_matches('.').eq_ignore_ascii_case("stl");
    if is_stl && stl_binary::is_binary(content) { stl_binary::extra(content) } else { 0 }
}
