//! What a run leaves behind.

pub(crate) mod atomic;
mod checkpoints;
mod contacts;
pub mod convert;
mod csv;
mod error;
pub mod estimate;
mod event_log;
mod folder;
mod gsd;
pub(crate) mod inputs;
mod lammps;
mod measurements;
mod npy;
pub(crate) mod number;
pub(crate) mod occupied;
mod owned;
pub(crate) mod partial;
pub mod rates;
mod replacement;
mod scene_copy;
mod scenes;
pub mod summary;
mod thermo;
mod vtk;

pub use atomic::Existing;
pub use error::OutputError;
pub use folder::{Completed, Folder};
pub(crate) use folder::{Frames, remove};
pub use inputs::refuse_input;
pub use measurements::{Measurements, StageMeasured};
pub use occupied::FolderState;
pub(crate) use owned::note;
pub use scenes::{read_scene, read_scene_text};
pub use summary::Summary;
