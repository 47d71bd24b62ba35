//! Meshes of triangles: their files, those of round shapes, and what is wrong with one.

pub mod read;
pub mod report;
pub(crate) mod revolution;
#[cfg(test)]
mod shapes;
mod write_stl;

pub use read::read_mesh;
pub use report::MeshReport;
pub use write_stl::write_stl;
