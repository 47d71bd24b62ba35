//! Meshes of triangles: their files, those of round shapes, and those of the surfaces of a scene.

mod clip;
pub mod read;
pub(crate) mod revolution;
mod shown;
mod write_stl;

pub use read::read_mesh;
pub use shown::shown;
pub use write_stl::{WriteStlError, write_stl};
