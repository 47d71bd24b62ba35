//! Views of results: pictures, movies, pages, and a scene in words.

// Results of a run do not depend on views, so functions may differ in the last bit between machines.
#![allow(clippy::disallowed_methods)]

mod audit;
mod beside;
pub mod describe;
pub mod description;
mod error;
pub mod final_table;
pub mod live;
pub mod movie;
pub mod render;
pub mod report;
mod surfaces;

pub use error::ViewError;
pub use surfaces::Surfaces;
