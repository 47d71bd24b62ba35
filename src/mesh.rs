//! Triangle meshes: files, round shapes, surfaces of a scene, and reports on faults.

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
