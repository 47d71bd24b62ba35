//! What a run leaves behind.

mod checkpoints;
mod contacts;
mod error;
pub mod extended_xyz;
mod folder;
pub mod frame;
mod measurements;
mod number;
mod partial;
pub mod summary;
mod thermo;

pub use error::OutputError;
pub use folder::Folder;
pub use frame::Frame;
pub use summary::Summary;
