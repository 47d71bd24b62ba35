//! What a run leaves behind.

mod checkpoints;
mod contacts;
pub mod convert;
mod csv;
mod error;
pub mod estimate;
mod event_log;
mod folder;
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

pub use error::OutputError;
pub use folder::{Completed, Folder};
pub use inputs::refuse_input;
pub(crate) use owned::note;
pub use place::Existing;
pub use summary::Summary;
