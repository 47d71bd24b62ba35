//! Meshes of triangles: their files, and those of round shapes.

pub mod read;
pub(crate) mod revolution;
mod write_stl;

pub use read::read_mesh;
pub use write_stl::write_stl;
