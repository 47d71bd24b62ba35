//! What a run leaves behind.

mod checkpoints;
mod contacts;
pub mod convert;
mod csv;
mod error;
mod event_log;
pub mod extended_xyz;
mod folder;
pub mod frame;
mod gsd;
mod inputs;
mod kept_scene;
mod lammps;
mod measurements;
mod npy;
mod number;
mod occupied;
mod owned;
mod partial;
pub(crate) mod place;
pub mod rates;
mod replacement;
pub mod summary;
mod thermo;
mod vtk;

pub use convert::Format;
pub use error::OutputError;
pub use folder::Folder;
pub use frame::Frame;
pub use inputs::refuse_input;
pub(crate) use owned::note;
pub use place::Existing;
pub use summary::Summary;
