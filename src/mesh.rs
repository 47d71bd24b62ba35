//! Meshes of triangles: their files, those of round shapes and of the surfaces of a scene, and what
//! is wrong with one.

mod clip;
pub mod read;
pub mod report;
pub(crate) mod revolution;
#[cfg(test)]
mod shapes;
mod shown;
mod write_stl;

pub use read::{read_mesh, unread_bytes};
pub use report::MeshReport;
pub use shown::shown;
pub use write_stl::{WriteStlError, write_stl};
