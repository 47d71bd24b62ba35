//! Meshes of triangles: their files, and those of round shapes.

pub(crate) mod read;
pub(crate) mod revolution;
